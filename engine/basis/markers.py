"""Recorded markers on a face: freed of the head's motion, gaps filled, bound to its surface, spread over the mesh."""

from __future__ import annotations

from collections.abc import Sequence

from engine.basis.binding import BoundMarkers, MarkerBinding, MarkerPair, Pairs
from engine.basis.spread import SpreadMethod, spread
from engine.mesh import FloatArray, TriangleMesh
from engine.motion import MarkerClip, MeshMotion
from engine.progress import Progress, silent

__all__ = ["BoundMarkers", "MarkerBinding", "MarkerPair", "bind_markers", "marker_motion", "spread"]


def bind_markers(
    mesh: TriangleMesh,
    clip: MarkerClip,
    *,
    pairs: Pairs | None = None,
    head: Sequence[str] = (),
    rest_frame: int | None = None,
    scale: bool = False,
    farthest_mm: float = 15.0,
    longest_gap_s: float = 0.2,
    progress: Progress = silent,
) -> BoundMarkers:
    """Return a clip bound to a mesh.

    Parameters
    ----------
    mesh : TriangleMesh
        The neutral face, mm.
    clip : MarkerClip
        mm, +Y up, +Z out of the face.
    pairs : sequence of MarkerPair, optional
        Where markers sit; those without a pair, and all without any pairs, sit at the nearest surface point after
        alignment.
    head : sequence of str
        Markers on the head, whose rigid motion is removed; they are not bound to the face.
    rest_frame : int, optional
        The frame that shows the neutral face, from 0; the first that shows the most markers where left out.
    scale : bool
        Whether the performer's size is fitted to the mesh.
    farthest_mm : float
        A marker further from the surface is warned about.
    longest_gap_s : float
        Gaps up to this long are interpolated in time, longer ones filled from the other markers.
    progress : callable
        See ``engine.progress``.

    Raises
    ------
    InputError
        On labels that the clip does not have, fewer than 3 usable markers, head markers on a line.
    """
    from engine.basis.bind import bound

    return bound(mesh, clip, pairs, tuple(head), rest_frame, scale, farthest_mm, longest_gap_s, progress)


def marker_motion(
    mesh: TriangleMesh, bound: BoundMarkers, phi: FloatArray | None = None, method: SpreadMethod | None = None
) -> MeshMotion:
    """Return the motion of the mesh under bound markers, factored (Kim & Ko 2007, section 5.2).

    Parameters
    ----------
    mesh : TriangleMesh
        The neutral face the clip is bound to.
    bound : BoundMarkers
        From ``bind_markers``.
    phi : (N, K) float, optional
        From ``spread``; made where left out.
    method : {"surface", "rbf"}, optional
        How it is made.
    """
    if phi is None:
        phi = spread(mesh, bound.binding) if method is None else spread(mesh, bound.binding, method)
    return MeshMotion.factored(phi, bound.displacements, mesh.vertices, bound.fps)
