"""Scans as NumPy archives: ``points`` (H, W, 3), optional ``colour``, ``camera`` and ``unit``."""

from __future__ import annotations

import io
import math
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.scan_file import MM_PER_UNIT, ScanFile, choose_unit, make_scan
from engine.files.source import MAX_PIXELS, checked_file
from engine.scan.range_image import Camera, RangeImage

_MAX_HEADER = 10_000
_MAX_MEMBERS = 1000
_DAMAGE = (
    zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError, KeyError, IndexError, TypeError,
    NotImplementedError, RuntimeError, OverflowError, SyntaxError, MemoryError,
)  # fmt: skip


def read_npz(path: str | Path, unit: str | None = None) -> ScanFile:
    """Read a scan from a ``.npz`` archive.

    It holds ``points (H, W, 3)`` numbers (NaN = missing) and optionally ``colour (H, W, 3)`` uint8,
    ``camera (4,)`` = fx fy cx cy in pixels, and ``unit``, a string: mm, cm or m.

    Raises
    ------
    InputError
        On a damaged archive, missing or wrong arrays, pickled objects, or sizes that the file does not bear out.
    """
    path = checked_file(path)
    with path.open("rb") as handle:
        if handle.read(2) != b"PK":
            raise InputError(str(path), "is not a NumPy archive", "save it with numpy.savez")
    try:
        with zipfile.ZipFile(path) as archive:
            members = _members(path, archive)
            if "points" not in members:
                raise InputError(f"{path}, points", "is missing", "save the points (H, W, 3) under this name")
            points = _array(path, archive, members["points"], "points", (None, None, 3), "fiu", 8)
            height, width = points.shape[:2]
            colour = camera = named = None
            if "colour" in members:
                shape = (height, width, 3)
                colour = _array(path, archive, members["colour"], "colour", shape, "u", 1)
            if "camera" in members:
                camera = _camera(path, _array(path, archive, members["camera"], "camera", (4,), "fiu", 8))
            if "unit" in members:
                named = str(_array(path, archive, members["unit"], "unit", (), "U", 256))
    except _DAMAGE as error:
        if isinstance(error, InputError):
            raise
        raise InputError(str(path), "is damaged or cut off", "copy or save it again") from error
    unit, assumed, warnings = choose_unit(unit, named, str(path))
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = np.multiply(points, MM_PER_UNIT[unit], dtype=np.float64)
    del points
    scan, more = make_scan(str(path), scaled, colour, camera, unit)
    return ScanFile(scan, unit, assumed, (path,), "npz", warnings + more)


def write_npz(path: str | Path, scan: RangeImage) -> None:
    """Write a scan as a compressed ``.npz`` archive, in mm and without loss; see ``read_npz``."""
    arrays: dict[str, NDArray[Any]] = {"points": scan.points, "unit": np.array("mm")}
    if scan.colour is not None:
        arrays["colour"] = scan.colour
    if scan.camera is not None:
        arrays["camera"] = np.array([scan.camera.fx, scan.camera.fy, scan.camera.cx, scan.camera.cy])
    with atomic_write(path) as handle:
        np.savez_compressed(handle, allow_pickle=False, **arrays)


def _members(path: Path, archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    infos = archive.infolist()
    if len(infos) > _MAX_MEMBERS:
        raise InputError(str(path), f"holds {len(infos)} arrays", "save only the scan's")
    members: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        name = info.filename.removesuffix(".npy")
        if name in members:
            raise InputError(f"{path}, {name[:40]!r}", "is stored twice", "save it again")
        members[name] = info
    return members


def _array(
    path: Path,
    archive: zipfile.ZipFile,
    info: zipfile.ZipInfo,
    name: str,
    shape: tuple[int | None, ...],
    kinds: str,
    largest_item: int,
) -> NDArray[Any]:
    """Return one array whose shape, type and length are checked before its data are unpacked."""
    subject = f"{path}, {name}"
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or info.flag_bits & 1:
        raise InputError(subject, "is packed in a way that NumPy does not use", "save it with numpy.savez")
    with archive.open(info) as member:
        start, found, fortran, dtype = _header(subject, member)
        if dtype.hasobject:
            raise InputError(subject, "holds pickled objects, which are never loaded", "save plain numbers")
        if dtype.kind not in kinds or dtype.itemsize > largest_item:
            raise InputError(subject, f"stores {dtype}", _expected(kinds))
        if len(found) != len(shape) or any(want not in (None, have) for want, have in zip(shape, found, strict=True)):
            wanted = " x ".join("?" if want is None else str(want) for want in shape) or "a single value"
            raise InputError(subject, f"has shape {found}", f"it must be {wanted}")
        if math.prod(found[:2]) > MAX_PIXELS or min(found, default=1) < 1:
            raise InputError(subject, f"has shape {found}", f"give 1 to {MAX_PIXELS // 1_000_000} million pixels")
        length = math.prod(found) * dtype.itemsize
        if info.file_size != start + length:
            raise InputError(subject, f"announces {length} bytes, not what is stored", "save it again")
        data = member.read(length + 1)
    if len(data) != length:
        raise InputError(subject, f"holds {len(data)} of the {length} bytes it announces", "save it again")
    values = np.frombuffer(data, dtype)
    return values.reshape(found, order="F" if fortran else "C")


def _header(subject: str, member: Any) -> tuple[int, tuple[int, ...], bool, np.dtype[Any]]:
    """Return (header length, shape, Fortran order, type) of an ``.npy`` stream."""
    first = member.read(8)
    if first[:6] != b"\x93NUMPY" or first[6:] not in (b"\1\0", b"\2\0"):
        raise InputError(subject, "is not a NumPy array", "save it with numpy.savez")
    code = "<H" if first[6] == 1 else "<I"
    read = np.lib.format.read_array_header_1_0 if first[6] == 1 else np.lib.format.read_array_header_2_0
    size = member.read(struct.calcsize(code))
    (length,) = struct.unpack(code, size)
    if length > _MAX_HEADER:
        raise InputError(subject, f"announces a header of {length} bytes", "save it again")
    text = member.read(length)
    shape, fortran, dtype = read(io.BytesIO(size + text), max_header_size=_MAX_HEADER)
    return 8 + len(size) + length, tuple(int(extent) for extent in shape), bool(fortran), dtype


def _camera(path: Path, values: NDArray[Any]) -> Camera:
    fx, fy, cx, cy = (float(value) for value in values)
    if not np.isfinite([fx, fy, cx, cy]).all() or fx <= 0 or fy <= 0:
        raise InputError(f"{path}, camera", f"is {fx:g} {fy:g} {cx:g} {cy:g}", "give fx fy cx cy, fx and fy positive")
    return Camera(fx, fy, cx, cy)


def _expected(kinds: str) -> str:
    return {"fiu": "give numbers", "u": "give bytes (uint8)", "U": "give a string"}[kinds]
