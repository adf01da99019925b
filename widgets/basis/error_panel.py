"""The reproduction error: three bases under three bounds, and the checks that say whether they mean something."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget

AlphaTable = Mapping[str, Mapping[str, tuple[float, float]]]
"""Basis -> bounds -> alpha in %: mean over frames, pooled."""


@dataclass(frozen=True)
class BasisFigures:
    """What the checks judge; None where it is not known yet.

    Parameters
    ----------
    hand_ratio : float, optional
        Alpha by hand over alpha by quasi-eigen, both in the bounds in use.
    pca_ratio : float, optional
        Alpha by quasi-eigen over alpha of free PCA.
    weight_p99 : float, optional
        99th percentile of the absolute quasi-eigen weights.
    median_cosine : float, optional
        Median over the shapes of the cosine to the hand-made shape.
    rank : int, optional
        Rank of W.
    shapes, axes : int
        n and m.
    """

    hand_ratio: float | None = None
    pca_ratio: float | None = None
    weight_p99: float | None = None
    median_cosine: float | None = None
    rank: int | None = None
    shapes: int = 0
    axes: int = 0


class ErrorPanel(QWidget):
    """Table of alpha and table of checks.

    Signals
    -------
    bounds_chosen(str)
        Key of ``words.BOUNDS``.
    statistic_chosen(str)
        ``mean`` or ``pooled``.
    """

    bounds_chosen = Signal(str)
    statistic_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._alpha: AlphaTable | None = None
        self._bounds, self._statistic = "-1..2", "mean"
        self._mask, self._frames, self._origin = "", 0, ""

    @property
    def note(self) -> str:
        """What stands beside the dock's name: mask, statistic and number of frames."""
        return ""

    def set_alpha(self, alpha: AlphaTable | None) -> None:
        """Show errors in %, or that there are none yet."""
        self._alpha = alpha

    def set_bounds(self, bounds: str) -> None:
        """Mark the bounds in use without telling anybody."""
        self._bounds = bounds

    def set_statistic(self, statistic: str) -> None:
        """Show ``mean`` or ``pooled`` without telling anybody."""
        self._statistic = statistic

    def set_measure(self, mask: str, frames: int, origin: str = "centroid of the neutral face") -> None:
        """Name the vertices and frames that are measured, and the origin of |v*|."""
        self._mask, self._frames, self._origin = mask, frames, origin

    def set_figures(self, figures: BasisFigures | None) -> None:
        """Judge the basis."""

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(296, 232)
