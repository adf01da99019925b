"""Small pictures of shapes for the list, drawn from their vertices alone, beside the window. No Qt."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from engine.geometry.normals import vertex_normals
from engine.mesh import FloatArray, IntArray
from engine.progress import Progress, silent

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from engine.shapes import Rig

SIZE = 40
_CLAY = np.array([214.0, 172.0, 148.0])
_GROUND = np.array([30, 31, 34], np.uint8)
_LIGHT = np.array([-0.35, 0.45, 0.82]) / np.linalg.norm([-0.35, 0.45, 0.82])


def shape_pictures(rig: Rig, progress: Progress = silent) -> dict[str, NDArray[np.uint8]]:
    """Return a picture (40, 40, 3) of the face under every shape at full weight, seen from the front."""
    basis, faces = rig.basis, rig.mesh.faces
    rest = basis.neutral if basis.mean is None else basis.neutral + basis.mean
    moving = np.linalg.norm(basis.displacements, axis=2).max(axis=0)
    about = basis.neutral[moving > 0.25 * moving.max()] if moving.max() > 0 else basis.neutral
    low, high = about.min(axis=0), about.max(axis=0)
    middle, half = (low + high) / 2, 0.62 * float((high - low)[:2].max())
    found = {}
    for i, name in enumerate(basis.names):
        progress(i / len(basis), "drawing the shapes")
        found[name] = _drawn(rest + basis.displacements[i], faces, middle, half)
    return found


def _drawn(vertices: FloatArray, faces: IntArray, middle: FloatArray, half: float) -> NDArray[np.uint8]:
    """Return vertices and middles of edges as points, the nearest to the eye on top, with small holes closed."""
    normals = vertex_normals(vertices, faces)
    first, second = faces[:, 0], faces[:, 1]
    points = np.concatenate([vertices, (vertices[first] + vertices[second]) / 2, vertices[faces].mean(axis=1)])
    light = normals @ _LIGHT
    lit = np.concatenate([light, (light[first] + light[second]) / 2, light[faces].mean(axis=1)])
    across = ((points[:, 0] - middle[0]) / half + 1) * SIZE / 2
    down = (1 - (points[:, 1] - middle[1]) / half) * SIZE / 2
    shown = np.flatnonzero((across >= 0) & (across < SIZE) & (down >= 0) & (down < SIZE))
    order = shown[np.argsort(points[shown, 2], kind="stable")]
    values = np.full((SIZE, SIZE), np.nan)
    values[down[order].astype(int), across[order].astype(int)] = np.clip(lit[order], 0.0, 1.0)
    for _ in range(2):
        values = _closed(values)
    there = np.isfinite(values)
    picture = np.empty((SIZE, SIZE, 3), np.uint8)
    picture[:] = _GROUND
    picture[there] = np.clip((0.18 + 0.92 * values[there])[:, None] * _CLAY, 0, 255).astype(np.uint8)
    return picture


def _closed(values: FloatArray) -> FloatArray:
    """Give a pixel without a point the mean of its neighbours, where at least five of eight have one."""
    padded = np.pad(values, 1, constant_values=np.nan)
    size = values.shape[0]
    around = np.stack([padded[y : y + size, x : x + size] for y in range(3) for x in range(3) if (y, x) != (1, 1)])
    count = np.isfinite(around).sum(axis=0)
    filled = np.isnan(values) & (count >= 5)
    result = values.copy()
    result[filled] = np.nansum(around[:, filled], axis=0) / count[filled]
    return result
