"""Signed values as colours: violet below zero, green above, the ground of the theme at zero."""

from __future__ import annotations

import numpy as np

from engine.mesh import FloatArray
from widgets import theme
from widgets.canvases.pictures import Picture

_ENDS = {"dark": ((186, 136, 232), (126, 204, 120)), "light": ((112, 58, 160), (28, 118, 52))}
_ZERO = {"dark": (34, 36, 39), "light": (250, 250, 250)}


def diverging(values: FloatArray) -> Picture:
    """Return colours (..., 3) uint8 of values -1..1; what lies beyond is shown as the end, NaN as the panel."""
    current = theme.current()
    low, high = (np.array(end, dtype=np.float64) for end in _ENDS[current.name])
    zero = np.array(_ZERO[current.name], dtype=np.float64)
    good = np.isfinite(values)
    share = np.clip(np.where(good, values, 0.0), -1.0, 1.0)[..., None]
    # A root draws small values away from zero: most of W is small.
    strength = np.abs(share) ** 0.8
    colours = zero + strength * (np.where(share < 0, low, high) - zero)
    panel = current.colour("panel")
    colours[~good] = (panel.red(), panel.green(), panel.blue())
    made: Picture = np.round(colours).astype(np.uint8)
    return made
