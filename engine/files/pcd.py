"""Organised point clouds as PCD (Point Cloud Library 0.5 to 0.7): text, binary and packed."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.lzf import LzfError, unpack_lzf
from engine.files.pcd_header import PADDING, PcdField, PcdHeader, read_pcd_header
from engine.files.pixel_grid import scan_of_cloud
from engine.files.point_colour import from_channels, from_packed
from engine.files.scan_file import MM_PER_UNIT, ScanFile, choose_unit, likely_unit, make_scan
from engine.files.scanner_frame import face_scanner, pinhole_scatter
from engine.files.source import MAX_PIXELS, check_pixels, checked_file
from engine.files.text_numbers import read_table
from engine.mesh import FloatArray
from engine.scan.range_image import ColourImage

Columns = dict[str, NDArray[Any]]
_WANTED = ("x", "y", "z", "rgb", "rgba", "r", "g", "b")


def read_pcd(path: str | Path, unit: str | None = None) -> ScanFile:
    """Read a scan from a PCD file: ``DATA ascii``, ``binary`` or ``binary_compressed``.

    The fields x y z give the points, ``rgb``, ``rgba`` or ``r g b`` their colours; other fields are skipped. HEIGHT
    above 1 makes the cloud an image; a cloud without rows is put on the pixels of its pinhole where it lies on them.
    NaN is missing, and so is (0, 0, 0), where the sensor stands. Metres are usual; where only mm make a likely size,
    mm are assumed. VIEWPOINT is taken back where the points are on no pinhole's rays without that.

    Raises
    ------
    InputError
        On a damaged header, sizes that the file does not bear out, damaged packing, or a cloud that is no image.
    """
    path = checked_file(path)
    subject = str(path)
    with path.open("rb") as handle:
        header = read_pcd_header(handle, subject)
        _check(header, subject)
        columns = _READERS[header.data](path, handle, header)
    with np.errstate(over="ignore", invalid="ignore"):
        points = np.stack([columns.pop(axis).astype(np.float64) for axis in "xyz"], axis=1)
    colour, warnings = _colours(columns)
    del columns
    zeros = (points == 0).all(axis=1)
    if zeros.any():
        points[zeros] = np.nan
        warnings += (f"{int(zeros.sum())} points at the origin were taken as missing",)
    chosen, assumed, more = choose_unit(unit, None, subject, likely_unit(points, "m", "mm"))
    points *= MM_PER_UNIT[chosen]
    if header.height == 1:
        return scan_of_cloud(path, points, colour, "pcd", (chosen, assumed, warnings + more))
    points = points.reshape(header.height, header.width, 3)
    points[~np.isfinite(points).all(axis=2)] = np.nan
    if np.isnan(points).all():
        raise InputError(subject, "has no valid pixel", "export the cloud before its points are filtered")
    if colour is not None:
        colour = colour.reshape(header.height, header.width, 3)
    points, note = _from_viewpoint(points, header.viewpoint, MM_PER_UNIT[chosen])
    facing = face_scanner(points, colour)
    scan, others = make_scan(subject, facing.points, facing.colour, facing.camera, chosen)
    assumed = "; ".join((assumed, *note, *facing.said))
    return ScanFile(scan, chosen, assumed, (path,), "pcd", warnings + more + facing.warnings + others)


def _check(header: PcdHeader, subject: str) -> None:
    names = {field.name: field for field in header.fields}
    for axis in "xyz":
        if axis not in names:
            raise InputError(f"{subject}, FIELDS", f"has no field {axis}", "export x, y and z")
        if names[axis].count != 1:
            raise InputError(f"{subject}, COUNT", f"is {names[axis].count} for {axis}", "it must be 1")
    if header.height < 1 or header.width < 1:
        raise InputError(subject, f"its size is {header.width} x {header.height}", "export it again")
    if header.height == 1 and header.width > MAX_PIXELS:
        raise InputError(subject, f"has {header.width} points", f"give at most {MAX_PIXELS // 1_000_000} million")
    check_pixels(subject, header.width, header.height)


def _text(path: Path, handle: BinaryIO, header: PcdHeader) -> Columns:
    total = sum(field.count for field in header.fields)
    table = read_table(handle, str(path), total, header.points)
    result, place = {}, 0
    for field in header.fields:
        if field.name in _WANTED and field.count == 1:
            values = table[:, place]
            # A packed colour is told from its bits, so it keeps the type in which it was printed.
            result[field.name] = values if "rgb" in field.name else values.astype(np.float64)
        place += field.count
    return result


def _binary(path: Path, handle: BinaryIO, header: PcdHeader) -> Columns:
    row = sum(field.size for field in header.fields)
    needed, left = row * header.points, path.stat().st_size - handle.tell()
    if needed > left:
        raise InputError(str(path), f"is cut off: its points need {needed} bytes, {left} are there", "export it again")
    result = {field.name: np.empty(header.points, "<" + field.type) for field in header.fields if _is_wanted(field)}
    at_once = max(1, (4 << 20) // row)
    for first in range(0, header.points, at_once):
        count = min(at_once, header.points - first)
        data = handle.read(count * row)
        if len(data) != count * row:
            raise InputError(str(path), "is cut off", "export it again")
        block, place = np.frombuffer(data, np.uint8).reshape(count, row), 0
        for field in header.fields:
            if field.name in result:
                piece = np.ascontiguousarray(block[:, place : place + field.size])
                result[field.name][first : first + count] = piece.view("<" + field.type)[:, 0]
            place += field.size
    return result


def _packed(path: Path, handle: BinaryIO, header: PcdHeader) -> Columns:
    start = handle.read(8)
    if len(start) < 8:
        raise InputError(str(path), "is cut off", "export it again")
    packed, length = struct.unpack("<II", start)
    left = path.stat().st_size - handle.tell()
    if packed > left:
        raise InputError(
            str(path), f"is cut off: {packed} packed bytes are announced, {left} are there", "copy it again"
        )
    # Padding is not stored by the library itself, but by others.
    fields = [field for field in header.fields if field.name != PADDING]
    if length != header.points * sum(field.size for field in fields):
        fields = list(header.fields)
    if length != header.points * sum(field.size for field in fields):
        raise InputError(str(path), f"its points do not make the {length} bytes it announces", "export it again")
    if length > _MOST_UNPACKED:
        problem = f"unpacks to {length / 1e6:.0f} MB, more than {_MOST_UNPACKED / 1e6:.0f}"
        raise InputError(str(path), problem, "save it as DATA binary, with x y z and rgb only")
    try:
        data = unpack_lzf(handle.read(packed), length)
    except LzfError as error:
        raise InputError(str(path), f"is damaged: {error}", "copy or export it again") from error
    result, place = {}, 0
    for field in fields:
        if _is_wanted(field):
            result[field.name] = np.frombuffer(data, "<" + field.type, header.points, place)
        place += field.size * header.points
    return result


_READERS = {"ascii": _text, "binary": _binary, "binary_compressed": _packed}
_MOST_UNPACKED = 256 << 20


def _is_wanted(field: PcdField) -> bool:
    return field.name in _WANTED and field.count == 1


def _colours(columns: Columns) -> tuple[ColourImage | None, tuple[str, ...]]:
    for name in ("rgb", "rgba"):
        if name in columns and columns[name].dtype.itemsize in (4, 8):
            return from_packed(columns[name]), ()
    if {"r", "g", "b"} <= set(columns):
        return from_channels(np.stack([columns[name] for name in "rgb"], axis=1))
    return None, ()


def _from_viewpoint(
    points: FloatArray, viewpoint: tuple[float, ...], scale: float
) -> tuple[FloatArray, tuple[str, ...]]:
    """Return points (H, W, 3) in the sensor's frame, and what is said about a VIEWPOINT that is not the identity."""
    if np.allclose(viewpoint[4:], 0) and np.allclose(viewpoint[:3], 0):
        return points, ()
    w, x, y, z = np.array(viewpoint[3:]) / np.linalg.norm(viewpoint[3:])
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    moved = (points - scale * np.array(viewpoint[:3])) @ rotation
    before, after = pinhole_scatter(points), pinhole_scatter(moved)
    if after < 0.5 * before:
        return moved, ("VIEWPOINT taken back",)
    if before < np.inf:
        return points, ("VIEWPOINT left out: the points are in the sensor's frame",)
    return points, ("VIEWPOINT left out: no pinhole there sees the points",)
