"""A textured triangle mesh from a file: Wavefront OBJ, PLY or GLB."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.glb_mesh import read_glb_mesh
from engine.files.mesh_parts import FARTHEST_PLACE, RawMesh
from engine.files.mesh_unit import mesh_unit, mm_per_unit
from engine.files.obj_mesh import read_obj_mesh
from engine.files.ply_mesh import read_ply_mesh
from engine.files.scan_file import FARTHEST_MM
from engine.files.source import checked_file
from engine.files.textures import cover
from engine.mesh import BoolArray, TriangleMesh, frozen
from engine.scan.range_image import ColourImage

_READERS: dict[str, Callable[[Path], RawMesh]] = {".obj": read_obj_mesh, ".ply": read_ply_mesh, ".glb": read_glb_mesh}
MESH_SUFFIXES = tuple(_READERS)
"""Endings of the files that may hold a mesh."""
_SMALLEST_EXTENT, _LARGEST_EXTENT = 1e-3, 1e8
"""Largest side, in the file's own unit, of what can be brought to the size of a head."""


@dataclass(frozen=True)
class MeshFile:
    """A mesh as it was read, and what was taken for granted.

    Parameters
    ----------
    mesh : TriangleMesh
        Positions in mm, in the file's own frame; ``uv`` is there exactly when ``texture`` is.
    texture : (h, w, 3) uint8, optional
        sRGB picture; those of several materials are packed into one.
    colours : (N, 3) uint8, optional
        sRGB colour per vertex. Together with a texture it is a factor, 255 meaning 1.
    unit : str
        ``mm``, ``cm``, ``m``, or the millimetres of one unit of the file, as ``"85.3 mm"``.
    assumed : str
        In words, where the unit came from.
    source_files : tuple of Path
        All files that were read, the one the user named first.
    warnings : tuple of str
        What was left out or is unlikely.
    format : str
        ``obj``, ``ply`` or ``glb``.
    """

    mesh: TriangleMesh
    texture: ColourImage | None
    colours: NDArray[np.uint8] | None
    unit: str
    assumed: str
    source_files: tuple[Path, ...]
    warnings: tuple[str, ...] = ()
    format: str = "obj"

    @property
    def mm_per_unit(self) -> float:
        """Millimetres in one unit of the file."""
        return mm_per_unit(self.unit)


def read_mesh(path: str | Path, unit: str | None = None) -> MeshFile:
    """Read a mesh with its texture or colours.

    Parameters
    ----------
    path : str or Path
        OBJ with its MTL and pictures beside it, PLY, or GLB.
    unit : str, optional
        ``mm``, ``cm``, ``m`` or the millimetres of one unit, ``"85.3 mm"``. Left out, the file's own word counts
        (GLB is in metres), or where it has none the unit that makes a head; ``MeshFile.assumed`` says which.

    Raises
    ------
    InputError
        When the file is no mesh that can be read, or holds no triangle.
    """
    if unit is not None:
        mm_per_unit(unit)
    path = checked_file(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(str(path), "is not a mesh that can be read", "give an .obj, .ply or .glb file")
    try:
        return _assembled(path, reader(path), unit)
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "check the file and the disk") from error


def _assembled(path: Path, raw: RawMesh, wanted: str | None) -> MeshFile:
    subject, notes = str(path), list(raw.notes)
    vertices = np.asarray(raw.vertices, dtype=np.float64)
    finite: BoolArray = np.asarray(np.isfinite(vertices).all(axis=1), dtype=bool)
    sound: BoolArray = np.asarray(finite[raw.faces].all(axis=1), dtype=bool)
    if not sound.all():
        notes.append(f"{int((~sound).sum())} faces at positions that are no numbers were left out")
        raw = raw.with_faces(sound)
    if not len(raw.faces):
        raise InputError(subject, "holds no triangles", "export the surface, not only points or lines")
    used = np.unique(raw.faces)
    low, high = vertices[used].min(axis=0), vertices[used].max(axis=0)
    with np.errstate(over="ignore"):
        extent = float((high - low).max())
    if not _SMALLEST_EXTENT < extent < _LARGEST_EXTENT:
        raise InputError(subject, f"is {extent:.3g} units large", "export it again")
    unit, assumed, warnings = mesh_unit(wanted, raw.unit, extent)
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = vertices * mm_per_unit(unit)
    farthest = float(np.abs(vertices[used]).max())
    if farthest > FARTHEST_MM:
        problem = f"a coordinate of {farthest:.3g} mm, more than {FARTHEST_MM:.0e} mm"
        raise InputError(f"{subject}, vertices", problem, f"check whether it is in {unit}, or move it to the origin")
    # Vertices that no face uses keep their numbers, but a position that is no number has no place in a mesh.
    lost = ~np.isfinite(vertices).all(axis=1) | (np.abs(vertices) > FARTHEST_MM).any(axis=1)
    vertices[lost] = vertices[used[0]]
    raw = _with_sound_places(raw, notes)
    covering = cover(raw.materials, raw.face_material, raw.uv, raw.uv_faces)
    if covering.spilled:
        notes.append(f"{covering.spilled} faces repeat a picture across its edge: held at the edge")
    mesh = TriangleMesh(vertices, raw.faces, covering.uv, covering.uv_faces)
    texture = None if covering.texture is None else frozen(covering.texture, np.uint8)
    colours = None if raw.colours is None else frozen(raw.colours, np.uint8)
    files = (path, *dict.fromkeys(raw.files))
    return MeshFile(mesh, texture, colours, unit, assumed, files, (*notes, *warnings), path.suffix.lower()[1:])


def _with_sound_places(raw: RawMesh, notes: list[str]) -> RawMesh:
    """Take away texture coordinates that are no numbers or beyond ``FARTHEST_PLACE``; ``notes`` says how many."""
    if raw.uv is None or raw.uv_faces is None:
        return raw
    lost: BoolArray = np.asarray(~(np.abs(raw.uv) <= FARTHEST_PLACE).all(axis=1), dtype=bool)
    if not lost.any():
        return raw
    gone = (raw.uv_faces >= 0) & lost[raw.uv_faces]
    number = int(gone.any(axis=1).sum())
    if number and any(material.texture is not None for material in raw.materials):
        notes.append(f"{number} faces have texture coordinates that are no numbers or too large: left out")
    return replace(raw, uv=np.where(lost[:, None], 0.0, raw.uv), uv_faces=np.where(gone, -1, raw.uv_faces))
