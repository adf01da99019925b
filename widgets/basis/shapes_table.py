"""The table of the shapes: thumbnail, name, change in mm, cosine to the hand-made shape."""

from __future__ import annotations

from dataclasses import dataclass, field

from widgets.canvases.pictures import Picture

COSINE_LIMIT = 0.85


@dataclass(frozen=True)
class ShapeRow:
    """One shape as it is listed.

    Parameters
    ----------
    name : str
        Unique in the rig.
    change_mm : float, optional
        Mean distance in mm between the shape in use and its hand-made form.
    cosine : float, optional
        Cosine between them; NaN where the shape does not move.
    tip : str
        What else is known, a line or two.
    thumbnail : (h, w, 3) uint8, optional
        Any size; the middle is shown in a square.
    """

    name: str
    change_mm: float | None = None
    cosine: float | None = None
    tip: str = ""
    thumbnail: Picture | None = field(default=None, compare=False, repr=False)
