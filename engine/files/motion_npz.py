"""Dense motion as a NumPy archive: ``vertices (L, N, 3)`` and ``fps``."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.motion_axes import place_mesh
from engine.files.motion_file import DenseClip, MotionFile, choose_fps
from engine.files.npy_stream import DAMAGE, array_header, unpacked
from engine.files.source import checked_file
from engine.mesh import FloatArray

MAX_UNPACKED = 1 << 30
"""Most bytes that are unpacked into memory; an archive that is not compressed is mapped and may be larger."""

MAX_FILE = 1 << 36
_CHECKED_AT_ONCE = 16 << 20


def read_motion_npz(
    path: str | Path,
    *,
    unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    fps: float | None = None,
) -> MotionFile:
    """Read ``vertices (L, N, 3)``, ``fps`` and optionally ``unit`` (mm, cm or m) from a ``.npz`` archive.

    The vertices stay as they are stored (float16, 32 or 64): an array that is not compressed is memory-mapped, a
    compressed one unpacked up to 1 GB.

    Raises
    ------
    InputError
        On a damaged archive, missing or wrong arrays, pickled objects, sizes that the file does not bear out, and
        positions that are not finite (naming the frame).
    """
    path = checked_file(path, MAX_FILE)
    try:
        with zipfile.ZipFile(path) as archive:
            members = _members(path, archive)
            if "vertices" not in members:
                raise InputError(f"{path}, vertices", "is missing", "save the positions (L, N, 3) under this name")
            vertices = _vertices(path, archive, members["vertices"])
            named = _scalar(path, archive, members, "fps", "fiu")
            word = _scalar(path, archive, members, "unit", "U")
    except DAMAGE as error:
        if isinstance(error, InputError):
            raise
        raise InputError(str(path), "is damaged or cut off", "copy or save it again") from error
    rate, rate_said, guessed = choose_fps(str(path), fps, None if named is None else float(named))
    extent = check_positions(path, vertices)
    placing = place_mesh(unit, None if word is None else str(word), up, forward, extent)
    axes = placing.rotation if (placing.up, placing.forward) != ("y", "z") else None
    return MotionFile(
        DenseClip(vertices, rate, placing.scale, axes),
        "dense",
        "npz",
        placing.unit,
        f"{placing.assumed}; {rate_said}",
        (path,),
        up=placing.up,
        forward=placing.forward,
        guessed=(*placing.guessed, *(("fps",) if guessed else ())),
        warnings=placing.warnings,
    )


def check_positions(path: Path, vertices: NDArray[Any]) -> float:
    """Return the largest side of the first frame, having seen that all positions are finite.

    Raises
    ------
    InputError
        Naming the first frame with one that is not, or a first frame without any size.
    """
    step = max(1, _CHECKED_AT_ONCE // max(1, vertices[0].nbytes))
    for start in range(0, len(vertices), step):
        piece = np.asarray(vertices[start : start + step])
        good = np.isfinite(piece).all(axis=(1, 2))
        if not good.all():
            frame = start + int(np.flatnonzero(~good)[0]) + 1
            raise InputError(f"{path}, frame {frame}", "holds positions that are not finite", "export it again")
    first: FloatArray = np.asarray(vertices[0], dtype=np.float64)
    extent = float(np.ptp(first, axis=0).max())
    if not 0 < extent < 1e12:
        raise InputError(f"{path}, frame 1", f"spans {extent:g} units", "export it again")
    return extent


def _members(path: Path, archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    infos = archive.infolist()
    if len(infos) > 1000:
        raise InputError(str(path), f"holds {len(infos)} arrays", "save only vertices and fps")
    members: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        name = info.filename.removesuffix(".npy")
        if name in members:
            raise InputError(f"{path}, {name[:40]!r}", "is stored twice", "save it again")
        members[name] = info
    return members


def _vertices(path: Path, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[Any]:
    subject = f"{path}, vertices"
    with archive.open(info) as member:
        found = array_header(subject, member, info, kinds="f", largest_item=8)
    if len(found.shape) != 3 or found.shape[2] != 3 or min(found.shape) < 1:
        raise InputError(subject, f"has shape {found.shape}", "it must be frames x vertices x 3, none of them 0")
    if info.compress_type == zipfile.ZIP_STORED:
        place = _stored_at(path, info) + found.start
        order = "F" if found.fortran else "C"
        return np.memmap(path, found.dtype, "r", place, found.shape, order=order)  # type: ignore[call-overload,no-any-return]
    if found.bytes > MAX_UNPACKED:
        problem = f"is packed and takes {found.bytes / 1e6:.0f} MB"
        raise InputError(subject, problem, "save it with numpy.savez (not compressed), which is read piece by piece")
    with archive.open(info) as member:
        return unpacked(subject, member, found)


def _stored_at(path: Path, info: zipfile.ZipInfo) -> int:
    """Return the byte at which an uncompressed member's data begin: its local header has lengths of its own."""
    with path.open("rb") as handle:
        handle.seek(info.header_offset)
        local = handle.read(30)
    if len(local) < 30 or local[:4] != b"PK\x03\x04" or info.compress_size != info.file_size:
        raise InputError(str(path), "is damaged or cut off", "copy or save it again")
    name, extra = struct.unpack_from("<HH", local, 26)
    place = info.header_offset + 30 + int(name) + int(extra)
    if place + info.file_size > path.stat().st_size:
        raise InputError(str(path), "is damaged or cut off", "copy or save it again")
    return place


def _scalar(
    path: Path, archive: zipfile.ZipFile, members: dict[str, zipfile.ZipInfo], name: str, kinds: str
) -> Any | None:
    if name not in members:
        return None
    subject = f"{path}, {name}"
    with archive.open(members[name]) as member:
        found = array_header(subject, member, members[name], kinds=kinds, largest_item=256)
    if int(np.prod(found.shape)) != 1 or found.bytes > 256:
        raise InputError(subject, f"has shape {found.shape}", "it must be a single value")
    with archive.open(members[name]) as member:
        return unpacked(subject, member, found).reshape(-1)[0]
