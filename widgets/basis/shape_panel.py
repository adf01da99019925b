"""One shape between its hand-made form and its quasi-eigen form."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget

from widgets.basis.shapes_table import COSINE_LIMIT


@dataclass(frozen=True)
class ShapeFacts:
    """Figures of a shape.

    Parameters
    ----------
    name : str
    amount : float
        0 the hand-made shape, 1 the quasi-eigen one.
    change_mm : float, optional
        Mean distance from the hand-made shape in mm, at this amount.
    residual_mm : float, optional
        RMS of what the axes cannot show of the hand-made shape, mm.
    residual_fraction : float, optional
        The same as a share of the shape's size, 0..1.
    cosine : float, optional
        Between the hand-made shape and the one in use.
    """

    name: str
    amount: float = 1.0
    change_mm: float | None = None
    residual_mm: float | None = None
    residual_fraction: float | None = None
    cosine: float | None = None


class ShapePanel(QWidget):
    """Slider hand .. quasi-eigen and the figures of a shape.

    Signals
    -------
    amount_dragged(float)
        While the slider moves.
    amount_set(float)
        When it is let go, or moved by keys or typed.
    """

    amount_dragged = Signal(float)
    amount_set = Signal(float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._facts: ShapeFacts | None = None
        self._count = 1
        self._limit = COSINE_LIMIT

    @property
    def note(self) -> str:
        """What stands beside the dock's name: the shape, or how many are meant."""
        return "" if self._facts is None else self._facts.name

    def set_shape(self, facts: ShapeFacts | None, count: int = 1) -> None:
        """Show a shape; ``count`` says how many marked shapes the slider moves together."""
        self._facts, self._count = facts, count

    def set_cosine_limit(self, limit: float) -> None:
        """Judge the cosine by another limit."""
        self._limit = limit

    def set_live_alpha(self, mean: float | None, pooled: float | None = None) -> None:
        """Show the reproduction error in % that the slider's place would give; ``None`` when it is not known."""

    def set_available(self, available: bool, reason: str = "") -> None:
        """Allow to move the slider, or say why not."""

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(296, 104)
