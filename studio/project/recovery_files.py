"""Where one session keeps what a crash would lose. No Qt, and none of the models of the project's file."""

from __future__ import annotations

import contextlib
import hashlib
from dataclasses import dataclass
from pathlib import Path

from studio.project.document import SUFFIX


@dataclass(frozen=True)
class RecoveryFiles:
    """The folder of one session: a journal, a picture, and a piece for every range image, rig, performance
    and result.

    A piece is a project file of its own, written once under the key of what it holds and never changed, so that adding
    a scan costs that scan alone. Without a journal there is nothing to recover.
    """

    folder: Path

    @classmethod
    def of(cls, folder: Path, session: str) -> RecoveryFiles:
        """Return the files of the session of this name."""
        return cls(folder / session)

    @property
    def journal(self) -> Path:
        """All that edits can change, as JSON."""
        return self.folder / "journal.json"

    @property
    def picture(self) -> Path:
        """A PNG of the scan in view."""
        return self.folder / "picture.png"

    @property
    def target(self) -> Path:
        """The path of the project that was saved last, for what a saving that was killed leaves beside it."""
        return self.folder / "target.txt"

    def image(self, key: str) -> Path:
        """Return the piece of a range image, by its content key."""
        return self.folder / f"image-{key[:40]}{SUFFIX}"

    def fit(self, key: str) -> Path:
        """Return the piece of a result, by its input key."""
        return self.folder / f"fit-{hashlib.sha256(key.encode()).hexdigest()[:40]}{SUFFIX}"

    def rig(self, key: str) -> Path:
        """Return the piece of a rig, by its content key."""
        return self.folder / f"rig-{key[:40]}{SUFFIX}"

    def motion(self, key: str) -> Path:
        """Return the piece of a performance, by its content key."""
        return self.folder / f"motion-{key[:40]}{SUFFIX}"

    def pieces(self, kind: str = "*") -> tuple[Path, ...]:
        """Return the pieces that are there; ``kind`` is ``"image"``, ``"fit"``, ``"rig"`` or ``"motion"``."""
        return tuple(sorted(self.folder.glob(f"{kind}-*{SUFFIX}")))

    @property
    def complete(self) -> bool:
        """Whether there is something to recover."""
        return self.journal.is_file()

    def remove(self) -> None:
        """Delete everything, the journal first: half a session is not offered."""
        with contextlib.suppress(OSError):
            self.journal.unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            for path in self.folder.iterdir():
                path.unlink(missing_ok=True)
            self.folder.rmdir()
