"""The header of a PCD file: fields, size, viewpoint and how the points are stored."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from engine.errors import InputError

_MAX_LINE = 4096
_MAX_LINES = 200
_MOST_FIELDS = 100
_MOST_BYTES = 1 << 16
_TYPES = {"F": "f", "U": "u", "I": "i"}
_KEYS = ("VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA")
PADDING = "_"


@dataclass(frozen=True)
class PcdField:
    """One field: its name (``_`` for padding), NumPy type and how many values of it every point has."""

    name: str
    type: str
    count: int

    @property
    def size(self) -> int:
        """Bytes of the field in every point."""
        return np.dtype(self.type).itemsize * self.count


@dataclass(frozen=True)
class PcdHeader:
    """Fields in order, pixels, sensor pose (tx ty tz qw qx qy qz) and ``ascii``, ``binary``, ``binary_compressed``."""

    fields: tuple[PcdField, ...]
    width: int
    height: int
    viewpoint: tuple[float, ...]
    data: str

    @property
    def points(self) -> int:
        """How many points the file announces."""
        return self.width * self.height


def read_pcd_header(handle: BinaryIO, subject: str) -> PcdHeader:
    """Read the header; ``handle`` stands at the first byte of the data afterwards.

    Raises
    ------
    InputError
        When a line cannot be understood, is missing, stands there twice or contradicts another.
    """
    lines: dict[str, list[str]] = {}
    for _ in range(_MAX_LINES):
        raw = handle.readline(_MAX_LINE)
        if not raw.endswith(b"\n"):
            raise InputError(subject, "its header is cut off or too long", "export it again")
        words = raw.decode("latin-1").split("#")[0].split()
        if not words:
            continue
        key = "FIELDS" if words[0] == "COLUMNS" else words[0]
        if key not in _KEYS:
            problem = f"its header cannot be understood at {' '.join(words)[:60]!r}"
            raise InputError(subject, problem, "export it as PCD 0.6 or 0.7")
        if key in lines:
            raise InputError(f"{subject}, {key}", "stands there twice", "export it again")
        lines[key] = words[1:]
        if key == "DATA":
            return _checked(lines, subject)
    raise InputError(subject, "its header has no end (DATA)", "export it again")


def _checked(lines: dict[str, list[str]], subject: str) -> PcdHeader:
    for key in ("FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT"):
        if key not in lines:
            raise InputError(f"{subject}, {key}", "is missing", "export it as PCD 0.6 or 0.7")
    version = (lines.get("VERSION") or [".7"])[0].lstrip("0")
    if version not in (".7", ".6", ".5"):
        raise InputError(f"{subject}, VERSION", f"{version[:20]!r} is not known", "export it as PCD 0.7")
    names = lines["FIELDS"]
    counts = lines.get("COUNT", ["1"] * len(names))
    for key, words in (("SIZE", lines["SIZE"]), ("TYPE", lines["TYPE"]), ("COUNT", counts)):
        if len(words) != len(names):
            raise InputError(f"{subject}, {key}", f"has {len(words)} of {len(names)} entries", "export it again")
    if not 0 < len(names) <= _MOST_FIELDS:
        raise InputError(f"{subject}, FIELDS", f"names {len(names)} fields", "export x y z and rgb only")
    fields: list[PcdField] = []
    for name, size, kind, count in zip(names, lines["SIZE"], lines["TYPE"], counts, strict=True):
        if size not in ("1", "2", "4", "8") or kind not in _TYPES or (kind == "F" and size not in ("4", "8")):
            raise InputError(f"{subject}, TYPE and SIZE", f"{kind[:9]}{size[:9]} is not known", "export it again")
        if name != PADDING and name in [field.name for field in fields]:
            raise InputError(f"{subject}, FIELDS", f"names {name[:40]!r} twice", "export it again")
        number = _number(count, f"{subject}, COUNT")
        if not 0 < number <= _MOST_BYTES:
            raise InputError(f"{subject}, COUNT", f"is {number}", f"it must be 1 to {_MOST_BYTES}")
        fields.append(PcdField(name, _TYPES[kind] + size, number))
    if sum(field.size for field in fields) > _MOST_BYTES:
        raise InputError(f"{subject}, SIZE", "a point has too many bytes", "export x y z and rgb only")
    width, height = (_number("".join(lines[key]), f"{subject}, {key}") for key in ("WIDTH", "HEIGHT"))
    points = _number("".join(lines.get("POINTS", [str(width * height)])), f"{subject}, POINTS")
    if points != width * height:
        problem = f"is {points}, not {width} x {height} = {width * height}"
        raise InputError(f"{subject}, POINTS", problem, "export it again")
    data = " ".join(lines["DATA"])
    if data not in ("ascii", "binary", "binary_compressed"):
        remedy = "it must be ascii, binary or binary_compressed"
        raise InputError(f"{subject}, DATA", f"{data[:40]!r} is not known", remedy)
    return PcdHeader(tuple(fields), width, height, _viewpoint(lines.get("VIEWPOINT"), subject), data)


def _number(text: str, subject: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 16):
        raise InputError(subject, f"{text[:40]!r} is not a count", "export it again")
    return int(text)


def _viewpoint(words: list[str] | None, subject: str) -> tuple[float, ...]:
    if words is None:
        return (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    try:
        values = tuple(float(word) for word in words)
    except ValueError:
        values = ()
    if len(values) != 7 or not all(map(math.isfinite, values)) or not 1e-3 < math.hypot(*values[3:]) < 1e3:
        remedy = "it must be tx ty tz qw qx qy qz"
        raise InputError(f"{subject}, VIEWPOINT", f"is {' '.join(words)[:60]!r}", remedy)
    return values
