"""Point text: x y z and perhaps red green blue in every line, in the order of a scan whose holes are left out."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import numpy as np

from engine.errors import InputError
from engine.files.pixel_grid import scan_of_cloud
from engine.files.point_colour import from_channels
from engine.files.scan_file import MM_PER_UNIT, ScanFile, choose_unit
from engine.files.source import checked_file
from engine.files.text_numbers import numbers_in, read_table

_SEPARATORS = b",;"
_MAX_LINE = 4096
_MOST_HEADER_LINES = 100
_MOST_COLUMNS = 32


def read_xyz(path: str | Path, unit: str | None = None) -> ScanFile:
    """Read a scan from text with one point a line: x y z, and red green blue where six numbers or more stand there.

    Blanks, commas or semicolons part the numbers; ``#`` and ``//`` begin comments; lines without numbers may head the
    file, and so may the number of points. Colours are 0..255, or 0..1 where a fraction is among them. The pixels are
    found from the points (``pixel_grid``), and points at the origin, where the scanner stands, are left out.

    Raises
    ------
    InputError
        On what is no number, rows of different lengths, a wrong count, or points that lie on no grid.
    """
    path = checked_file(path)
    subject = str(path)
    with path.open("rb") as handle:
        columns, count = _beginning(handle, subject)
        table = read_table(handle, subject, columns, None, _SEPARATORS, comments=True)
    if count is not None and count != len(table):
        raise InputError(subject, f"holds {len(table)} points, its first line says {count}", "copy or export it again")
    points = table[:, :3]
    colour, warnings = None, tuple[str, ...]()
    if columns >= 6:
        colour, warnings = from_channels(table[:, 3:6])
    elif columns > 3:
        warnings = (f"columns 4 to {columns} are no colours: left out",)
    if columns > 6:
        warnings += (f"columns 7 to {columns} were left out",)
    measured = (points != 0).any(axis=1)
    if not measured.all():
        points, colour = points[measured], None if colour is None else colour[measured]
        warnings += (f"{int((~measured).sum())} points at the origin were taken as missing",)
    chosen, assumed, more = choose_unit(unit, None, subject)
    with np.errstate(over="ignore", invalid="ignore"):
        points = points * MM_PER_UNIT[chosen]
    return scan_of_cloud(path, points, colour, "xyz", (chosen, assumed, warnings + more))


def looks_like_points(start: bytes) -> bool:
    """Whether the first bytes of a file are lines of three numbers or more."""
    lines = [line.split(b"#")[0].translate(_BLANKED) for line in start.splitlines()[:-1]]
    found = [numbers for line in lines if line.strip() and (numbers := numbers_in(line)) is not None]
    return len(found) > 1 and len(found[-1]) >= 3 and len(found[-1]) == len(found[-2])


def _beginning(handle: BinaryIO, subject: str) -> tuple[int, int | None]:
    """Return how many columns there are and the announced count of points; ``handle`` stands at the first point."""
    count: int | None = None
    for _ in range(_MOST_HEADER_LINES):
        place = handle.tell()
        line = handle.readline(_MAX_LINE)
        if not line:
            break
        if len(line) == _MAX_LINE:
            raise InputError(subject, "has a line that is too long for text", "export it again")
        bare = line.removeprefix(b"\xef\xbb\xbf").split(b"#")[0].split(b"//")[0].translate(_BLANKED)
        numbers = numbers_in(bare)
        if not numbers:
            continue
        if len(numbers) == 1 and count is None and numbers[0].is_integer() and numbers[0] > 0:
            count = int(numbers[0])
            continue
        if not 3 <= len(numbers) <= _MOST_COLUMNS:
            problem = f"its first row has {len(numbers)} numbers, not x y z and perhaps red green blue"
            raise InputError(subject, problem, "give 3 or 6 columns")
        handle.seek(place + (3 if line.startswith(b"\xef\xbb\xbf") else 0))
        return len(numbers), count
    raise InputError(subject, "holds no rows of numbers", "give x y z in every line")


_BLANKED = bytes.maketrans(_SEPARATORS, b" " * len(_SEPARATORS))
