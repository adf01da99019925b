"""Keeps what a crash would lose: every step is written down within a second, and offered at the next start."""

from __future__ import annotations

import contextlib
import os
import secrets
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import platformdirs
from PySide6.QtCore import QLockFile, QObject, QTimer, Signal

from engine.errors import InputError
from studio import log
from studio.project.kept_pieces import KeptPieces
from studio.project.recovery_files import RecoveryFiles
from studio.project_lock import ProjectLock
from studio.session import Session
from studio.settings import APPLICATION
from studio.tasks import describe

if TYPE_CHECKING:
    from engine.landmarks import LandmarkSet
    from engine.scan.range_image import RangeImage
    from studio.project.recovery import Journal

DELAY_MS = 200
"""How long after a step it is written down, with all that follow until then."""
RETRY_MS = 10_000
"""How long after a failure it is tried again, also without another step."""
_PATIENCE = 30.0


def recovery_folder() -> Path:
    """Return the folder that unsaved work is kept in, of this user on this machine."""
    return platformdirs.user_state_path(APPLICATION, appauthor=False) / "recovery"


class RecoveryKeeper(QObject):
    """Writes down the unsaved state of a session, and forgets it once it is saved or given up.

    The journal has a thread of its own, so that neither a fit nor a large scan keeps it waiting; pieces and picture
    have another. A lock file tells sessions that are alive from those that ended without saying so. The reading and
    writing of files is loaded when it is first needed: the models of the project's file need not stand before the
    first paint.

    Attributes
    ----------
    in_view : callable
        Returns the id of the scan that is looked at, for the picture; set by the stage.
    """

    _ended = Signal(object)
    """Something was written (None), or could not be (the error)."""

    def __init__(self, session: Session, folder: Path | None = None) -> None:
        super().__init__(session)
        self._session = session
        self._folder = folder or recovery_folder()
        self._name = secrets.token_hex(6)
        self._files = RecoveryFiles.of(self._folder, self._name)
        self.in_view: Callable[[], str | None] = lambda: None
        self._journals = ThreadPoolExecutor(1, thread_name_prefix="journal")
        self._pieces = ThreadPoolExecutor(1, thread_name_prefix="pieces")
        self._lock: QLockFile | None = None
        self._kept = KeptPieces()
        self._newest = 0
        self._written = 0
        self._pending = 0
        self._trouble = False
        self._stepped = time.time()
        self._steps_before = 0
        self._inherited: tuple[RecoveryFiles, QLockFile] | None = None
        self._told = ""
        self._closed = False
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(DELAY_MS)
        self._timer.timeout.connect(self._write)
        self._retry = QTimer(self)
        self._retry.setSingleShot(True)
        self._retry.setInterval(RETRY_MS)
        self._retry.timeout.connect(self._later)
        self._ended.connect(self._on_ended)
        session.stack.indexChanged.connect(self._on_step)
        session.stack.cleanChanged.connect(self._later)
        session.changed.connect(self._later)
        session.replaced.connect(self._on_replaced)
        session.saving.connect(self._on_saving)

    @property
    def busy(self) -> bool:
        """Whether something is still to be written."""
        return self._timer.isActive() or self._pending > 0

    @property
    def is_kept(self) -> bool:
        """Whether a crash now would lose no edit: nothing is unsaved, or the newest journal is on the disk."""
        return not self._session.is_dirty or (self._written == self._newest and not self._timer.isActive())

    def abandoned(self) -> tuple[RecoveryFiles, ...]:
        """Return what sessions left that are not alive any more, the newest first; empty remains are swept away."""
        found = []
        for folder in self._folder.iterdir() if self._folder.is_dir() else ():
            if not folder.is_dir() or folder.name == self._name:
                continue
            files, lock = RecoveryFiles(folder), _lock(self._folder, folder.name)
            if not lock.tryLock(0):
                continue
            _tidy(files)
            if files.complete:
                with contextlib.suppress(OSError):
                    found.append((files.journal.stat().st_mtime, files))
            else:
                files.remove()
            lock.unlock()
        return tuple(files for _, files in sorted(found, key=lambda pair: -pair[0]))

    def restore(self, files: RecoveryFiles) -> tuple[str, ...]:
        """Open what a session left as unsaved work; its files go once this session has written its own.

        Returns
        -------
        tuple of str
            What could not be found again.

        Raises
        ------
        InputError
            When nothing can be read, or another window has it; the files stay where they are.
        """
        from studio.project.recovery import read_journal, recover

        lock = _lock(self._folder, files.folder.name)
        if not lock.tryLock(0):
            raise InputError(str(files.journal), "is open in another window", "go on there")
        steps = 0
        try:
            with contextlib.suppress(InputError):
                steps = read_journal(files.journal).steps
            found = recover(files)
            if found.path is not None:
                found.project.set_path(found.path)
            self._session.take_over(found.project, found.stamp)
        except BaseException:
            lock.unlock()
            raise
        self._inherited, self._steps_before = (files, lock), steps
        return found.lost

    def discard(self, files: RecoveryFiles) -> None:
        """Delete what a session left, unless another window has it."""
        lock = _lock(self._folder, files.folder.name)
        if lock.tryLock(0):
            files.remove()
            lock.unlock()

    def secure(self, seconds: float = 2.0) -> bool:
        """Write the journal now and wait for it, at most ``seconds``: something went wrong, and more may follow.

        Returns
        -------
        bool
            `is_kept`.
        """
        if not self._closed:
            self._timer.stop()
            self._write()
            with contextlib.suppress(TimeoutError):
                self._journals.submit(int).result(seconds)
        return self.is_kept

    def close(self) -> None:
        """Forget what was written down: the session ends as its user wants."""
        self._closed = True
        self._timer.stop()
        self._retry.stop()
        self._newest += 1
        for pool in (self._journals, self._pieces):
            pool.shutdown(wait=True, cancel_futures=True)
        self._files.remove()
        self._drop_inherited()
        if self._lock is not None:
            self._lock.unlock()
            self._lock = None

    def _on_step(self, _index: int) -> None:
        self._stepped = time.time()
        self._later()

    def _later(self, *_values: object) -> None:
        if not self._closed and not self._timer.isActive():  # never put off: steps may follow each other without end
            self._timer.start()

    def _on_replaced(self) -> None:
        """Forget the project before: it was saved or given up."""
        self._newest += 1
        self._steps_before = 0
        self._drop_inherited()
        files, self._kept = self._files, KeptPieces()
        self._submit(self._journals, files.journal.unlink, True)
        self._submit(self._pieces, _sweep, files)
        path = self._session.project.path
        if path is not None:
            self._on_saving(path)
        self._later()

    def _on_saving(self, target: Path) -> None:
        """Note where a file is about to be written, before it is."""
        with contextlib.suppress(OSError, ValueError):
            self._take_folder()
            self._files.target.write_bytes(os.fsencode(target.resolve()))

    def _take_folder(self) -> None:
        self._files.folder.mkdir(parents=True, exist_ok=True)
        if self._lock is None:
            self._lock = _lock(self._folder, self._name)
            self._lock.tryLock(0)

    def _write(self) -> None:
        self._newest += 1
        if not self._session.is_dirty:
            # The pieces stay: the next step needs no more than a journal then.
            self._steps_before = 0
            self._drop_inherited()
            self._submit(self._journals, self._files.journal.unlink, True)
            return
        try:
            self._write_down()
        except Exception as error:  # whatever it is: the next try may go better, and nobody must rely on this one
            self._fail(error)

    def _write_down(self) -> None:
        from studio.project.recovery import journal_of, pieces_of

        self._take_folder()
        session, view, kept, number = self._session, self.in_view(), self._kept, self._newest
        self._trouble = False
        journal = journal_of(session.project, self._stepped, self._steps(), view, session.stamp_digest)
        self._submit(self._journals, self._put_journal, number, journal)
        pieces = dict(pieces_of(session.project, self._files))
        missing = kept.want(pieces)
        for path in filter(missing.__contains__, pieces):
            self._submit(self._pieces, kept.put, path, pieces[path])
        self._submit(self._pieces, self._drop_pieces, number, kept)
        self._submit(self._pieces, self._put_picture, number, *self._pictured(view))

    def _pictured(self, view: str | None) -> tuple[RangeImage | None, LandmarkSet | None]:
        project = self._session.project
        if not project.scans:
            return None, None
        item = project.scan(view) if view is not None and view in project else project.scans[0]
        return project.range_image(item.id), item.landmarks

    def _steps(self) -> int:
        stack = self._session.stack
        clean = max(stack.cleanIndex(), 0)  # -1: it cannot be come back to
        return max(1, self._steps_before + abs(stack.index() - clean))

    def _submit(self, pool: ThreadPoolExecutor, work: Callable[..., object], *values: object) -> None:
        def run() -> None:
            try:
                work(*values)
            except BaseException as error:
                self._ended.emit(error)
            else:
                self._ended.emit(None)

        self._pending += 1
        pool.submit(run)

    def _put_journal(self, number: int, journal: Journal) -> None:
        from studio.project.recovery import write_journal

        if number == self._newest:  # else a newer one is on its way
            write_journal(journal, self._files.journal)
            self._written = number

    def _drop_pieces(self, number: int, kept: KeptPieces) -> None:
        """Drop what the journal of this number does without, once it is on the disk."""
        if self._written < number and not self._closed:
            self._journals.submit(int).result(_PATIENCE)
        if self._written >= number:
            kept.drop()

    def _put_picture(self, number: int, image: RangeImage | None, landmarks: LandmarkSet | None) -> None:
        if number != self._newest or image is None or landmarks is None:
            return
        from engine.files.atomic import atomic_write
        from studio.project.thumbnail import draw

        with atomic_write(self._files.picture) as handle:
            handle.write(draw(image, landmarks))

    def _drop_inherited(self) -> None:
        if self._inherited is not None:
            files, lock = self._inherited
            self._inherited = None
            files.remove()
            lock.unlock()

    def _on_ended(self, error: BaseException | None) -> None:
        self._pending -= 1
        if self._closed:
            return
        if error is not None:
            self._fail(error)
        elif self._pending == 0 and not self._trouble and not self._timer.isActive():
            self._told = ""
            if self._files.complete:
                self._drop_inherited()

    def _fail(self, error: BaseException) -> None:
        self._trouble = True
        self._retry.start()
        text = f"Unsaved work cannot be kept for recovery: {describe(error).splitlines()[0]}"
        if text != self._told:  # once, not after every step
            self._told = text
            if not isinstance(error, (InputError, OSError)):
                log.studio_log.error("the journal failed", exc_info=error)
            self._session.message.emit("error", text)


def _sweep(files: RecoveryFiles) -> None:
    for path in (*files.pieces(), files.picture):
        path.unlink(missing_ok=True)


def _tidy(files: RecoveryFiles) -> None:
    """Delete what a saving left that was killed in the middle: half a file, and the lock of the project."""
    from studio.project.store import remove_remains

    try:
        target = Path(os.fsdecode(files.target.read_bytes()))
        lock = ProjectLock(target)
        lock.take()
    except (OSError, ValueError):  # no saving, or somebody else has the project
        return
    remove_remains(target)
    lock.release()


def _lock(folder: Path, name: str) -> QLockFile:
    lock = QLockFile(str(folder / f"{name}.lock"))
    lock.setStaleLockTime(0)
    return lock
