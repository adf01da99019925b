"""The head of a C3D file: its first block and its parameters, believed as far as the bytes bear them out."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError

BLOCK = 512
_MAGIC = 0x50
_PROCESSORS = {84: "intel", 85: "dec", 86: "mips"}
_ITEM_BYTES = {-1: 1, 1: 1, 2: 2, 4: 4}
_MAX_PARAMETERS = 20_000

Value = NDArray[Any] | tuple[str, ...]


@dataclass(frozen=True)
class C3DHeader:
    """What the head of a C3D file says.

    Parameters
    ----------
    points, analog : int
        Markers, and analog samples, of every frame.
    frames : int
        Frames that the file announces and has room for.
    rate : float
        Frames a second, 0 or NaN where the file says so.
    scale : float
        Millimetres (or the file's unit) of one count; negative where positions are stored as floats.
    data : int
        Byte at which the frames begin.
    processor : {"intel", "dec", "mips"}
        Order of bytes and form of floats.
    parameters : mapping of (group, name) to array or texts
        Upper case keys; numbers in the file's order (first index fastest).
    """

    points: int
    analog: int
    frames: int
    rate: float
    scale: float
    data: int
    processor: str
    parameters: Mapping[tuple[str, str], Value]

    @property
    def frame_bytes(self) -> int:
        """Bytes of one frame."""
        return (4 * self.points + self.analog) * (4 if self.scale < 0 else 2)

    def text(self, group: str, name: str) -> str:
        """Return a parameter of one text, stripped; empty where there is none."""
        value = self.parameters.get((group, name), ())
        return value[0].strip() if isinstance(value, tuple) and value else ""

    def number(self, group: str, name: str, default: float) -> float:
        """Return a parameter of one number; ``default`` where there is none."""
        return _number(self.parameters, group, name, default)

    def texts(self, group: str, name: str) -> tuple[str, ...]:
        """Return a list of texts and its continuations (``LABELS``, ``LABELS2``, ...), stripped."""
        found: list[str] = []
        for k in range(1, 200):
            value = self.parameters.get((group, name if k == 1 else f"{name}{k}"))
            if not isinstance(value, tuple):
                break
            found += [item.strip() for item in value]
        return tuple(found)


def read_header(data: bytes, subject: str) -> C3DHeader:
    """Return the head of a C3D file from all of its bytes.

    Raises
    ------
    InputError
        When it is no C3D file, or announces what the file does not hold.
    """
    if len(data) < 2 * BLOCK or data[1] != _MAGIC or data[0] < 1:
        raise InputError(subject, "does not begin like a C3D file", "export it again")
    start = (data[0] - 1) * BLOCK
    if start + 4 > len(data) or start < BLOCK:
        raise InputError(subject, f"its parameters should begin at byte {start}", "export it again")
    processor = _PROCESSORS.get(data[start + 3])
    if processor is None:
        raise InputError(subject, f"names processor {data[start + 3]}, which no format has", "export it again")
    order = ">" if processor == "mips" else "<"
    parameters = _parameters(data, start + 4, processor, subject)
    points, analog, first, last = struct.unpack_from(f"{order}4H", data, 2)
    scale, rate = floats(data[12:16], processor)[0], floats(data[20:24], processor)[0]
    (block,) = struct.unpack_from(f"{order}H", data, 16)
    points = _count(_number(parameters, "POINT", "USED", points))
    block = _count(_number(parameters, "POINT", "DATA_START", block)) or block
    place = (block - 1) * BLOCK
    if points < 1:
        raise InputError(subject, "has no markers", "export the marker positions")
    scale = _number(parameters, "POINT", "SCALE", float(scale))
    if not math.isfinite(scale) or scale == 0:
        raise InputError(f"{subject}, POINT:SCALE", f"is {scale:g}", "export it again")
    if place < start + 4 or place >= len(data):
        raise InputError(subject, f"its frames should begin at byte {place} of {len(data)}", "export it again")
    named = _number(parameters, "POINT", "RATE", math.nan)
    rate = float(rate) if math.isnan(named) else named
    bare = C3DHeader(points, analog, 0, rate, scale, place, processor, parameters)
    room = (len(data) - place) // bare.frame_bytes
    frames = _frames(parameters, first, last, room)
    if frames > room:
        problem = f"is cut off: {frames} frames are announced, there is room for {room}"
        raise InputError(subject, problem, "copy or export it again")
    if frames < 1:
        raise InputError(subject, "has no frames", "export it again")
    return C3DHeader(points, analog, frames, rate, scale, place, processor, parameters)


def floats(data: bytes, processor: str) -> NDArray[np.float32]:
    """Return the floats of bytes as ``processor`` writes them."""
    if processor == "dec":
        words = np.frombuffer(data, "<u2").reshape(-1, 2).astype(np.uint32)
        with np.errstate(all="ignore"):
            return ((words[:, 0] << 16) | words[:, 1]).view(np.float32) / np.float32(4)
    return np.frombuffer(data, ">f4" if processor == "mips" else "<f4").astype(np.float32)


def _frames(parameters: Mapping[tuple[str, str], Value], first: int, last: int, room: int) -> int:
    """Return the number of frames: beyond 65,535 the header's fields are full, and parameters hold it."""
    claims = [last - first + 1 if last >= first else 0]
    if last == 65535 or claims[0] < 1:
        claims += [_count(_number(parameters, "POINT", key, 0)) for key in ("LONG_FRAMES", "FRAMES")]
        begin, end = (_field(parameters, key) for key in ("ACTUAL_START_FIELD", "ACTUAL_END_FIELD"))
        claims += [end - begin + 1] if begin and end else []
    fitting = [claim for claim in claims if claim <= room]
    return max(fitting) if fitting and max(fitting) > 0 else max(claims)


def _field(parameters: Mapping[tuple[str, str], Value], name: str) -> int:
    value = parameters.get(("TRIAL", name), ())
    if isinstance(value, tuple) or value.size != 2 or not np.isfinite(value).all():
        return 0
    low, high = (int(word) & 0xFFFF for word in value.ravel())
    return low + (high << 16)


def _number(parameters: Mapping[tuple[str, str], Value], group: str, name: str, default: float) -> float:
    value = parameters.get((group, name))
    if value is None or isinstance(value, tuple) or not value.size:
        return default
    return float(value.ravel()[0])


def _count(value: float) -> int:
    """Return a count that may have been stored as a signed word."""
    if not math.isfinite(value) or abs(value) > 1e9:
        return 0
    return int(value) & 0xFFFF if value < 0 else int(value)


def _parameters(data: bytes, place: int, processor: str, subject: str) -> dict[tuple[str, str], Value]:
    order = ">" if processor == "mips" else "<"
    groups: dict[int, str] = {}
    found: list[tuple[int, str, Value]] = []
    damaged = InputError(subject, "its parameters are damaged", "export it again")
    for _ in range(_MAX_PARAMETERS):
        if place + 2 > len(data):
            break
        length, group = struct.unpack_from("bb", data, place)
        length = abs(length)
        if length == 0 or group == 0:
            break
        after = place + 2 + length
        if after + 2 > len(data):
            raise damaged
        name = data[place + 2 : after].decode("latin-1").strip().upper()
        (step,) = struct.unpack_from(f"{order}h", data, after)
        if group < 0:
            groups[-group] = name
        else:
            found.append((group, name, _value(data, after + 2, processor, f"{subject}, {name}")))
        if step == 0:
            break
        if step < 2:
            raise damaged
        place = after + step
    return {(groups.get(group, ""), name): value for group, name, value in found}


def _value(data: bytes, place: int, processor: str, subject: str) -> Value:
    damaged = InputError(subject, "announces more than is there", "export it again")
    if place + 2 > len(data):
        raise damaged
    kind, dimensions = struct.unpack_from("bB", data, place)
    place += 2
    shape = tuple(data[place : place + dimensions])
    place += dimensions
    size = _ITEM_BYTES.get(kind)
    if size is None or dimensions > 7 or len(shape) < dimensions:
        raise InputError(subject, f"is of type {kind} in {dimensions} dimensions", "export it again")
    raw = data[place : place + size * math.prod(shape)]
    if len(raw) < size * math.prod(shape):
        raise damaged
    if kind == -1:
        width = shape[0] if shape else 1
        return tuple(raw[k : k + width].decode("latin-1").rstrip("\0") for k in range(0, len(raw), max(width, 1)))
    if kind == 4:
        return floats(raw, processor).astype(np.float64)
    order = ">" if processor == "mips" else "<"
    return np.frombuffer(raw, "u1" if kind == 1 else f"{order}i2").astype(np.float64)
