"""Landmarks as ``.pts``: ``version: 1``, ``n_points: 68``, and between braces one point a line.

The format has no names and no holes. Its tools count pixels from 1, as Matlab does: the centre of the top left pixel
is (1, 1) in the files of iBUG and menpo, and that is what is read and written unless another origin is asked for.
Points of three coordinates lie on a mesh and have no origin to take off.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.landmark_file import (
    MAX_POINTS,
    LandmarkFile,
    checked_origin,
    shifted_number,
    shifted_text,
)
from engine.files.source import read_bytes
from engine.mesh import FloatArray

MAX_PTS_BYTES = 8 << 20
_REMEDY = "export it again"


def read_pts(path: str | Path, group: str | None = None, origin: float | None = None) -> LandmarkFile:
    """Read a ``.pts`` file.

    Parameters
    ----------
    path : str or Path
        The file.
    group : str, optional
        There is only one, without a name.
    origin : {0, 0.5, 1}, optional
        What the file calls the centre of the top left pixel; 1 where left out.

    Raises
    ------
    InputError
        On a header that does not fit the lines, and on what is no number.
    """
    first = checked_origin(origin, "pts")
    if group:
        raise InputError(str(path), f"has no group {group[:60]!r}", "a .pts file has one group only")
    data = read_bytes(path, MAX_PTS_BYTES)
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(str(path), f"is not text (byte {error.start})", _REMEDY) from error
    count, body = _body(path, lines)
    if len(body) != count:
        raise InputError(f"{path}, n_points", f"names {count} points, {len(body)} are there", _REMEDY)
    rows = [[word.rstrip(",;") for word in text.split()] for _, text in body]
    width = len(rows[0])
    if width not in (2, 3):
        raise InputError(f"{path}, line {body[0][0]}", f"has {width} numbers", "give x and y, or x, y and z")
    points = np.empty((count, width))
    for k, ((line, text), row) in enumerate(zip(body, rows, strict=True)):
        place = f"{path}, line {line}"
        if len(row) != width:
            raise InputError(place, f"{text[:40]!r} has {len(row)} numbers, the first point {width}", "correct it")
        points[k] = [shifted_number(word, first if width == 2 else 0.0, place) for word in row]
    remarks: tuple[str, ...] = ()
    if width == 2:
        asked = "as asked" if origin is not None else "as iBUG and menpo write them"
        remarks = (f"pixels counted from {first:g}, {asked}",)
    labels = tuple(str(k) for k in range(count))
    return LandmarkFile(points, labels, origin=first if width == 2 else 0.0, format="pts", remarks=remarks)


def _body(path: str | Path, lines: list[str]) -> tuple[int, list[tuple[int, str]]]:
    """Return n_points and the numbered lines between the braces."""
    count: int | None = None
    body: list[tuple[int, str]] | None = None
    for line, raw in enumerate(lines, start=1):
        text = raw.strip()
        if not text or text.startswith(("#", "//")):
            continue
        place = f"{path}, line {line}"
        if body is not None:
            if text == "}":
                if count is None:
                    raise InputError(f"{path}, n_points", "is missing", "add it")
                return count, body
            if len(body) >= MAX_POINTS:
                raise InputError(place, f"more than {MAX_POINTS} points", _REMEDY)
            body.append((line, text))
        elif text == "{":
            body = []
        else:
            key, colon, value = (part.strip() for part in text.partition(":"))
            if not colon:
                raise InputError(place, f"{text[:40]!r} is no line of a .pts header", "it begins with version: 1")
            if key == "version" and value not in ("1", "1.0"):
                raise InputError(f"{path}, version", f"is {value[:20]!r}, not 1", _REMEDY)
            if key == "n_points":
                if not (value.isascii() and value.isdigit() and len(value) < 10 and 1 <= int(value) <= MAX_POINTS):
                    problem = f"is {value[:20]!r}, not a count of 1 to {MAX_POINTS}"
                    raise InputError(f"{path}, n_points", problem, "correct it")
                count = int(value)
    missing = "its points have no end: '}' is missing" if body is not None else "has no points: '{' is missing"
    raise InputError(str(path), missing, _REMEDY)


def write_pts(path: str | Path, points: FloatArray, origin: float | None = None) -> None:
    """Write points (n, 2) or (n, 3) as ``.pts``, so that reading gives the same numbers.

    Raises
    ------
    InputError
        On a point without a place, which the format cannot hold, and where the file cannot be written.
    """
    points = np.asarray(points, dtype=np.float64)
    first = checked_origin(origin, "pts") if points.shape[1] == 2 else 0.0
    holes = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(holes):
        problem = (
            f"{len(holes)} of {len(points)} points have no place (number {holes[0]}), and .pts cannot leave them out"
        )
        raise InputError(str(path), problem, "write .ljson or .csv, or export names that are all placed")
    lines = [" ".join(shifted_text(value, first) for value in row) for row in points.tolist()]
    text = "\n".join(["version: 1", f"n_points: {len(points)}", "{", *lines, "}", ""])
    with atomic_write(path) as handle:
        handle.write(text.encode())
