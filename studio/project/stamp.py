"""What a file held when it was read or written, to tell later whether somebody else has changed it. No Qt."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

_BEGIN, _END = 1024 * 1024, 64 * 1024


@dataclass(frozen=True)
class Stamp:
    """Size in bytes, time of the last change in ns, and a digest.

    The digest covers the size, the first MB and the last 64 kB. A project's header stands in front and names all of its
    arrays by content, so that two projects of one digest are equal; a file that was only touched keeps it.
    """

    size: int
    time_ns: int
    digest: str

    @classmethod
    def of(cls, path: Path) -> Stamp | None:
        """Return the stamp of a file; None where it is not there or cannot be read."""
        try:
            found = path.stat()
            return cls(found.st_size, found.st_mtime_ns, _digest(path, found.st_size))
        except OSError:
            return None

    def fits(self, path: Path) -> bool:
        """Return whether a file still holds what it did; one that is not there does not."""
        try:
            found = path.stat()
            if (found.st_size, found.st_mtime_ns) == (self.size, self.time_ns):
                return True
            return found.st_size == self.size and _digest(path, found.st_size) == self.digest
        except OSError:
            return False


def _digest(path: Path, size: int) -> str:
    digest = hashlib.sha256(str(size).encode())
    with path.open("rb") as handle:
        digest.update(handle.read(_BEGIN))
        if size > _BEGIN:
            handle.seek(max(_BEGIN, size - _END))
            digest.update(handle.read(_END))
    return digest.hexdigest()
