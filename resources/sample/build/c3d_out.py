"""Writes marker positions as a C3D file of 16-bit integers, byte for byte the same every time."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from resources.sample.build.source import FloatArray

_BLOCK = 512
_GAP = np.array([0, 0, 0, -1], dtype="<i2")


def write_c3d(path: Path, labels: Sequence[str], positions: FloatArray, fps: float, scale_mm: float) -> None:
    """Write positions (L, K, 3) in mm, +Y up, in counts of ``scale_mm``; NaN is a gap, stored with residual -1.

    Raises
    ------
    ValueError
        When a position lies further out than the integers reach.
    """
    frames, markers = positions.shape[:2]
    counts = np.rint(np.nan_to_num(positions) / scale_mm)
    if np.abs(counts).max() > 32767:
        raise ValueError(f"positions reach {np.abs(positions).max():.0f} mm, {scale_mm} mm a count does not")
    data = np.zeros((frames, markers, 4), dtype="<i2")
    data[..., :3] = counts
    data[np.isnan(positions).any(axis=2)] = _GAP

    def groups(data_start: int) -> bytes:
        length = max(len(label) for label in labels)
        text = b"".join(label.encode("ascii").ljust(length) for label in labels)
        return b"".join(
            [
                _group(1, "POINT"),
                _parameter(1, "USED", 2, (), struct.pack("<h", markers)),
                _parameter(1, "SCALE", 4, (), struct.pack("<f", scale_mm)),
                _parameter(1, "RATE", 4, (), struct.pack("<f", fps)),
                _parameter(1, "DATA_START", 2, (), struct.pack("<h", data_start)),
                _parameter(1, "FRAMES", 2, (), struct.pack("<h", frames)),
                _parameter(1, "UNITS", -1, (2,), b"mm"),
                _parameter(1, "X_SCREEN", -1, (2,), b"+X"),
                _parameter(1, "Y_SCREEN", -1, (2,), b"+Y"),
                _parameter(1, "LABELS", -1, (length, markers), text),
                _group(2, "ANALOG"),
                _parameter(2, "USED", 2, (), struct.pack("<h", 0)),
                b"\0\0",
            ]
        )

    blocks = -(-(4 + len(groups(0))) // _BLOCK)
    parameters = (bytes([1, 0x50, blocks, 84]) + groups(2 + blocks)).ljust(blocks * _BLOCK, b"\0")
    header = struct.pack("<BB5HfHHf", 2, 0x50, markers, 0, 1, frames, 10, scale_mm, 2 + blocks, 0, fps)
    body = data.tobytes()
    path.write_bytes(header.ljust(_BLOCK, b"\0") + parameters + body.ljust(-(-len(body) // _BLOCK) * _BLOCK, b"\0"))


def _group(number: int, name: str) -> bytes:
    return struct.pack("<bb", len(name), -number) + name.encode() + struct.pack("<hB", 3, 0)


def _parameter(group: int, name: str, kind: int, dimensions: Sequence[int], values: bytes) -> bytes:
    body = struct.pack("<bB", kind, len(dimensions)) + bytes(dimensions) + values + b"\0"
    return struct.pack("<bb", len(name), group) + name.encode() + struct.pack("<h", len(body) + 2) + body
