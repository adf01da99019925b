"""Scans as NumPy archives: ``points`` (H, W, 3), optional ``colour``, ``camera`` and ``unit``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.npz_arrays import open_npz
from engine.files.scan_file import MM_PER_UNIT, ScanFile, choose_unit, make_scan
from engine.files.source import MAX_PIXELS
from engine.scan.range_image import Camera, RangeImage


def read_npz(path: str | Path, unit: str | None = None) -> ScanFile:
    """Read a scan from a ``.npz`` archive.

    It holds ``points (H, W, 3)`` numbers (NaN = missing) and optionally ``colour (H, W, 3)`` uint8,
    ``camera (4,)`` = fx fy cx cy in pixels, and ``unit``, a string: mm, cm or m.

    Raises
    ------
    InputError
        On a damaged archive, missing or wrong arrays, pickled objects, or sizes that the file does not bear out.
    """
    with open_npz(path) as archive:
        path = archive.path
        points = archive.array("points", (None, None, 3), "fiu", check=_check_pixels)
        height, width = points.shape[:2]
        colour = camera = named = None
        if "colour" in archive:
            colour = archive.array("colour", (height, width, 3), "u", 1)
        if "camera" in archive:
            camera = _camera(path, archive.array("camera", (4,), "fiu"))
        if "unit" in archive:
            named = str(archive.array("unit", (), "U", 256))
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


def _check_pixels(subject: str, shape: tuple[int, ...]) -> None:
    if math.prod(shape[:2]) > MAX_PIXELS or min(shape) < 1:
        raise InputError(subject, f"has shape {shape}", f"give 1 to {MAX_PIXELS // 1_000_000} million pixels")


def _camera(path: Path, values: NDArray[Any]) -> Camera:
    fx, fy, cx, cy = (float(value) for value in values)
    if not np.isfinite([fx, fy, cx, cy]).all() or fx <= 0 or fy <= 0:
        raise InputError(f"{path}, camera", f"is {fx:g} {fy:g} {cx:g} {cy:g}", "give fx fy cx cy, fx and fy positive")
    return Camera(fx, fy, cx, cy)
