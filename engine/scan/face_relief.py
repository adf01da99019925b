"""Where a face is in the mid-plane of a symmetric surface: its relief compared with that of an average face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.mesh import BoolArray, FloatArray

STEP_MM = 6.0
"""Distance of neighbouring values of ``RELIEF``."""

TOP_MM = 66.0
"""Height of its first row above the tip of the nose."""

RELIEF = (
    (-17, -17, -17, -18, -20, -22, -26, -31, -38),
    (-16, -16, -17, -18, -19, -21, -25, -29, -36),
    (-17, -17, -17, -19, -20, -22, -25, -29, -36),
    (-17, -18, -20, -21, -22, -23, -25, -29, -36),
    (-18, -19, -22, -23, -24, -25, -27, -30, -37),
    (-18, -19, -23, -25, -26, -27, -29, -32, -37),
    (-16, -19, -25, -28, -29, -30, -31, -34, -39),
    (-13, -17, -24, -28, -30, -30, -32, -35, -39),
    (-10, -13, -21, -26, -28, -30, -31, -34, -38),
    (-6, -9, -16, -24, -28, -29, -31, -33, -36),
    (-2, -5, -12, -21, -26, -28, -30, -32, -36),
    (0, -2, -10, -21, -25, -27, -29, -32, -37),
    (-4, -8, -14, -21, -24, -26, -29, -33, -38),
    (-9, -12, -16, -19, -22, -25, -29, -34, -39),
    (-10, -11, -13, -17, -21, -25, -29, -34, -41),
    (-9, -10, -13, -16, -21, -25, -30, -36, -43),
    (-10, -11, -13, -19, -22, -27, -32, -38, -46),
    (-11, -12, -15, -20, -24, -28, -34, -41, -50),
    (-16, -17, -19, -22, -26, -30, -36, -44, -54),
    (-20, -20, -22, -24, -28, -33, -39, -48, -60),
)
"""Depth in mm of an average face relative to the tip of the nose: rows from the forehead down, columns from the middle
outwards. The mean of the two heads of the bundled sample, both sides."""

_SCALES = np.array([0.5, 0.58, 0.68, 0.79, 0.92, 1.07, 1.25, 1.45])
_DEEPEST = 70.0
_CELL = 5.0


@dataclass(frozen=True)
class FaceMatch:
    """The place in the mid-plane that looks most like a face.

    Attributes
    ----------
    angle : float
        Direction out of the face, radians from the first axis of the plane to the second.
    up : int
        +1 where up is a quarter turn on from that, -1 where it is a quarter turn back.
    height, depth : float
        The tip of the nose, along up and out of the face, mm.
    scale : float
        Size relative to an average face.
    likeness : float
        Correlation with the average relief, once its general curvature is taken off, -1..1.
    """

    angle: float
    up: int
    height: float
    depth: float
    scale: float
    likeness: float


def find_faces(sideways: FloatArray, plane: FloatArray, angles: FloatArray, stride: int = 1) -> list[FaceMatch]:
    """Return the best match for each direction.

    Parameters
    ----------
    sideways : (k,) float
        Distance of points on the surface from the mid-plane, mm.
    plane : (k, 2) float
        Their coordinates in it, mm.
    angles : (a,) float
        Directions out of the face that are tried, radians.
    stride : int
        Only every so many heights are tried, of cells of 5 mm.
    """
    near = np.abs(sideways) < 48 * _SCALES[-1] + _CELL
    sideways, plane = np.abs(sideways[near]), plane[near]
    return [match for angle in angles for match in _best(sideways, plane, float(angle), stride)]


def refine_face(sideways: FloatArray, plane: FloatArray, start: FaceMatch) -> FaceMatch:
    """Return a match with the tilt that the average face has, from one found in a coarse search."""
    best = start
    angle = start.angle
    for _ in range(4):
        found = [m for m in find_faces(sideways, plane, np.array([angle])) if m.up == start.up]
        if not found:
            break
        best = found[0]
        slope = _tilt(sideways, plane, best)
        angle = best.angle + best.up * np.clip(slope, -0.25, 0.25)
        if abs(slope) < 0.005:
            break
    return best


def _columns() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return per value: relief (clamped), height and sideways, mm; weight; and the general shapes (v, 5)."""
    relief = np.maximum(np.array(RELIEF, dtype=np.float64), -_DEEPEST)
    rows, columns = relief.shape
    y = np.repeat(TOP_MM - STEP_MM * np.arange(rows), columns)
    x = np.tile(STEP_MM * np.arange(columns), rows)
    weight = np.where(x > 0, 1.0, 0.5)
    shapes = np.stack([np.ones_like(x), y / 50, (x / 50) ** 2, (y / 50) ** 2, (x / 50) ** 4], axis=1)
    return relief.ravel(), y, x, weight, shapes


_DEPTH, _Y, _X, _WEIGHT, _SHAPES = _columns()
_ROOT = np.sqrt(_WEIGHT)
_GENERAL = np.linalg.qr(_SHAPES * _ROOT[:, None])[0]


def _special(depth: FloatArray) -> FloatArray:
    """Return weighted reliefs (n, v) without what a smooth bump has too."""
    values = depth * _ROOT
    result: FloatArray = values - (values @ _GENERAL) @ _GENERAL.T
    return result


_TEMPLATE = _special(_DEPTH[None])[0]
_STRENGTH = float(np.linalg.norm(_TEMPLATE))


def _front(sideways: FloatArray, plane: FloatArray, angle: float) -> tuple[FloatArray, BoolArray, float] | None:
    """Return the foremost depth in cells (rows up, columns outwards), which are filled, and the lowest height."""
    forward, up = _axes(angle)
    depth, height = plane @ forward, plane @ up
    low = float(height.min())
    rows = int((height.max() - low) / _CELL) + 1
    columns = int((48 * _SCALES[-1] + _CELL) / _CELL) + 1
    if rows < 4 or rows > 2000:
        return None
    cell = ((height - low) / _CELL).astype(int) * columns + np.minimum((sideways / _CELL).astype(int), columns - 1)
    front = np.full(rows * columns, -np.inf)
    np.maximum.at(front, cell, depth)
    return _without_holes(front.reshape(rows, columns), low)


def _without_holes(front: FloatArray, low: float) -> tuple[FloatArray, BoolArray, float]:
    rows, columns = front.shape
    filled = np.isfinite(front)
    # A cell that no point happens to lie in takes the mean of its filled neighbours.
    padded = np.pad(np.where(filled, front, 0.0), 1)
    known = np.pad(filled.astype(float), 1)
    total, number = np.zeros(front.shape), np.zeros(front.shape)
    for i in range(3):
        for j in range(3):
            total += padded[i : i + rows, j : j + columns]
            number += known[i : i + rows, j : j + columns]
    hole = ~filled & (number >= 3)
    front[hole] = total[hole] / number[hole]
    known_now: BoolArray = filled | hole
    return front, known_now, low


def _best(sideways: FloatArray, plane: FloatArray, angle: float, stride: int) -> list[FaceMatch]:
    seen = _front(sideways, plane, angle)
    if seen is None:
        return []
    front, filled, low = seen
    rows, columns = front.shape
    result = []
    for up in (1, -1):
        best: FaceMatch | None = None
        for scale in _SCALES:
            noses = np.arange(0, rows, stride)
            row = noses[:, None] + np.rint(up * _Y * scale / _CELL).astype(int)[None]
            column = np.minimum((_X * scale / _CELL).astype(int), columns - 1)
            inside = (row >= 0) & (row < rows)
            row = np.clip(row, 0, rows - 1)
            valid = inside & filled[row, column]
            depth = np.where(valid, front[row, column], -np.inf)
            share = valid @ _WEIGHT / _WEIGHT.sum()
            usable = share > 0.8
            if not usable.any():
                continue
            depth = depth[usable]
            middle = depth[:, (_X == 0) & (np.abs(_Y) <= 9)].max(axis=1)
            top = np.where(np.isfinite(middle), middle, depth.max(axis=1))[:, None]
            relief = np.clip((depth - top) / scale, -_DEEPEST, 30.0)
            special = _special(relief)
            strength = np.linalg.norm(special, axis=1)
            product = special @ _TEMPLATE
            correlation = product / np.maximum(strength * _STRENGTH, 1e-9)
            amount = product / _STRENGTH**2
            # A bump that is much flatter or much rougher than a face is none, whatever its shape.
            score = correlation * np.clip(amount / 0.45, 0, 1) * np.clip(2.5 / np.maximum(amount, 1e-9), 0, 1)
            k = int(score.argmax())
            if best is None or score[k] > best.likeness:
                height = low + (noses[usable][k] + 0.5) * _CELL
                best = FaceMatch(angle, up, float(up * height), float(top[k, 0]), float(scale), float(score[k]))
        if best is not None:
            result.append(best)
    return result


def _tilt(sideways: FloatArray, plane: FloatArray, match: FaceMatch) -> float:
    """Return by how many radians the face at a match looks further up (+) or down than the average one."""
    seen = _front(sideways, plane, match.angle)
    if seen is None:
        return 0.0
    front, filled, low = seen
    row = np.floor((match.up * match.height + match.up * _Y * match.scale - low) / _CELL).astype(int)
    column = np.minimum((_X * match.scale / _CELL).astype(int), front.shape[1] - 1)
    inside = (row >= 0) & (row < front.shape[0])
    row = np.clip(row, 0, front.shape[0] - 1)
    valid = inside & filled[row, column] & (_DEPTH > -45)
    difference = (front[row, column][valid] - match.depth) / match.scale - _DEPTH[valid]
    y = _Y[valid]
    keep = np.abs(difference - np.median(difference)) < 25
    if keep.sum() < 30:
        return 0.0
    slope = np.polyfit(y[keep], difference[keep], 1)[0]
    return float(np.arctan(-slope))


def _axes(angle: float) -> tuple[FloatArray, FloatArray]:
    forward = np.array([np.cos(angle), np.sin(angle)])
    return forward, np.array([-forward[1], forward[0]])
