"""What stands in an empty work zone: the sample, a place to drop files, and the projects opened last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QEvent, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QImage, QPainter, QPainterPath, QPaintEvent, QPen
from PySide6.QtWidgets import (
    QAbstractButton,
    QFrame,
    QHBoxLayout,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from widgets import theme
from widgets.parts.buttons import KeyButton
from widgets.parts.section import DimLabel

THUMB_W, THUMB_H, CARD = 64, 48, 60
WIDEST = 460


@dataclass(frozen=True)
class RecentProject:
    """A project that was opened before: its file, and when it was saved last."""

    path: Path
    saved: datetime | None = None


class Card(QAbstractButton):
    """A picture with two lines beside it; a click or the space bar opens it.

    Parameters
    ----------
    title, note : str
        What it is, and a dimmer line below; both are cut where they do not fit.
    tip : str
        The whole of it.
    """

    def __init__(self, title: str, note: str, tip: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setText(title)
        self._note = note
        self._picture = QImage()
        self.setToolTip(tip)
        self.setAccessibleName(f"{title}, {note}")
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)
        theme.fix(self, height=CARD)

    def set_picture(self, picture: QImage) -> None:
        """Show a picture of any size; its middle is seen."""
        self._picture = picture
        self.update()

    @property
    def has_picture(self) -> bool:
        """Whether there is one."""
        return not self._picture.isNull()

    def sizeHint(self) -> QSize:
        """Return a modest width: the column decides."""
        return QSize(theme.px(200), theme.px(CARD))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw ground, picture and both lines."""
        current, painter = theme.current(), QPainter(self)
        painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        frame = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        lit = self.underMouse() or self.isDown()
        painter.setPen(QPen(current.colour("accent" if self.hasFocus() else "dim" if lit else "line"), 1))
        painter.setBrush(current.colour("raised" if lit else "panel"))
        painter.drawRoundedRect(frame, 4, 4)
        inset = (self.height() - theme.px(THUMB_H)) / 2
        box = QRectF(inset, inset, theme.px(THUMB_W), theme.px(THUMB_H))
        clip = QPainterPath()
        clip.addRoundedRect(box, 2, 2)
        painter.fillPath(clip, current.colour("window"))
        if self.has_picture:
            painter.save()
            painter.setClipPath(clip)
            painter.drawImage(_filling(box, self._picture), self._picture)
            painter.restore()
        left = round(box.right()) + 10
        room = self.width() - left - 8
        middle = self.height() // 2
        for text, font, role, top in (
            (self.text(), theme.font(), "text", middle - theme.px(18)),
            (self._note, theme.font(theme.TABLE_PX), "dim", middle),
        ):
            painter.setFont(font)
            painter.setPen(current.colour(role))
            cut = QFontMetrics(font).elidedText(text, Qt.TextElideMode.ElideMiddle, room)
            painter.drawText(QRect(left, top, room, theme.px(18)), Qt.AlignmentFlag.AlignVCenter, cut)


class WelcomePage(QWidget):
    """Where to begin: open the sample, drop or choose files, go on with a project.

    Signals
    -------
    sample_requested(), add_requested(), open_requested()
        The buttons.
    recent_requested(Path)
        A project opened before.
    """

    sample_requested = Signal()
    add_requested = Signal()
    open_requested = Signal()
    recent_requested = Signal(Path)

    def __init__(self, add_key: str, open_key: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("welcome")
        self.setAccessibleName("Start")
        self.drop = _DropZone()
        self.add_button = KeyButton("Add scans…", add_key, primary=True)
        self.open_button = KeyButton("Open project…", open_key)
        self.sample = Card("Open the sample", "six scans of one face, with fiducials", "Add the bundled sample")
        self.heading = DimLabel("Recent projects", role="dim")
        self.recent: tuple[Card, ...] = ()
        self._paths: tuple[RecentProject, ...] | None = None
        inside = QWidget()
        self._column = QVBoxLayout(inside)
        self._column.setContentsMargins(16, 36, 16, 16)
        self._column.setSpacing(8)
        drop = QVBoxLayout(self.drop)
        drop.setContentsMargins(16, 16, 16, 16)
        drop.setSpacing(8)
        words = DimLabel("Drop scans, meshes, folders or a project anywhere here")
        words.setWordWrap(True)
        words.setAlignment(Qt.AlignmentFlag.AlignCenter)
        drop.addWidget(words)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addStretch(1)
        row.addWidget(self.add_button)
        row.addWidget(self.open_button)
        row.addStretch(1)
        drop.addLayout(row)
        for widget in (self.drop, self.sample, self.heading):
            self._column.addWidget(widget)
        self._column.addStretch(1)
        self._area = QScrollArea(self)
        self._area.setWidgetResizable(True)
        self._area.setFrameShape(QFrame.Shape.NoFrame)
        self._area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._area.setWidget(inside)
        self._area.viewport().setAutoFillBackground(False)
        inside.setAutoFillBackground(False)
        inside.setMaximumWidth(theme.px(WIDEST))
        self._inside = inside
        box = QHBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self._area)
        self.setFocusProxy(self.add_button)
        self.sample.clicked.connect(self.sample_requested)
        self.add_button.clicked.connect(self.add_requested)
        self.open_button.clicked.connect(self.open_requested)
        theme.signals.changed.connect(self.update)
        self.set_recent(())

    def set_recent(self, projects: Sequence[RecentProject]) -> None:
        """List projects, the newest first; cards whose project stays keep their picture."""
        if self._paths == tuple(projects):
            return
        self._paths = tuple(projects)
        for card in self.recent:
            self._column.removeWidget(card)
            card.hide()
            card.deleteLater()
        cards = []
        for project in projects:
            when = "" if project.saved is None else f"{spoken(project.saved, datetime.now())}, "
            card = Card(project.path.stem, f"{when}{project.path.parent.name}", str(project.path))
            card.clicked.connect(lambda _checked=False, path=project.path: self.recent_requested.emit(path))
            self._column.insertWidget(self._column.count() - 1, card)
            cards.append(card)
        self.recent = tuple(cards)
        self.heading.setVisible(bool(cards))

    def set_sample_picture(self, picture: QImage) -> None:
        """Show the sample's face."""
        self.sample.set_picture(picture)

    def set_thumbnail(self, path: Path, picture: QImage) -> None:
        """Show the picture of a project, where it is still listed."""
        for project, card in zip(self._paths or (), self.recent, strict=False):
            if project.path == path:
                card.set_picture(picture)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the ground of an empty view."""
        QPainter(self).fillRect(self.rect(), theme.current().colour("view_bottom"))

    def changeEvent(self, event: QEvent) -> None:
        """Follow the text scale."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange and hasattr(self, "_inside"):
            self._inside.setMaximumWidth(theme.px(WIDEST))


class _DropZone(QWidget):
    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        pen = QPen(theme.current().colour("missing"), 1.2, Qt.PenStyle.CustomDashLine)
        pen.setDashPattern([4, 4])
        painter.setPen(pen)
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(1, 1, -1, -1), 6, 6)


def _filling(box: QRectF, picture: QImage) -> QRectF:
    """Return where a picture is drawn so that it fills a box and keeps its form."""
    scale = max(box.width() / picture.width(), box.height() / picture.height())
    size = QSize(round(picture.width() * scale), round(picture.height() * scale))
    return QRectF(
        box.center().x() - size.width() / 2, box.center().y() - size.height() / 2, size.width(), size.height()
    )


def spoken(then: datetime, now: datetime) -> str:
    """Return a time as people say it: today 14:05, yesterday 9:12, 3 May, 3 May 2024."""
    days = (now.date() - then.date()).days
    if days == 0:
        return f"today {then:%H:%M}"
    if days == 1:
        return f"yesterday {then:%H:%M}"
    return f"{then.day} {then:%B}" + ("" if then.year == now.year else f" {then.year}")
