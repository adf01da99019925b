"""A row of joined buttons of which one is on."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QHelpEvent, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from widgets import theme

SHORTEST = 34


class Segments(QWidget):
    """Joined buttons, 24 high, of which exactly one is on; arrow keys move along.

    Parameters
    ----------
    items : sequence of (key, text)
        What ``chosen`` sends, and what is read.
    stretch : bool
        Whether the segments share the whole width in equal parts.
    name : str
        Accessible name.

    Signals
    -------
    chosen(str)
        The user picked a segment that was not on.
    """

    chosen = Signal(str)

    def __init__(
        self,
        items: Sequence[tuple[str, str]],
        *,
        stretch: bool = False,
        name: str = "",
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._items = list(items)
        self._tips: dict[str, str] = {}
        self._disabled: dict[str, str] = {}
        self._stretch = stretch
        self._current = self._items[0][0]
        theme.fix(self, height=24)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName(name)
        horizontal = QSizePolicy.Policy.Expanding if stretch else QSizePolicy.Policy.Maximum
        self.setSizePolicy(horizontal, QSizePolicy.Policy.Fixed)
        theme.signals.changed.connect(self.updateGeometry)
        theme.signals.changed.connect(self.update)

    @property
    def current(self) -> str:
        """Key of the segment that is on."""
        return self._current

    def set_current(self, key: str) -> None:
        """Turn a segment on without telling anybody."""
        if key != self._current and any(key == k for k, _ in self._items):
            self._current = key
            self.update()

    def set_text(self, key: str, text: str) -> None:
        """Change what a segment reads."""
        self._items = [(k, text if k == key else t) for k, t in self._items]
        self.updateGeometry()
        self.update()

    def set_tip(self, key: str, tip: str) -> None:
        """Set the tooltip of one segment."""
        self._tips[key] = tip

    def set_available(self, key: str, available: bool, reason: str = "") -> None:
        """Allow a segment, or grey it and say why."""
        if available:
            self._disabled.pop(key, None)
        else:
            self._disabled[key] = reason
        self.update()

    def box(self, key: str) -> QRectF:
        """Return where a segment lies, pixels of this widget."""
        left = 0.0
        for (k, _), width in zip(self._items, self._widths(), strict=True):
            if k == key:
                return QRectF(left, 0, width, self.height())
            left += width
        raise KeyError(key)

    def _widths(self) -> list[float]:
        if self._stretch:
            return [self.width() / len(self._items)] * len(self._items)
        metrics = QFontMetrics(theme.font())
        wanted = [float(metrics.horizontalAdvance(text) + theme.px(17)) for _, text in self._items]
        share = min(1.0, self.width() / sum(wanted))
        return [width * share for width in wanted]

    def sizeHint(self) -> QSize:
        """Return the room for all texts."""
        metrics = QFontMetrics(theme.font())
        return QSize(sum(metrics.horizontalAdvance(text) + theme.px(17) for _, text in self._items), theme.px(24))

    def minimumSizeHint(self) -> QSize:
        """Return the room for a few letters each: where it is narrow, texts are cut rather than tools pushed out."""
        return QSize(min(theme.px(SHORTEST) * len(self._items), self.sizeHint().width()), theme.px(24))

    def _key_at(self, position: QPointF) -> str | None:
        return next((k for k, _ in self._items if self.box(k).contains(position)), None)

    def _choose(self, key: str) -> None:
        if key != self._current and key not in self._disabled:
            self._current = key
            self.update()
            self.chosen.emit(key)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Choose the segment under the mouse."""
        key = self._key_at(event.position())
        if event.button() == Qt.MouseButton.LeftButton and key is not None:
            self._choose(key)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move along with the arrow keys."""
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        if step is None:
            super().keyPressEvent(event)
            return
        keys = [k for k, _ in self._items if k not in self._disabled]
        if self._current in keys:
            self._choose(keys[(keys.index(self._current) + step) % len(keys)])

    def event(self, event: QEvent) -> bool:
        """Show the tooltip of the segment under the mouse."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            key = self._key_at(QPointF(event.pos())) or ""
            lines = [self._tips.get(key, ""), self._disabled.get(key, "")]
            text = dict(self._items).get(key, "")
            cut = bool(key) and QFontMetrics(theme.font()).horizontalAdvance(text) > self.box(key).width() - 4
            tip = "\n".join(x for x in (text if cut else "", *lines) if x)
            QToolTip.showText(event.globalPos(), tip, self)
            return True
        return super().event(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the frame, the segment that is on, the lines between and the texts."""
        current = theme.current()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        frame = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        clip = QPainterPath()
        clip.addRoundedRect(frame, 4, 4)
        painter.fillPath(clip, current.colour("segment_off"))
        painter.setClipPath(clip)
        painter.fillRect(self.box(self._current), current.colour("segment_on"))
        painter.setPen(QPen(current.colour("line"), 1))
        for key, _ in self._items[1:]:
            x = round(self.box(key).left()) - 0.5
            painter.drawLine(QPointF(x, 0), QPointF(x, self.height()))
        painter.setClipping(False)
        painter.drawPath(clip)
        if self.hasFocus():
            painter.setPen(QPen(current.colour("accent"), 1))
            painter.drawRoundedRect(self.box(self._current).adjusted(0.5, 0.5, -0.5, -0.5), 4, 4)
        painter.setFont(theme.font())
        metrics = QFontMetrics(theme.font())
        for key, text in self._items:
            role = "missing" if key in self._disabled else ("text" if key == self._current else "dim")
            painter.setPen(current.colour(role))
            box = self.box(key)
            cut = metrics.elidedText(text, Qt.TextElideMode.ElideRight, round(box.width()) - 4)
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, cut)
