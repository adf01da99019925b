"""Values on a face calmed for the eye: each vertex takes the mean of what lies around it on the surface."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.mesh import FloatArray

REACH_MM = 3.0
"""How far around a vertex the heatmap looks."""
SMOOTHED = f"smoothed {REACH_MM:g} mm"
"""What a legend says of colours that were calmed so."""
_MOST_STEPS = 40


def calmed(values: FloatArray, vertices: FloatArray, faces: NDArray[np.integer], reach: float = REACH_MM) -> FloatArray:
    """Return values (N,) averaged over the surface within about ``reach`` mm, weighted by area.

    Values walk from vertex to neighbouring vertex until they have come as far as the points of a disc of radius
    ``reach`` lie from its middle (in the root mean square), however long the edges are. So nothing passes from lip
    to lip through the air. Unknown values (NaN) stay unknown and have no part in any mean.

    Parameters
    ----------
    values : (N,) float
    vertices : (N, 3) float
        Positions in mm.
    faces : (F, 3) int
    reach : float
        Radius in mm; 0 changes nothing.
    """
    values = np.asarray(values, dtype=np.float64)
    if reach <= 0.0 or not len(faces) or not len(values):
        return values.copy()
    known = ~np.isnan(values)
    rows, columns = _neighbours(np.ascontiguousarray(faces, dtype=np.int64).tobytes(), len(values))
    weights = _areas(vertices, faces)[columns] * known[columns]
    total = np.bincount(rows, weights, len(values))
    weights = weights / np.where(total > 0, total, 1.0)[rows]
    squared = ((vertices[rows] - vertices[columns]) ** 2).sum(axis=1)
    spread = np.bincount(rows, weights * squared, len(values))
    usual = float(np.median(spread[spread > 0])) if (spread > 0).any() else 1.0
    wanted = 0.5 * reach**2
    steps = int(np.clip(np.ceil(2.0 * wanted / usual), 1, _MOST_STEPS))
    share = np.minimum(1.0, wanted / (steps * np.maximum(spread, 1e-12)))
    share[total <= 0] = 0.0
    walk = _matrix(rows, columns, weights * share[rows], len(values))
    stay = 1.0 - share
    result = np.where(known, values, 0.0)
    for _ in range(steps):
        result = stay * result + walk @ result
    return np.where(known, result, np.nan)


def _matrix(rows: NDArray[np.int64], columns: NDArray[np.int64], weights: FloatArray, count: int) -> Any:
    from scipy.sparse import csr_array

    return csr_array((weights, (rows, columns)), shape=(count, count))


@lru_cache(maxsize=4)
def _neighbours(faces: bytes, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return pairs (vertex, neighbour), every vertex among its own neighbours, for faces as bytes of int64."""
    corners = np.frombuffer(faces, dtype=np.int64).reshape(-1, 3)
    ends = np.concatenate([corners[:, [a, b]] for a, b in ((0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2))])
    codes = np.unique(np.concatenate([ends[:, 0] * count + ends[:, 1], np.arange(count) * (count + 1)]))
    return codes // count, codes % count


def _areas(vertices: FloatArray, faces: NDArray[np.integer]) -> FloatArray:
    """Return a third of the area of the triangles around each vertex (N,), mm²."""
    a, b, c = (np.asarray(vertices, dtype=np.float64)[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.asarray(np.bincount(np.asarray(faces).ravel(), np.repeat(area, 3), len(vertices)), dtype=np.float64)
