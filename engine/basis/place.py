"""Bringing a performer's resting markers onto a face: by pairs, or by looking where on it they fit (ours)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from engine.errors import InputError
from engine.geometry.distance import closest_points
from engine.geometry.normals import vertex_normals
from engine.geometry.rigid import RigidTransform, align
from engine.mesh import FloatArray, IntArray, TriangleMesh
from engine.shapes import SKIN

_KEPT = 0.85
_ROUNDS, _FINAL_ROUNDS = 12, 30
_SMALLEST_SCALE, _LARGEST_SCALE = 0.7, 1.4


@dataclass(frozen=True)
class Surface:
    """What markers can be stuck to: the skin's faces, and its front for finding the way."""

    vertices: FloatArray
    faces: IntArray
    face_numbers: IntArray

    @classmethod
    def of(cls, mesh: TriangleMesh) -> Surface:
        """Return the skin of a mesh, or all of it where no part is called so."""
        numbers = mesh.parts[SKIN] if SKIN in mesh.parts else np.arange(len(mesh.faces))
        return cls(mesh.vertices, mesh.faces[numbers], np.asarray(numbers, dtype=np.int64))

    def nearest(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return the nearest surface point (k, 3) to points, and the mesh's face (k,) it lies on."""
        found, face = closest_points(points, self.vertices, self.faces)
        return found, self.face_numbers[face]


def place_by_pairs(source: FloatArray, target: FloatArray, scale: bool) -> RigidTransform:
    """Return the transform that brings paired markers (n, 3) onto their places on the face.

    Raises
    ------
    InputError
        For fewer than 3 pairs, or markers on a line.
    """
    try:
        return align(source, target, scale=scale)
    except InputError as error:
        raise InputError(
            f"pairs, {error.subject}", error.problem, "pair at least 3 markers that span a plane"
        ) from None


def place_on_face(points: FloatArray, mesh: TriangleMesh, scale: bool) -> RigidTransform:
    """Return the transform that brings resting face markers (K, 3), +Y up and +Z forward, onto a face.

    Many starts (height, depth, nod) are refined by trimmed point-to-plane steps against the front of the skin; the best
    is refined against the surface itself. With ``scale`` the size is found too, within 0.7 to 1.4.

    Raises
    ------
    InputError
        For fewer than 6 markers: too few say where on a face they are.
    """
    if len(points) < 6:
        problem = f"are {len(points)}, too few to find their place on the face"
        raise InputError("markers", problem, "give a pairs file")
    surface = Surface.of(mesh)
    used = np.unique(surface.faces)
    normals = vertex_normals(mesh.vertices, surface.faces)
    front = used[normals[used, 2] > 0.1]
    front = front if len(front) >= 100 else used
    places, directions = mesh.vertices[front], normals[front]
    tree = cKDTree(places)
    starts = _starts(points, places, scale)
    tried = [_refined(points, start, tree, places, directions, scale, _ROUNDS) for start in starts]
    best = min(tried, key=lambda found: found[1])[0]
    best = _refined(points, best, tree, places, directions, scale, _FINAL_ROUNDS)[0]
    return _on_surface(points, best, surface, scale)


def _starts(points: FloatArray, front: FloatArray, scale: bool) -> list[RigidTransform]:
    low, high = np.percentile(front, [2, 98], axis=0)
    middle = points.mean(axis=0)
    sizes = [1.0]
    if scale:
        # The width of a face is what neither neck nor crown changes.
        ratio = (high - low)[0] / max(float(np.ptp(points[:, 0])), 1e-9)
        sizes = [0.75 * ratio, 0.95 * ratio]
    starts = []
    for size in sizes:
        for nod in np.deg2rad((-20, 0, 20)):
            rotation = Rotation.from_rotvec([nod, 0, 0]).as_matrix()
            for height in np.linspace(0.1, 0.9, 9):
                at = np.array([(low[0] + high[0]) / 2, low[1] + height * (high[1] - low[1]), 0.0])
                turned = size * (points - middle) @ rotation.T + at
                # Pushed in from the front until half of it has touched the nearest skin.
                near = cKDTree(front[:, :2]).query(turned[:, :2])[1]
                at[2] = float(np.median(front[near, 2] - turned[:, 2]))
                starts.append(RigidTransform(rotation, at - size * rotation @ middle, float(size)))
    return starts


def _refined(
    points: FloatArray,
    start: RigidTransform,
    tree: cKDTree,
    places: FloatArray,
    normals: FloatArray,
    scale: bool,
    rounds: int,
) -> tuple[RigidTransform, float]:
    """Return the transform after some trimmed point-to-plane steps, and its cost: the trimmed RMS distance."""
    found = start
    kept = max(6, round(_KEPT * len(points)))
    for _ in range(rounds):
        moved = found.apply(points)
        away, near = (np.asarray(part) for part in tree.query(moved))
        keep = np.argsort(away)[:kept]
        step = _plane_step(moved[keep], places[near[keep]], normals[near[keep]], scale)
        # The markers' spread is what a free size would shrink to nothing; it stays near the start's.
        if not 0.8 * start.scale <= step.scale * found.scale <= 1.25 * start.scale:
            step = _plane_step(moved[keep], places[near[keep]], normals[near[keep]], False)
        found = step.after(found)
    away = np.sort(np.asarray(tree.query(found.apply(points))[0]))[:kept]
    return found, float(np.sqrt((away**2).mean())) / (found.scale / start.scale)


def _plane_step(points: FloatArray, places: FloatArray, normals: FloatArray, scale: bool) -> RigidTransform:
    """One linearised step (Chen & Medioni 1992), lightly held back so that flat places do not slide."""
    middle = points.mean(axis=0)
    local = points - middle
    columns = [np.cross(local, normals), normals]
    if scale:
        columns.append(np.einsum("ki,ki->k", local, normals)[:, None])
    table = np.hstack(columns)
    right = np.einsum("ki,ki->k", places - points, normals)
    size = float(np.sqrt((local**2).sum(axis=1).mean()))
    damping = np.array([size] * 3 + [1.0] * 3 + ([size] if scale else [])) * 0.05 * np.sqrt(len(points))
    solved = np.linalg.lstsq(
        np.vstack([table, np.diag(damping)]), np.append(right, np.zeros(len(damping))), rcond=None
    )[0]
    rotation = Rotation.from_rotvec(solved[:3]).as_matrix()
    factor = 1.0 + float(np.clip(solved[6], -0.1, 0.1)) if scale else 1.0
    return RigidTransform(rotation, middle + solved[3:6] - factor * rotation @ middle, factor)


def _on_surface(points: FloatArray, start: RigidTransform, surface: Surface, scale: bool) -> RigidTransform:
    """Last steps against the triangles themselves."""
    found = start
    kept = max(6, round(_KEPT * len(points)))
    for _ in range(4):
        moved = found.apply(points)
        near, face = closest_points(moved, surface.vertices, surface.faces)
        corner = surface.vertices[surface.faces[face]]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        keep = np.argsort(np.linalg.norm(near - moved, axis=1))[:kept]
        found = _plane_step(moved[keep], near[keep], normal[keep], scale).after(found)
    return found
