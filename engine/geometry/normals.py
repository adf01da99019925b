"""Face and vertex normals, signed areas, triangle angles."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from engine.mesh import FloatArray, IntArray


def face_normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return the normals (F, 3) of ``faces``, as long as twice their area in mm^2."""
    corner = vertices[faces]
    return np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])


def vertex_normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return unit normals (N, 3), weighted by area; +Z where a vertex has no face of any area."""
    weighted = incidence(faces, len(vertices)) @ face_normals(vertices, faces)
    length = np.linalg.norm(weighted, axis=1, keepdims=True)
    return np.where(length > 0, weighted / np.where(length > 0, length, 1.0), np.array([0.0, 0.0, 1.0]))


def incidence(faces: IntArray, count: int) -> csr_matrix:
    """Return the matrix (count, F) with a one where a vertex belongs to a face."""
    rows = faces.ravel()
    columns = np.repeat(np.arange(len(faces)), 3)
    return csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, len(faces)))


def signed_areas(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return the signed areas (F,) of flat triangles at ``points`` (N, 2); positive keeps the plane's orientation."""
    corner = points[faces]
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    return np.asarray(0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]), dtype=np.float64)


def smallest_angles(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return the smallest angle (F,) of every face, radians; 0 for a face without area."""
    corner = vertices[faces]
    sides = np.stack([np.linalg.norm(corner[:, (k + 1) % 3] - corner[:, (k + 2) % 3], axis=1) for k in range(3)], 1)
    a, b, c = np.sort(sides, axis=1).T
    cosine = (b**2 + c**2 - a**2) / np.where(b * c > 0, 2 * b * c, 1.0)
    return np.where(b * c > 0, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
