"""Live Link Face tables: a time code and the ARKit weights of every frame, as a phone records them."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from engine.errors import InputError, some
from engine.files.motion_file import MAX_FRAMES, MotionFile, choose_fps, nearest_rate
from engine.files.motion_text import check_labels, decoded, number_table
from engine.mesh import BoolArray
from engine.motion import WeightCurves

_TIMECODE = re.compile(r"(\d{1,3}):(\d{1,2}):(\d{1,2})[:;](\d{1,3})(?:\.(\d{1,6}))?")
_FIRST = ("timecode", "blendshapecount")


def looks_like_live_link(header: str) -> bool:
    """Return whether the first line of a table is one of Live Link Face."""
    return [cell.strip().lower() for cell in header.split(",")[:2]] == list(_FIRST)


def read_live_link(path: str | Path, fps: float | None = None) -> MotionFile:
    """Read a Live Link Face table: ``Timecode,BlendShapeCount,<name>...``.

    The frame rate is found from the time code, ``hh:mm:ss:frame.part``; frames that it skips are counted and left
    out, not invented. Rows without numbers are left out and counted.

    Parameters
    ----------
    path : str or Path
        The file.
    fps : float, optional
        Frames a second; from the time code where left out.

    Raises
    ------
    InputError
        Naming the line: on a row of another length, what is no number, no time code.
    """
    path = Path(path)
    text = decoded(path)
    rows = list(csv.reader(text.splitlines()))
    header = [cell.strip() for cell in rows[0]] if rows else []
    if not looks_like_live_link(",".join(header)):
        raise InputError(f"{path}, line 1", "does not begin with Timecode,BlendShapeCount", "export it again")
    names = check_labels(path, header[2:], "shape")
    lines = [(line, row) for line, row in enumerate(rows[1:], start=2) if any(cell.strip() for cell in row)]
    if len(lines) > MAX_FRAMES:
        raise InputError(str(path), f"has {len(lines)} frames", f"cut it to at most {MAX_FRAMES}")
    for line, row in lines:
        if len(row) != len(header):
            raise InputError(
                f"{path}, line {line}", f"has {len(row)} cells, its header {len(header)}", "export it again"
            )
    values = number_table(path, [(line, row[2:]) for line, row in lines])
    good: BoolArray = np.asarray(np.isfinite(values).all(axis=1), dtype=bool)
    warnings: list[str] = []
    if not good.all():
        warnings.append(f"{int((~good).sum())} of {len(good)} rows lack numbers and were left out")
    if not good.any():
        raise InputError(str(path), "has no row with all numbers", "record or export it again")
    kept = [place for place, use in zip(lines, good, strict=True) if use]
    measured, dropped = _rate(path, [(line, row[0]) for line, row in kept])
    rate, said, guessed = choose_fps(str(path), fps, measured)
    if fps is None and measured is not None:
        said = f"{rate:g} frames a second, from the time code"
    if fps is None and measured is None:
        said = f"{rate:g} frames a second assumed: the time code is too short to tell"
    if dropped:
        warnings.append(f"the time code skips {dropped} frames: the clip is shorter than the performance by as many")
    outside = [name for k, name in enumerate(names) if np.abs(values[good][:, k]).max() > 10]
    if outside:
        warnings.append(f"{some(outside)} exceeds 10, where weights are customarily 0 to 1")
    curves = WeightCurves(names, values[good], rate)
    return MotionFile(
        curves,
        "weights",
        "live link",
        "",
        said,
        (path,),
        up="",
        forward="",
        guessed=("fps",) if guessed else (),
        warnings=tuple(warnings),
        dropped=dropped,
    )


def _rate(path: Path, codes: list[tuple[int, str]]) -> tuple[float | None, int]:
    """Return the frame rate of time codes and how many frames they skip; None where they do not tell."""
    seconds, frames = np.empty(len(codes)), np.empty(len(codes))
    for k, (line, code) in enumerate(codes):
        found = _TIMECODE.fullmatch(code.strip())
        if found is None:
            problem = f"{code[:40]!r} is no time code hh:mm:ss:frame"
            raise InputError(f"{path}, line {line}", problem, "export it again")
        seconds[k] = int(found[1]) * 3600 + int(found[2]) * 60 + int(found[3])
        frames[k] = float(f"{found[4]}.{found[5] or 0}")
    if len(codes) < 2:
        return None, 0
    stated = len(np.unique(seconds)) > 1
    base = next((rate for rate in (24, 25, 30, 48, 50, 60, 90, 100, 120, 240) if frames.max() < rate), 1000)
    # A short clip may not reach the last frame numbers of a second; one that counts on into the next second tells more.
    turns = np.flatnonzero(np.diff(seconds) == 1)
    if len(turns):
        steps = np.diff(frames)
        usual = np.median(steps[np.diff(seconds) == 0]) if (np.diff(seconds) == 0).any() else 1.0
        span = np.median(frames[turns] - frames[turns + 1]) + usual
        base = int(min((24, 25, 30, 48, 50, 60, 90, 100, 120, 240), key=lambda rate: abs(rate - span)))
    times = seconds + frames / base
    steps = np.diff(times)
    steps = np.where(steps < -43200, steps + 86400, steps)
    forward = steps[steps > 0]
    if not len(forward):
        return None, 0
    usual = float(np.median(forward))
    if (steps <= 0).any():
        line = codes[int(np.flatnonzero(steps <= 0)[0]) + 1][0]
        raise InputError(f"{path}, line {line}", "its time code does not go on", "export one take at a time")
    dropped = int(np.maximum(np.rint(steps / usual) - 1, 0).sum())
    # Within one second nothing says how many frames it has.
    return nearest_rate(1 / usual) if stated else None, dropped
