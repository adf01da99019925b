"""How the views of the basis stage are arranged and what they show, apart from the data: one small value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

HAND, QUASI, CHANGE, ORIGINAL, BY_HAND, BY_QUASI, BY_PCA = range(7)
"""Indices of the views; shapes above, one frame of the performance below."""
VIEWS = 7
FRAME_VIEWS = (ORIGINAL, BY_HAND, BY_QUASI, BY_PCA)

Mode = Literal["side", "overlay", "wipe", "grid"]
MODES: Mapping[str, str] = {"side": "Side by side", "overlay": "Overlay", "wipe": "Wipe", "grid": "Grid"}
"""Ways to compare a hand shape with its quasi-eigen shape, as they are called."""
START_RANGE_MM = (0.0, 3.0)

Place = tuple[int, int, int, int]
"""Row, column, rows and columns of a view in a grid."""


@dataclass(frozen=True)
class ViewState:
    """What the user has switched on.

    Attributes
    ----------
    mode : str
        A key of ``MODES``.
    heat : bool
        Whether the change of a shape has a view of its own.
    clip_heat : bool
        Whether reconstructions wear their error over the whole clip.
    pca : bool
        Whether the reconstruction by the PCA basis is shown too.
    flipped : bool
        Whether the quasi-eigen shape stands where the hand shape does.
    wipe : float
        Where the line of the wipe stands, 0..1 of the view's width.
    """

    mode: Mode = "side"
    heat: bool = True
    clip_heat: bool = False
    wire: bool = False
    markers: bool = True
    pca: bool = False
    textured: bool = True
    flipped: bool = False
    wipe: float = 0.5

    @property
    def together(self) -> bool:
        """Whether both shapes stand in one view."""
        return self.mode in ("overlay", "wipe")


def places(state: ViewState) -> dict[int, Place]:
    """Return which views are seen and where, in a grid of two rows and twelve columns."""
    if state.together:
        above = {HAND: (0, 0, 1, 8), CHANGE: (0, 8, 1, 4)} if state.heat else {HAND: (0, 0, 1, 12)}
    elif state.heat:
        above = {HAND: (0, 0, 1, 4), QUASI: (0, 4, 1, 4), CHANGE: (0, 8, 1, 4)}
    else:
        above = {HAND: (0, 0, 1, 6), QUASI: (0, 6, 1, 6)}
    below = FRAME_VIEWS if state.pca else FRAME_VIEWS[:3]
    step = 12 // len(below)
    return above | {view: (1, step * k, 1, step) for k, view in enumerate(below)}
