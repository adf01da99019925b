"""How every table looks: header with a line below, rows of 20 px, every second lighter; and a table of checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QRect, QSize, Qt
from PySide6.QtGui import QFontMetrics, QHelpEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from widgets import theme
from widgets.parts import picture

HEADER_HEIGHT, ROW_HEIGHT = 22, 20


def paint_header(painter: QPainter, rect: QRect) -> None:
    """Paint a header's ground and line and leave the painter ready for its dim texts."""
    current = theme.current()
    painter.fillRect(rect, current.colour("panel"))
    painter.fillRect(QRect(rect.left(), rect.bottom(), rect.width(), 1), current.colour("line"))
    painter.setFont(theme.font(theme.TABLE_PX))
    painter.setPen(current.colour("dim"))


def paint_row(painter: QPainter, rect: QRect, row: int, chosen: bool = False) -> None:
    """Paint the ground of a row: alternating, or the selection's colour."""
    role = "selection" if chosen else "alternate" if row % 2 else "panel"
    painter.fillRect(rect, theme.current().colour(role))


@dataclass(frozen=True)
class CheckRow:
    """A figure as it is read: ``verdict`` is ``ok``, ``warn``, ``fail`` or empty, ``tip`` says what it means."""

    name: str
    value: str
    limit: str = ""
    verdict: str = ""
    tip: str = ""


VERDICT_ROLES = {"ok": "fresh_text", "warn": "stale_text", "fail": "captured"}


class CheckTable(QWidget):
    """Figures with their limit and verdict: header 22 high, rows 20.

    Parameters
    ----------
    title, unit : str
        The first two headers; the unit stands there and in no row.
    """

    def __init__(self, title: str, unit: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._headers = (title, unit, "limit")
        self._rows: tuple[CheckRow, ...] = ()
        self.setAccessibleName(title)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        theme.signals.changed.connect(self.updateGeometry)
        theme.signals.changed.connect(self.update)
        picture.offer(self, title.replace(" ", "_"), f"table {title}", table=self.cells)

    def cells(self) -> list[list[str]]:
        """Return headers and figures as rows of cells, for a spreadsheet."""
        head = [*self._headers, "verdict"]
        return [head, *([r.name, r.value, r.limit, r.verdict] for r in self._rows)]

    @property
    def rows(self) -> tuple[CheckRow, ...]:
        """What is shown."""
        return self._rows

    def set_rows(self, rows: Sequence[CheckRow]) -> None:
        """Show other figures."""
        self._rows = tuple(rows)
        words = (f"{r.name} {r.value} {r.verdict}".strip() for r in self._rows)
        self.setAccessibleDescription("; ".join(words))
        self.updateGeometry()
        self.update()

    def sizeHint(self) -> QSize:
        """Return header and rows."""
        return QSize(theme.px(200), theme.px(HEADER_HEIGHT) + theme.px(ROW_HEIGHT) * len(self._rows))

    def minimumSizeHint(self) -> QSize:
        """Return the size hint: no row is ever cut."""
        return self.sizeHint()

    def _columns(self) -> tuple[QRect, QRect, QRect, QRect]:
        width, px = self.width(), theme.px
        return (
            QRect(8, 0, width - px(172), 0),
            QRect(width - px(172), 0, px(60), 0),
            QRect(width - px(108), 0, px(56), 0),
            QRect(width - px(48), 0, px(40), 0),
        )

    def event(self, event: QEvent) -> bool:
        """Say what a figure means."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            row = (event.pos().y() - theme.px(HEADER_HEIGHT)) // theme.px(ROW_HEIGHT)
            tip = self._rows[row].tip if 0 <= row < len(self._rows) else ""
            QToolTip.showText(event.globalPos(), tip, self)
            return True
        return super().event(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw header and rows."""
        painter = QPainter(self)
        current, columns = theme.current(), self._columns()
        middle, right = Qt.AlignmentFlag.AlignVCenter, Qt.AlignmentFlag.AlignRight
        head, height = theme.px(HEADER_HEIGHT), theme.px(ROW_HEIGHT)
        paint_header(painter, QRect(0, 0, self.width(), head))
        for k, text in enumerate(self._headers):
            box = QRect(columns[k].left(), 0, columns[k].width(), head)
            painter.drawText(box, middle | (right if k else Qt.AlignmentFlag.AlignLeft), text)
        for index, row in enumerate(self._rows):
            top = head + index * height
            paint_row(painter, QRect(0, top, self.width(), height), index)
            cells = [QRect(c.left(), top, c.width(), height) for c in columns]
            painter.setPen(current.colour("text"))
            metrics = QFontMetrics(theme.font(theme.TABLE_PX))
            name = metrics.elidedText(row.name, Qt.TextElideMode.ElideRight, cells[0].width())
            painter.drawText(cells[0], middle, name)
            painter.drawText(cells[1], middle | right, row.value)
            painter.setPen(current.colour("dim"))
            painter.drawText(cells[2], middle | right, row.limit)
            painter.setPen(current.colour(VERDICT_ROLES.get(row.verdict, "dim")))
            painter.drawText(cells[3], middle | right, row.verdict)
