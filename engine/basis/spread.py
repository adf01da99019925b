"""How the displacements of a few markers move every vertex of a mesh: linear, exact at the markers, zero far away."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from engine.basis.binding import MarkerBinding
from engine.errors import InputError, some
from engine.mesh import FloatArray, IntArray, TriangleMesh, frozen
from engine.progress import Progress, silent

SpreadMethod = Literal["surface", "rbf"]

REACH_MM = 60.0
"""Beyond this distance from all markers nothing moves."""

JAW_PARTS = ("teeth_lower", "lower_teeth", "tongue", "jaw", "gums_lower", "lower_gums")
"""Parts that follow the chin; every other part without a marker stays still: upper teeth, eyes, hair."""

TEETH = "teeth"
"""A part that holds both rows: its lower pieces follow the chin."""

_TOGETHER_MM = 0.05
_CHIN_BELOW_MM = (15.0, 50.0)
_CHIN_BESIDE_MM = 15.0


def spread(
    mesh: TriangleMesh,
    binding: MarkerBinding,
    method: SpreadMethod = "surface",
    *,
    reach_mm: float = REACH_MM,
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
        ``surface`` (ours) follows the skin: lips and lids move apart. ``rbf`` is the paper's, in space.
    reach_mm : float
        Beyond this distance from all markers nothing moves.
    progress : callable
        See ``engine.progress``.

    Returns
    -------
    (N, K) float
        ``binding.on(phi, mesh.faces)`` is the identity. Parts that no marker sits on stay still, but for those named
        in `JAW_PARTS`: they follow the chin as a whole (ours).

    Raises
    ------
    InputError
        When two markers sit in one place, more than three in one triangle, or ``method`` is not known.
    """
    points = binding.points(mesh)
    _check_apart(points, binding.labels)
    progress(0.0, "spreading the markers over the mesh")
    # Each of the two pulls in a part of SciPy that the other does without.
    if method == "surface":
        from engine.basis.spread_surface import spread_surface

        phi = spread_surface(mesh, binding, reach_mm)
    elif method == "rbf":
        from engine.basis.spread_rbf import spread_rbf

        phi = spread_rbf(mesh, binding, reach_mm)
        piece = _pieces(mesh)
        phi[~np.isin(piece, piece[mesh.faces[binding.faces, 0]])] = 0.0
    else:
        raise InputError("method", f"{str(method)[:20]!r} is not known", "choose surface or rbf")
    _follow_jaw(mesh, binding, phi)
    progress(1.0, "")
    spread_over: FloatArray = frozen(phi, np.float64)
    return spread_over


def _check_apart(points: FloatArray, labels: tuple[str, ...]) -> None:
    if not len(points):
        raise InputError("markers", "are none", "bind at least one")
    away = cdist(points, points)
    np.fill_diagonal(away, np.inf)
    if away.min() < _TOGETHER_MM:
        pair = np.unravel_index(int(away.argmin()), away.shape)
        raise InputError(f"markers {some([labels[k] for k in pair])}", "sit in one place", "leave one of them out")


def _pieces(mesh: TriangleMesh) -> IntArray:
    """Return the number (N,) of the connected piece that every vertex belongs to."""
    count = len(mesh.vertices)
    rows, columns = mesh.faces[:, [0, 1]].ravel(), mesh.faces[:, [1, 2]].ravel()
    joined = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    piece: IntArray = connected_components(joined, directed=False)[1].astype(np.int64)
    return piece


def _lower(height: FloatArray, part: IntArray, piece: IntArray) -> IntArray:
    """Return the vertices of a part whose pieces lie in its lower half; none where it is one piece."""
    pieces, of = np.unique(piece[part], return_inverse=True)
    middles = np.bincount(of, height[part]) / np.bincount(of)
    lower = middles < (middles.min() + middles.max()) / 2
    return part[lower[of]] if len(pieces) > 1 else part[:0]


def _follow_jaw(mesh: TriangleMesh, binding: MarkerBinding, phi: FloatArray) -> None:
    """Give parts of the jaw the mean motion of the chin before them, in place."""
    piece = _pieces(mesh)
    carried = np.isin(piece, piece[mesh.faces[binding.faces, 0]])
    skin = np.flatnonzero(carried & (np.abs(phi).sum(axis=1) > 0))
    for name, own in mesh.parts.items():
        if name.lower() not in (*JAW_PARTS, TEETH) or not len(own) or not len(skin):
            continue
        part = np.unique(mesh.faces[own])
        if name.lower() == TEETH:
            part = _lower(mesh.vertices[:, 1], part, piece)
        if not len(part) or carried[part].any():
            continue
        middle = mesh.vertices[part].mean(axis=0)
        beside, below, before = (mesh.vertices[skin] - middle).T
        chin = (np.abs(beside) < _CHIN_BESIDE_MM) & (before > 0)
        chin &= (-below > _CHIN_BELOW_MM[0]) & (-below < _CHIN_BELOW_MM[1])
        if chin.any():
            phi[part] = phi[skin[chin]].mean(axis=0)
