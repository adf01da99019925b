"""Keeps what a crash would lose: every step is written down within a second, and offered at the next start."""

from __future__ import annotations

import contextlib
import secrets
import threading
from pathlib import Path

import platformdirs
from PySide6.QtCore import QLockFile, QObject, QTimer

from engine.errors import InputError
from engine.progress import Progress
from studio.project.document import Project
from studio.project.recovery_files import RecoveryFiles
from studio.session import Session
from studio.settings import APPLICATION
from studio.tasks import describe

DELAY_MS = 400
"""How long after a step it is written down, with all that follow until then."""


def recovery_folder() -> Path:
    """Return the folder that unsaved work is kept in, of this user on this machine."""
    return platformdirs.user_state_path(APPLICATION, appauthor=False) / "recovery"


class RecoveryKeeper(QObject):
    """Writes down the unsaved state of a session, and forgets it once it is saved or given up.

    A lock file tells sessions that are alive from those that ended without saying so. The reading and writing of files
    is loaded when it is first needed: the models of the project's file need not stand before the first paint.
    """

    def __init__(self, session: Session, folder: Path | None = None) -> None:
        super().__init__(session)
        self._session = session
        self._folder = folder or recovery_folder()
        self._name = secrets.token_hex(6)
        self._files = RecoveryFiles.of(self._folder, self._name)
        self._lock: QLockFile | None = None
        self._kept: tuple[tuple[str, str], ...] | None = None
        self._writing: object | None = None
        self._gate = threading.Lock()
        self._inherited: tuple[RecoveryFiles, QLockFile] | None = None
        self._told = ""
        self._closed = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(DELAY_MS)
        self._timer.timeout.connect(self._write)
        session.stack.indexChanged.connect(self._later)
        session.stack.cleanChanged.connect(self._later)
        session.replaced.connect(self._forget_snapshot)

    def abandoned(self) -> tuple[RecoveryFiles, ...]:
        """Return what sessions left that are not alive any more, the newest first."""
        found = []
        for journal in self._folder.glob("*.json") if self._folder.is_dir() else ():
            files = RecoveryFiles.of(self._folder, journal.stem)
            lock = _lock(self._folder, journal.stem)
            if journal.stem != self._name and files.complete and lock.tryLock(0):
                lock.unlock()
                found.append((journal.stat().st_mtime, files))
        return tuple(files for _, files in sorted(found, key=lambda pair: -pair[0]))

    def restore(self, files: RecoveryFiles) -> None:
        """Open what a session left as unsaved work; its files go once this session has written its own.

        Raises
        ------
        InputError
            When they are damaged, or another window has them; they stay where they are.
        """
        from studio.project.recovery import recover

        lock = _lock(self._folder, files.journal.stem)
        if not lock.tryLock(0):
            raise InputError(str(files.journal), "is open in another window", "go on there")
        try:
            project, path = recover(files)
        except InputError:
            lock.unlock()
            raise
        if path is not None:
            project.set_path(path)
        self._session.take_over(project)
        self._inherited = files, lock

    def close(self) -> None:
        """Forget what was written down: the session ends as its user wants, and no task of it runs any more."""
        self._closed = True
        self._timer.stop()
        self._forget()
        if self._lock is not None:
            self._lock.unlock()
            self._lock = None

    def _later(self, *_values: object) -> None:
        if not self._closed and not self._timer.isActive():  # never put off: steps may follow each other without end
            self._timer.start()

    def _forget_snapshot(self) -> None:
        self._kept = None
        with self._gate:
            self._writing = None
        self._later()

    def _forget(self) -> None:
        """Delete all that was written, and what is being written when it is there."""
        with self._gate:
            self._writing = None
            self._files.remove()
        self._kept = None
        self._drop_inherited()

    def _drop_inherited(self) -> None:
        if self._inherited is not None:
            files, lock = self._inherited
            self._inherited = None
            files.remove()
            lock.unlock()

    def _write(self) -> None:
        project = self._session.project
        if not self._session.is_dirty:
            self._forget()
            return
        from studio.project.recovery import contents, write_journal

        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._lock is None:
                self._lock = _lock(self._folder, self._name)
                self._lock.tryLock(0)
            write_journal(project, self._files.journal)
            if contents(project) == self._kept:
                self._told = ""
                self._drop_inherited()
            elif self._writing is None:
                self._write_snapshot(project)
        except (InputError, OSError) as error:
            self._tell(error)

    def _write_snapshot(self, project: Project) -> None:
        from studio.project import store
        from studio.project.recovery import contents, copy_of

        copy, what, token = copy_of(project), contents(project), object()
        fresh = self._folder / f"{self._name}.{secrets.token_hex(4)}.new"
        self._writing = token

        def work(_progress: Progress) -> None:
            try:
                store.save(copy, fresh)
                with self._gate:  # a snapshot that nobody waits for any more must not come after a newer one
                    if self._writing is token:
                        fresh.replace(self._files.snapshot)
            finally:
                with contextlib.suppress(OSError):
                    fresh.unlink(missing_ok=True)

        def done(_result: object) -> None:
            self._writing, self._kept = None, what
            self._later()

        def failed(error: BaseException) -> None:
            self._writing = None
            self._tell(error)

        self._session.tasks.submit("Keeping unsaved work", work, done, failed=failed, quiet=True)

    def _tell(self, error: BaseException) -> None:
        text = f"Unsaved work cannot be kept for recovery: {describe(error)}"
        if text != self._told:  # once, not after every step
            self._told = text
            self._session.message.emit("error", text)


def _lock(folder: Path, name: str) -> QLockFile:
    lock = QLockFile(str(folder / f"{name}.lock"))
    lock.setStaleLockTime(0)
    return lock
