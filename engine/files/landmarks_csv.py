"""Landmarks as tables: one point a line, or one picture a line; separated by commas, semicolons or tabs.

Forms that are told apart by their header, or by their numbers where there is none:

* ``name,x,y[,z]``: one point a line;
* ``frame,chin_x,chin_y[,chin_z],...``: one picture a line, columns by name, others ignored;
* ``frame,x0,y0,x1,y1,...`` or ``x_0,x_1,...,y_0,...``: one picture a line, columns by number;
* without a header: ``x,y`` or ``x,y,z`` a point, or ``frame,x,y,x,y,...`` a picture.

An empty cell or NA is a point without a place. Pixels count from 0 unless another origin is asked for.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.landmark_file import (
    MAX_LANDMARK_BYTES,
    MAX_POINTS,
    LandmarkFile,
    checked_name,
    checked_origin,
    chosen_group,
    number,
    shifted_number,
    shifted_text,
)
from engine.files.source import read_bytes
from engine.mesh import FloatArray

MAX_ROWS, MAX_LINE = 200_000, 2_000_000
"""Most lines of a table, and most characters of a line."""
SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
_NAME_COLUMNS = ("name", "label", "landmark", "fiducial", "point", "marker", "id", "")
_ROW_COLUMNS = ("frame", "image", "picture", "file", "filename", "index", "row", "time", "time_s", "timestamp", "")
_BY_NAME = re.compile(r"^(.+?)[_ .]?([xyz])$", re.IGNORECASE)
_BY_NUMBER = re.compile(r"^([xyz])_?(\d{1,5})$")


class _Layout(NamedTuple):
    """Where in a row the points stand: labels, their columns (x, y[, z]), and the column that names the row."""

    labels: tuple[str, ...]
    columns: tuple[tuple[int, ...], ...]
    row_column: int | None


def read_landmark_csv(path: str | Path, group: str | None = None, origin: float | None = None) -> LandmarkFile:
    """Read a table of landmarks.

    Parameters
    ----------
    path : str or Path
        The file, UTF-8.
    group : str, optional
        Which row of a table with one picture a line, by its first column (or its number, from 0, where no column
        names the rows); the first where left out, and the file's remarks say so.
    origin : {0, 0.5, 1}, optional
        What the file calls the centre of the top left pixel; 0 where left out.

    Raises
    ------
    InputError
        On a table of another form, a decimal comma, and what is no number.
    """
    first = checked_origin(origin, "csv")
    text, separator = _text(path)
    rows = _rows(path, text, separator)
    line, cells = next(rows, (1, []))
    header = [cell.strip() for cell in cells]
    if len(header) < 2:
        problem = "has one column" if header else "has no rows"
        raise InputError(f"{path}, line {line}", problem, "separate columns with commas, semicolons or tabs")
    said: tuple[str, ...] = (f"separated by {SEPARATORS[separator]}",)
    if all(_is_number(cell) for cell in header):
        if len(header) in (2, 3):
            said = (*said, "no header: one point a line")
            return _long(path, _rows(path, text, separator), (None, tuple(range(len(header)))), first, said)
        layout = _bare_layout(path, len(header))
        order = "frame first" if layout.row_column == 0 else "x, y in turn"
        said = (*said, f"no header: one picture a line, {order}")
        skipped = 0
    else:
        named = _name_layout(header)
        if named is not None:
            return _long(path, rows, named, first, said)
        layout, skipped = _wide_layout(path, header), 1
    # Read twice, so that of a film only one row is ever kept.
    groups = _groups(islice(_rows(path, text, separator), skipped, None), layout.row_column)
    if not groups:
        raise InputError(str(path), "has a header and no rows", "export it again")
    chosen, choice = chosen_group(str(path), groups, group)
    at = groups.index(chosen) + skipped
    line, cells = next(islice(_rows(path, text, separator), at, None))
    return _wide(f"{path}, line {line}", cells, layout, (chosen, groups), first, (*said, *choice))


def _text(path: str | Path) -> tuple[str, str]:
    """Return the whole text, and what separates its cells."""
    data = read_bytes(path, MAX_LANDMARK_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(str(path), f"is not UTF-8 text (byte {error.start})", "save it as UTF-8") from error
    if "\0" in text[:4096]:
        raise InputError(str(path), "is not text", "give a table of numbers")
    head = text[: 1 << 20].splitlines()
    start = next((line for line in head if line.strip() and not line.startswith("#")), "")
    # A semicolon or tab anywhere means that commas, if any, are decimal ones.
    return text, next((mark for mark in (";", "\t") if mark in start), ",")


def _rows(path: str | Path, text: str, separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the numbered rows that are not empty."""
    reader = csv.reader(_lines(path, text), delimiter=separator, strict=True, skipinitialspace=True)
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells) and not cells[0].startswith("#"):
                yield reader.line_num, cells
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}", f"is not a table ({error})", "export it again") from error


def _lines(path: str | Path, text: str) -> Iterator[str]:
    """Yield the lines of a table that has neither too many of them nor endless ones."""
    for count, line in enumerate(io.StringIO(text, newline="")):
        if count >= MAX_ROWS:
            raise InputError(str(path), f"has more than {MAX_ROWS} lines", "cut it into shorter ones")
        if len(line) > MAX_LINE:
            problem = f"has more than {MAX_LINE} characters"
            raise InputError(f"{path}, line {count + 1}", problem, "give the points of one picture a line")
        yield line


def _name_layout(header: Sequence[str]) -> tuple[int | None, tuple[int, ...]] | None:
    """Return the columns of name and x, y[, z] of a table with one point a line; None for other tables."""
    lower = [cell.lower() for cell in header]
    if lower.count("x") != 1 or lower.count("y") != 1 or lower.count("z") > 1:
        return None
    name = next((lower.index(word) for word in _NAME_COLUMNS if word in lower), None)
    axes = tuple(lower.index(axis) for axis in "xyz" if axis in lower)
    return name, axes


def _wide_layout(path: str | Path, header: Sequence[str]) -> _Layout:
    """Return the columns of a table with one picture a line from its header."""
    found: dict[str, dict[str, int]] = {}
    numbers = [_BY_NUMBER.match(cell) for cell in header]
    if not any(numbers):
        numbers = [_BY_NUMBER.match(cell.lower()) for cell in header]
    for column, cell in enumerate(header):
        by_number, by_name = numbers[column], _BY_NAME.match(cell)
        if by_number is not None:
            label, axis = str(int(by_number[2])), by_number[1]
        elif by_name is not None and not any(numbers):
            label, axis = by_name[1], by_name[2].lower()
        else:
            continue
        axes = found.setdefault(label, {})
        if axis in axes:
            raise InputError(f"{path}, header", f"names {cell[:40]!r} twice", "rename one of the columns")
        axes[axis] = column
    points = {label: axes for label, axes in found.items() if {"x", "y"} <= axes.keys()}
    if not points:
        remedy = "name them name,x,y or chin_x,chin_y,... or frame,x0,y0,x1,y1,..."
        raise InputError(f"{path}, header", "no columns of points are found", remedy)
    solid = {"z" in axes for axes in points.values()}
    wanted = "xyz" if solid == {True} else "xy"
    if len(points) > MAX_POINTS:
        raise InputError(f"{path}, header", f"names more than {MAX_POINTS} points", "export fewer")
    if any(numbers):
        points = dict(sorted(points.items(), key=lambda item: int(item[0])))
    labels = tuple(checked_name(label, f"{path}, header") for label in points)
    used = {column for axes in points.values() for column in axes.values()}
    lower = [cell.lower() for cell in header]
    row = next((lower.index(word) for word in _ROW_COLUMNS if word in lower and lower.index(word) not in used), None)
    return _Layout(labels, tuple(tuple(axes[a] for a in wanted) for axes in points.values()), row)


def _bare_layout(path: str | Path, width: int) -> _Layout:
    """Return the columns of numbers without a header: an odd count begins with the frame."""
    start = width % 2
    count = (width - start) // 2
    if count > MAX_POINTS:
        raise InputError(str(path), f"has more than {MAX_POINTS} points a row", "export fewer")
    columns = tuple((start + 2 * k, start + 2 * k + 1) for k in range(count))
    return _Layout(tuple(str(k) for k in range(count)), columns, 0 if start else None)


def _long(
    path: str | Path,
    rows: Iterator[tuple[int, list[str]]],
    columns: tuple[int | None, tuple[int, ...]],
    origin: float,
    said: tuple[str, ...],
) -> LandmarkFile:
    name, axes = columns
    labels: list[str] = []
    points: list[list[float]] = []
    shift = origin if len(axes) == 2 else 0.0
    for line, cells in rows:
        if len(labels) == MAX_POINTS:
            raise InputError(str(path), f"has more than {MAX_POINTS} points", "give the points of one picture")
        place = f"{path}, line {line}"
        cells = _full(cells, max(*axes, name or 0) + 1, place)
        labels.append(str(len(labels)) if name is None else checked_name(cells[name], place))
        points.append([shifted_number(cells[axis], shift, place) for axis in axes])
    if not labels:
        raise InputError(str(path), "has a header and no points", "export it again")
    _once(labels, path)
    return LandmarkFile(
        np.array(points), tuple(labels), origin=shift, format="csv", remarks=(*said, *_origin_remark(len(axes), origin))
    )


def _wide(
    place: str,
    cells: list[str],
    layout: _Layout,
    chosen: tuple[str, tuple[str, ...]],
    origin: float,
    said: tuple[str, ...],
) -> LandmarkFile:
    cells = _full(cells, max(max(columns) for columns in layout.columns) + 1, place)
    width = len(layout.columns[0])
    shift = origin if width == 2 else 0.0
    points = np.array([[shifted_number(cells[c], shift, place) for c in columns] for columns in layout.columns])
    remarks = (*said, *_origin_remark(width, origin))
    return LandmarkFile(points, layout.labels, *chosen, origin=shift, format="csv", remarks=remarks)


def _groups(rows: Iterable[tuple[int, list[str]]], column: int | None) -> tuple[str, ...]:
    """Return one name for each row: its cell, with the line behind it where another row has the same."""
    names: dict[str, None] = {}
    for k, (line, cells) in enumerate(rows):
        name = str(k) if column is None or column >= len(cells) else cells[column].strip()[:200]
        name = name if name and name.isprintable() else f"line {line}"
        names[name if name not in names else f"{name} (line {line})"] = None
    return tuple(names)


def _full(cells: list[str], count: int, place: str) -> list[str]:
    """Return a row that has at least ``count`` cells; decimal commas between comma separators give too many or few."""
    if len(cells) < count:
        raise InputError(place, f"has {len(cells)} cells, its header {count}", "check separators and decimal points")
    return cells


def _once(labels: Sequence[str], path: str | Path) -> None:
    seen: set[str] = set()
    for label in labels:
        if label in seen:
            raise InputError(str(path), f"names {label[:60]!r} twice", "rename or remove one of them")
        seen.add(label)


def _is_number(cell: str) -> bool:
    try:
        number(cell, "")
    except InputError as error:
        return "decimal comma" in error.problem
    return True


def _origin_remark(width: int, origin: float) -> tuple[str, ...]:
    return (f"pixels counted from {origin:g}",) if width == 2 else ()


def write_landmark_csv(
    path: str | Path, points: FloatArray, labels: Sequence[str], origin: float | None = None
) -> None:
    """Write points as ``name,x,y[,z]``, one a line, so that reading gives the same points and names.

    Parameters
    ----------
    path : str or Path
        The file.
    points : (n, 2) or (n, 3) float
        Pixels x, y, or x, y, z; a row with NaN becomes empty cells.
    labels : sequence of str
        What each point is called.
    origin : {0, 0.5, 1}, optional
        What the file calls the centre of the top left pixel; 0 where left out.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    points = np.asarray(points, dtype=np.float64)
    width = points.shape[1]
    first = checked_origin(origin, "csv") if width == 2 else 0.0
    text = io.StringIO(newline="")
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["name", *"xyz"[:width]])
    for label, row in zip(labels, points.tolist(), strict=True):
        has_place = bool(np.isfinite(row).all())
        table.writerow([label, *([shifted_text(v, first) for v in row] if has_place else [""] * width)])
    with atomic_write(path) as handle:
        handle.write(text.getvalue().encode())
