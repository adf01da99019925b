"""The regions of a face: how far each lies from the scan, and whether that passes; pointing shows where it is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from PySide6.QtCore import QEvent, QPointF, QRect, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QHelpEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from widgets import theme
from widgets.parts import picture
from widgets.parts.tables import HEADER_HEIGHT, ROW_HEIGHT, VERDICT_ROLES, paint_header, paint_row

WORDS = {"ok": "pass", "warn": "warn", "fail": "fail"}
"""Verdict -> the word beside its sign."""


class Region(Protocol):
    """What a row shows; ``engine.scan.quality.RegionQuality`` has it all."""

    @property
    def name(self) -> str:
        """What the region is called."""

    @property
    def vertices(self) -> int:
        """How many vertices it has."""

    @property
    def median_mm(self) -> float:
        """Half of the measured vertices lie nearer to the scan."""

    @property
    def p95_mm(self) -> float:
        """95 of 100 measured vertices lie nearer."""

    @property
    def max_mm(self) -> float:
        """The farthest."""

    @property
    def filled_fraction(self) -> float:
        """The share, 0..1, of vertices that were filled in."""

    @property
    def verdict(self) -> str:
        """``ok``, ``warn`` or ``fail``."""


class RegionTable(QWidget):
    """A row for every region: name, median, 95th percentile, verdict as sign and word.

    Signals
    -------
    pointed(str)
        The region under the pointer, else the chosen one; empty for none.
    """

    pointed = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows: tuple[Region, ...] = ()
        picture.offer(self, "regions", "table of regions", table=self.cells)
        self._hovered, self._chosen, self._told = "", "", ""
        self._meaning: dict[str, str] = {}
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName("Regions, mm")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        theme.signals.changed.connect(self.updateGeometry)
        theme.signals.changed.connect(self.update)

    def cells(self) -> list[list[str]]:
        """Return every figure of every region as rows of cells, mm, for a spreadsheet."""
        head = ["region", "vertices", "median mm", "p95 mm", "max mm", "filled", "verdict"]
        return [head, *(
            [r.name, str(r.vertices), *(f"{v:.3f}" for v in (r.median_mm, r.p95_mm, r.max_mm, r.filled_fraction)),
             WORDS.get(str(r.verdict), "")]
            for r in self._rows
        )]  # fmt: skip

    @property
    def rows(self) -> tuple[Region, ...]:
        """What is shown."""
        return self._rows

    @property
    def chosen(self) -> str:
        """The region that stays marked; empty for none."""
        return self._chosen

    def set_meaning(self, meaning: dict[str, str]) -> None:
        """Say what belongs to each region; shown in its tooltip."""
        self._meaning = dict(meaning)

    def set_rows(self, rows: Sequence[Region]) -> None:
        """Show other figures."""
        self._rows = tuple(rows)
        names = [row.name for row in self._rows]
        if self._chosen not in names:
            self._chosen = ""
        if self._hovered not in names:
            self._hovered = ""
        words = (f"{r.name} {r.median_mm:.2f} {WORDS.get(str(r.verdict), '')}" for r in self._rows)
        self.setAccessibleDescription("; ".join(words))
        self.updateGeometry()
        self.update()
        self._tell()

    def sizeHint(self) -> QSize:
        """Return header and rows."""
        return QSize(theme.px(200), theme.px(HEADER_HEIGHT) + theme.px(ROW_HEIGHT) * len(self._rows))

    def minimumSizeHint(self) -> QSize:
        """Return the size hint: no row is ever cut."""
        return self.sizeHint()

    def row_at(self, y: int) -> str:
        """Return the region at a height of the widget; empty where there is none."""
        row = (y - theme.px(HEADER_HEIGHT)) // theme.px(ROW_HEIGHT)
        return self._rows[row].name if 0 <= row < len(self._rows) else ""

    def event(self, event: QEvent) -> bool:
        """Say more about a region."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            name = self.row_at(event.pos().y())
            QToolTip.showText(event.globalPos(), self._tip(name), self)
            return True
        return super().event(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Point at the region below the mouse."""
        self._hovered = self.row_at(round(event.position().y()))
        self._tell()

    def leaveEvent(self, event: QEvent) -> None:
        """Go back to the chosen region."""
        self._hovered = ""
        self._tell()
        super().leaveEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Choose a region, or let go of it."""
        if event.button() == Qt.MouseButton.LeftButton:
            self._choose(self.row_at(round(event.position().y())))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Go along the regions with the arrow keys; Esc lets go."""
        names = [row.name for row in self._rows]
        step = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1}.get(Qt.Key(event.key()))
        if step is not None and names:
            at = names.index(self._chosen) + step if self._chosen else (0 if step > 0 else len(names) - 1)
            self._chosen = names[max(0, min(at, len(names) - 1))]
            self._tell()
            self.update()
        elif event.key() == Qt.Key.Key_Escape and self._chosen:
            self._choose(self._chosen)
        else:
            super().keyPressEvent(event)

    def _choose(self, name: str) -> None:
        self._chosen = "" if name == self._chosen else name
        self._tell()
        self.update()

    def _tell(self) -> None:
        name = self._hovered or self._chosen
        if name != self._told:
            self._told = name
            self.update()
            self.pointed.emit(name)

    def _tip(self, name: str) -> str:
        row = next((r for r in self._rows if r.name == name), None)
        if row is None:
            return ""
        figures = (
            f"largest {_number(row.max_mm)} mm, filled {100 * row.filled_fraction:.1f} % of {row.vertices} vertices"
        )
        return f"{self._meaning.get(name, name)}\n{figures}"

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw header and rows."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        current, px, width = theme.current(), theme.px, self.width()
        middle, right = Qt.AlignmentFlag.AlignVCenter, Qt.AlignmentFlag.AlignRight
        head, height = px(HEADER_HEIGHT), px(ROW_HEIGHT)
        lefts = [(8, width - px(172)), (width - px(172), px(56)), (width - px(112), px(48)), (width - px(44), px(36))]
        paint_header(painter, QRect(0, 0, width, head))
        for k, text in enumerate(("region, mm", "median", "95th", "")):
            painter.drawText(QRect(lefts[k][0], 0, lefts[k][1], head), middle | (right if k else middle), text)
        metrics = QFontMetrics(theme.font(theme.TABLE_PX))
        for index, row in enumerate(self._rows):
            top = head + index * height
            paint_row(painter, QRect(0, top, width, height), index, row.name in (self._chosen, self._hovered))
            cells = [QRect(left, top, wide, height) for left, wide in lefts]
            painter.setPen(current.colour("text"))
            name = metrics.elidedText(row.name, Qt.TextElideMode.ElideRight, cells[0].width())
            painter.drawText(cells[0], middle, name)
            painter.drawText(cells[1], middle | right, _number(row.median_mm))
            painter.drawText(cells[2], middle | right, _number(row.p95_mm))
            verdict = str(row.verdict)
            painter.setPen(current.colour(VERDICT_ROLES.get(verdict, "dim")))
            painter.drawText(cells[3], middle | right, WORDS.get(verdict, ""))
            sign(painter, QPointF(width - px(50), top + height / 2), verdict)
        if self.hasFocus():
            painter.setPen(QPen(current.colour("accent"), 1))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(QRect(0, 0, width - 1, self.height() - 1))


def sign(painter: QPainter, at: QPointF, verdict: str) -> None:
    """Draw the sign of a verdict: ring, triangle or square, so that no colour has to be told apart."""
    colour = theme.current().colour(VERDICT_ROLES.get(verdict, "dim"))
    radius = theme.px(7) / 2
    painter.setPen(QPen(colour, 1.4))
    painter.setBrush(Qt.BrushStyle.NoBrush if verdict == "ok" else colour)
    if verdict == "warn":
        x, y = at.x(), at.y()
        painter.drawPolygon(
            QPolygonF([QPointF(x - radius, y + radius), QPointF(x + radius, y + radius), QPointF(x, y - radius)])
        )
    elif verdict == "fail":
        painter.drawRect(round(at.x() - radius), round(at.y() - radius), round(2 * radius), round(2 * radius))
    else:
        painter.drawEllipse(at, radius, radius)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def _number(value: float) -> str:
    return "\u2013" if value != value else f"{value:.2f}"
