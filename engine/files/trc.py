"""Marker tracks as text: TRC, as Motion Analysis and OpenSim write it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.marker_table import marker_file
from engine.files.motion_file import MotionFile
from engine.files.motion_text import MAX_COLUMNS, MISSING, decoded, length_unit, number_table

_HEAD_LINES = 3


def read_trc(
    path: str | Path,
    *,
    unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    fps: float | None = None,
) -> MotionFile:
    """Read a TRC file: tab separated, empty fields and NaN are gaps.

    Raises
    ------
    InputError
        Naming the line: on a head that lacks something, rows of another length, what is no number; on a frame rate of
        0, double labels, and another number of markers than announced.
    """
    path = Path(path)
    lines = decoded(path).splitlines()
    if len(lines) < _HEAD_LINES + 2 or not lines[0].startswith("PathFileType"):
        raise InputError(f"{path}, line 1", "does not begin with PathFileType", "export it as TRC again")
    said = dict(zip(_cells(lines[1]), _cells(lines[2]), strict=False))
    rate = _named_number(path, said, "DataRate")
    columns = _cells(lines[3])
    if [cell.rstrip("#").lower() for cell in columns[:2]] != ["frame", "time"]:
        raise InputError(f"{path}, line 4", "does not begin with Frame# and Time", "export it as TRC again")
    labels = tuple(cell for cell in columns[2:] if cell)
    announced = _named_number(path, said, "NumMarkers")
    if announced is not None and announced != len(labels):
        problem = f"announces {announced:g} markers, {len(labels)} are named"
        raise InputError(f"{path}, line 3", problem, "export it again")
    width = 2 + 3 * len(labels)
    if width > MAX_COLUMNS:
        raise InputError(f"{path}, line 4", f"names {len(labels)} markers", "export fewer")
    rows = []
    for number, line in enumerate(lines[5:], start=6):
        cells = line.split("\t")
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) < width or any(cell.strip() for cell in cells[width:]):
            problem = f"has {len(cells)} fields, {width} belong to {len(labels)} markers"
            raise InputError(f"{path}, line {number}", problem, "export it again")
        rows.append((number, cells[2:width]))
    if not rows:
        raise InputError(str(path), "has a head and no frames", "export it again")
    positions = number_table(path, rows).reshape(len(rows), len(labels), 3)
    warnings: tuple[str, ...] = ()
    frames = _named_number(path, said, "NumFrames")
    if frames is not None and frames != len(rows):
        warnings = (f"the file announces {frames:g} frames and holds {len(rows)}",)
    return marker_file(
        path,
        "trc",
        labels,
        positions,
        unit=unit,
        named_unit=length_unit(said.get("Units", "")),
        up=up,
        forward=forward,
        fps=fps,
        named_fps=rate,
        warnings=warnings,
    )


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split("\t")]


def _named_number(path: Path, said: dict[str, str], name: str) -> float | None:
    text = said.get(name, "")
    if text.lower() in MISSING:
        return None
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{path}, line 3", f"{name} is {text[:40]!r}", "correct it") from None
    if not np.isfinite(value):
        raise InputError(f"{path}, line 3", f"{name} is {text[:40]!r}", "correct it")
    return value
