"""The header of a PLY file: its elements, their properties and the ``obj_info`` lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import BinaryIO

from engine.errors import InputError

MAX_HEADER_BYTES = 64 << 10

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_ENCODINGS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class PlyProperty:
    """One property: its NumPy type, and the type of its length where it is a list."""

    name: str
    type: str
    length_type: str | None = None


@dataclass(frozen=True)
class PlyElement:
    """One element: how many rows, and what stands in each."""

    name: str
    count: int
    properties: tuple[PlyProperty, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the properties, in order."""
        return tuple(item.name for item in self.properties)

    @property
    def has_list(self) -> bool:
        """Whether a row's length varies."""
        return any(item.length_type is not None for item in self.properties)


@dataclass(frozen=True)
class PlyHeader:
    """Byte order (empty for text), elements, ``obj_info``, the length of the header in bytes, and the comments."""

    order: str
    elements: tuple[PlyElement, ...]
    info: dict[str, str]
    length: int
    comments: tuple[str, ...] = ()


def read_ply_header(handle: BinaryIO, subject: str) -> PlyHeader:
    """Read the header; ``handle`` stands at the first byte of the data afterwards.

    Raises
    ------
    InputError
        When the file does not begin like a PLY file, or the header is cut off, too long or contradicts itself.
    """
    first = handle.readline(16)
    if first.rstrip() != b"ply" or not first.endswith(b"\n"):
        raise InputError(subject, "does not begin like a PLY file", "export it again")
    order: str | None = None
    elements: list[PlyElement] = []
    info: dict[str, str] = {}
    comments: list[str] = []
    while True:
        raw = handle.readline(4096)
        if not raw.endswith(b"\n") or handle.tell() > MAX_HEADER_BYTES:
            raise InputError(subject, "its header is cut off or too long", "export it again")
        words = raw.decode("latin-1").split()
        match words:
            case ["end_header"]:
                break
            case []:
                pass
            case ["comment", *rest]:
                comments.append(" ".join(rest))
            case ["obj_info", key, *rest]:
                info[key] = " ".join(rest)
            case ["obj_info"]:
                pass
            case ["format", encoding, "1.0"] if encoding in _ENCODINGS and order is None:
                order = _ENCODINGS[encoding]
            case ["element", name, count] if name.isprintable() and _is_count(count):
                if name in [element.name for element in elements]:
                    raise InputError(subject, f"declares the element {name[:40]!r} twice", "export it again")
                elements.append(PlyElement(name, int(count), ()))
            case ["property", *rest] if elements:
                elements[-1] = _with_property(elements[-1], rest, subject)
            case _:
                line = " ".join(words)[:60]
                raise InputError(subject, f"its header cannot be understood at {line!r}", "export it again")
    if order is None:
        raise InputError(subject, "its header names no format", "export it again")
    return PlyHeader(order, tuple(elements), info, handle.tell(), tuple(comments))


def _is_count(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 16


def _with_property(element: PlyElement, words: list[str], subject: str) -> PlyElement:
    match words:
        case ["list", length, kind, name] if length in _TYPES and kind in _TYPES and _TYPES[length][0] != "f":
            added = PlyProperty(name, _TYPES[kind], _TYPES[length])
        case [kind, name] if kind in _TYPES:
            added = PlyProperty(name, _TYPES[kind])
        case _:
            line = " ".join(words)[:60]
            raise InputError(subject, f"its header cannot be understood at 'property {line}'", "export it again")
    if added.name in element.names:
        raise InputError(subject, f"declares the property {added.name[:40]!r} twice", "export it again")
    return PlyElement(element.name, element.count, (*element.properties, added))
