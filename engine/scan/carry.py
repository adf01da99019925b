"""Fiducials carried from one scan to another of a like face by what the two pictures show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.mesh import FloatArray
from engine.scan.mouth import INNER_FRACTIONS, MouthOpening, find_opening
from engine.scan.range_image import RangeImage

AGREES_PX = 1.5
"""A point that the flow there and back brings to within this distance of its start is taken to be certain."""

_PATCH_PX = 12
_WORK_PX = 640
"""Larger pictures are brought to this longer side before they are compared, pixels."""

_MARGIN = 0.3
"""What is compared around the fiducials, in shares of the face's larger side: points move, and flow needs room."""

Positions = Mapping[str, tuple[float, float]]
Picture = NDArray[Any]


@dataclass(frozen=True)
class Carried:
    """Where the fiducials of one scan lie on another.

    Attributes
    ----------
    positions : mapping of str to (x, y)
        Pixels of the target; those of the inner lips as well where its mouth is open.
    certain : frozenset of str
        Names that the pictures agree on; the others follow from these.
    opening : MouthOpening or None
        What was found between the target's lips.
    """

    positions: Positions
    certain: frozenset[str]
    opening: MouthOpening | None


def carry_fiducials(source: RangeImage, positions: Positions, target: RangeImage) -> Carried:
    """Return where the fiducials of ``source`` lie on ``target``.

    Parameters
    ----------
    source, target : RangeImage
        Two scans of one face, or of faces alike, from about the same side. Their colour pictures are compared, or
        their shaded ranges where one has no colour.
    positions : mapping of str to (x, y)
        Fiducials of the source, pixels.

    Notes
    -----
    Dense optical flow (dense inverse search) is computed both ways between the pictures, after the faces have been
    brought to one place and size. Points for which there and back disagree by more than `AGREES_PX` move as those
    around them do, by a smooth field through the certain ones. Points of the inner lips come from the opening of the
    mouth: skin that turns inwards has no likeness to follow.
    """
    names = tuple(positions)
    start = np.array([positions[name] for name in names], dtype=np.float64).reshape(-1, 2)
    if not len(names):
        return Carried({}, frozenset(), None)
    pictures = _pictures(source, target)
    placing = _placing(source, target)
    to_work, size = _window(_apply(placing, start), target)
    scale = float(to_work[0, 0])
    one = cv2.warpAffine(pictures[0], (to_work @ placing)[:2], size, flags=cv2.INTER_AREA)
    two = cv2.warpAffine(pictures[1], to_work[:2], size, flags=cv2.INTER_AREA)
    begun = _apply(to_work @ placing, start)
    ended = np.asarray(begun + _at(_flow(one, two), begun))
    back = np.asarray(ended + _at(_flow(two, one), ended))
    certain = np.hypot(*(back - begun).T) <= AGREES_PX * scale
    to_target = np.asarray(np.linalg.inv(to_work), dtype=np.float64)
    moved = _apply(to_target, _followed(begun, ended, certain, scale))
    found = {name: (float(x), float(y)) for name, (x, y) in zip(names, moved, strict=True)}
    opening = find_opening(target, found)
    if opening is not None:
        found |= opening.inner
    sure = {name for name, is_certain in zip(names, certain, strict=True) if is_certain}
    return Carried(found, frozenset(sure - set(INNER_FRACTIONS)), opening)


def _window(places: FloatArray, target: RangeImage) -> tuple[FloatArray, tuple[int, int]]:
    """Return the map (3, 3) from target pixels into the window around the face that is compared, and its size."""
    edges = np.array([[0.0, 0.0], [target.width - 1.0, target.height - 1.0]])
    margin = _MARGIN * float(np.ptp(places, axis=0).max()) + 2 * _PATCH_PX
    low = np.clip(places.min(axis=0) - margin, edges[0], edges[1] - 2 * _PATCH_PX)
    high = np.clip(places.max(axis=0) + margin, low + 2 * _PATCH_PX, edges[1])
    scale = min(1.0, _WORK_PX / max(target.width, target.height))
    size = np.maximum(np.ceil(scale * (high - low)), 2 * _PATCH_PX).astype(int)
    shift = -scale * low
    return np.array([[scale, 0.0, shift[0]], [0.0, scale, shift[1]], [0.0, 0.0, 1.0]]), (int(size[0]), int(size[1]))


def _pictures(*scans: RangeImage) -> list[Picture]:
    """Return one grey picture per scan: colour where all have it, else the range shaded from above."""
    if all(scan.colour is not None for scan in scans):
        return [cv2.cvtColor(np.array(scan.colour), cv2.COLOR_RGB2GRAY) for scan in scans]
    return [_shaded(scan) for scan in scans]


def _shaded(scan: RangeImage) -> Picture:
    """Return the range image lit from above, 0 where nothing was measured."""
    known = scan.valid
    level = np.median(scan.points[known][:, 2])
    height = cv2.GaussianBlur(np.where(known, scan.points[..., 2], level), (0, 0), 1.5)
    slopes = [np.gradient(height, axis=axis) / _pitch(scan, axis) for axis in (0, 1)]
    light = 128.0 + 110.0 * slopes[0] / np.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2)
    picture: Picture = np.where(known, np.clip(light, 1, 255), 0).astype(np.uint8)
    return picture


def _pitch(scan: RangeImage, axis: int) -> float:
    """Return the median distance of neighbouring pixels' points along rows (axis 0) or columns, mm."""
    steps = np.abs(np.diff(scan.points[..., 1 - axis], axis=axis))
    steps = steps[np.isfinite(steps)]
    return float(np.median(steps)) if len(steps) and np.median(steps) > 0 else 1.0


def _placing(source: RangeImage, target: RangeImage) -> FloatArray:
    """Return the (3, 3) map from source pixels to target pixels that puts the measured parts over each other."""
    boxes = []
    for scan in (source, target):
        rows, columns = np.nonzero(scan.valid)
        near = scan.points[rows, columns, 2]
        face = near >= np.percentile(near, 98) - 150.0  # what stands far behind the nearest part is background
        boxes.append((columns[face].mean(), rows[face].mean(), np.sqrt(columns[face].var() + rows[face].var())))
    (x1, y1, size1), (x2, y2, size2) = boxes
    same_size = (source.width, source.height) == (target.width, target.height)
    factor = float(np.clip(size2 / max(size1, 1e-9), 0.2, 5.0))
    if same_size and abs(np.log(factor)) < 0.15:
        factor = 1.0
    shift = np.array([x2 - factor * x1, y2 - factor * y1])
    if factor == 1.0 and np.hypot(*shift) < 0.05 * max(target.width, target.height):
        shift[:] = 0.0  # such a step the flow finds better than a mean over holes and hair
    return np.array([[factor, 0.0, shift[0]], [0.0, factor, shift[1]], [0.0, 0.0, 1.0]])


def _flow(one: Picture, two: Picture) -> Picture:
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    search.setFinestScale(0)
    search.setPatchSize(_PATCH_PX)
    return np.asarray(search.calc(one, two, None))  # type: ignore[call-overload]


def _at(flow: Picture, places: FloatArray) -> FloatArray:
    """Return the flow (k, 2) at places (k, 2), bilinear; that of the border outside."""
    grid = places.astype(np.float32)
    values: FloatArray = cv2.remap(
        flow, grid[:, None, :1], grid[:, None, 1:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )[:, 0].astype(np.float64)
    return values


def _followed(begun: FloatArray, ended: FloatArray, certain: NDArray[np.bool_], scale: float) -> FloatArray:
    """Return the ends, those of uncertain points moved as the certain ones around them move."""
    if certain.all() or certain.sum() < 3:
        return ended
    result = ended.copy()
    motion = ended[certain] - begun[certain]
    mean = np.median(motion, axis=0)
    distance = np.linalg.norm(begun[~certain, None] - begun[None, certain], axis=2)
    weights = 1.0 / (distance + 5.0 * scale) ** 3
    weights /= weights.sum(axis=1, keepdims=True)
    result[~certain] = begun[~certain] + mean + weights @ (motion - mean)
    return result


def _apply(matrix: FloatArray, points: FloatArray) -> FloatArray:
    moved: FloatArray = points @ matrix[:2, :2].T + matrix[:2, 2]
    return moved
