"""What the readers of mesh files have in common: the mesh as a file has it, and its limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.textures import Material
from engine.mesh import BoolArray, FloatArray, IntArray

MAX_VERTICES = 3_000_000
MAX_FACES = 3_000_000
MAX_MATERIALS = 500
FARTHEST_PLACE = 1e6
"""Texture coordinate above which it means nothing: no picture is repeated a million times."""


@dataclass(frozen=True)
class RawMesh:
    """A mesh in the file's own unit, its faces cut into triangles.

    ``uv`` has its origin at the top left, ``uv_faces`` is -1 where a corner has no coordinate, ``face_material`` an
    index into ``materials`` or -1, ``face_group`` one into ``group_names``, which an OBJ file has; ``unit`` is the
    file's own word, ``notes`` what was left out.
    """

    vertices: FloatArray
    faces: IntArray
    face_material: IntArray
    materials: Sequence[Material] = ()
    uv: FloatArray | None = None
    uv_faces: IntArray | None = None
    colours: NDArray[np.uint8] | None = None
    unit: str | None = None
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = field(default=())
    face_group: IntArray | None = None
    group_names: tuple[str, ...] = ()

    def with_faces(self, kept: BoolArray) -> RawMesh:
        """Return the mesh with some of its faces."""
        uv_faces = None if self.uv_faces is None else self.uv_faces[kept]
        group = None if self.face_group is None else self.face_group[kept]
        material = self.face_material[kept]
        return replace(self, faces=self.faces[kept], face_material=material, uv_faces=uv_faces, face_group=group)


def check_counts(subject: str, vertices: int, faces: int) -> None:
    """Raise InputError for a mesh beyond ``MAX_VERTICES`` or ``MAX_FACES``."""
    for name, count, most in (("vertices", vertices, MAX_VERTICES), ("triangles", faces, MAX_FACES)):
        if count > most:
            problem = f"has {count} {name}, more than {most // 1_000_000} million"
            raise InputError(subject, problem, "decimate it in the program it comes from")


def check_faces(subject: str, faces: IntArray, count: int) -> None:
    """Raise InputError when an index is outside 0..count - 1."""
    if len(faces) and (faces.min() < 0 or faces.max() >= count):
        raise InputError(f"{subject}, faces", f"an index is outside the {count} vertices", "export it again")


def fans(sizes: IntArray) -> tuple[IntArray, IntArray]:
    """Return (corners (T, 3), polygon (T,)) of polygons of ``sizes`` (P,) corners cut into fans.

    Corners count through all polygons; those with fewer than three corners have no triangle.
    """
    number = np.maximum(sizes - 2, 0)
    polygon = np.repeat(np.arange(len(sizes)), number)
    start = np.cumsum(sizes) - sizes
    step = np.arange(len(polygon)) - np.repeat(np.cumsum(number) - number, number)
    first = start[polygon]
    return np.stack([first, first + step + 1, first + step + 2], axis=1), polygon


def byte_colours(colours: FloatArray) -> NDArray[np.uint8]:
    """Return sRGB bytes of colours (N, 3) that are 0..1, or 0..255 where one is above 1; no number is black."""
    values = np.nan_to_num(np.asarray(colours, dtype=np.float64), posinf=0.0, neginf=0.0)
    scale = 255.0 if values.max(initial=0.0) <= 1.0 else 1.0
    return np.clip(np.rint(values * scale), 0, 255).astype(np.uint8)
