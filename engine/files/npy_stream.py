"""One array of a NumPy archive: its head checked against the bytes that are there before anything is unpacked."""

from __future__ import annotations

import io
import math
import struct
import zipfile
import zlib
from dataclasses import dataclass
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError

DAMAGE = (
    zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError, KeyError, IndexError, TypeError,
    NotImplementedError, RuntimeError, OverflowError, SyntaxError, MemoryError,
)  # fmt: skip
"""What the standard library raises on archives that lie."""

_MAX_HEADER = 10_000


@dataclass(frozen=True)
class ArrayHeader:
    """Shape and type of a stored array, and the byte at which its data begin."""

    start: int
    shape: tuple[int, ...]
    fortran: bool
    dtype: np.dtype[Any]

    @property
    def bytes(self) -> int:
        """Bytes of its data."""
        return math.prod(self.shape) * self.dtype.itemsize


def array_header(
    subject: str, member: IO[bytes], info: zipfile.ZipInfo, *, kinds: str, largest_item: int
) -> ArrayHeader:
    """Return the head of a member that stands at its first byte.

    Raises
    ------
    InputError
        On pickled objects, a type whose kind is not among ``kinds``, and a length other than the archive's.
    """
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or info.flag_bits & 1:
        raise InputError(subject, "is packed in a way that NumPy does not use", "save it with numpy.savez")
    first = member.read(8)
    if first[:6] != b"\x93NUMPY" or first[6:] not in (b"\1\0", b"\2\0"):
        raise InputError(subject, "is not a NumPy array", "save it with numpy.savez")
    code = "<H" if first[6] == 1 else "<I"
    read = np.lib.format.read_array_header_1_0 if first[6] == 1 else np.lib.format.read_array_header_2_0
    size = member.read(struct.calcsize(code))
    (length,) = struct.unpack(code, size)
    if length > _MAX_HEADER:
        raise InputError(subject, f"announces a header of {length} bytes", "save it again")
    shape, fortran, dtype = read(io.BytesIO(size + member.read(length)), max_header_size=_MAX_HEADER)
    found = ArrayHeader(8 + len(size) + length, tuple(int(extent) for extent in shape), bool(fortran), dtype)
    if dtype.hasobject:
        raise InputError(subject, "holds pickled objects, which are never loaded", "save plain numbers")
    if dtype.kind not in kinds or dtype.itemsize > largest_item:
        raise InputError(subject, f"stores {dtype}", "give a string" if kinds == "U" else "give numbers")
    if min(found.shape, default=0) < 0 or info.file_size != found.start + found.bytes:
        raise InputError(subject, f"announces {found.bytes} bytes, not what is stored", "save it again")
    return found


def unpacked(subject: str, member: IO[bytes], header: ArrayHeader) -> NDArray[Any]:
    """Return the array of a member that stands at its first byte.

    Raises
    ------
    InputError
        When it holds fewer bytes than it announces.
    """
    member.read(header.start)
    data = member.read(header.bytes + 1)
    if len(data) != header.bytes:
        problem = f"holds {len(data)} of the {header.bytes} bytes it announces"
        raise InputError(subject, problem, "save it again")
    return np.frombuffer(data, header.dtype).reshape(header.shape, order="F" if header.fortran else "C")
