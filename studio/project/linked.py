"""Files that are too large to be copied into a project: where they lie, and how they are known again. No Qt."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from engine.errors import InputError
from engine.files.source import checked_file, kind_of

LARGEST_EMBEDDED = 64 << 20
"""Motion of more bytes than this is linked instead of copied into the project."""
LARGEST_LINKED = 1 << 40

SAMPLES, BLOCK = 64, 64 * 1024
"""So many blocks of so many bytes are looked at, spread evenly over the file."""

LinkState = Literal["there", "missing", "changed"]


@dataclass(frozen=True)
class LinkedFile:
    """A file beside the project.

    Attributes
    ----------
    path : Path
        Where it lies.
    size, time_ns : int
        Bytes, and time of the last change, ns since 1970.
    digest : str
        SHA-256 over the size and 64 blocks spread over the file: it tells takes apart without reading all of one.
    """

    path: Path
    size: int
    time_ns: int
    digest: str

    @classmethod
    def of(cls, path: Path) -> LinkedFile:
        """Return the link to a file.

        Raises
        ------
        InputError
            When it cannot be read.
        """
        path = checked_file(Path(path), LARGEST_LINKED)
        try:
            found = path.stat()
            return cls(path.absolute(), found.st_size, found.st_mtime_ns, sampled_digest(path, found.st_size))
        except OSError as error:
            raise InputError(str(path), f"cannot be read ({error.strerror})", "check the disk") from error

    def state(self) -> LinkState:
        """Return whether the file is still there, and still the one that was linked; touching it changes nothing."""
        try:
            if kind_of(self.path) != "file":
                return "missing"
            found = self.path.stat()
            if (found.st_size, found.st_mtime_ns) == (self.size, self.time_ns):
                return "there"
            same = found.st_size == self.size and sampled_digest(self.path, self.size) == self.digest
        except (OSError, InputError):
            return "missing"
        return "there" if same else "changed"

    def at(self, path: Path) -> LinkedFile:
        """Return the link to the same content at another place."""
        return replace(self, path=path)


def sampled_digest(path: Path, size: int) -> str:
    """Return SHA-256, in hex, over the size and `SAMPLES` blocks from the first byte to the last.

    Raises
    ------
    OSError
        When it cannot be read.
    """
    digest = hashlib.sha256(str(size).encode())
    last = max(0, size - BLOCK)
    with path.open("rb") as handle:
        for start in sorted({last * k // (SAMPLES - 1) for k in range(SAMPLES)}):
            handle.seek(start)
            digest.update(handle.read(BLOCK))
    return digest.hexdigest()


def relative_to(path: Path, folder: Path) -> str:
    """Return a path as seen from ``folder``, with forward slashes; empty where there is no way (another drive)."""
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:
        return ""


def place_of(relative: str, absolute: str, folder: Path | None) -> Path:
    """Return where a linked file lies: where it is relative to the project, else where it was, else the former."""
    places = ([folder / relative] if relative and folder is not None else []) + [Path(absolute)]
    for place in places:
        try:
            if kind_of(place) == "file":
                return Path(os.path.normpath(place))
        except InputError:
            continue
    return Path(os.path.normpath(places[0]))
