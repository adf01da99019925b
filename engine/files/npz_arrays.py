"""NumPy archives of strangers: arrays whose type, shape and length are checked before they are unpacked."""

from __future__ import annotations

import io
import math
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.source import MAX_BYTES, checked_file

MAX_VALUES = 64_000_000
"""Most numbers of one array: 300 shapes of 70,000 vertices."""

_MAX_HEADER = 10_000
_MAX_MEMBERS = 1000
_DAMAGE = (
    zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError, KeyError, IndexError, TypeError,
    NotImplementedError, RuntimeError, OverflowError, SyntaxError, MemoryError,
)  # fmt: skip


class NpzArchive:
    """The arrays of an archive by name; ``array`` returns one of them."""

    def __init__(self, path: Path, archive: zipfile.ZipFile) -> None:
        self.path = path
        self._archive = archive
        self._members = _members(path, archive)

    def __contains__(self, name: str) -> bool:
        return name in self._members

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the arrays, as they are stored."""
        return tuple(self._members)

    def array(
        self,
        name: str,
        shape: tuple[int | None, ...],
        kinds: str,
        largest_item: int = 8,
        check: Callable[[str, tuple[int, ...]], None] | None = None,
        most: int = MAX_VALUES,
    ) -> NDArray[Any]:
        """Return one array.

        Parameters
        ----------
        name : str
            Which.
        shape : tuple of int or None
            What it must have; None is any extent of 1 and more.
        kinds : str
            The kinds of NumPy type that will do: ``"fiu"``, ``"u"``, ``"U"``.
        largest_item : int
            Most bytes of one element.
        check : callable, optional
            Called with the subject and the shape before anything is unpacked; raises InputError where it is too large.
        most : int
            Most numbers of the array.

        Raises
        ------
        InputError
            When it is missing, packed in an unknown way, pickled, of another kind or shape, or not as long as it says.
        """
        if name not in self:
            raise InputError(f"{self.path}, {name}", "is missing", "save the array under this name")
        return _array(self.path, self._archive, self._members[name], name, shape, kinds, largest_item, check, most)

    def unpacked_bytes(self, name: str) -> int:
        """Return the bytes that an array there takes unpacked, as the archive says; ``array`` holds it to that."""
        return self._members[name].file_size

    def mapped(self, name: str, shape: tuple[int | None, ...], kinds: str) -> NDArray[Any] | None:
        """Return one array as a memory map; None where it is compressed.

        Raises
        ------
        InputError
            As ``array`` does.
        """
        if name not in self:
            raise InputError(f"{self.path}, {name}", "is missing", "save the array under this name")
        info, subject = self._members[name], f"{self.path}, {name}"
        if info.compress_type != zipfile.ZIP_STORED or info.flag_bits & 1:
            return None
        with self._archive.open(info) as member:
            start, found, fortran, dtype = _header(subject, member)
        _check(subject, found, dtype, shape, kinds, 8)
        length = math.prod(found) * dtype.itemsize
        place = _stored_at(self.path, info)
        if min(found) < 1 or info.file_size != start + length or place + info.file_size > self.path.stat().st_size:
            raise InputError(subject, f"announces {length} bytes, not what is stored", "save it again")
        return np.memmap(self.path, dtype, "r", place + start, found, "F" if fortran else "C")


@contextmanager
def open_npz(path: str | Path, largest: int = MAX_BYTES) -> Iterator[NpzArchive]:
    """Open a ``.npz`` file of at most ``largest`` bytes; what its damage raises in the block becomes an InputError.

    Raises
    ------
    InputError
        When it is no archive, is damaged, or holds too many arrays or one twice.
    """
    path = checked_file(path, largest)
    with path.open("rb") as handle:
        if handle.read(2) != b"PK":
            raise InputError(str(path), "is not a NumPy archive", "save it with numpy.savez")
    try:
        with zipfile.ZipFile(path) as archive:
            yield NpzArchive(path, archive)
    except _DAMAGE as error:
        if isinstance(error, InputError):
            raise
        raise InputError(str(path), "is damaged or cut off", "copy or save it again") from error


def _members(path: Path, archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    infos = archive.infolist()
    if len(infos) > _MAX_MEMBERS:
        raise InputError(str(path), f"holds {len(infos)} arrays", "save only the scan's")
    members: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        name = info.filename.removesuffix(".npy")
        if name in members:
            raise InputError(f"{path}, {name[:40]!r}", "is stored twice", "save it again")
        members[name] = info
    return members


def _array(
    path: Path,
    archive: zipfile.ZipFile,
    info: zipfile.ZipInfo,
    name: str,
    shape: tuple[int | None, ...],
    kinds: str,
    largest_item: int,
    check: Callable[[str, tuple[int, ...]], None] | None,
    most: int,
) -> NDArray[Any]:
    """Return one array whose shape, type and length are checked before its data are unpacked."""
    subject = f"{path}, {name}"
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or info.flag_bits & 1:
        raise InputError(subject, "is packed in a way that NumPy does not use", "save it with numpy.savez")
    with archive.open(info) as member:
        start, found, fortran, dtype = _header(subject, member)
        _check(subject, found, dtype, shape, kinds, largest_item)
        if check is not None:
            check(subject, found)
        if math.prod(found) > most or min(found, default=1) < 1:
            raise InputError(subject, f"has shape {found}", f"give 1 to {most // 1_000_000} million numbers")
        length = math.prod(found) * dtype.itemsize
        if info.file_size != start + length:
            raise InputError(subject, f"announces {length} bytes, not what is stored", "save it again")
        data = member.read(length + 1)
    if len(data) != length:
        raise InputError(subject, f"holds {len(data)} of the {length} bytes it announces", "save it again")
    values = np.frombuffer(data, dtype)
    return values.reshape(found, order="F" if fortran else "C")


def _check(
    subject: str,
    found: tuple[int, ...],
    dtype: np.dtype[Any],
    shape: tuple[int | None, ...],
    kinds: str,
    largest_item: int,
) -> None:
    if dtype.hasobject:
        raise InputError(subject, "holds pickled objects, which are never loaded", "save plain numbers")
    if dtype.kind not in kinds or dtype.itemsize > largest_item:
        raise InputError(subject, f"stores {dtype}", _expected(kinds))
    if len(found) != len(shape) or any(want not in (None, have) for want, have in zip(shape, found, strict=True)):
        wanted = " x ".join("?" if want is None else str(want) for want in shape) or "a single value"
        raise InputError(subject, f"has shape {found}", f"it must be {wanted}")


def _stored_at(path: Path, info: zipfile.ZipInfo) -> int:
    """Return the byte at which an uncompressed member begins: its local head has lengths of its own."""
    with path.open("rb") as handle:
        handle.seek(info.header_offset)
        local = handle.read(30)
    if len(local) < 30 or local[:4] != b"PK\x03\x04" or info.compress_size != info.file_size:
        raise InputError(str(path), "is damaged or cut off", "copy or save it again")
    name, extra = struct.unpack_from("<HH", local, 26)
    return info.header_offset + 30 + int(name) + int(extra)


def _header(subject: str, member: Any) -> tuple[int, tuple[int, ...], bool, np.dtype[Any]]:
    """Return (header length, shape, Fortran order, type) of an ``.npy`` stream."""
    first = member.read(8)
    if first[:6] != b"\x93NUMPY" or first[6:] not in (b"\1\0", b"\2\0"):
        raise InputError(subject, "is not a NumPy array", "save it with numpy.savez")
    code = "<H" if first[6] == 1 else "<I"
    read = np.lib.format.read_array_header_1_0 if first[6] == 1 else np.lib.format.read_array_header_2_0
    size = member.read(struct.calcsize(code))
    (length,) = struct.unpack(code, size)
    if length > _MAX_HEADER:
        raise InputError(subject, f"announces a header of {length} bytes", "save it again")
    text = member.read(length)
    shape, fortran, dtype = read(io.BytesIO(size + text), max_header_size=_MAX_HEADER)
    return 8 + len(size) + length, tuple(int(extent) for extent in shape), bool(fortran), dtype


def _expected(kinds: str) -> str:
    return {"u": "give bytes (uint8)", "U": "give a string", "US": "give strings", "iu": "give whole numbers"}.get(
        kinds, "give numbers"
    )
