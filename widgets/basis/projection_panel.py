"""How the hand shapes lie on the axes: W as a picture, and how much of the motion the axes hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QHBoxLayout, QWidget

from engine.mesh import FloatArray
from widgets import theme
from widgets.canvases.curves import ScreePlot
from widgets.canvases.matrix import MatrixCanvas
from widgets.parts import picture


class ProjectionPanel(QWidget):
    """Matrix of W beside the scree plot.

    Signals
    -------
    shape_chosen(str), axis_chosen(int)
        The row and the column clicked; axes from 0.
    """

    shape_chosen = Signal(str)
    axis_chosen = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.matrix = MatrixCanvas("How each shape lies on the axes of the performance appears here.")
        self.scree = ScreePlot("How much of the motion each axis holds appears here.")
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 8, 8, 2)
        row.setSpacing(8)
        row.addWidget(self.matrix, 4)
        row.addWidget(self.scree, 5)
        self.matrix.row_chosen.connect(lambda row: self.shape_chosen.emit(self.matrix.rows[row]))
        self.matrix.column_chosen.connect(self.axis_chosen)
        for plot, name, title, there in (
            (self.matrix, "projection", "projection W", lambda: self.matrix.values is not None),
            (self.scree, "scree", "variance by axis", lambda: self.scree.shares is not None),
        ):
            ready = lambda there=there: "" if there() else "there is no basis yet"  # noqa: E731
            picture.offer(plot, name, title, table=plot.cells, ready=ready)

    @property
    def note(self) -> str:
        """What stands beside the dock's name: ``W, 24 shapes × 22 axes``."""
        if self.matrix.values is None:
            return ""
        shapes, axes = self.matrix.values.shape
        return f"W, {shapes} shapes × {axes} axes"

    def set_projection(self, projection: FloatArray | None, names: Sequence[str] = ()) -> None:
        """Show W (n, m), mm, with the names of its rows; the row and the column marked stay."""
        marked = self.matrix.rows[self.matrix.row] if 0 <= self.matrix.row < len(self.matrix.rows) else None
        self.matrix.set_matrix(projection, names)
        self.set_current(marked)
        if projection is None or self.matrix.column >= np.shape(projection)[1]:
            self.set_axis(None)

    def set_spectrum(
        self,
        eigenvalues: FloatArray | None,
        cumulative: FloatArray | None = None,
        count: int = 0,
        coverage: float | None = None,
    ) -> None:
        """Show eigenvalues (r,) mm^2, their cumulative shares (r,) 0..1, and how many axes were chosen."""
        if eigenvalues is None or not len(eigenvalues):
            self.scree.set_spectrum(None, None, 0, "")
            return
        values = np.asarray(eigenvalues, dtype=np.float64)
        if cumulative is None:
            cumulative = np.cumsum(values) / max(float(values.sum()), 1e-300)
        shares = np.diff(np.concatenate([[0.0], cumulative]))
        held = float(cumulative[count - 1]) if coverage is None and 0 < count <= len(cumulative) else coverage
        words = f"{count} axes" if count != 1 else "1 axis"
        self.scree.set_spectrum(shares, cumulative, count, words if held is None else f"{words}, {held:.3f}")

    def set_current(self, name: str | None) -> None:
        """Mark the row of a shape without telling anybody."""
        self.matrix.set_row(self.matrix.rows.index(name) if name in self.matrix.rows else -1)

    def set_axis(self, axis: int | None) -> None:
        """Mark the column of an axis, from 0, without telling anybody."""
        self.matrix.set_column(-1 if axis is None else axis)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(theme.px(296), theme.px(144))

    def minimumSizeHint(self) -> QSize:
        """Return the least that can be read."""
        return QSize(theme.px(200), theme.px(96))
