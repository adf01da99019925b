"""The template's own edges on a face that was subdivided from it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]


def coarse_edges(faces: NDArray[np.integer], levels: int) -> IntArray:
    """Return the edges (E, 2) of a subdivided mesh that lie on edges of the mesh it came from.

    One-to-four subdivision lays the children of all F0 coarse faces out in rounds, so ``faces[i]`` descends from
    face ``i % F0``; an edge lies on a coarse edge where its two sides descend from different faces, or where it
    has one side only.

    Parameters
    ----------
    faces : (F, 3) int
        Faces after ``levels`` subdivisions.
    levels : int
        0 gives all edges.
    """
    faces = np.asarray(faces, dtype=np.int64)
    if not len(faces):
        return np.zeros((0, 2), dtype=np.int64)
    origin = np.tile(np.arange(len(faces)) % (len(faces) // 4**levels), 3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    order = np.lexsort((origin, edges[:, 1], edges[:, 0]))
    edges, origin = edges[order], origin[order]
    first = np.ones(len(edges), dtype=bool)
    first[1:] = (edges[1:] != edges[:-1]).any(axis=1)
    group = np.cumsum(first) - 1
    sides = np.bincount(group)
    starts = np.flatnonzero(first)
    ends = starts + sides - 1
    keep = (sides != 2) | (origin[starts] != origin[ends])
    return np.asarray(edges[starts[keep]], dtype=np.int64)
