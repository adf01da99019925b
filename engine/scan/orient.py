"""Which way a head looks: its mirror plane, and in that plane the place that looks like a face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.errors import InputError
from engine.mesh import FloatArray, TriangleMesh, frozen
from engine.scan.face_relief import FaceMatch, find_faces, refine_face
from engine.scan.mirror_plane import MirrorPlane, mirror_planes

SURE = 0.5
"""Confidence from which an orientation is taken without a question."""

_SAMPLES = 40_000
_PLANE_SAMPLES = 5_000
_FACE_BELOW_MM, _FACE_ABOVE_MM = 70.0, 90.0


@dataclass(frozen=True)
class Orientation:
    """How a face lies in a mesh.

    Attributes
    ----------
    rotation : (3, 3) float
        Turns the mesh so that the face looks along +Z with +Y up; its rows are the subject's left, up, and forward.
    face_centre : (3,) float
        Middle of the face, a little behind the tip of the nose, in the mesh's own frame, mm.
    face_height_mm : float
        About from the chin to the hair line.
    symmetry : float
        Share of the surface that is symmetric, 0..1.
    likeness : float
        How much the relief is like that of an average face, -1..1.
    confidence : float
        0..1; below `SURE` the user should look.
    """

    rotation: FloatArray
    face_centre: FloatArray
    face_height_mm: float
    symmetry: float
    likeness: float
    confidence: float


def orient(mesh: TriangleMesh, seed: int = 0) -> Orientation:
    """Find the face of a mesh in any position.

    Parameters
    ----------
    mesh : TriangleMesh
        A head or face in about mm: half to one and a half times the size of an average one.
    seed : int
        Of the points that are drawn from the surface; the same seed gives the same answer.

    Raises
    ------
    InputError
        For a mesh without area.
    """
    points, normals = surface_points(mesh, _SAMPLES, seed)
    planes = mirror_planes(points[:_PLANE_SAMPLES], normals[:_PLANE_SAMPLES])
    angles = np.deg2rad(np.arange(0, 360, 9.0))
    found: list[tuple[float, MirrorPlane, FaceMatch, FloatArray]] = []
    for plane in planes:
        axes = _axes(plane)
        sideways = points @ plane.normal - plane.offset
        flat = points @ axes.T
        some = slice(None, 25_000)
        for match in sorted(find_faces(sideways[some], flat[some], angles, stride=2), key=lambda m: -m.likeness)[:1]:
            found.append((plane.score * max(match.likeness, 0.0), plane, match, flat))
    if not found:
        return _unknown(points)
    found.sort(key=lambda item: -item[0])
    _, plane, match, flat = found[0]
    match = refine_face(points @ plane.normal - plane.offset, flat, match)
    axes = _axes(plane)
    forward = np.cos(match.angle) * axes[0] + np.sin(match.angle) * axes[1]
    up = match.up * (-np.sin(match.angle) * axes[0] + np.cos(match.angle) * axes[1])
    left = np.cross(up, forward)
    rotation = np.stack([left, up, forward])
    inwards = match.depth - 25 * match.scale
    nose = plane.offset * plane.normal + match.height * up + inwards * forward
    middle = (_FACE_ABOVE_MM - _FACE_BELOW_MM) / 2 * match.scale
    height = (_FACE_ABOVE_MM + _FACE_BELOW_MM) * match.scale
    confidence = float(np.clip((plane.score - 0.1) / 0.2, 0, 1) * np.clip((match.likeness - 0.6) / 0.2, 0, 1))
    return Orientation(
        frozen(rotation, np.float64), frozen(nose + middle * up, np.float64), height, plane.score, match.likeness,
        confidence,
    )  # fmt: skip


def surface_points(mesh: TriangleMesh, count: int, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """Return points (count, 3) spread evenly over a mesh at random, and their unit face normals.

    Raises
    ------
    InputError
        For a mesh without area.
    """
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(cross, axis=1)
    total = double.sum()
    if not total > 0:
        raise InputError("mesh", "has no area", "check that it is a surface")
    rng = np.random.default_rng(seed)
    face = np.minimum(np.searchsorted(np.cumsum(double), rng.random(count) * total), len(double) - 1)
    a, b = rng.random((2, count, 1))
    over = a + b > 1
    a, b = np.where(over, 1 - a, a), np.where(over, 1 - b, b)
    c = corners[face]
    points = c[:, 0] + a * (c[:, 1] - c[:, 0]) + b * (c[:, 2] - c[:, 0])
    return points, cross[face] / np.maximum(double[face], 1e-300)[:, None]


def _axes(plane: MirrorPlane) -> FloatArray:
    """Return two unit vectors (2, 3) in the plane, the second a quarter turn on from the first about its normal."""
    first = np.cross(plane.normal, [1.0, 0, 0] if abs(plane.normal[0]) < 0.8 else [0, 1.0, 0])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(plane.normal, first)])


def _unknown(points: FloatArray) -> Orientation:
    low, high = points.min(axis=0), points.max(axis=0)
    height = float((high - low).max())
    return Orientation(np.eye(3), (low + high) / 2, height, 0.0, 0.0, 0.0)
