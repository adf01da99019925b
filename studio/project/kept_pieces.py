"""Which pieces of a project are on the disk, and which of them may go. No Qt."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from pathlib import Path

SPARE_BYTES = 256 * 1024 * 1024
"""What removed items held is kept on the disk up to this size: undo brings it back without another writing."""


class KeptPieces:
    """The pieces of one project; the thread that edits says what it wants, another one writes and drops.

    Parameters
    ----------
    spare_bytes : int
        Range images, rigs and performances that no item has any more go from the oldest on, beyond this size. Results
        that no scan has go at once: they can be made again.
    """

    def __init__(self, spare_bytes: int = SPARE_BYTES) -> None:
        self._spare = spare_bytes
        self._gate = threading.Lock()
        self._present: dict[Path, int] = {}
        self._wanted: frozenset[Path] = frozenset()

    def want(self, paths: Iterable[Path]) -> frozenset[Path]:
        """Say which pieces the project needs now, and return those that have to be written."""
        with self._gate:
            self._wanted = frozenset(paths)
            return self._wanted - self._present.keys()

    def put(self, path: Path, write: Callable[[], object]) -> None:
        """Write a piece, unless it is there already."""
        if path in self._present:
            return
        write()
        size = path.stat().st_size
        with self._gate:
            self._present[path] = size

    def drop(self) -> None:
        """Delete what is not wanted any more; only when the journal that does without it is on the disk."""
        with self._gate:
            spare = 0
            for path in reversed(tuple(self._present)):
                if path in self._wanted:
                    continue
                if path.name.startswith(("image-", "rig-", "motion-")):
                    spare += self._present[path]
                    if spare <= self._spare:
                        continue
                path.unlink(missing_ok=True)
                del self._present[path]
