"""One window per project: a small file beside it says which program on which machine has it open."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

from PySide6.QtCore import QLockFile

from engine.errors import InputError


class ProjectInUseError(InputError):
    """A project is open elsewhere.

    Attributes
    ----------
    path : Path
        The project.
    can_take : bool
        Whether the other one is on another machine, so that nobody here can tell whether it is still alive.
    """

    def __init__(self, path: Path, holder: str, can_take: bool) -> None:
        super().__init__(str(path), f"is open {holder}", "go on there, or open a copy")
        self.path = path
        self.can_take = can_take


class ProjectLock:
    """The lock of one project: ``.name.qface.lock`` with process, machine and time.

    That of a process of this machine which has ended is taken over. That of another machine is not, however old: on a
    network folder nobody can see from here whether it is alive. Where no lock can be written (a folder without the
    right to write) the project is opened without one; saving will fail there and say so.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        file = self.path.resolve()
        self.file = file.with_name(f".{file.name}.lock")
        self._lock = QLockFile(str(self.file))
        self._lock.setStaleLockTime(0)

    def take(self, *, by_force: bool = False) -> None:
        """Take the lock; ``by_force`` also takes that of another machine.

        Raises
        ------
        ProjectInUseError
            When somebody else has it.
        """
        if self._lock.tryLock(0) or self._lock.error() != QLockFile.LockError.LockFailedError:
            return
        holder, elsewhere = self._holder()
        if by_force and elsewhere:
            self.file.unlink(missing_ok=True)
            if self._lock.tryLock(0):
                return
        raise ProjectInUseError(self.path, holder, elsewhere)

    def release(self) -> None:
        """Let go of the lock; may be called twice, and does nothing where somebody else has it."""
        self._lock.unlock()

    def _holder(self) -> tuple[str, bool]:
        """Return who has the lock, in words, and whether that is another machine."""
        import platform

        found, host = self._info()
        since = ""
        with contextlib.suppress(OSError):
            since = time.strftime(" since %d %b, %H:%M", time.localtime(self.file.stat().st_mtime))
        if found and host and host != platform.node():
            return f"on {host}{since}", True
        return f"in another window{since}", False

    def _info(self) -> tuple[bool, str]:
        """Return what the lock file says: whether it could be read, and the name of the machine."""
        try:
            lines = self.file.read_text(errors="replace")[:2000].splitlines()
        except OSError:
            return False, ""
        return True, lines[2].strip() if len(lines) > 2 else ""
