"""Exact distances from points to a triangle surface."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from engine.errors import InputError
from engine.mesh import FloatArray, IntArray

FIRST_CANDIDATES = 16


def closest_points(points: FloatArray, vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the nearest surface point (k, 3) for every point (k, 3), and the face (k,) it lies on.

    Candidates are the faces with the nearest middles; their number doubles until no face further away can be nearer,
    so the answer is exact.

    Raises
    ------
    InputError
        For a surface without faces.
    """
    if not len(faces):
        raise InputError("surface", "has no faces", "give at least one triangle")
    corner = vertices[faces]
    middles = corner.mean(axis=1)
    radius = np.linalg.norm(corner - middles[:, None], axis=2).max(axis=1)
    found, face = np.empty((len(points), 3)), np.zeros(len(points), dtype=np.int64)
    best = np.full(len(points), np.inf)
    # Faces of one size at a time: among large and small ones together, the largest would decide how far to look.
    size = np.ceil(np.log2(np.maximum(radius, 1e-300)))
    for step in np.unique(size):
        members = np.flatnonzero(size == step)
        _improve(points, corner[members], middles[members], 2.0**step, members, found, face, best)
    return found, face


def _improve(
    points: FloatArray,
    corner: FloatArray,
    middles: FloatArray,
    radius: float,
    members: IntArray,
    found: FloatArray,
    face: IntArray,
    best: FloatArray,
) -> None:
    """Lower ``best`` in place where one of these faces, none larger than ``radius``, is nearer."""
    tree = cKDTree(middles)
    open_, count = np.arange(len(points)), min(FIRST_CANDIDATES, len(members))
    while len(open_):
        near = tree.query(points[open_], k=count)
        away, candidate = (np.asarray(part).reshape(len(open_), count) for part in near)
        reachable = away[:, 0] - radius < best[open_]
        open_, away, candidate = open_[reachable], away[reachable], candidate[reachable]
        nearest = closest_on_triangles(points[open_][:, None], corner[candidate])
        distance = np.linalg.norm(nearest - points[open_][:, None], axis=2)
        row, column = np.arange(len(open_)), distance.argmin(axis=1)
        nearer = distance[row, column] < best[open_]
        row, column, improved = row[nearer], column[nearer], open_[nearer]
        found[improved], face[improved] = nearest[row, column], members[candidate[row, column]]
        best[improved] = distance[row, column]
        if count == len(members):
            break
        open_ = open_[away[:, -1] - radius < best[open_]]
        count = min(2 * count, len(members))


def surface_distance(points: FloatArray, vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return the distance (k,) of every point (k, 3) to the surface, in the points' unit."""
    distance: FloatArray = np.linalg.norm(closest_points(points, vertices, faces)[0] - points, axis=1)
    return distance


def closest_on_triangles(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the nearest point (..., 3) of each triangle (..., 3, 3) to each point (..., 3).

    The foot of the perpendicular where it lies inside, else the nearest of the three sides.
    """
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    first, second, offset = b - a, c - a, points - a
    d11, d12, d22 = (np.einsum("...k,...k", u, v) for u, v in ((first, first), (first, second), (second, second)))
    p1, p2 = np.einsum("...k,...k", offset, first), np.einsum("...k,...k", offset, second)
    determinant = d11 * d22 - d12 * d12
    safe = np.where(determinant > 0, determinant, 1.0)
    v, w = (d22 * p1 - d12 * p2) / safe, (d11 * p2 - d12 * p1) / safe
    inside = (determinant > 0) & (v >= 0) & (w >= 0) & (v + w <= 1)
    best = a + v[..., None] * first + w[..., None] * second
    distance = np.where(inside, 0.0, np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        side = end - start
        square = np.einsum("...k,...k", side, side)
        share = np.einsum("...k,...k", points - start, side) / np.where(square > 0, square, 1.0)
        foot = start + np.clip(share, 0, 1)[..., None] * side
        away = np.linalg.norm(points - foot, axis=-1)
        nearer = ~inside & (away < distance)
        best = np.where(nearer[..., None], foot, best)
        distance = np.where(nearer, away, distance)
    return np.asarray(best, dtype=np.float64)
