"""Spreading marker displacements through space with a radial basis function, as Kim & Ko 2007 do."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from engine.basis.binding import MarkerBinding
from engine.mesh import FloatArray, TriangleMesh

_ANCHORS = 200


def spread_rbf(mesh: TriangleMesh, binding: MarkerBinding, reach_mm: float) -> FloatArray:
    """Return ``phi`` (N, K) of the kernel r in space, exact at the markers (Kim & Ko 2007, section 5.2).

    Vertices further than ``reach_mm`` from every marker stay still: some of them, evenly chosen, count as markers
    that do not move, and beyond that distance the result fades to zero (ours).
    """
    points = binding.points(mesh)
    away = np.asarray(cKDTree(points).query(mesh.vertices)[0])
    anchors = _even(mesh.vertices[away > reach_mm], _ANCHORS)
    centres = np.vstack([points, anchors])
    # A linear term would carry motion to the back of the head; the anchors fix what it is there for.
    weights = lu_solve(lu_factor(cdist(centres, centres)), np.eye(len(centres), len(points)))
    phi = np.asarray(cdist(mesh.vertices, centres) @ weights, dtype=np.float64)
    fade = np.clip((1.5 * reach_mm - away) / (0.5 * reach_mm), 0.0, 1.0)
    phi = phi * (fade * fade * (3 - 2 * fade))[:, None]
    # The kernel knows the markers, the mesh only its vertices: make it exact in the triangles between them.
    return np.asarray(np.linalg.solve(binding.on(phi, mesh.faces).T, phi.T).T, dtype=np.float64)


def _even(points: FloatArray, count: int) -> FloatArray:
    """Return ``count`` points spread evenly: each the farthest from those before."""
    if len(points) <= count:
        return points
    chosen = [0]
    away = np.linalg.norm(points - points[0], axis=1)
    for _ in range(count - 1):
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return points[chosen]
