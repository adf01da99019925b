"""Soft darkening of hollows, per vertex: what an open sky would not reach."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy import sparse

FloatArray = NDArray[np.float64]

_SCALES = ((2, 0.35, 0.40), (8, 1.2, 0.45), (28, 3.6, 0.60))
"""Rounds of averaging, the depth in mm below the average that counts as fully hollow, and its weight."""


def openness(
    vertices: FloatArray, faces: NDArray[np.integer], normals: FloatArray, edge: float | None = None
) -> FloatArray:
    """Return how open every vertex lies, 1 on plain and convex ground, down to 0 in deep hollows.

    A vertex is hollow where the average of its surroundings lies above it along the normal; three sizes of
    surroundings are added up, so that both the lip line and the eye socket darken. Border vertices hold still.

    Parameters
    ----------
    vertices, normals : (N, 3) float
        Positions in mm and unit normals.
    faces : (F, 3) int
    edge : float, optional
        Edge length in mm from which on depths are forgiven, with its square: where a mesh is coarse, surroundings
        reach far, and a plain curve lies as far below their average as a hollow does where it is fine.
    """
    average = _averaging(len(vertices), np.asarray(faces))
    allowed = np.ones(len(vertices)) if edge is None else _coarseness(vertices, np.asarray(faces), edge, average)
    smooth = np.asarray(vertices, dtype=np.float64)
    hollow = np.zeros(len(vertices))
    done = 0
    for rounds, depth, weight in _SCALES:
        for _ in range(rounds - done):
            smooth = average @ smooth
        done = rounds
        below = np.einsum("ij,ij->i", smooth - vertices, normals)
        hollow += weight * np.clip(below / (depth * allowed), 0.0, 1.0)
    return np.asarray(1.0 - np.clip(average @ hollow, 0.0, 1.0))


def tint(open_ground: FloatArray, strength: float) -> FloatArray:
    """Return factors (N, 3) for RGB colours: blue and green fall a little more than red, as light in skin does."""
    factor = 1.0 - strength * (1.0 - open_ground)
    return np.stack([factor**0.80, factor, factor**1.06], axis=1)


def _coarseness(
    vertices: FloatArray, faces: NDArray[np.integer], edge: float, average: sparse.csr_matrix
) -> FloatArray:
    """Return the square of the edges' length around every vertex over that of ``edge``, at least 1."""
    total, uses = np.zeros(len(vertices)), np.zeros(len(vertices))
    for a, b in ((0, 1), (1, 2), (2, 0)):
        squared = ((vertices[faces[:, a]] - vertices[faces[:, b]]) ** 2).sum(axis=1)
        for end in (a, b):
            total += np.bincount(faces[:, end], squared, len(vertices))
            uses += np.bincount(faces[:, end], minlength=len(vertices))
    squared = total / np.maximum(uses, 1)
    for _ in range(12):
        squared = average @ squared
    return np.asarray(np.maximum(squared / edge**2, 1.0))


def _averaging(count: int, faces: NDArray[np.integer]) -> sparse.csr_matrix:
    from scipy import sparse  # with the first face: empty views need not wait for it

    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ones = np.ones(len(edges))
    directed = sparse.csr_matrix((ones, (edges[:, 0], edges[:, 1])), shape=(count, count))
    links = directed + directed.T
    border_edges = links.tocoo()
    border = np.zeros(count, dtype=bool)
    alone = border_edges.data < 1.5
    border[border_edges.row[alone]] = True
    links.data[:] = 1.0
    keep = sparse.diags(np.where(border, 0.0, 1.0)) @ links
    matrix = sparse.eye(count) + keep
    rows = np.asarray(matrix.sum(axis=1)).ravel()
    return sparse.csr_matrix(sparse.diags(1.0 / rows) @ matrix)
