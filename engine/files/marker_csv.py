"""Markers as tables: three columns a marker, one row a frame, whatever separates the cells."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from engine.errors import InputError, some
from engine.files.marker_table import marker_file
from engine.files.motion_file import MotionFile, rate_of_times
from engine.files.motion_text import MISSING, decoded, number_table

SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "blanks"}
_BY_NAME = re.compile(r"^(.+?)(?:[_ .:/-]|\[|\()?([xyz])[\])]?(?:\s*[\[(].{0,12}[\])])?$", re.IGNORECASE)
_AXIS = re.compile(r"^(?:[a-z]*[_ .:])?([xyz])\d*(?:\s*[\[(].{0,12}[\])])?$", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"^[+-]?\d*,\d+(?:[eE][+-]?\d+)?$")
_NUMBERED = re.compile(r"^[\dA-F]+$|^position$", re.IGNORECASE)
_HEADER_LINES, _LOOKED_AT = 15, 200
_TIME = ("time", "time_s", "time (seconds)", "time(s)", "time [s]", "time (s)", "seconds", "timestamp", "t")
_FRAME = ("frame", "frame#", "frames", "field", "sample", "index", "")


class _Mark(NamedTuple):
    """What a row says of itself: its line in the file, frame number and time as they are written."""

    line: int
    frame: str | None
    time: str | None


_Header = tuple[int, tuple[str, ...], tuple[tuple[int, int, int], ...]]


class _Layout(NamedTuple):
    """Where a table's header ends (lines), its labels, their columns x, y, z, and those of frame and time."""

    lines: int
    labels: tuple[str, ...]
    columns: tuple[tuple[int, int, int], ...]
    width: int
    frame: int | None
    time: int | None


def read_marker_csv(
    path: str | Path,
    *,
    unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    fps: float | None = None,
) -> MotionFile:
    """Read a table of markers.

    The columns of a marker are named ``brow_x,brow_y,brow_z``, ``brow.X``, or by two rows: labels above, X, Y, Z below.
    Cells are separated by commas, semicolons, tabs, bars or blanks; an empty cell, NA and NaN are gaps. The frame rate
    is that of a time column, else it must be asked for. Columns that belong to no marker are passed over.

    Raises
    ------
    InputError
        Naming the line: on rows of another length, what is no number; on a header without markers, double columns.
    """
    path = Path(path)
    lines = decoded(path).splitlines()
    separator = _separator(lines)
    head = list(_rows(path, lines[:_HEADER_LINES], separator))
    layout = _layout(path, head)
    warnings = [f"separated by {SEPARATORS[separator]}"] if separator not in ",;\t" else []
    first = [row for row in _rows(path, lines[: _HEADER_LINES + _LOOKED_AT], separator) if row[0] > layout.lines]
    comma = separator != "," and _decimal_commas(first, layout)
    if comma:
        warnings.append("decimal commas are read as points")
    wanted = [column for columns in layout.columns for column in columns]
    marks: list[_Mark] = []

    def cells() -> Iterator[tuple[int, list[str]]]:
        for line, row in _rows(path, lines, separator):
            if line <= layout.lines:
                continue
            if len(row) < layout.width or any(cell.strip() for cell in row[layout.width :]):
                problem = f"has {len(row)} cells, its header {layout.width}"
                raise InputError(f"{path}, line {line}", problem, "check separators and decimal points")
            row = [cell.replace(",", ".") for cell in row] if comma else row
            frame, time = (None if column is None else row[column].strip() for column in (layout.frame, layout.time))
            marks.append(_Mark(line, frame, time))
            yield line, [row[c] for c in wanted]

    values = number_table(path, cells())
    if not len(values):
        raise InputError(str(path), "has a header and no rows", "export it again")
    rate, more = _rate(path, marks, timed=fps is None)
    return marker_file(
        path,
        "marker csv",
        layout.labels,
        values.reshape(len(values), -1, 3),
        unit=unit,
        up=up,
        forward=forward,
        fps=fps,
        named_fps=rate,
        warnings=(*warnings, *more),
    )


def names_markers(lines: Sequence[str]) -> bool:
    """Return whether the first lines of a table name the columns of markers."""
    rows = list(_rows(Path("table"), lines, _separator(lines)))
    return _one_row("table", rows) is not None or _two_rows(rows) is not None


def _separator(lines: Sequence[str]) -> str:
    """What parts the cells of the first lines: the one that makes the most of them, alike in every line."""
    few = [line for line in lines[:_HEADER_LINES] if line.strip()]
    counts = {separator: max((line.count(separator) for line in few), default=0) for separator in "\t;,|"}
    best = max(counts, key=lambda separator: counts[separator])
    # Semicolons and tabs go with decimal commas, of which there are then nearly as many.
    for stronger in ("\t", ";"):
        if 2 * counts[stronger] >= counts[best] > 0 and counts[stronger] >= 2:
            return stronger
    return best if counts[best] >= 2 else " "


def _rows(path: Path, lines: Sequence[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield line numbers and cells of the lines that hold something."""
    if separator == " ":
        yield from ((k, line.split()) for k, line in enumerate(lines, start=1) if line.strip())
        return
    table = csv.reader(lines, delimiter=separator)
    try:
        for row in table:
            if any(cell and not cell.isspace() for cell in row):
                yield table.line_num, row
    except csv.Error as error:
        raise InputError(
            f"{path}, line {table.line_num}", f"is no line of a table ({error})", "export it again"
        ) from error


def _layout(path: Path, rows: Sequence[tuple[int, list[str]]]) -> _Layout:
    found = _two_rows(rows) or _one_row(str(path), rows)
    if found is None:
        remedy = "name three columns a marker: brow_x, brow_y, brow_z, or two rows: labels, then X, Y, Z"
        raise InputError(f"{path}, header", "no columns of markers are found", remedy)
    line, labels, columns = found
    double = sorted({label for label in labels if labels.count(label) > 1})
    if double:
        raise InputError(f"{path}, line {line}", f"names the marker {some(double)} twice", "rename one of them")
    header = [cell.strip().lower() for cell in dict(rows)[line]]
    used = {column for triple in columns for column in triple}
    free = [k for k in range(len(header)) if k not in used]
    width = max(len(header), max(used) + 1)
    while width > max(used) + 1 and not header[width - 1]:
        width -= 1
    time = next((k for k in free if header[k] in _TIME), None)
    frame = next((k for k in free if header[k] in _FRAME and k < min(used)), None)
    return _Layout(line, labels, columns, width, frame, time)


def _one_row(
    subject: str,
    rows: Sequence[tuple[int, list[str]]],
) -> _Header | None:
    """Find names such as ``brow_x`` in one line: (line, labels, columns)."""
    for line, cells in rows:
        found: dict[str, dict[str, int]] = {}
        for column, cell in enumerate(cells):
            match = _BY_NAME.match(cell.strip())
            if match is None:
                continue
            axes = found.setdefault(match[1].strip(), {})
            if match[2].lower() in axes:
                problem = f"names the column {cell.strip()[:40]!r} twice"
                raise InputError(f"{subject}, line {line}", problem, "rename one of them")
            axes[match[2].lower()] = column
        whole = {label: axes for label, axes in found.items() if len(axes) == 3}
        if whole:
            columns = tuple((axes["x"], axes["y"], axes["z"]) for axes in whole.values())
            return line, tuple(whole), columns
    return None


def _two_rows(
    rows: Sequence[tuple[int, list[str]]],
) -> _Header | None:
    """Find a line of X, Y, Z below one of labels: (line of the axes, labels, columns)."""
    for place, (line, cells) in enumerate(rows):
        axes = [match[1].lower() if (match := _AXIS.match(cell.strip())) else "" for cell in cells]
        starts = [k for k in range(len(axes) - 2) if axes[k : k + 3] == ["x", "y", "z"]]
        if not starts:
            continue
        # Some exporters put "Position" or numbers between: the labels are in the nearest line that tells markers apart.
        above = [tuple(row[k].strip() if k < len(row) else "" for k in starts) for _, row in reversed(rows[:place])]
        full = [labels for labels in above if all(labels)]
        telling = [labels for labels in full if len(set(labels)) == len(labels)]
        worded = [labels for labels in telling if not all(_NUMBERED.match(label) for label in labels)]
        best = next(iter(worded or telling or full), None)
        if best is not None:
            return line, best, tuple((k, k + 1, k + 2) for k in starts)
    return None


def _decimal_commas(body: Sequence[tuple[int, list[str]]], layout: _Layout) -> bool:
    some_rows = [row for _, row in body[:: max(1, len(body) // 200)]]
    cells = [row[c].strip() for row in some_rows for triple in layout.columns for c in triple if c < len(row)]
    return any(_DECIMAL_COMMA.match(cell) for cell in cells) and not any("." in cell for cell in cells)


def _rate(path: Path, marks: Sequence[_Mark], timed: bool) -> tuple[float | None, list[str]]:
    """Return the frame rate that a time column tells where it is asked, and what frame numbers and times tell."""
    said = []
    frames = [
        mark.frame for mark in marks if mark.frame is not None and mark.frame.isdecimal() and len(mark.frame) < 12
    ]
    if len(frames) == len(marks):
        steps = np.diff([int(frame) for frame in frames])
        skipped = int(np.maximum(steps - int(np.median(steps)), 0).sum()) if len(steps) else 0
        if (steps <= 0).any():
            line = marks[int(np.flatnonzero(steps <= 0)[0]) + 1].line
            said.append(f"the frame numbers turn back in line {line}: several takes may stand in one file")
        elif skipped:
            said.append(f"the frame numbers skip {skipped}: the clip is shorter than the performance")
    if not timed or any(mark.time is None for mark in marks):
        return None, said
    if any((mark.time or "").lower() in MISSING for mark in marks):
        return None, [*said, "the time column has gaps and is not used"]
    times = number_table(path, [(mark.line, [mark.time or ""]) for mark in marks])[:, 0]
    rate, odd = rate_of_times(times)
    return rate, [*said, *odd]
