"""A matrix as a picture: rows and columns to point at, a colour bar, and the value under the pointer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QImage, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from engine.mesh import FloatArray
from widgets import theme
from widgets.canvases.diverging import diverging
from widgets.canvases.pictures import to_image
from widgets.canvases.plot import MIDDLE, RIGHT, Plot, advance

_FOOT, _TEXT, _BAR = 30, 14, 8


class MatrixCanvas(Plot):
    """Values -1..1 by rows and columns, each row the share that a shape has on every axis.

    A click chooses row and column, arrow keys move to others.

    Signals
    -------
    row_chosen(int), column_chosen(int)
        From 0.
    """

    row_chosen = Signal(int)
    column_chosen = Signal(int)

    def __init__(self, sentence: str = "", parent: QWidget | None = None) -> None:
        super().__init__(sentence, parent)
        self.values: FloatArray | None = None
        self.shares: FloatArray | None = None
        self.rows: tuple[str, ...] = ()
        self.row, self.column = -1, -1
        self._hover: tuple[int, int] | None = None
        self._image: QImage | None = None
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Projection W: a row a shape, a column an axis")

    def set_matrix(self, values: FloatArray | None, rows: Sequence[str] = ()) -> None:
        """Show values (n, m) with the names of the rows; each row is drawn as a share of its length."""
        self.values = None if values is None or not np.size(values) else np.asarray(values, dtype=np.float64)
        self.rows, self.shares = tuple(rows), None
        if self.values is not None:
            length = np.linalg.norm(self.values, axis=1, keepdims=True)
            self.shares = np.divide(self.values, length, out=np.zeros_like(self.values), where=length > 0)
        self._hover = None
        self.forget()

    def set_row(self, row: int) -> None:
        """Frame a row; -1 for none."""
        self.row = row
        self.update()

    def set_column(self, column: int) -> None:
        """Frame a column; -1 for none."""
        self.column = column
        self.update()

    def forget(self) -> None:
        """Colour the cells anew."""
        self._image = None
        super().forget()

    # -- places ----------------------------------------------------------------------------------------------

    def box(self) -> QRectF:
        """Return where the cells are drawn, pixels of this widget."""
        return QRectF(0, 0, self.width(), max(1, self.height() - theme.px(_FOOT)))

    def cell(self, row: int, column: int) -> QRectF:
        """Return where a cell lies."""
        assert self.values is not None
        box, (rows, columns) = self.box(), self.values.shape
        wide, high = box.width() / columns, box.height() / rows
        return QRectF(box.left() + column * wide, box.top() + row * high, wide, high)

    def cell_at(self, place: QPointF) -> tuple[int, int] | None:
        """Return row and column at a place."""
        if self.values is None or not self.box().contains(place):
            return None
        box, (rows, columns) = self.box(), self.values.shape
        row = int((place.y() - box.top()) / box.height() * rows)
        return min(row, rows - 1), min(int((place.x() - box.left()) / box.width() * columns), columns - 1)

    def words(self, row: int, column: int) -> str:
        """Return what a cell says."""
        assert self.values is not None and self.shares is not None
        name = self.rows[row] if row < len(self.rows) else f"row {row + 1}"
        value, share = (f"{v[row, column]:.3g}".replace("-", "−") for v in (self.values, self.shares))
        return f"{name}, axis {column + 1}: {share} of its length, w = {value} mm"

    # -- hands -----------------------------------------------------------------------------------------------

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Choose row and column."""
        found = self.cell_at(event.position())
        if event.button() == Qt.MouseButton.LeftButton and found is not None:
            self._choose(*found)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Say what lies under the pointer."""
        found = self.cell_at(event.position())
        if found != self._hover:
            self._hover = found
            self.update()
            if found is None:
                QToolTip.hideText()
            else:
                QToolTip.showText(event.globalPosition().toPoint() + QPoint(8, 8), self.words(*found), self)

    def leaveEvent(self, event: QEvent) -> None:
        """Let the cell go."""
        self._hover = None
        self.update()
        super().leaveEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Go to the cell beside."""
        steps = {
            Qt.Key.Key_Left: (0, -1), Qt.Key.Key_Right: (0, 1), Qt.Key.Key_Up: (-1, 0), Qt.Key.Key_Down: (1, 0),
        }  # fmt: skip
        step = steps.get(Qt.Key(event.key()))
        if step is None or self.values is None:
            super().keyPressEvent(event)
            return
        rows, columns = self.values.shape
        row, column = min(max(0, self.row + step[0]), rows - 1), min(max(0, self.column + step[1]), columns - 1)
        self._choose(row if step[0] else self.row, column if step[1] else self.column)

    def _choose(self, row: int, column: int) -> None:
        if column != self.column:
            self.set_column(column)
            self.column_chosen.emit(column)
        if row != self.row:
            self.set_row(row)
            self.row_chosen.emit(row)
        if self.values is not None and row >= 0 and column >= 0:
            self.setAccessibleDescription(self.words(row, column))

    # -- drawing ---------------------------------------------------------------------------------------------

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the cells, what is framed, the names of the ends and the colour bar."""
        painter, current = QPainter(self), theme.current()
        if self.values is None or self.shares is None:
            self.paint_sentence(painter, QRectF(self.rect()))
            return
        if self._image is None:
            self._image = to_image(diverging(self.shares))
        box = self.box()
        painter.drawImage(box, self._image)
        pen = QPen(current.colour("accent"), 1)
        if 0 <= self.column < self.values.shape[1]:
            first, last = self.cell(0, self.column), self.cell(len(self.values) - 1, self.column)
            self._frame(painter, first.united(last), pen)
        if 0 <= self.row < len(self.values):
            first, last = self.cell(self.row, 0), self.cell(self.row, self.values.shape[1] - 1)
            self._frame(painter, first.united(last), QPen(current.colour("text"), 1.2))
        if self._hover is not None:
            self._frame(painter, self.cell(*self._hover), QPen(current.colour("text"), 1))
        if self.hasFocus():
            painter.setPen(QPen(current.colour("accent", 0.7), 1))
            painter.drawRect(box.adjusted(0.5, 0.5, -0.5, -0.5))
        self._paint_foot(painter, box)

    def _frame(self, painter: QPainter, area: QRectF, pen: QPen) -> None:
        painter.setPen(pen)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        inside = self.box().adjusted(0.5, 0.5, -0.5, -0.5)
        painter.drawRect(QRectF(area.toAlignedRect()).adjusted(0.5, 0.5, -0.5, -0.5).intersected(inside))

    def _paint_foot(self, painter: QPainter, box: QRectF) -> None:
        assert self.values is not None
        current, px = theme.current(), theme.px
        painter.setFont(theme.font(theme.AXIS_PX))
        painter.setPen(current.colour("dim"))
        line = QRectF(box.left(), box.bottom() + 2, box.width(), px(_TEXT))
        painter.drawText(line, MIDDLE, "axis 1")
        painter.drawText(line, MIDDLE | RIGHT, str(self.values.shape[1]))
        foot = QRectF(box.left(), line.bottom(), box.width(), px(_TEXT))
        left, right = advance("−1", theme.AXIS_PX) + 6, advance("1", theme.AXIS_PX) + 6
        painter.drawText(foot, MIDDLE, "−1")
        painter.drawText(foot, MIDDLE | RIGHT, "1")
        bar = QRectF(foot.left() + left, foot.center().y() - px(_BAR) / 2, foot.width() - left - right, px(_BAR))
        shades = to_image(diverging(np.linspace(-1.0, 1.0, 65)[None]))
        painter.drawImage(bar, shades)

    def cells(self) -> list[list[str]]:
        """Return the matrix as rows of cells, for a spreadsheet."""
        if self.values is None:
            return []
        head = ["w, mm", *(f"axis {k + 1}" for k in range(self.values.shape[1]))]
        return [head, *([name, *(f"{w:.6g}" for w in row)] for name, row in zip(self.rows, self.values, strict=False))]

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(theme.px(112), theme.px(108 + _FOOT))

    def minimumSizeHint(self) -> QSize:
        """Return the least that can be pointed at."""
        return QSize(theme.px(80), theme.px(48 + _FOOT))
