"""Weight curves as tables of ours: ``frame,time_s,<shape>...``, written without loss."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.motion_file import MAX_FRAMES, MotionFile, choose_fps, rate_of_times
from engine.files.motion_text import check_labels, decoded, number_table
from engine.mesh import IntArray
from engine.motion import WeightCurves

_FIRST = ("frame", "time_s")


def looks_like_weights(header: str) -> bool:
    """Return whether the first line of a table is one of weights."""
    return [cell.strip().lower() for cell in header.split(",")[:2]] == list(_FIRST)


def read_weights(path: str | Path, fps: float | None = None) -> MotionFile:
    """Read weight curves: ``frame,time_s,<shape>...``, one row a frame.

    Raises
    ------
    InputError
        Naming the line: on a row of another length, what is no number or missing.
    """
    path = Path(path)
    rows = list(csv.reader(decoded(path).splitlines()))
    header = [cell.strip() for cell in rows[0]] if rows else []
    if not looks_like_weights(",".join(header[:2])):
        raise InputError(f"{path}, line 1", "does not begin with frame,time_s", "export it again")
    names = check_labels(path, header[2:], "shape")
    lines = [(line, row) for line, row in enumerate(rows[1:], start=2) if any(cell.strip() for cell in row)]
    if not 1 <= len(lines) <= MAX_FRAMES:
        raise InputError(str(path), f"has {len(lines)} frames", f"give 1 to {MAX_FRAMES}")
    for line, row in lines:
        if len(row) != len(header):
            raise InputError(
                f"{path}, line {line}", f"has {len(row)} cells, its header {len(header)}", "export it again"
            )
    numbers = number_table(path, lines)
    values = numbers[:, 1:]
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        raise InputError(f"{path}, line {lines[int(bad[0])][0]}", "lacks a number", "give every weight of every frame")
    counted, steps = np.diff(numbers[:, 0]), np.diff(values[:, 0])
    dropped = 0
    if len(steps) and np.isfinite(numbers[:, 0]).all() and (counted >= 1).all():
        # Frames that a recording shows too little of are left out, and the numbers of the others say so.
        dropped, steps = int((counted - 1).sum()), steps / counted
    named: float | None = None
    odd: tuple[str, ...] = ()
    if fps is None and len(steps):
        named, odd = rate_of_times(np.append(0.0, np.cumsum(steps)))
    rate, said, guessed = choose_fps(str(path), fps, named)
    return MotionFile(
        WeightCurves(names, values[:, 1:], rate),
        "weights",
        "weights csv",
        "",
        said,
        (path,),
        up="",
        forward="",
        guessed=("fps",) if guessed else (),
        warnings=((f"its numbers skip {dropped} frames, which are left out",) if dropped else ()) + odd,
        dropped=dropped,
    )


def write_weights(path: str | Path, curves: WeightCurves, frames: IntArray | None = None) -> None:
    """Write weight curves so that reading gives the same numbers, bit by bit; frames count from 1, time from 0 s.

    ``frames`` (L,) says which frames of a recording these are, from 0; the first ones where it is left out.

    Raises
    ------
    InputError
        When the file cannot be written, or a name is one that no table can hold.
    """
    names = check_labels(path, [name.strip() for name in curves.names], "shape")
    with atomic_write(path) as handle:
        text = io.TextIOWrapper(handle, encoding="utf-8", newline="")
        table = csv.writer(text, lineterminator="\n")
        table.writerow([*_FIRST, *names])
        which = range(len(curves)) if frames is None else np.asarray(frames).tolist()
        for frame, row in zip(which, curves.weights.tolist(), strict=True):
            table.writerow([frame + 1, repr(frame / curves.fps), *map(repr, row)])
        text.flush()
        text.detach()
