"""How the hand-made shapes lie on the axes: W as a picture, and how much of the motion the axes hold."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget

from engine.mesh import FloatArray


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
        self._projection: FloatArray | None = None

    @property
    def note(self) -> str:
        """What stands beside the dock's name: ``W, 24 shapes x 22 axes``."""
        return ""

    def set_projection(self, projection: FloatArray | None, names: Sequence[str] = ()) -> None:
        """Show W (n, m) with the names of its rows."""
        self._projection = projection

    def set_spectrum(
        self,
        eigenvalues: FloatArray | None,
        cumulative: FloatArray | None = None,
        count: int = 0,
        coverage: float | None = None,
    ) -> None:
        """Show eigenvalues (r,) mm^2, their cumulative shares (r,) 0..1, and how many axes were chosen."""

    def set_current(self, name: str | None) -> None:
        """Mark the row of a shape without telling anybody."""

    def set_axis(self, axis: int | None) -> None:
        """Mark the column of an axis, from 0, without telling anybody."""

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(296, 144)
