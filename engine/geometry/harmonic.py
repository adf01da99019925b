"""Harmonic fill: the calmest continuation of known values over a mesh."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from engine.mesh import BoolArray, FloatArray, IntArray

STEEPEST_COTANGENT = 20.0


def harmonic_fill(
    values: FloatArray, known: BoolArray, faces: IntArray, positions: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return ``values`` with the unknown ones continued from the known ones over the mesh.

    Solves Laplace's equation with cotangent weights: inside a hole the result is linear where its border is, and it
    never leaves the range of the border's values on a mesh of acute triangles.

    Parameters
    ----------
    values : (N, C) float
        Anything where unknown.
    known : (N,) bool
        The vertices whose value stays.
    faces : (F, 3) int
        Connectivity.
    positions : (N, 2) or (N, 3) float
        Where the vertices lie; only angles matter.

    Returns
    -------
    filled : (N, C) float
        NaN where a whole component has no known vertex.
    reached : (N,) bool
        Vertices that now have a value.
    """
    # Only faces that touch an unknown vertex have a say, and there are few of them.
    around = faces[~known[faces].all(axis=1)]
    used, local = np.unique(around, return_inverse=True)
    fixed = known[used]
    laplacian = cotangent_laplacian(positions[used], local.reshape(-1, 3))
    _, component = connected_components(laplacian, directed=False)
    supported = np.isin(component, component[fixed])
    reached = known.copy()
    reached[used] = supported
    filled = np.where(known[:, None], values, np.nan)
    unknown = supported & ~fixed
    if unknown.any():
        rows = laplacian[unknown]
        right = -(rows[:, fixed] @ values[used[fixed]])
        filled[used[unknown]] = splu(rows[:, unknown].tocsc()).solve(np.asarray(right))
    return filled, reached


def cotangent_laplacian(positions: FloatArray, faces: IntArray) -> csr_matrix:
    """Return the positive semi-definite cotangent Laplacian (N, N) of a triangle mesh.

    Cotangents of slivers are limited to +-20, and a face without area counts as equilateral.
    """
    count = len(positions)
    rows, columns, weights = [], [], []
    for corner in range(3):
        tip, start, end = (faces[:, (corner + k) % 3] for k in range(3))
        first, second = positions[start] - positions[tip], positions[end] - positions[tip]
        dot = np.einsum("fk,fk->f", first, second)
        square = np.einsum("fk,fk->f", first, first) * np.einsum("fk,fk->f", second, second) - dot**2
        area = np.sqrt(np.maximum(square, 0.0))
        cotangent = np.where(area > 0, dot / np.where(area > 0, area, 1.0), 1 / np.sqrt(3))
        rows.append(start)
        columns.append(end)
        weights.append(0.5 * np.clip(cotangent, -STEEPEST_COTANGENT, STEEPEST_COTANGENT))
    row, column, weight = np.concatenate(rows), np.concatenate(columns), np.concatenate(weights)
    half = coo_matrix((weight, (row, column)), shape=(count, count))
    adjacency = (half + half.T).tocsr()
    degree = np.asarray(adjacency.sum(axis=1)).ravel()
    diagonal = coo_matrix((degree, (np.arange(count), np.arange(count))), shape=(count, count))
    return csr_matrix(diagonal - adjacency)
