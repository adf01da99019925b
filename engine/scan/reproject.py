"""Points of one picture of a mesh found again in another picture of it, through space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.geometry.sampling import sample_bilinear
from engine.mesh import BoolArray, FloatArray
from engine.scan.mesh_view import MeshView
from engine.scan.range_image import RangeImage

_STEP_MM = 5.0
_REACH_PX = 4
_HIDDEN_MM = 5.0


@dataclass(frozen=True)
class Reprojected:
    """Pixels (k, 2) in the new picture, NaN where lost; why: ``unmeasured``, ``outside`` or ``hidden`` (k,)."""

    pixels: FloatArray
    unmeasured: BoolArray
    outside: BoolArray
    hidden: BoolArray


def reproject(
    pixels: FloatArray, old: tuple[RangeImage, MeshView], new: tuple[RangeImage, MeshView], scale: float = 1.0
) -> Reprojected:
    """Return where points of one view of a mesh lie in another.

    Parameters
    ----------
    pixels : (k, 2) float
        In the old picture.
    old, new : (RangeImage, MeshView)
        What was seen, and from where.
    scale : float
        New millimetres in an old one, where the unit of the mesh has changed too.
    """
    pixels = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    placed = old[1].into_mesh(_points(old[0], pixels)) * scale
    result = new[1].project(placed)
    unmeasured: BoolArray = np.asarray(np.isnan(placed).any(axis=1), dtype=bool)
    limit = np.array([new[0].width - 1, new[0].height - 1])
    with np.errstate(invalid="ignore"):
        inside: BoolArray = np.asarray(((result >= 0) & (result <= limit)).all(axis=1), dtype=bool)
    outside = ~unmeasured & ~inside
    seen = _points(new[0], np.where(inside[:, None], result, 0.0))
    expected = new[1].into_camera(placed)
    with np.errstate(invalid="ignore"):
        hidden = inside & ~(np.abs(seen[:, 2] - expected[:, 2]) <= _HIDDEN_MM * scale_of(new))
    result = np.where((inside & ~hidden)[:, None], result, np.nan)
    return Reprojected(result, unmeasured, outside, hidden)


def scale_of(seen: tuple[RangeImage, MeshView]) -> float:
    """Return the millimetres of a pixel at the middle of the picture, and 1 where it is finer."""
    _, view = seen
    return max(1.0, view.distance_mm / view.camera.fy)


def _points(scan: RangeImage, pixels: FloatArray) -> FloatArray:
    """Return the points (k, 3) at pixels (k, 2): between the neighbours, else at the depth of the nearest measured."""
    found, _ = sample_bilinear(scan.points, pixels, scan.valid, step=_STEP_MM)
    assert scan.camera is not None
    for k in np.flatnonzero(np.isnan(found).any(axis=1)):
        x, y = pixels[k]
        left, top = max(0, int(x) - _REACH_PX), max(0, int(y) - _REACH_PX)
        depth = scan.points[top : int(y) + _REACH_PX + 2, left : int(x) + _REACH_PX + 2, 2]
        rows, columns = np.nonzero(~np.isnan(depth))
        if not len(rows):
            continue
        nearest = int(np.argmin((columns + left - x) ** 2 + (rows + top - y) ** 2))
        far = -float(depth[rows[nearest], columns[nearest]])
        camera = scan.camera
        found[k] = (x - camera.cx) / camera.fx * far, -(y - camera.cy) / camera.fy * far, -far
    return found
