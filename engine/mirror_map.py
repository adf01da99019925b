"""Which vertex is which on the other side of a face: by walking the mesh, else by its mid plane (ours)."""

from __future__ import annotations

from itertools import chain
from typing import Literal, NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, TriangleMesh, frozen
from engine.mirror_walk import Polygons, fan_polygons, paired_polygons, walk

_TRIES = 12
_SAMPLE = 4000
_FARTHEST = 0.1
"""Median distance, in sizes of the mesh, at which a walk has found another symmetry than that of a face."""


class MirrorMap(NamedTuple):
    """The other side of every vertex.

    ``vertices`` (N,) int is the vertex on the other side, itself on the mid-line; ``how`` is ``topological`` where the
    walk reached every face, else ``by plane``; ``unmatched`` (k,) int are vertices with none near where the plane puts
    them, whose nearest was taken; ``middle`` is the x in mm of the mid plane, ``walked`` the vertices that were found
    over the mesh.
    """

    vertices: IntArray
    how: Literal["topological", "by plane"]
    unmatched: IntArray
    middle: float
    walked: int


def mirror_map(mesh: TriangleMesh) -> MirrorMap:
    """Return the other side of every vertex of a face whose left is +X.

    Every connected piece is walked from a face near its image in the mid plane: what lies left of an edge must lie
    right of its image. Polygons are put together again first, since their triangles are seldom cut symmetrically. So
    a face that is sculpted or posed unevenly is still paired exactly; a piece whose two sides are connected in
    different ways is paired by nearest points in the mid plane.

    Raises
    ------
    InputError
        When the mesh has no faces.
    """
    if not len(mesh.faces):
        raise InputError("mesh", "has no faces", "a face is needed to tell its sides apart")
    used = np.unique(mesh.faces)
    middle = mid_plane(mesh)
    tree = cKDTree(mesh.vertices[used])
    distance, nearest = tree.query(_reflected(mesh.vertices, middle))
    distance, image = np.asarray(distance, dtype=np.float64), used[nearest]
    found = np.full(len(mesh.vertices), -1, dtype=np.int64)
    for put_together in (fan_polygons, paired_polygons, Polygons.triangles):
        if (found[used] < 0).any():
            _walk_pieces(mesh, put_together(mesh.faces), image, distance, middle, found)
    walked = int((found >= 0).sum())
    near = 0.5 * _edge_length(mesh)
    open_ = found < 0
    unmatched = np.flatnonzero(open_ & (distance > near) & np.isin(np.arange(len(found)), used))
    how: Literal["topological", "by plane"] = "topological" if not open_[used].any() else "by plane"
    found[open_] = image[open_]
    return MirrorMap(frozen(found, np.int64), how, frozen(unmatched, np.int64), middle, walked)


def mid_plane(mesh: TriangleMesh) -> float:
    """Return the x in mm of the plane that parts left and right, which the normal +X is taken for."""
    points = mesh.vertices[np.unique(mesh.faces)]
    some = points[:: max(1, len(points) // _SAMPLE)]
    tree = cKDTree(points)
    best, score = 0.0, np.inf
    for start in (0.0, float(points[:, 0].min() + points[:, 0].max()) / 2, float(np.median(points[:, 0]))):
        middle = start
        for _ in range(4):
            distance, nearest = tree.query(_reflected(some, middle))
            if float(np.median(distance)) < score:
                best, score = middle, float(np.median(distance))
            middle = float(np.median(some[:, 0] + points[nearest, 0])) / 2
    return best


def mirrored(shape: FloatArray, pairs: MirrorMap) -> FloatArray:
    """Return displacements (N, 3) as a mirror shows them."""
    seen: FloatArray = shape[pairs.vertices] * np.array([-1.0, 1.0, 1.0])
    return seen


def _reflected(points: FloatArray, middle: float) -> FloatArray:
    reflected: FloatArray = points * np.array([-1.0, 1.0, 1.0]) + np.array([2 * middle, 0.0, 0.0])
    return reflected


def _edge_length(mesh: TriangleMesh) -> float:
    corner = mesh.vertices[mesh.faces]
    return float(np.median(np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)))


def _walk_pieces(
    mesh: TriangleMesh, polygons: Polygons, image: IntArray, distance: FloatArray, middle: float, found: IntArray
) -> None:
    """Walk every connected piece that is not paired yet, from the faces nearest to their image; fill ``found``."""
    count = len(mesh.vertices)
    links = mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]]
    rows, columns = np.concatenate(links).T
    _, piece = connected_components(coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, count)), False)
    size = float(np.ptp(mesh.vertices, axis=0).max())
    starts = np.cumsum([0, *map(len, polygons.loops[:-1])])
    apart = np.maximum.reduceat(distance[np.fromiter(chain.from_iterable(polygons.loops), np.int64)], starts)
    pieces, known = piece.tolist(), (found >= 0).tolist()
    tries: dict[int, int] = {}
    for start in np.argsort(apart, kind="stable").tolist():
        loop = polygons.loops[start]
        own = pieces[loop[0]]
        if all(known[vertex] for vertex in loop) or tries.get(own, 0) >= _TRIES:
            continue
        pairs = walk(polygons, start, image[loop].tolist())
        if pairs is not None:
            here, there = np.array(list(pairs.items())).T
            far = np.linalg.norm(_reflected(mesh.vertices[here], middle) - mesh.vertices[there], axis=1)
            taken = found[here]
            if np.median(far) <= _FARTHEST * size and ((taken < 0) | (taken == there)).all():
                found[here] = there
                for vertex in pairs:
                    known[vertex] = True
                continue
        tries[own] = tries.get(own, 0) + 1
