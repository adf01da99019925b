"""Vertices that a file had to split, joined again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.mesh import FloatArray, IntArray

_APART = 1e-6
"""Distance, relative to the size of the face, up to which copies of a vertex may differ."""
_SHARP = 1e-3


@dataclass(frozen=True)
class Welded:
    """``index`` (V,) says which joined vertex each vertex is, ``first`` (N,) at which vertex each is found."""

    index: IntArray
    first: IntArray


def by_source(sources: Sequence[FloatArray | None], positions: FloatArray, shapes: FloatArray) -> Welded | None:
    """Join vertices by the numbers (V, 1) that pieces keep of them.

    Returns None where a piece has none, where they are no whole numbers 0, 1, 2, ... without a hole, or where vertices
    of one number are apart at rest or under a shape: another program has changed the mesh since.

    Parameters
    ----------
    sources : sequence of (V_k, 1) float or None
        Numbers of the vertices of each piece.
    positions, shapes : (V, 3), (n, V, 3) float
        Of all pieces together.
    """
    kept = [source for source in sources if source is not None]
    if len(kept) < len(sources):
        return None
    numbers = np.concatenate(kept)[:, 0]
    if not (np.isfinite(numbers).all() and (numbers == np.round(numbers)).all() and numbers.min() >= 0):
        return None
    if numbers.max() >= len(numbers):
        return None
    index = numbers.astype(np.int64)
    found, first = np.unique(index, return_index=True)
    if len(found) != index.max() + 1:
        return None
    split = np.flatnonzero(first[index] != np.arange(len(index)))
    twin = first[index[split]]
    with np.errstate(over="ignore", invalid="ignore"):
        near = _APART * max(float(np.ptp(positions, axis=0).max()), 1e-12)
        alike = all((np.abs(at[split] - at[twin]) <= near).all() for at in (positions, *shapes))
    return Welded(index, first) if alike else None


def by_touch(positions: FloatArray, shapes: FloatArray, normals: FloatArray | None, faces: int) -> Welded:
    """Join vertices that are one at rest, under every shape, and in their normals; numbered as they first occur.

    Normals keep lips apart that touch. In a faceted mesh they part every face from the next; there they do not count.

    Parameters
    ----------
    positions, shapes, normals : (V, 3), (n, V, 3), (V, 3) float
        Of all vertices; None where there are no normals.
    faces : int
        Number of triangles.
    """
    rows = [positions]
    if normals is not None:
        rows.append(np.round(normals / _SHARP))
    found = _joined(np.concatenate(rows, axis=1), shapes)
    if normals is not None and len(found.first) > 1.5 * faces:
        found = _joined(positions, shapes)
    return found


def _joined(keys: FloatArray, shapes: FloatArray) -> Welded:
    group = _alike(keys)
    counts = np.bincount(group)
    number = group.copy()
    several = np.flatnonzero(counts[group] > 1)
    if len(several):
        kinds = _alike(np.stack([group[several].astype(np.float64), _mixed(shapes, several)], axis=1))
        twin = several[np.unique(kinds, return_index=True)[1][kinds]]
        apart = np.zeros(len(several), dtype=bool)
        for shape in shapes:
            apart |= (shape[several] != shape[twin]).any(axis=1)
        kinds[apart] = len(several) + np.arange(int(apart.sum()))
        number[several] = len(counts) + kinds
    _, first, number = np.unique(number, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return Welded(rank[number.reshape(-1)], np.sort(first))


def _alike(rows: FloatArray) -> IntArray:
    """Return a number (V,) per row (V, k) that equal rows share."""
    _, first, group = np.unique(_projected(rows), return_index=True, return_inverse=True)
    group = group.reshape(-1)
    if (rows == rows[first[group]]).all():
        return group
    return np.unique(rows + 0.0, axis=0, return_inverse=True)[1].reshape(-1)


def _projected(rows: FloatArray) -> FloatArray:
    total = np.zeros(len(rows))
    with np.errstate(over="ignore", invalid="ignore"):
        for column, factor in zip(rows.T, np.random.default_rng(2).normal(size=(rows.shape[1],)).tolist(), strict=True):
            # Element by element: a matrix product may round one row another way than its twin.
            total += factor * column
    return total


def _mixed(shapes: FloatArray, vertices: IntArray) -> FloatArray:
    """Return a number per vertex that is the same for those that all shapes move alike."""
    total = np.zeros(len(vertices))
    rng = np.random.default_rng(1)
    with np.errstate(over="ignore", invalid="ignore"):
        for shape in shapes:
            total += rng.normal() * _projected(shape[vertices])
    return total
