"""Mesh caches: PC2, the positions of every vertex in every sample, memory-mapped."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.dense_checks import MAX_DENSE_BYTES, dense_file
from engine.files.motion_file import MAX_FRAMES, MotionFile
from engine.files.source import checked_file

_HEAD = struct.Struct("<12siiffi")
_MAGIC = b"POINTCACHE2\0"


def read_pc2(
    path: str | Path,
    *,
    unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    fps: float | None = None,
) -> MotionFile:
    """Read a PC2 mesh cache; its positions stay in the file until they are asked for.

    The format tells samples a frame, not frames a second: with ``fps`` or 30 assumed, samples are frames / rate apart.

    Raises
    ------
    InputError
        When it is no PC2 file, its size does not bear out its head, or positions are not finite (naming the frame).
    """
    path = checked_file(path, MAX_DENSE_BYTES)
    with path.open("rb") as handle:
        head = handle.read(_HEAD.size)
    if len(head) < _HEAD.size or head[:12] != _MAGIC:
        raise InputError(str(path), "does not begin with POINTCACHE2", "export it as PC2 again")
    _, version, points, _, rate, samples = _HEAD.unpack(head)
    if version != 1:
        raise InputError(str(path), f"is PC2 version {version}", "export it as version 1")
    if points < 1 or not 1 <= samples <= MAX_FRAMES:
        raise InputError(str(path), f"announces {points} points in {samples} samples", "export it again")
    wanted, there = _HEAD.size + 12 * points * samples, path.stat().st_size
    if wanted > there:
        problem = f"is cut off: {points} points in {samples} samples take {wanted} bytes, {there} are there"
        raise InputError(str(path), problem, "copy or export it again")
    warnings: tuple[str, ...] = ()
    if wanted < there:
        warnings = (f"{there - wanted} bytes behind the last sample are passed over",)
    if not np.isfinite(rate) or rate <= 0:
        raise InputError(str(path), f"names {rate:g} frames a sample", "export it again")
    if rate != 1:
        warnings = (*warnings, f"a sample every {rate:g} frames: the samples count as frames here")
    vertices = np.memmap(path, "<f4", "r", _HEAD.size, (samples, points, 3))
    return dense_file(path, "pc2", vertices, unit=unit, up=up, forward=forward, fps=fps, warnings=warnings)
