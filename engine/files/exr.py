"""Depth images as OpenEXR: one channel of floats; needs the extra ``exr``."""

from __future__ import annotations

import importlib.util
import io
import struct
import subprocess
import sys
import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError

EXR = b"v/1\x01"
_FLAGS_REFUSED = 0x200 | 0x800 | 0x1000
_MOST_ATTRIBUTES = 1000
_LONGEST_NAME = 256
_MOST_BYTES = 256 << 20
_LONGEST_S = 30.0
# The library tells of damage on the standard streams only and returns what it has, so it works where these are seen.
_DECODER = """
import io, sys
import numpy, OpenEXR
out, sys.stdout = sys.stdout, io.StringIO()
with OpenEXR.File(io.BytesIO(sys.stdin.buffer.read()), separate_channels=True, num_threads=0) as file:
    channels = {name: numpy.array(channel.pixels) for name, channel in file.channels().items()}
if sys.stdout.getvalue():
    sys.exit(1)
packed = io.BytesIO()
numpy.savez(packed, **channels)
out.buffer.write(packed.getbuffer())
"""
_DEPTH_CHANNELS = ("Z", "z", "depth", "Depth", "depth.Z", "Y", "V", "R")


class ExrDamagedError(ValueError):
    """The header is cut off or not that of one part of scan lines; the message says so."""


def exr_size(data: bytes) -> tuple[int, int]:
    """Return (width, height) in pixels as the header of an EXR file says.

    Raises
    ------
    ExrDamagedError
        On tiles, deep data or several parts, and when the header is cut off or names no size.
    """
    try:
        (version,) = struct.unpack_from("<I", data, 4)
        if version & _FLAGS_REFUSED:
            raise ExrDamagedError("is tiled, deep or in several parts: save one part of scan lines")
        attributes = _attributes(data)
        left, top, right, bottom = struct.unpack("<4i", attributes.get(b"dataWindow", b""))
        width, height = right - left + 1, bottom - top + 1
        channels, place, names = attributes.get(b"channels", b""), 0, 0
        while place < len(channels) - 1:
            place, names = _word(channels, place)[1] + 16, names + 1
    except (struct.error, IndexError) as error:
        raise ExrDamagedError("is damaged or cut off") from error
    if names * max(width, 0) * max(height, 0) * 4 > _MOST_BYTES:
        raise ExrDamagedError(f"holds {names} channels of {width} x {height} pixels: save the depth alone")
    return width, height


def read_exr(data: bytes, subject: str) -> NDArray[Any]:
    """Return the depth channel (H, W) float32 of an EXR file whose size has been checked.

    The channel is Z, depth, Y, V or R, or the only one.

    Raises
    ------
    InputError
        Where the extra is not installed, on a damaged file, or without such a channel.
    """
    if importlib.util.find_spec("OpenEXR") is None:
        remedy = "install quasiface-studio[exr], or save the depth as float TIFF"
        raise InputError(subject, "is an EXR image, which needs the package OpenEXR", remedy)
    damaged = InputError(subject, "is a damaged EXR image, or cut off", "copy or export it again")
    try:
        done = subprocess.run([sys.executable, "-c", _DECODER], input=data, capture_output=True, timeout=_LONGEST_S)
        if done.returncode != 0 or done.stderr:
            raise damaged
        channels: dict[str, NDArray[Any]] = dict(np.load(io.BytesIO(done.stdout), allow_pickle=False))
    except (OSError, ValueError, subprocess.SubprocessError, zipfile.BadZipFile) as error:
        raise damaged from error
    found = [name for name in _DEPTH_CHANNELS if name in channels] or (list(channels) if len(channels) == 1 else [])
    if not found:
        names = ", ".join(sorted(channels))[:60]
        raise InputError(subject, f"has no channel of depth among {names}", "name it Z, or save one channel only")
    pixels = channels[found[0]]
    if pixels.ndim != 2 or pixels.dtype.kind != "f":
        raise InputError(subject, f"stores {pixels.dtype} in {found[0][:20]}", "give floats")
    return pixels.astype(np.float32)


def _attributes(data: bytes) -> dict[bytes, bytes]:
    result: dict[bytes, bytes] = {}
    place = 8
    for _ in range(_MOST_ATTRIBUTES):
        name, place = _word(data, place)
        if not name:
            return result
        _, place = _word(data, place)
        (length,) = struct.unpack_from("<I", data, place)
        if length > len(data) - place - 4:
            raise IndexError
        result[name] = data[place + 4 : place + 4 + length]
        place += 4 + length
    raise IndexError


def _word(data: bytes, place: int) -> tuple[bytes, int]:
    end = data.index(b"\0", place, place + _LONGEST_NAME) if b"\0" in data[place : place + _LONGEST_NAME] else -1
    if end < 0:
        raise IndexError
    return data[place:end], end + 1
