"""Where the mouth of a scan is open: the pit between the lips, and the points on the lips' inner borders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from engine.mesh import BoolArray, FloatArray
from engine.scan.range_image import RangeImage

CORNERS = ("mouth_right", "mouth_left")
BORDERS = ("lip_upper", "lip_lower")

PIT_MM = 4.0
"""What lies this far behind the lips around it, or was not measured at all, is not lip."""

INNER_FRACTIONS = {
    "lip_upper_inner_right": 0.2,
    "lip_upper_inner": 0.5,
    "lip_upper_inner_left": 0.8,
    "lip_lower_inner_right": 0.25,
    "lip_lower_inner": 0.5,
    "lip_lower_inner_left": 0.75,
}
"""Where the points of the inner borders lie between the corners, from the right one."""

_SIDE_SHARE = 0.4
"""How far a side point stands off the line of the corners, in shares of the middle one, where no opening is seen."""

_SAMPLES_PER_WIDTH = 96
_OPEN_FROM = 0.05
"""Share of the mouth's width that the opening must be high in its middle to count as open."""


@dataclass(frozen=True)
class MouthOpening:
    """The opening of a mouth.

    Attributes
    ----------
    height_fraction : float
        Height in the middle over the distance of the corners, both in pixels.
    inner : mapping of str to (x, y)
        The fiducials of the inner lip borders (``lip_upper_inner_right`` ...), pixels.
    """

    height_fraction: float
    inner: Mapping[str, tuple[float, float]]


def find_opening(scan: RangeImage, positions: Mapping[str, tuple[float, float]]) -> MouthOpening | None:
    """Return the opening between the lips, or None where the lips meet or their points are not known.

    Parameters
    ----------
    scan : RangeImage
        mm; an open mouth shows as a pit: nothing measured, or teeth and tongue well behind the lips.
    positions : mapping of str to (x, y)
        Must hold both corners and the outer mid-points of both lips (pixels) for anything to be found.

    Notes
    -----
    The neighbourhood of the mouth is resampled along its own axes, pits of the depth are closed (grey closing), and
    what lies deeper than the closed surface is opening; the borders are read off at three places between the corners.
    """
    if any(name not in positions for name in (*CORNERS, *BORDERS)):
        return None
    right, left, upper, lower = (np.array(positions[name], dtype=np.float64) for name in (*CORNERS, *BORDERS))
    width = float(np.hypot(*(left - right)))
    if width < 4.0 or not np.isfinite(width):
        return None
    along = (left - right) / width
    down = np.array([-along[1], along[0]])
    heights = sorted(float((border - right) @ down) for border in (upper, lower))
    step = width / _SAMPLES_PER_WIDTH
    margin = int(0.3 * _SAMPLES_PER_WIDTH)
    rows = np.arange(int(np.floor(heights[0] / step)) - margin, int(np.ceil(heights[1] / step)) + margin + 1)
    columns = np.arange(-margin, _SAMPLES_PER_WIDTH + margin + 1)
    if len(rows) > 8 * _SAMPLES_PER_WIDTH:
        return None
    places = right + step * (columns[None, :, None] * along + rows[:, None, None] * down)
    pit = _pits(_depth(scan, places))
    between = (rows * step >= heights[0]) & (rows * step <= heights[1])
    opening = _main_part(pit & between[:, None] & (columns >= 0) & (columns <= _SAMPLES_PER_WIDTH), margin)
    middle = _rims(opening, margin, 0.5)
    if middle is None or middle[1] - middle[0] < _OPEN_FROM * _SAMPLES_PER_WIDTH:
        return None
    inner = {}
    for name, fraction in INNER_FRACTIONS.items():
        rims = _rims(opening, margin, fraction)
        lower_lip = name.startswith("lip_lower")
        off = _SIDE_SHARE * (middle[lower_lip] + rows[0]) if rims is None else rims[lower_lip] + rows[0]
        place = right + step * (fraction * _SAMPLES_PER_WIDTH * along + off * down)
        inner[name] = (float(place[0]), float(place[1]))
    return MouthOpening((middle[1] - middle[0]) / _SAMPLES_PER_WIDTH, inner)


def _depth(scan: RangeImage, places: FloatArray) -> FloatArray:
    """Height towards the scanner (h, w) at pixel places (h, w, 2), nearest pixel; NaN where nothing was measured."""
    pixels = np.rint(places).astype(np.int64)
    x, y = pixels[..., 0], pixels[..., 1]
    within = (x >= 0) & (x < scan.width) & (y >= 0) & (y < scan.height)
    values = scan.points[np.clip(y, 0, scan.height - 1), np.clip(x, 0, scan.width - 1), 2]
    depth: FloatArray = np.where(within, values, np.nan)
    return depth


def _pits(depth: FloatArray) -> BoolArray:
    """Whether a sample lies more than `PIT_MM` behind the surface around it, or holds nothing within it."""
    known = np.isfinite(depth)
    if not known.any():
        return np.zeros(depth.shape, dtype=bool)
    floor = float(np.min(depth[known])) - 10 * PIT_MM
    filled = np.where(known, depth, floor).astype(np.float32)
    calm = cv2.medianBlur(filled, 3)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (_SAMPLES_PER_WIDTH // 2 * 2 + 1,) * 2)
    pits: BoolArray = calm < cv2.morphologyEx(calm, cv2.MORPH_CLOSE, kernel, borderType=cv2.BORDER_REPLICATE) - PIT_MM
    return pits


def _main_part(mask: BoolArray, margin: int) -> BoolArray:
    """Return the largest connected part of a mask that crosses the middle between the corners."""
    count, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    middle = labels[:, margin + _SAMPLES_PER_WIDTH // 2]
    sizes = np.bincount(middle[middle > 0], minlength=count)
    part: BoolArray = (labels == sizes.argmax()) & mask if sizes.any() else np.zeros(mask.shape, dtype=bool)
    return part


def _rims(opening: BoolArray, margin: int, fraction: float) -> tuple[float, float] | None:
    """Return the rows where the opening begins and ends at a place between the corners; None where there is none."""
    column = margin + round(fraction * _SAMPLES_PER_WIDTH)
    inside = np.flatnonzero(opening[:, column - 1 : column + 2].all(axis=1))
    return (inside[0] - 0.5, inside[-1] + 0.5) if len(inside) else None
