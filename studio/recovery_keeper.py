"""Keeps what a crash would lose: every step is written down within a second, and offered at the next start."""

from __future__ import annotations

import secrets
from pathlib import Path

import platformdirs
from PySide6.QtCore import QLockFile, QObject, QTimer

from engine.errors import InputError
from engine.progress import Progress
from studio.project import store
from studio.project.document import Project
from studio.project.recovery import RecoveryFiles, contents, copy_of, recover, write_journal
from studio.session import Session
from studio.settings import APPLICATION

DELAY_MS = 400
"""How long after a step it is written down; steps that follow faster are written together."""


def recovery_folder() -> Path:
    """Return the folder that unsaved work is kept in, of this user on this machine."""
    return platformdirs.user_state_path(APPLICATION, appauthor=False) / "recovery"


class RecoveryKeeper(QObject):
    """Writes down the unsaved state of a session, and forgets it once it is saved or given up.

    A lock file tells sessions that are alive from those that ended without saying so.
    """

    def __init__(self, session: Session, folder: Path | None = None) -> None:
        super().__init__(session)
        self._session = session
        self._folder = folder or recovery_folder()
        self._name = secrets.token_hex(6)
        self._files = RecoveryFiles.of(self._folder, self._name)
        self._lock: QLockFile | None = None
        self._kept: tuple[tuple[str, str], ...] | None = None
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
        """Open what a session left as unsaved work, and delete its files.

        Raises
        ------
        InputError
            When they are damaged; they stay where they are.
        """
        project, path = recover(files)
        if path is not None:
            project.set_path(path)
        self._session.take_over(project)
        files.remove()

    def close(self) -> None:
        """Forget what was written down: the session ends as its user wants."""
        self._closed = True
        self._timer.stop()
        self._files.remove()
        if self._lock is not None:
            self._lock.unlock()
            self._lock = None

    def _later(self, *_values: object) -> None:
        if not self._closed:
            self._timer.start()

    def _forget_snapshot(self) -> None:
        self._kept = None
        self._later()

    def _write(self) -> None:
        project = self._session.project
        if not self._session.is_dirty:
            self._files.remove()
            self._kept = None
            return
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._lock is None:
                self._lock = _lock(self._folder, self._name)
                self._lock.tryLock(0)
            if contents(project) == self._kept:
                write_journal(project, self._files.journal)
            else:
                self._write_snapshot(project)
        except (InputError, OSError) as error:
            self._session.message.emit("error", f"Unsaved work cannot be kept for recovery: {error}")

    def _write_snapshot(self, project: Project) -> None:
        copy, what = copy_of(project), contents(project)

        def work(_progress: Progress) -> None:
            store.save(copy, self._files.snapshot)

        def done(_result: object) -> None:
            if project is self._session.project and not self._closed:
                self._kept = what
                self._later()

        self._session.tasks.submit(
            "Keeping unsaved work", work, done, failed=lambda _error: None, key="recovery", quiet=True
        )


def _lock(folder: Path, name: str) -> QLockFile:
    lock = QLockFile(str(folder / f"{name}.lock"))
    lock.setStaleLockTime(0)
    return lock
