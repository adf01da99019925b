"""How the displacements of a few markers move every vertex of a mesh: linear, exact at the markers, zero far away."""

from __future__ import annotations

from typing import Literal

from engine.basis.binding import MarkerBinding
from engine.basis.spread_rbf import spread_rbf
from engine.mesh import FloatArray, TriangleMesh, frozen
from engine.progress import Progress, silent

SpreadMethod = Literal["surface", "rbf"]


def spread(
    mesh: TriangleMesh,
    binding: MarkerBinding,
    method: SpreadMethod = "rbf",
    *,
    reach_mm: float = 45.0,
    progress: Progress = silent,
) -> FloatArray:
    """Return ``phi`` (N, K): displacement of every vertex per displacement of every marker (Kim & Ko 2007, 5.2).

    Parameters
    ----------
    mesh : TriangleMesh
        The neutral face.
    binding : MarkerBinding
        Where the K markers sit on it.
    method : {"surface", "rbf"}
        ``rbf`` is the paper's, in space.
    reach_mm : float
        Beyond this distance from all markers nothing moves.
    progress : callable
        See ``engine.progress``.

    Returns
    -------
    (N, K) float
        Interpolating: ``binding.on(phi, mesh.faces)`` is the identity.
    """
    progress(0.0, "spreading the markers over the mesh")
    phi = spread_rbf(mesh, binding, reach_mm)
    progress(1.0, "")
    return frozen(phi, float)
