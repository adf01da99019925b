"""Spreading marker displacements along a surface, so that what is near in space but far along the skin stays apart."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.csgraph import dijkstra
from scipy.sparse.linalg import splu

from engine.basis.binding import MarkerBinding
from engine.errors import InputError
from engine.geometry.harmonic import cotangent_laplacian
from engine.mesh import FloatArray, IntArray, TriangleMesh

TENSION = 0.03
"""1 / mm^2. A thin plate overshoots where markers end, a membrane peaks at them; they balance over 6 mm."""

_SMALLEST_AREA = 1e-3
_FLOATING = 1e-8


def spread_surface(mesh: TriangleMesh, binding: MarkerBinding, reach_mm: float) -> FloatArray:
    """Return ``phi`` (N, K) of the calmest displacement field on the surface that follows the markers (ours).

    Minimises bending plus a little stretching energy (squared Laplacian with lumped masses, and `TENSION` times the
    Dirichlet energy, cotangent weights) with the markers as exact barycentric constraints and zero further along the
    surface than ``reach_mm`` from all of them. Lips and lids move apart because no edge joins them; parts that no
    marker sits on stay still.

    Raises
    ------
    InputError
        When markers cannot be told apart: more than three in one triangle.

    References
    ----------
    Botsch & Kobbelt 2004 (constrained bilaplacian on meshes); Jacobson et al. 2010 (mixed elements with lumped mass).
    """
    vertices, faces, count = mesh.vertices, mesh.faces, len(mesh.vertices)
    own = faces[binding.faces]
    free: IntArray = np.flatnonzero(_along(mesh, np.unique(own)) < reach_mm)
    laplacian = cotangent_laplacian(vertices, faces)
    area = _areas(vertices, faces)
    area = np.maximum(area, _SMALLEST_AREA * float(area[free].mean()))
    energy = csr_matrix((laplacian @ diags(1 / area) @ laplacian + TENSION * laplacian)[free][:, free])
    # Where the markers' reach ends nowhere, the whole surface may move along: hold it by next to nothing.
    energy = energy + _FLOATING * diags(np.maximum(energy.diagonal(), 1e-12))
    rows = np.repeat(np.arange(len(binding)), 3)
    weights = coo_matrix((binding.barycentric.ravel(), (rows, own.ravel())), shape=(len(binding), count))
    at_markers = csr_matrix(weights)[:, free]
    factor = splu(energy.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    answers = factor.solve(at_markers.T.toarray())
    coupling = np.asarray(at_markers @ answers)
    if np.linalg.matrix_rank(coupling, tol=1e-10 * float(np.abs(coupling).max()), hermitian=True) < len(binding):
        raise InputError("markers", "more than three sit in one triangle", "leave some out or use a finer mesh")
    phi = np.zeros((count, len(binding)))
    phi[free] = np.linalg.solve(coupling.T, answers.T).T
    return phi


def _along(mesh: TriangleMesh, starts: IntArray) -> FloatArray:
    """Length (N,) of the shortest way along edges from the nearest start, mm; infinite for parts of their own."""
    edges = np.vstack([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    # An edge of no length would be no edge.
    length = np.maximum(np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1), 1e-9)
    count = len(mesh.vertices)
    graph = coo_matrix((length, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()
    away: FloatArray = dijkstra(graph, directed=False, indices=starts, min_only=True)
    return away


def _areas(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """A third of the area (N,) of the triangles around every vertex, mm^2."""
    corner = vertices[faces]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1) / 6
    return np.bincount(faces.ravel(), np.repeat(area, 3), len(vertices)).astype(np.float64)
