"""A small grey picture of a head from the front or the side, as a ground for points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.geometry.normals import vertex_normals
from engine.mesh import FloatArray, TriangleMesh

FRONT = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
"""Rows: across the picture, up it, towards the eye. The subject's left is on the right."""

SIDE = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
"""The subject looks to the right: seen from its right side."""

_FILLED = 2
_LIGHT = np.array([-0.35, 0.45, 0.82])
_INSIDE = np.array([(i + 1 / 3, j + 1 / 3) for i in range(5) for j in range(5) if i + j < 5]) / 5


def shade(
    mesh: TriangleMesh, view: FloatArray, size: tuple[int, int], scale: float, middle: FloatArray
) -> NDArray[np.float32]:
    """Return brightness (h, w), 0..1, NaN where nothing is: points splatted by depth, lit from above.

    Parameters
    ----------
    mesh : TriangleMesh
        mm.
    view : (3, 3) float
        `FRONT` or `SIDE`.
    size : (int, int)
        Width and height, pixels.
    scale : float
        Pixels a mm.
    middle : (2,) float
        What lies in the middle of the picture, mm across and up.
    """
    width, height = size
    corners = mesh.vertices[mesh.faces] @ view.T
    normals = vertex_normals(mesh.vertices, mesh.faces) @ view.T
    lit = np.clip(normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0, 1)[mesh.faces]
    u, v = _INSIDE.T
    weights = np.column_stack([1 - u - v, u, v])
    points = np.einsum("sc,fck->fsk", weights, corners).reshape(-1, 3)
    values = np.einsum("sc,fc->fs", weights, lit).ravel()
    across = np.rint((points[:, 0] - middle[0]) * scale + width / 2).astype(np.int64)
    down = np.rint(height / 2 - (points[:, 1] - middle[1]) * scale).astype(np.int64)
    shown = (across >= 0) & (across < width) & (down >= 0) & (down < height)
    order = np.flatnonzero(shown)
    order = order[np.argsort(points[order, 2], kind="stable")]
    picture = np.full((height, width), np.nan, np.float32)
    picture[down[order], across[order]] = values[order]
    for _ in range(_FILLED):
        picture = _closed(picture)
    return picture


def smooth(picture: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return brightness and coverage (2h, 2w), 0..1, of a shaded picture at twice its size, with soft edges."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter, zoom

    there = np.isfinite(picture)
    if not there.any():
        empty = np.zeros((2 * picture.shape[0], 2 * picture.shape[1]), np.float32)
        return empty, empty
    nearest = distance_transform_edt(~there, return_distances=False, return_indices=True)
    light = zoom(gaussian_filter(picture[tuple(nearest)], 0.6), 2, order=1)
    edge = zoom(gaussian_filter(there.astype(np.float32), 1.0), 2, order=1)
    return np.clip(light, 0, 1), np.clip((edge - 0.5) * 3.0 + 0.5, 0, 1)


def _closed(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """Fill pixels most of whose neighbours hold something: large triangles are sampled sparsely."""
    padded = np.pad(picture, 1, constant_values=np.nan)
    height, width = picture.shape
    around = np.stack([padded[i : i + height, j : j + width] for i in range(3) for j in range(3) if (i, j) != (1, 1)])
    there = np.isfinite(around)
    count = there.sum(axis=0)
    mean = np.where(there, around, 0).sum(axis=0) / np.maximum(count, 1)
    return np.where(np.isnan(picture) & (count >= 4), mean, picture).astype(np.float32)
