"""The mirror plane of a surface, found although only a part of it is symmetric."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from engine.mesh import FloatArray

_CELLS = 56
_DIRECTIONS = 300
_OFFSETS = np.linspace(-0.25, 0.25, 21)
_COARSE, _FINE = 0.06, 0.012


@dataclass(frozen=True)
class MirrorPlane:
    """Points x with normal . x = offset; ``score`` 0..1 is the share of the surface that the mirror carries onto it."""

    normal: FloatArray
    offset: float
    score: float

    def reflect(self, points: FloatArray) -> FloatArray:
        """Return the mirror image of points (k, 3)."""
        reflected: FloatArray = points - 2 * np.outer(points @ self.normal - self.offset, self.normal)
        return reflected


def mirror_planes(points: FloatArray, normals: FloatArray, count: int = 3) -> list[MirrorPlane]:
    """Return up to ``count`` different mirror planes, the best first.

    Planes in all directions are scored in a grid of distances; the best are refined by robust Gauss-Newton steps from
    reflected points to the tangent planes of the nearest ones, where a pair counts the less the further it is apart,
    so that hair, shoulders and cuts on one side only have no say.

    Parameters
    ----------
    points : (k, 3) float
        Some thousand points spread evenly over the surface.
    normals : (k, 3) float
        Unit normals there.
    """
    low, high = np.percentile(points, [1, 99], axis=0)
    size = float(np.linalg.norm(high - low))
    found = _coarse(points, size)
    tree = cKDTree(points)
    planes = sorted((_refined(plane, points, normals, tree, size) for plane in found), key=lambda p: -p.score)
    chosen: list[MirrorPlane] = []
    for plane in planes:
        if all(_differ(plane, other, size) for other in chosen):
            chosen.append(plane)
    return chosen[:count]


def _differ(one: MirrorPlane, other: MirrorPlane, size: float, degrees: float = 10.0) -> bool:
    cosine = float(one.normal @ other.normal)
    apart = abs(one.offset - float(np.sign(cosine)) * other.offset)
    return abs(cosine) < float(np.cos(np.deg2rad(degrees))) or apart > 0.05 * size


def _coarse(points: FloatArray, size: float) -> list[MirrorPlane]:
    cell = size / _CELLS
    origin = points.min(axis=0) - 4 * cell
    shape = np.ceil((points.max(axis=0) - origin) / cell).astype(int) + 4
    # Stray points far away must not make the grid large: what lies outside is far from everything anyway.
    shape = np.minimum(shape, 3 * _CELLS)
    index = ((points - origin) / cell).astype(int)
    index = index[(index < shape).all(axis=1)]
    empty = np.ones(shape, dtype=bool)
    empty[tuple(index.T)] = False
    far = 4.0
    score = np.zeros(shape + 2)
    distance = np.minimum(distance_transform_edt(empty), far)
    score[1:-1, 1:-1, 1:-1] = 1 - (distance / far) ** 2
    flat, strides = score.ravel(), np.array([score.shape[1] * score.shape[2], score.shape[2], 1])
    some = points[:: max(1, len(points) // 350)]
    directions = _hemisphere(_DIRECTIONS)
    middles = np.median(points @ directions.T, axis=0)
    planes: list[MirrorPlane] = []
    for normal, middle in zip(directions, middles, strict=True):
        offsets = middle + _OFFSETS * size
        height = some @ normal
        mirrored = some[None] - 2 * (height[None, :] - offsets[:, None])[..., None] * normal
        cells = ((mirrored - origin) / cell).astype(int) + 1
        cells = np.where((cells < 0) | (cells >= score.shape), 0, cells)
        # Points close to the plane are carried onto themselves whatever the surface is.
        weight = np.minimum(np.abs(height[None, :] - offsets[:, None]) / (0.1 * size), 1.0)
        values = (flat[cells @ strides] * weight).sum(axis=1) / np.maximum(weight.sum(axis=1), 0.3 * len(some))
        k = int(values.argmax())
        planes.append(MirrorPlane(normal, float(offsets[k]), float(values[k])))
    chosen: list[MirrorPlane] = []
    for plane in sorted(planes, key=lambda p: -p.score):
        if all(_differ(plane, other, size, 14.0) for other in chosen):
            chosen.append(plane)
        if len(chosen) == 8:
            break
    return chosen


def _refined(
    plane: MirrorPlane, points: FloatArray, normals: FloatArray, tree: cKDTree, size: float, steps: int = 12
) -> MirrorPlane:
    some = slice(None, None, max(1, len(points) // 1500))
    p, p_normal = points[some], normals[some]
    normal, offset = plane.normal, plane.offset
    for step in range(steps):
        reach = size * max(_FINE, _COARSE * 0.75**step)
        current = MirrorPlane(normal, offset, 0.0)
        mirrored = current.reflect(p)
        _, near = tree.query(mirrored)
        towards = normals[near]
        residual = np.einsum("ki,ki->k", towards, mirrored - points[near])
        apart = np.linalg.norm(mirrored - points[near], axis=1)
        turned = p_normal - 2 * np.outer(p_normal @ normal, normal)
        agree = np.maximum(np.abs(np.einsum("ki,ki->k", turned, towards)), 0.0) ** 2
        weight = agree / (1 + (apart / reach) ** 2) ** 2
        side = np.cross(normal, [1.0, 0, 0] if abs(normal[0]) < 0.8 else [0, 1.0, 0])
        side /= np.linalg.norm(side)
        other = np.cross(normal, side)
        height = p @ normal - offset
        facing = towards @ normal
        columns = [-2 * ((p @ t) * facing + height * (towards @ t)) for t in (side, other)]
        jacobian = np.stack([*columns, 2 * facing], axis=1)
        scale = np.array([size, size, 1.0])
        jacobian = jacobian / scale
        matrix = (jacobian * weight[:, None]).T @ jacobian
        change = np.linalg.solve(
            matrix + 1e-6 * np.trace(matrix) * np.eye(3), -(jacobian * weight[:, None]).T @ residual
        )
        change = change / scale
        change[:2] = np.clip(change[:2], -0.2, 0.2)
        moved = normal + change[0] * side + change[1] * other
        length = float(np.linalg.norm(moved))
        normal, offset = moved / length, (offset + float(change[2])) / length
    return MirrorPlane(normal, offset, _score(MirrorPlane(normal, offset, 0.0), p, p_normal, normals, tree, size))


def _score(
    plane: MirrorPlane, p: FloatArray, p_normal: FloatArray, normals: FloatArray, tree: cKDTree, size: float
) -> float:
    distance, near = tree.query(plane.reflect(p))
    turned = p_normal - 2 * np.outer(p_normal @ plane.normal, plane.normal)
    agree = np.maximum(np.abs(np.einsum("ki,ki->k", turned, normals[near])), 0.0) ** 4
    height = np.abs(p @ plane.normal - plane.offset)
    weight = np.minimum(height / (0.1 * size), 1.0)
    match = agree / (1 + (distance / (1.5 * _FINE * size)) ** 2)
    return float((weight * match).sum() / max(weight.sum(), 0.3 * len(p)))


def _hemisphere(count: int) -> FloatArray:
    """Return unit vectors (count, 3) spread evenly over half a sphere (golden spiral)."""
    k = np.arange(count) + 0.5
    z, angle = k / count, np.pi * (1 + 5**0.5) * k
    radius = np.sqrt(1 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
