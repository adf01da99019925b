"""1-to-4 subdivision that keeps what it came from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, TriangleMesh, frozen

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


@dataclass(frozen=True)
class Subdivision:
    """A finer set of faces and how its vertices follow from the coarse ones.

    Parameters
    ----------
    faces : (4^levels F, 3) int
        The fine faces; the first N vertices are the coarse ones under their old numbers.
    parent_faces : (4^levels F,) int
        The coarse face every fine face lies in.
    weights : (M, N) sparse
        Fine vertices are ``weights @ coarse``; every row sums to one.
    """

    faces: IntArray
    parent_faces: IntArray
    weights: csr_matrix

    def apply(self, values: FloatArray) -> FloatArray:
        """Return values (M, ...) on the fine vertices from ``values`` (N, ...) on the coarse ones."""
        return np.asarray(self.weights @ values, dtype=np.float64)


def subdivision(faces: IntArray, count: int, levels: int) -> Subdivision:
    """Return the 1-to-4 subdivision of ``faces`` (F, 3) over ``count`` vertices, ``levels`` times.

    Every edge gets one vertex at its middle, shared by both faces, so borders stay borders and no crack opens.

    Raises
    ------
    InputError
        With levels outside 0..6 (a level takes four times the memory).

    Notes
    -----
    Yano & Harada 2009, section 3.1.
    """
    from scipy.sparse import identity  # slow to load, and whoever only draws the template never comes here

    if not 0 <= levels <= 6:
        raise InputError("levels", f"is {levels}", "give 0 to 6")
    fine, parents = np.asarray(faces, dtype=np.int64), np.arange(len(faces), dtype=np.int64)
    weights = identity(count, format="csr", dtype=np.float64)
    for _ in range(levels):
        fine, step = _split(fine, weights.shape[0])
        weights = (step @ weights).tocsr()
        parents = np.tile(parents, 4)
    return Subdivision(frozen(fine, np.int64), frozen(parents, np.int64), weights)


def one_to_four(mesh: TriangleMesh, levels: int = 1) -> TriangleMesh:
    """Return ``mesh`` with every face split into four, ``levels`` times, chart and parts with it.

    Parameters
    ----------
    mesh : TriangleMesh
        Old vertices keep their numbers.
    levels : int
        0 to 6.

    Raises
    ------
    InputError
        With levels outside 0..6.
    """
    points = subdivision(mesh.faces, len(mesh.vertices), levels)
    uv = uv_faces = None
    if mesh.uv is not None and mesh.uv_faces is not None:
        chart = subdivision(mesh.uv_faces, len(mesh.uv), levels)
        uv, uv_faces = chart.apply(mesh.uv), chart.faces
    parts = {name: np.flatnonzero(np.isin(points.parent_faces, part)) for name, part in mesh.parts.items()}
    return TriangleMesh(points.apply(mesh.vertices), points.faces, uv, uv_faces, parts)


def _split(faces: IntArray, count: int) -> tuple[IntArray, csr_matrix]:
    from scipy.sparse import csr_matrix

    edges, side = unique_edges(faces)
    middle = count + side
    fine = np.concatenate(
        [
            np.stack([faces[:, 0], middle[:, 0], middle[:, 2]], axis=1),
            np.stack([middle[:, 0], faces[:, 1], middle[:, 1]], axis=1),
            np.stack([middle[:, 2], middle[:, 1], faces[:, 2]], axis=1),
            middle,
        ]
    )
    rows = np.concatenate([np.arange(count), np.repeat(count + np.arange(len(edges)), 2)])
    columns = np.concatenate([np.arange(count), edges.ravel()])
    values = np.concatenate([np.ones(count), np.full(2 * len(edges), 0.5)])
    return fine, csr_matrix((values, (rows, columns)), shape=(count + len(edges), count))


def unique_edges(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return the edges (E, 2) of ``faces`` once each, and the edge (F, 3) of the sides 01, 12, 20 of every face."""
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    edges, inverse = np.unique(sides, axis=0, return_inverse=True)
    return edges, inverse.reshape(-1, 3)
