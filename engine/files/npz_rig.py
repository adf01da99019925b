"""Rigs as NumPy archives: ``neutral``, ``faces``, ``names``, ``displacements``, optional ``mean``, chart and parts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.npz_arrays import NpzArchive, open_npz
from engine.files.rig_raw import RawRig, check_size
from engine.shapes import Rig

_LONGEST_NAME = 4 * 256
_PART = "part_"
_ALIASES = {
    "neutral": ("neutral", "vertices"),
    "faces": ("faces", "triangles"),
    "names": ("names", "expression_names"),
    "displacements": ("displacements", "expressions"),
    "uv_faces": ("uv_faces", "uv_triangles"),
}


def read_npz_rig(path: Path) -> RawRig:
    """Read a rig from a ``.npz`` archive.

    ``neutral (N, 3)``, ``faces (F, 3)`` (or ``triangles``), ``names (n,)`` (or ``expression_names``) and
    ``displacements (n, N, 3)`` (or ``expressions``) are needed; ``mean (N, 3)``, ``uv (U, 2)`` with its origin at the
    top left, ``uv_faces (F, 3)`` (or ``uv_triangles``), ``part_NAME`` (face indices) and ``unit`` may be there.
    Numbers of any precision are taken.

    Raises
    ------
    InputError
        On a damaged archive, missing or wrong arrays, pickled objects, or sizes that the file does not bear out.
    """
    with open_npz(path) as archive:
        neutral = _needed(archive, "neutral", (None, 3), "fiu")
        faces = _needed(archive, "faces", (None, 3), "iu")
        name = _stored(archive, "displacements")
        names = archive.array(_stored(archive, "names"), (None,), "US", _LONGEST_NAME, check=_some_shapes)

        def sized(subject: str, shape: tuple[int, ...]) -> None:
            check_size(subject, shape[0], len(neutral))

        displacements = archive.array(name, (len(names), len(neutral), 3), "f", check=sized)
        mean = archive.array("mean", (len(neutral), 3), "f") if "mean" in archive else None
        uv = uv_faces = None
        if "uv" in archive:
            uv = archive.array("uv", (None, 2), "f")
            at = _name(archive, "uv_faces")
            uv_faces = archive.array(at, (len(faces), 3), "iu") if at else faces
            if at is None and len(uv) != len(neutral):
                problem = f"has {len(uv)} rows for {len(neutral)} vertices, and no uv_faces"
                raise InputError(f"{path}, uv", problem, "save uv_faces too, or leave uv out")
        parts = {
            key.removeprefix(_PART): archive.array(key, (None,), "iu")
            for key in archive.names
            if key.startswith(_PART) and key != _PART
        }
        unit = str(archive.array("unit", (), "U", 256)) if "unit" in archive else None
    return RawRig(
        _float(neutral), _int(faces), [_word(name) for name in names.tolist()], _float(displacements),
        None if mean is None else _float(mean), None if uv is None else _float(uv),
        None if uv_faces is None else _int(uv_faces), {key: _int(value) for key, value in parts.items()}, unit=unit,
    )  # fmt: skip


def _some_shapes(subject: str, shape: tuple[int, ...]) -> None:
    if shape[0] == 0:
        raise InputError(subject, "holds no shapes", "save at least one")


def write_npz_rig(path: str | Path, rig: Rig) -> None:
    """Write a rig as a compressed ``.npz`` archive, in mm and without loss; see ``read_npz_rig``."""
    mesh, basis = rig.mesh, rig.basis
    arrays: dict[str, NDArray[Any]] = {
        "neutral": basis.neutral,
        "faces": mesh.faces,
        "names": np.array(basis.names),
        "displacements": basis.displacements,
        "unit": np.array("mm"),
    }
    if basis.mean is not None:
        arrays["mean"] = basis.mean
    if mesh.uv is not None and mesh.uv_faces is not None:
        arrays |= {"uv": mesh.uv, "uv_faces": mesh.uv_faces}
    arrays |= {_PART + name: faces for name, faces in mesh.parts.items() if len(faces)}
    with atomic_write(path) as handle:
        np.savez_compressed(handle, allow_pickle=False, **arrays)


def _name(archive: NpzArchive, wanted: str) -> str | None:
    return next((name for name in _ALIASES[wanted] if name in archive), None)


def _stored(archive: NpzArchive, wanted: str) -> str:
    found = _name(archive, wanted)
    if found is None:
        remedy = "a rig has neutral, faces, names and displacements"
        if "points" in archive:
            remedy += "; this archive looks like a scan"
        raise InputError(f"{archive.path}, {wanted}", "is missing", remedy)
    return found


def _needed(
    archive: NpzArchive, wanted: str, shape: tuple[int | None, ...], kinds: str, largest: int = 8
) -> NDArray[Any]:
    return archive.array(_stored(archive, wanted), shape, kinds, largest)


def _float(values: NDArray[Any]) -> NDArray[np.float64]:
    return np.asarray(values, dtype=np.float64)


def _int(values: NDArray[Any]) -> NDArray[np.int64]:
    # An unsigned number beyond the signed range becomes negative, which the mesh refuses as an index.
    return values.astype(np.int64)


def _word(name: str | bytes) -> str:
    return name.decode("utf-8", "replace") if isinstance(name, bytes) else name
