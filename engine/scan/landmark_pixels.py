"""Landmarks of any origin as pixels of one scan: scaled, projected, and looked at where they fall."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from engine.errors import InputError
from engine.geometry.sampling import valid_share
from engine.landmarks import LandmarkDefinition, Side, inside
from engine.mesh import BoolArray, FloatArray
from engine.scan.range_image import RangeImage
from engine.scan.rays import Rays

HIDDEN_MM = 10.0
"""A point of a mesh that lies farther than this behind the surface in view is hidden by it."""

_ROUND_PX = 2
_LEAST_SHARE = 0.25
_FEWEST_PAIRS = 2


class Place(StrEnum):
    """Where a point falls on a scan."""

    OK = "ok"
    HOLE = "on a hole"
    OUTSIDE = "outside"


@dataclass(frozen=True)
class ProjectedLandmarks:
    """Points in space as pixels: ``pixels`` (n, 2), NaN where there is no place, behind the camera or hidden;
    ``hidden`` (n,) those that another surface covers."""

    pixels: FloatArray
    hidden: BoolArray


def scale_pixels(points: FloatArray, made_on: tuple[int, int], used_on: tuple[int, int]) -> FloatArray:
    """Return pixels (n, 2) of a picture of one (width, height) as pixels of the same picture at another.

    Raises
    ------
    InputError
        When the two shapes differ by more than a pixel's rounding: then it is not the same picture.
    """
    (width, height), (new_width, new_height) = made_on, used_on
    across, down = new_width / width, new_height / height
    if abs(across - down) * max(width, height) > _ROUND_PX * max(1.0, across, down):
        sizes = f"{width} x {height} and {new_width} x {new_height}"
        raise InputError("image size", f"the pictures have other proportions ({sizes})", "give the points of this scan")
    return (np.asarray(points, dtype=np.float64) + 0.5) * (across, down) - 0.5


def project_points(points: FloatArray, scan: RangeImage, hidden_mm: float = HIDDEN_MM) -> ProjectedLandmarks:
    """Return where points in space fall in a scan's picture.

    Parameters
    ----------
    points : (n, 3) float
        In mm, in the scan's frame; NaN where there is none.
    scan : RangeImage
        With its camera, or with points that follow straight rays, which then stand for it.
    hidden_mm : float
        A point that lies farther than this behind the surface in view is hidden.

    Raises
    ------
    InputError
        When the scan has no camera and its points follow no rays.
    """
    points = np.asarray(points, dtype=np.float64)
    depth = -points[:, 2]
    ahead = np.isfinite(points).all(axis=1) & (depth > 0)
    pixels = np.full((len(points), 2), np.nan)
    pixels[ahead] = _project(points[ahead], scan)
    surface = _nearest_depth(scan, pixels)
    with np.errstate(invalid="ignore"):
        hidden = ahead & (depth > surface + hidden_mm)
    pixels[hidden] = np.nan
    return ProjectedLandmarks(pixels, hidden)


def _project(points: FloatArray, scan: RangeImage) -> FloatArray:
    if scan.camera is not None:
        return scan.camera.project(points)
    rays = Rays.of(scan)
    # x and y are linear in u and v at a known depth: two equations for two unknowns.
    depth = -points[:, 2]
    offset, by_u, by_v = (rays.coefficients[:, k] + depth[:, None] * rays.coefficients[:, k + 3] for k in range(3))
    system = np.stack([by_u, by_v], axis=2)
    if not rays.regular or not np.linalg.det(system).all():
        problem = "its camera is not known, so points in space have no pixels"
        raise InputError("scan", problem, "give pixels, or a scan with its camera")
    return np.asarray(np.linalg.solve(system, (points[:, :2] - offset)[..., None])[..., 0], dtype=np.float64)


def _nearest_depth(scan: RangeImage, pixels: FloatArray) -> FloatArray:
    """Return the depth (n,) of the pixels under positions (n, 2); NaN outside and on holes."""
    found = np.full(len(pixels), np.nan)
    for k, (x, y) in enumerate(pixels.tolist()):
        if inside(x, y, scan.width, scan.height):
            column, row = min(int(x + 0.5), scan.width - 1), min(int(y + 0.5), scan.height - 1)
            found[k] = -scan.points[row, column, 2]
    return found


def places(positions: Mapping[str, tuple[float, float]], scan: RangeImage) -> dict[str, Place]:
    """Return where each fiducial falls: on the scan, on missing pixels, or outside the picture."""
    found: dict[str, Place] = {}
    for name, (x, y) in positions.items():
        if not inside(x, y, scan.width, scan.height):
            found[name] = Place.OUTSIDE
            continue
        near = np.array([[min(max(x, 0.0), scan.width - 1.0), min(max(y, 0.0), scan.height - 1.0)]])
        found[name] = Place.OK if valid_share(scan.valid, near)[0] >= _LEAST_SHARE else Place.HOLE
    return found


def looks_mirrored(positions: Mapping[str, tuple[float, float]], scheme: Iterable[LandmarkDefinition]) -> bool:
    """Whether left and right look swapped: the subject's left is on the left of a face that is the right way up.

    A face that lies or stands on its head is no mirror image. False where too few pairs are there to tell.
    """
    definitions = {entry.name: entry for entry in scheme if entry.name in positions}
    pairs = [
        (entry.name, entry.mirror)
        for entry in definitions.values()
        if entry.side == Side.LEFT and entry.mirror in definitions
    ]
    high = [name for name, entry in definitions.items() if entry.group in _HIGH]
    low = [name for name, entry in definitions.items() if entry.group in _LOW]
    if len(pairs) < _FEWEST_PAIRS or not high or not low:
        return False
    across = np.mean([np.subtract(positions[left], positions[right]) for left, right in pairs], axis=0)
    down = np.mean([positions[name] for name in low], axis=0) - np.mean([positions[name] for name in high], axis=0)
    return bool(across[0] * down[1] - across[1] * down[0] < 0)


_HIGH, _LOW = frozenset(("forehead", "brows", "eyes")), frozenset(("mouth", "jaw", "inner lips"))
