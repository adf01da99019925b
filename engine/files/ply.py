"""Organised scans as PLY: every vertex row by row, or the valid ones with a ``range_grid`` (Stanford, Cyberware)."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.ply_grid import read_range_grid
from engine.files.ply_header import PlyElement, PlyHeader, read_ply_header
from engine.files.scan_file import MM_PER_UNIT, ScanFile, choose_unit, make_scan, rows_run_upwards
from engine.files.source import check_pixels, checked_file
from engine.files.text_numbers import read_table
from engine.mesh import IntArray
from engine.scan.range_image import Camera, RangeImage

_COLOUR = ("red", "green", "blue")


def read_ply(path: str | Path, unit: str | None = None) -> ScanFile:
    """Read a scan from an organised PLY file, text or binary of either byte order.

    ``obj_info num_cols`` and ``num_rows`` give the size. Either all vertices are there row by row (NaN = missing), or
    the element ``range_grid`` lists for every pixel the index of its vertex, or none. Colour is read from
    ``red green blue`` (uchar). ``obj_info unit`` and ``obj_info camera`` (fx fy cx cy), which ``write_ply`` writes,
    are understood. Range grids whose rows run upwards, as Stanford's do, are turned, which ``assumed`` says.

    Raises
    ------
    InputError
        On a damaged header, sizes that the file does not bear out, unknown layout, or no valid pixel.
    """
    path = checked_file(path)
    subject = str(path)
    with path.open("rb") as handle:
        header = read_ply_header(handle, subject)
        width, height = _grid_size(header, subject)
        tables = _read_elements(path, handle, header, width * height)
    vertex = tables["vertex"]
    grid = tables.get("range_grid")
    if grid is None and len(vertex) != width * height:
        problem = f"{len(vertex)} vertices for {width} x {height} pixels and no range_grid"
        raise InputError(subject, problem, "export all vertices, row by row, with NaN where none was measured")
    if grid is not None and (len(grid) != width * height or grid.max(initial=-1) >= len(vertex)):
        raise InputError(f"{subject}, range_grid", "does not fit the vertices or the size", "export it again")
    unit, assumed, warnings = choose_unit(unit, header.info.get("unit"), subject)
    with np.errstate(over="ignore", invalid="ignore"):
        stacked = np.empty((len(vertex), 3))
        for index, axis in enumerate("xyz"):
            np.multiply(vertex[axis], MM_PER_UNIT[unit], out=stacked[:, index], dtype=np.float64)
    stacked.flags.writeable = False  # a view of what may be written is copied later
    points = _on_grid(stacked, grid, np.nan).reshape(height, width, 3)
    colour = None
    if set(_COLOUR) <= set(vertex):
        shades = np.column_stack([vertex[name] for name in _COLOUR])
        if (shades.dtype.kind == "f" and header.order) or not ((shades >= 0) & (shades <= 255)).all():
            warnings += ("its colours are not bytes 0..255: left out",)
        else:
            colour = _on_grid(shades.astype(np.uint8), grid, 0).reshape(height, width, 3)
    camera = _camera(header.info.get("camera"), subject)
    if grid is not None and camera is None and rows_run_upwards(points):
        points = np.ascontiguousarray(points[::-1])
        colour = None if colour is None else np.ascontiguousarray(colour[::-1])
        assumed += "; its rows run upwards: turned"
    scan, more = make_scan(subject, points, colour, camera, unit)
    return ScanFile(scan, unit, assumed, (path,), "ply", warnings + more)


def write_ply(path: str | Path, scan: RangeImage) -> None:
    """Write a scan as organised binary PLY in mm: all pixels row by row, doubles, NaN = missing; without loss."""
    fields = [(axis, "<f8") for axis in "xyz"]
    lines = ["ply", "format binary_little_endian 1.0", f"obj_info num_cols {scan.width}"]
    lines += [f"obj_info num_rows {scan.height}", "obj_info unit mm"]
    if scan.camera is not None:
        values = (scan.camera.fx, scan.camera.fy, scan.camera.cx, scan.camera.cy)
        lines.append("obj_info camera " + " ".join(repr(float(value)) for value in values))
    lines += [f"element vertex {scan.width * scan.height}", *(f"property double {axis}" for axis in "xyz")]
    if scan.colour is not None:
        fields += [(name, "u1") for name in _COLOUR]
        lines += [f"property uchar {name}" for name in _COLOUR]
    rows = np.empty(scan.width * scan.height, dtype=fields)
    for index, axis in enumerate("xyz"):
        rows[axis] = scan.points[..., index].ravel()
    if scan.colour is not None:
        for index, name in enumerate(_COLOUR):
            rows[name] = scan.colour[..., index].ravel()
    with atomic_write(path) as handle:
        handle.write(("\n".join([*lines, "end_header"]) + "\n").encode("ascii"))
        handle.write(rows.tobytes())


def _grid_size(header: PlyHeader, subject: str) -> tuple[int, int]:
    size = []
    for key in ("num_cols", "num_rows"):
        text = header.info.get(key)
        if text is None:
            raise InputError(subject, f"has no obj_info {key}", "export it as an organised scan, not as a mesh")
        if not (text.isascii() and text.isdigit() and len(text) < 10):
            raise InputError(f"{subject}, obj_info {key}", f"{text[:40]!r} is not a count", "export it again")
        size.append(int(text))
    check_pixels(subject, size[0], size[1])
    return size[0], size[1]


def _read_elements(path: Path, handle: BinaryIO, header: PlyHeader, pixels: int) -> dict[str, Any]:
    """Return the columns of ``vertex`` and, where there is one, the indices of ``range_grid``."""
    wanted = [element for element in header.elements if element.name in ("vertex", "range_grid")]
    vertex = next((element for element in wanted if element.name == "vertex"), None)
    if vertex is None or not {"x", "y", "z"} <= set(vertex.names):
        raise InputError(str(path), "has no vertices with x, y and z", "export it again")
    result: dict[str, Any] = {}
    last = header.elements.index(wanted[-1])
    for element in header.elements[: last + 1]:
        if element in wanted and not 0 < element.count <= pixels:
            problem = f"{element.count} rows of {element.name} for {pixels} pixels"
            raise InputError(str(path), problem, "export it as an organised scan")
        if element.name == "range_grid":
            result["range_grid"] = read_range_grid(path, handle, header.order, element, vertex.count)
            continue
        if element.has_list:
            raise InputError(str(path), f"its element {element.name[:40]!r} holds lists", "export vertices first")
        if header.order:
            table = _binary_table(path, handle, header, element)
            columns = {name: table[name] for name in element.names}
        else:
            columns = _text_table(path, handle, element)
        if element is vertex:
            result["vertex"] = _Columns(columns)
    return result


class _Columns(dict[str, NDArray[Any]]):
    """Columns by name whose length is the number of rows."""

    def __len__(self) -> int:
        return len(next(iter(self.values())))


def _on_grid(values: NDArray[Any], grid: IntArray | None, missing: float) -> NDArray[Any]:
    if grid is None:
        return values
    result = np.full((len(grid), values.shape[1]), missing, dtype=values.dtype)
    result[grid >= 0] = values[grid[grid >= 0]]
    return result


def _binary_table(path: Path, handle: BinaryIO, header: PlyHeader, element: PlyElement) -> NDArray[Any]:
    dtype = np.dtype([(item.name, header.order + item.type) for item in element.properties])
    length, left = element.count * dtype.itemsize, path.stat().st_size - handle.tell()
    if length > left:
        problem = f"is cut off: {element.name[:40]} needs {length} bytes, {left} are there"
        raise InputError(str(path), problem, "export it again")
    return np.frombuffer(handle.read(length), dtype)


def _text_table(path: Path, handle: BinaryIO, element: PlyElement) -> dict[str, NDArray[Any]]:
    if element.count == 0 or not element.properties:
        return {name: np.zeros(0) for name in element.names}
    table = read_table(handle, f"{path}, {element.name[:40]}", len(element.properties), element.count)
    return {name: table[:, column] for column, name in enumerate(element.names)}


def _camera(text: str | None, subject: str) -> Camera | None:
    if text is None:
        return None
    try:
        fx, fy, cx, cy = (float(word) for word in text.split())
    except ValueError as error:
        raise InputError(f"{subject}, obj_info camera", "is not fx fy cx cy", "give four numbers") from error
    if not np.isfinite([fx, fy, cx, cy]).all() or fx <= 0 or fy <= 0:
        raise InputError(f"{subject}, obj_info camera", f"is {text[:60]!r}", "give fx fy cx cy, fx and fy positive")
    return Camera(fx, fy, cx, cy)
