"""Vertices split along texture seams, for formats with one texture coordinate a vertex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.mesh import FloatArray, IntArray, TriangleMesh


@dataclass(frozen=True)
class SplitMesh:
    """Faces (F, 3) over split vertices; ``source`` (V,) says which mesh vertex each is, ``uv`` (V, 2) its place."""

    source: IntArray
    faces: IntArray
    uv: FloatArray | None


def split_at_seams(mesh: TriangleMesh) -> SplitMesh:
    """Return the mesh with one texture coordinate per vertex, splitting as few vertices as possible.

    Without a seam vertices keep their order; with one they are ordered by mesh vertex, then texture coordinate.
    Every mesh vertex occurs at least once, also one that no face uses (its texture coordinate is then 0, 0).
    """
    if mesh.uv is None or mesh.uv_faces is None:
        return SplitMesh(np.arange(len(mesh.vertices)), mesh.faces, None)
    if len(mesh.uv) == len(mesh.vertices) and np.array_equal(mesh.faces, mesh.uv_faces):
        return SplitMesh(np.arange(len(mesh.vertices)), mesh.faces, mesh.uv)
    keys = mesh.faces * len(mesh.uv) + mesh.uv_faces
    unique, corners = np.unique(keys, return_inverse=True)
    source, chart = np.divmod(unique, max(1, len(mesh.uv)))
    unused = np.setdiff1d(np.arange(len(mesh.vertices)), source)
    uv = np.concatenate([mesh.uv[chart], np.zeros((len(unused), 2))])
    return SplitMesh(np.concatenate([source, unused]), corners.reshape(-1, 3), uv)
