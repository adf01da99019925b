"""From labelled positions, as any marker format gives them, to a checked clip in mm and our frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.errors import InputError, some
from engine.files.motion_axes import Placing, place_markers, seen_in
from engine.files.motion_file import MAX_FRAMES, MotionFile, choose_fps
from engine.files.motion_text import check_labels
from engine.mesh import BoolArray, FloatArray
from engine.motion import MarkerClip

_FARTHEST = 1e7


def marker_file(
    path: Path,
    kind: str,
    labels: tuple[str, ...],
    positions: FloatArray,
    *,
    unit: str | None = None,
    named_unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    named_axes: tuple[str, str] | None = None,
    fps: float | None = None,
    named_fps: float | None = None,
    warnings: tuple[str, ...] = (),
) -> MotionFile:
    """Return the file of markers (L, K, 3) in its own numbers, NaN where one was not seen.

    Markers that no frame shows are left out and named; a position that lacks a coordinate is a gap.

    Raises
    ------
    InputError
        On double labels, no frames, a frame rate of 0, or when no marker is ever seen.
    """
    labels = _without_subject(labels)
    check_labels(path, labels, "marker")
    if not 1 <= len(positions) <= MAX_FRAMES:
        raise InputError(str(path), f"has {len(positions)} frames", f"give 1 to {MAX_FRAMES}")
    rate, rate_said, rate_guessed = choose_fps(str(path), fps, named_fps)
    seen = seen_in(positions)
    shown: BoolArray = np.asarray(seen.any(axis=0), dtype=bool)
    if not shown.any():
        raise InputError(str(path), "shows none of its markers in any frame", "export a take with markers")
    unseen = tuple(label for label, is_shown in zip(labels, shown, strict=True) if not is_shown)
    said = list(warnings)
    if unseen:
        said.append(f"{some(unseen)} never seen: left out")
    positions, seen = positions[:, shown], seen[:, shown]
    positions = np.where(seen[..., None], positions, np.nan)
    farthest = float(np.nanmax(np.abs(positions)))
    if farthest > _FARTHEST:
        raise InputError(str(path), f"holds positions {farthest:.3g} units away", "correct them, or leave them empty")
    placing: Placing = place_markers(str(path), positions, unit, named_unit, up, forward, named_axes)
    gaps = int((~seen).sum())
    if gaps:
        empty = int((~seen.any(axis=1)).sum())
        also = f"; {empty} frames show no marker" if empty else ""
        said.append(f"{gaps} of {seen.size} positions are gaps ({100 * gaps / seen.size:.1f} %){also}")
    kept = tuple(label for label, is_shown in zip(labels, shown, strict=True) if is_shown)
    clip = MarkerClip(kept, placing.apply(positions), rate)
    return MotionFile(
        clip,
        "markers",
        kind,
        placing.unit,
        f"{placing.assumed}; {rate_said}",
        (path,),
        up=placing.up,
        forward=placing.forward,
        guessed=(*placing.guessed, *(("fps",) if rate_guessed else ())),
        warnings=(*said, *placing.warnings),
        gaps=gaps,
        unseen=unseen,
    )


def _without_subject(labels: tuple[str, ...]) -> tuple[str, ...]:
    """Return labels without the subject's name that all of them begin with: ``actress:brow1``."""
    subjects = {label.partition(":")[0] if ":" in label[1:-1] else "" for label in labels}
    if len(subjects) == 1 and "" not in subjects:
        return tuple(label.partition(":")[2].strip() for label in labels)
    return labels
