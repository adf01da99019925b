"""Where one session keeps what a crash would lose. No Qt, and none of the models of the project's file."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path

from studio.project.document import SUFFIX


@dataclass(frozen=True)
class RecoveryFiles:
    """Where one session keeps its snapshot and its journal."""

    snapshot: Path
    journal: Path

    @classmethod
    def of(cls, folder: Path, session: str) -> RecoveryFiles:
        """Return the files of the session of this name."""
        return cls(folder / f"{session}{SUFFIX}", folder / f"{session}.json")

    @property
    def complete(self) -> bool:
        """Whether there is something to recover."""
        return self.snapshot.is_file() and self.journal.is_file()

    def remove(self) -> None:
        """Delete both."""
        for path in (self.journal, self.snapshot):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
