"""Harmonic fill: the calmest continuation of known values over a mesh."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from engine.geometry.subdivide import unique_edges
from engine.mesh import BoolArray, FloatArray, IntArray


def harmonic_fill(
    values: FloatArray, known: BoolArray, faces: IntArray, order: int = 1
) -> tuple[FloatArray, BoolArray]:
    """Return ``values`` with the unknown ones continued from the known ones over the mesh.

    Parameters
    ----------
    values : (N, C) float
        Anything where unknown.
    known : (N,) bool
        The vertices whose value stays.
    faces : (F, 3) int
        Connectivity.
    order : int
        1 solves Laplace's equation (a membrane: flat between its borders), 2 the bi-Laplacian (a plate: continues the
        slope at the border, as a face under a hole does).

    Returns
    -------
    filled : (N, C) float
        NaN where a whole component has no known vertex.
    reached : (N,) bool
        Vertices that now have a value.
    """
    count = len(values)
    edges, _ = unique_edges(faces)
    ones = np.ones(2 * len(edges))
    adjacency = coo_matrix(
        (ones, (np.r_[edges[:, 0], edges[:, 1]], np.r_[edges[:, 1], edges[:, 0]])), shape=(count, count)
    ).tocsr()
    _, component = connected_components(adjacency, directed=False)
    supported = np.zeros(component.max() + 1 if count else 0, dtype=bool)
    supported[component[known]] = True
    reached = supported[component] if count else known
    unknown = reached & ~known
    filled = np.where(known[:, None], values, np.nan)
    if unknown.any():
        degree = np.asarray(adjacency.sum(axis=1)).ravel()
        laplacian: csr_matrix = (diags(degree) - adjacency).tocsr()
        operator = laplacian
        if order == 2:
            operator = (laplacian @ diags(1.0 / np.maximum(degree, 1)) @ laplacian).tocsr()
        rows = operator[unknown]
        right = -(rows[:, known] @ values[known])
        filled[unknown] = splu(rows[:, unknown].tocsc()).solve(np.asarray(right))
    return filled, reached
