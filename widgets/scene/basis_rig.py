"""What all pictures of one rig share: its parts with their materials, baked shadow, and how normals follow points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.mesh import BoolArray, FloatArray, IntArray, TriangleMesh
from widgets.scene.background import rgb
from widgets.scene.basis_eyes import iris_colours
from widgets.scene.basis_normals import Float32, VertexNormals
from widgets.scene.materials import CLAY, EYE, HAIR, MOUTH, TEETH, TONGUE, Material
from widgets.scene.occlusion import openness, tint

_DEPTH = {"skin": 0.62, "teeth": 0.62, "tongue": 0.45, "mouth": 0.7}
"""How much of the shadow in hollows each part takes; eyes and hair take none."""
_EDGE_MM = 2.6
_INSIDE = ("teeth", "tongue", "mouth")
_DARK_MM, _DARKEST = 50.0, 0.14
"""How far behind the lips no light comes, and how much is left of a colour there."""
_WORDS: tuple[tuple[str, str], ...] = (
    ("eyelash", "hair"), ("lash", "hair"), ("eyebrow", "hair"), ("brow", "hair"), ("hair", "hair"),
    ("socket", "skin"), ("eye", "eye"), ("teeth", "teeth"), ("tooth", "teeth"), ("tongue", "tongue"),
    ("gum", "mouth"), ("mouth", "mouth"),
)  # fmt: skip
MATERIALS: Mapping[str, Material] = {
    "skin": CLAY,
    "eye": EYE,
    "teeth": TEETH,
    "tongue": TONGUE,
    "mouth": MOUTH,
    "hair": HAIR,
}


@dataclass(frozen=True)
class Pose:
    """Points and unit normals (N, 3) float32 of a rig in one expression, mm."""

    points: Float32
    normals: Float32


@dataclass(frozen=True)
class Piece:
    """The faces of one material, on vertices of their own.

    Attributes
    ----------
    material : str
        A key of ``MATERIALS``.
    source : (n,) int
        The rig's vertex behind each of its vertices; a texture seam splits one into several.
    faces : (f, 3) int
        Indices into ``source``.
    uv : (n, 2) float32 or None
        Texture coordinates, origin **bottom** left as VTK counts them.
    colours : (n, 3) uint8
        The material's colour with baked shadow.
    """

    material: str
    source: NDArray[np.intp]
    faces: IntArray
    uv: Float32 | None
    colours: NDArray[np.uint8]


class RigLook:
    """A rig made ready to be drawn many times; nothing of it is changed afterwards.

    Parameters
    ----------
    mesh : TriangleMesh
        The neutral face, mm.
    skin : (V,) int or (N,) bool, optional
        Vertices that figures are measured on; all where left out.
    texture : (H, W, 3) uint8, optional
        Used where the mesh has a chart.
    """

    def __init__(
        self, mesh: TriangleMesh, skin: NDArray[Any] | None = None, texture: NDArray[np.uint8] | None = None
    ) -> None:
        count = len(mesh.vertices)
        self.count = count
        self.skin: BoolArray = np.zeros(count, dtype=bool)
        self.skin[slice(None) if skin is None else np.asarray(skin)] = True
        self.texture = None if texture is None or mesh.uv is None else np.array(texture, dtype=np.uint8)
        self._normals = VertexNormals(mesh.faces, count)
        self.neutral = self.pose(mesh.vertices)
        self._open = openness(mesh.vertices, mesh.faces, self.neutral.normals.astype(np.float64), _EDGE_MM)
        names = _material_of_faces(mesh)
        teeth = mesh.vertices[np.unique(mesh.faces[np.isin(names, _INSIDE[:2])])]
        self._lips = float(teeth[:, 2].max()) if len(teeth) else None
        self.pieces = tuple(
            self._piece(mesh, name, np.flatnonzero(names == name)) for name in MATERIALS if (names == name).any()
        )
        used = self.neutral.points[np.unique(mesh.faces)] if len(mesh.faces) else self.neutral.points
        self.outline: FloatArray = head_of(used.astype(np.float64))

    def pose(self, positions: NDArray[Any]) -> Pose:
        """Return points and normals of positions (N, 3) in mm, copied."""
        points = np.array(positions, dtype=np.float32, order="C")
        normals = np.empty_like(points)
        self._normals.into(points, normals)
        return Pose(points, normals)

    def moved(self, displacements: NDArray[Any]) -> Pose:
        """Return the pose that displacements (N, 3) in mm make of the neutral face."""
        return self.pose(self.neutral.points + np.asarray(displacements, dtype=np.float32))

    def openness_of(self, piece: Piece) -> FloatArray:
        """Return how open the ground is at a piece's vertices, 0..1."""
        return np.asarray(self._open[piece.source])

    def _piece(self, mesh: TriangleMesh, name: str, faces: IntArray) -> Piece:
        corners = mesh.faces[faces]
        uv = None
        if self.texture is not None and mesh.uv is not None and mesh.uv_faces is not None:
            pairs = np.stack([corners.ravel(), mesh.uv_faces[faces].ravel()], axis=1)
            split, local = np.unique(pairs, axis=0, return_inverse=True)
            source, chart = split[:, 0], mesh.uv[split[:, 1]]
            uv = np.stack([chart[:, 0], 1.0 - chart[:, 1]], axis=1).astype(np.float32)
        else:
            source, local = np.unique(corners, return_inverse=True)
        base = np.tile(np.array(rgb(MATERIALS[name].colour)) * 255.0, (len(source), 1))
        if name == "eye":
            base = iris_colours(mesh, faces, source, base)
        shadow = tint(self._open[source], _DEPTH.get(name, 0.0))
        if name in _INSIDE and self._lips is not None:
            # A shape that opens the mouth lets light in from the front alone: without this its floor is a flat slab.
            behind = np.clip((self._lips - mesh.vertices[source, 2]) / _DARK_MM, 0.0, 1.0)
            shadow = shadow * (1.0 - (1.0 - _DARKEST) * behind)[:, None]
        colours = np.clip(base * shadow + 0.5, 0, 255).astype(np.uint8)
        return Piece(name, source.astype(np.intp), local.reshape(-1, 3).astype(np.int64), uv, colours)


def head_of(points: FloatArray) -> FloatArray:
    """Return those points (k, 3) of a rig, +Y up, that make its head: without shoulders, with a little neck.

    The neck begins where the rig, from its widest downwards, has become nearly as narrow as it ever gets; a rig that
    stays wide has none.
    """
    if len(points) < 100:
        return points
    high, low = float(points[:, 1].max()), float(points[:, 1].min())
    steps = np.linspace(high, low, 41)
    level = np.clip(np.searchsorted(-steps, -points[:, 1]) - 1, 0, 39)
    width = np.array([np.ptp(points[level == k, 0]) if (level == k).any() else np.inf for k in range(40)])
    finite = np.where(np.isfinite(width), width, 0.0)
    widest = int(finite[:20].argmax())
    narrow = float(width[widest:].min())
    if narrow > 0.85 * finite[widest] or widest + int(width[widest:].argmin()) >= 39:
        return points
    neck = widest + int(np.argmax(width[widest:] <= 1.06 * narrow))
    cut = steps[neck] - 0.16 * (high - steps[neck])
    beside = np.abs(points[:, 0] - np.median(points[:, 0])) <= 0.5 * finite[: neck + 1].max() + 1.0
    return np.asarray(points[(points[:, 1] >= cut) & beside])


def material_of(part: str) -> str:
    """Return the material, a key of ``MATERIALS``, of a part by its name; skin where it says nothing else."""
    plain = part.lower()
    return next((material for word, material in _WORDS if word in plain), "skin")


def _material_of_faces(mesh: TriangleMesh) -> NDArray[Any]:
    names = np.full(len(mesh.faces), "skin", dtype="U8")
    for part, faces in mesh.parts.items():
        names[faces] = material_of(part)
    return names
