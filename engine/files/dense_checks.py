"""What the formats of dense motion share: finite positions, unit, axes and frame rate."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.motion_axes import place_mesh
from engine.files.motion_file import MAX_FRAMES, DenseClip, MotionFile, choose_fps
from engine.mesh import FloatArray

MAX_DENSE_BYTES = 1 << 36
"""Largest file of dense motion, in bytes: it is mapped, not read."""

_CHECKED_AT_ONCE = 16 << 20


def dense_file(
    path: Path,
    kind: str,
    vertices: NDArray[Any],
    *,
    unit: str | None,
    up: str | None,
    forward: str | None,
    fps: float | None,
    named_unit: str | None = None,
    named_fps: float | None = None,
    warnings: tuple[str, ...] = (),
) -> MotionFile:
    """Return the file of positions (L, N, 3) as stored.

    Raises
    ------
    InputError
        On positions that are not finite (naming the frame), too many frames, a frame rate of 0.
    """
    if len(vertices) > MAX_FRAMES:
        raise InputError(str(path), f"has {len(vertices)} frames", f"cut it to at most {MAX_FRAMES}")
    rate, rate_said, guessed = choose_fps(str(path), fps, named_fps)
    placing = place_mesh(unit, named_unit, up, forward, _extent(path, vertices))
    axes = placing.rotation if (placing.up, placing.forward) != ("y", "z") else None
    return MotionFile(
        DenseClip(vertices, rate, placing.scale, axes),
        "dense",
        kind,
        placing.unit,
        f"{placing.assumed}; {rate_said}",
        (path,),
        up=placing.up,
        forward=placing.forward,
        guessed=(*placing.guessed, *(("fps",) if guessed else ())),
        warnings=(*warnings, *placing.warnings),
    )


def _extent(path: Path, vertices: NDArray[Any]) -> float:
    """Return the largest side of the first frame, having seen that all positions are finite."""
    step = max(1, _CHECKED_AT_ONCE // max(1, vertices[0].nbytes))
    for start in range(0, len(vertices), step):
        piece = np.asarray(vertices[start : start + step])
        good = np.asarray(np.isfinite(piece).all(axis=(1, 2)), dtype=bool)
        if not good.all():
            frame = start + int(np.flatnonzero(~good)[0]) + 1
            raise InputError(f"{path}, frame {frame}", "holds positions that are not finite", "export it again")
    first: FloatArray = np.asarray(vertices[0], dtype=np.float64)
    extent = float(np.ptp(first, axis=0).max())
    if not 0 < extent < 1e12:
        raise InputError(f"{path}, frame 1", f"spans {extent:g} units", "export it again")
    return extent
