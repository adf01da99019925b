"""Eigenfaces: a slider per axis of the motion, in standard deviations."""

from __future__ import annotations

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget

from engine.mesh import FloatArray


class EigenPanel(QWidget):
    """A slider per axis, -3..3 standard deviations, with the trained range shaded.

    Signals
    -------
    values_dragged(object), values_set(object)
        (m,) float array in standard deviations: while a slider moves, and when it is let go.
    axis_chosen(int)
        The axis the user works on, from 0.
    """

    values_dragged = Signal(object)
    values_set = Signal(object)
    axis_chosen = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._values: FloatArray | None = None

    @property
    def note(self) -> str:
        """What stands beside the dock's name: how many axes there are."""
        return ""

    @property
    def values(self) -> FloatArray | None:
        """(m,) standard deviations as the sliders stand."""
        return self._values

    def set_axes(
        self, deviations: FloatArray | None, shares: FloatArray | None = None, ranges: FloatArray | None = None
    ) -> None:
        """Show axes.

        Parameters
        ----------
        deviations : (m,) float, or None
            Standard deviation of each axis, mm (root of the eigenvalue).
        shares : (m,) float, optional
            Share of the variance, 0..1.
        ranges : (m, 2) float, optional
            Least and largest coordinate of the training frames, in standard deviations.
        """

    def set_values(self, values: FloatArray) -> None:
        """Show other values (m,) without telling anybody."""

    def set_axis(self, axis: int | None) -> None:
        """Mark an axis, from 0, without telling anybody."""

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(296, 240)
