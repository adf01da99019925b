"""A face with the shapes that move it, from a file: GLB with morph targets, a folder of OBJs, or a NumPy archive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from engine.errors import InputError, some
from engine.files.glb_rig import read_glb_rig
from engine.files.mesh_unit import mesh_unit, mm_per_unit
from engine.files.npz_rig import read_npz_rig
from engine.files.obj_rig import read_obj_rig
from engine.files.rig_raw import RawRig, check_size
from engine.files.scan_file import FARTHEST_MM, MM_PER_UNIT
from engine.files.source import checked_file, kind_of
from engine.mesh import FloatArray, TriangleMesh, frozen
from engine.name_text import clean_names, told
from engine.scan.range_image import ColourImage
from engine.shapes import ExpressionBasis, Rig, check_names

_READERS: dict[str, Callable[[Path], RawRig]] = {".glb": read_glb_rig, ".npz": read_npz_rig}
RIG_SUFFIXES = (".glb", ".npz", ".obj")
"""Endings of the files that may hold a rig; an ``.obj`` stands for the folder it lies in."""
_SMALLEST_EXTENT, _LARGEST_EXTENT = 1e-3, 1e8
_STILL = 1e-9
"""Displacement in mm below which a vertex stands still."""


@dataclass(frozen=True)
class RigFile:
    """A rig as it was read, and what was taken for granted.

    Parameters
    ----------
    rig : Rig
        Mesh and shapes in mm, in the file's own frame.
    unit : str
        ``mm``, ``cm``, ``m``, or the millimetres of one unit of the file, as ``"85.3 mm"``.
    assumed : str
        In words, where the unit came from.
    source_files : tuple of Path
        All files that were read, the one the user named first.
    warnings : tuple of str
        What was joined, left out or is unlikely.
    format : str
        ``glb``, ``obj`` or ``npz``.
    texture : (h, w, 3) uint8, optional
        sRGB picture for the mesh's texture chart.
    """

    rig: Rig
    unit: str
    assumed: str
    source_files: tuple[Path, ...]
    warnings: tuple[str, ...] = ()
    format: str = "npz"
    texture: ColourImage | None = None

    @property
    def mm_per_unit(self) -> float:
        """Millimetres in one unit of the file."""
        return mm_per_unit(self.unit)


def read_rig(path: str | Path, unit: str | None = None) -> RigFile:
    """Read a rig: a neutral face, its shapes with names, and the mean displacement of an affine basis.

    Parameters
    ----------
    path : str or Path
        A ``.glb`` with morph targets, a ``.npz``, or a folder of OBJs of one topology (or one file of it).
    unit : str, optional
        ``mm``, ``cm``, ``m`` or the millimetres of one unit, ``"85.3 mm"``. Left out, the file's own word counts
        (GLB is in metres), or where it has none the unit that makes a head; ``RigFile.assumed`` says which.

    Raises
    ------
    InputError
        When the file is no rig that can be read: no shapes, names that stand for several, other topologies,
        numbers that are not finite, sizes that the file does not bear out.
    """
    if unit is not None:
        mm_per_unit(unit)
    path = Path(path)
    if kind_of(path) == "folder":
        return _assembled(path, read_obj_rig(path), unit, "obj")
    path = checked_file(path)
    if path.suffix.lower() == ".obj":
        return _assembled(path, read_obj_rig(path.parent), unit, "obj")
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        remedy = "give a .glb with morph targets, a folder of .obj files, or a .npz"
        raise InputError(str(path), "is not a rig that can be read", remedy)
    try:
        raw = reader(path)
        return _assembled(path, raw, unit, path.suffix.lower()[1:])
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "check the file and the disk") from error


def _assembled(path: Path, raw: RawRig, wanted: str | None, form: str) -> RigFile:
    subject = str(path)
    raw = _named(raw)
    check_size(subject, len(raw.names), len(raw.vertices))
    if not len(raw.faces):
        raise InputError(subject, "holds no triangles", "export the surface, not only points or lines")
    try:
        check_names(tuple(raw.names), len(raw.displacements))
        unit, assumed, warnings = _unit(raw, wanted)
        rig = _scaled(raw, mm_per_unit(unit))
    except InputError as error:
        raise InputError(f"{subject}, {error.subject}", error.problem, error.remedy) from error
    still = [name for name, d in zip(raw.names, rig.basis.displacements, strict=True) if np.abs(d).max() < _STILL]
    if still:
        warnings = (*warnings, f"{len(still)} shapes move nothing: {some(still)}")
    texture = None if raw.texture is None else frozen(raw.texture, np.uint8)
    files = (path, *dict.fromkeys(file for file in raw.files if file != path))
    return RigFile(rig, unit, assumed, files, (*raw.notes, *warnings), form, texture)


def _named(raw: RawRig) -> RawRig:
    """Return a rig whose names any project can hold; which of them were changed is in its notes."""
    names, changed = clean_names(raw.names)
    parts, others = clean_names(tuple(raw.parts))
    if not changed and not others:
        return raw
    renamed = dict(zip(parts, raw.parts.values(), strict=True))
    notes = (*raw.notes, *told(changed, "shape"), *told(others, "part"))
    return replace(raw, names=names, parts=renamed, notes=notes)


def _unit(raw: RawRig, wanted: str | None) -> tuple[str, str, tuple[str, ...]]:
    if not np.isfinite(raw.vertices).all():
        bad = int((~np.isfinite(raw.vertices)).any(axis=1).sum())
        raise InputError("neutral", f"{bad} positions are not finite", "export it again")
    if raw.faces.min() < 0 or raw.faces.max() >= len(raw.vertices):
        raise InputError("faces", f"an index is outside the {len(raw.vertices)} vertices", "export it again")
    used = raw.vertices[np.unique(raw.faces)]
    with np.errstate(over="ignore"):
        extent = float((used.max(axis=0) - used.min(axis=0)).max())
    if not _SMALLEST_EXTENT < extent < _LARGEST_EXTENT:
        raise InputError("neutral", f"is {extent:.3g} units large", "export it again")
    if raw.unit is not None and raw.unit not in MM_PER_UNIT:
        raise InputError("unit", f"{raw.unit[:40]!r} is not known", "write mm, cm or m")
    return mesh_unit(wanted, raw.unit, extent)


def _scaled(raw: RawRig, factor: float) -> Rig:
    vertices, displacements = _times(raw.vertices, factor), _times(raw.displacements, factor)
    mean = None if raw.mean is None else _times(raw.mean, factor)
    for name, values in (("neutral", vertices), ("mean", mean)):
        _check_near(name, values)
    _check_near("displacements", displacements)
    mesh = TriangleMesh(vertices, raw.faces, raw.uv, raw.uv_faces if raw.uv is not None else None, raw.parts)
    return Rig(mesh, ExpressionBasis(mesh.vertices, tuple(raw.names), displacements, mean))


def _times(values: FloatArray, factor: float) -> FloatArray:
    """Return what a reader has made, in mm; in its own memory where that can be written to."""
    if factor != 1.0:
        with np.errstate(over="ignore", invalid="ignore"):
            values = np.multiply(values, factor, out=values if values.flags.writeable else None)
    values.flags.writeable = False
    return values


def _check_near(name: str, values: FloatArray | None) -> None:
    """Raise InputError for a coordinate beyond a kilometre; what is no number is told by the basis, with its name."""
    if values is None or not values.size:
        return
    farthest = max(float(np.nanmax(values, initial=0.0)), -float(np.nanmin(values, initial=0.0)))
    if FARTHEST_MM < farthest < np.inf:
        problem = f"a coordinate of {farthest:.3g} mm, more than {FARTHEST_MM:.0e} mm"
        raise InputError(name, problem, "check the unit, or move the face to the origin")
