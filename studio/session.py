"""The open project with its undo stack and its tasks, and what is done with it as a whole: new, open, save."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoStack

from studio.project.document import Change, Project
from studio.project.qt_project import QtProject
from studio.project.stamp import Stamp
from studio.project_lock import ProjectInUseError, ProjectLock
from studio.settings import Settings
from studio.tasks import Task, TaskRunner

UNTITLED = "Untitled"


class Session(QObject):
    """What one window works on.

    Attributes
    ----------
    project : Project
        Changed by commands on ``stack`` alone; replaced as a whole by `new` and `open`.
    stack : QUndoStack
        Lives as long as the session; cleared with every other project.
    tasks : TaskRunner
        Runs the jobs.
    stamp : Stamp or None
        What the project's file held when this session last read or wrote it.
    """

    begun = Signal()
    """An empty project has just been started; `replaced` came before."""
    replaced = Signal()
    """Another project is open."""
    changed = Signal(object)
    """The project has changed (`Change`)."""
    title_changed = Signal()
    """Name or unsaved state are others."""
    message = Signal(str, str)
    """Something to tell the user: kind (``"info"`` or ``"error"``) and text."""
    noted = Signal(str)
    """Something to mention in passing."""
    saving = Signal(object)
    """The project is about to be written to this file (`Path`)."""
    saved = Signal()
    """The project has just been written to its file."""

    def __init__(self, settings: Settings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.settings = settings
        self.stack = QUndoStack(self)
        self.tasks = TaskRunner(self)
        self.project = Project()
        self.stamp: Stamp | None = None
        self._lock: ProjectLock | None = None
        self._has_results = False
        self._adapter = QtProject(self.project, self)
        self._adapter.changed.connect(self._on_changed)
        self.stack.cleanChanged.connect(self._on_clean)
        self.tasks.failed.connect(self._on_failed)

    @property
    def name(self) -> str:
        """The file name of the project, or what it is called before it has one."""
        return self.project.path.name if self.project.path is not None else UNTITLED

    @property
    def has_results(self) -> bool:
        """Whether there are results that the file has not: no edits, but saving keeps them."""
        return self._has_results

    @property
    def is_dirty(self) -> bool:
        """Whether there is something that saving would keep."""
        return not self.stack.isClean()

    @property
    def stamp_digest(self) -> str:
        """What the project's file held, for the recovery journal; empty without a file."""
        return "" if self.stamp is None else self.stamp.digest

    @property
    def changed_outside(self) -> bool:
        """Whether somebody else has written the project's file since this session read or wrote it."""
        path = self.project.path
        try:
            return path is not None and self.stamp is not None and path.is_file() and not self.stamp.fits(path)
        except OSError:  # a name that this machine does not take
            return False

    def new(self) -> None:
        """Start an empty project."""
        self._let_go()
        self._replace(Project())
        self.begun.emit()

    def open(self, path: Path, *, as_copy: bool = False, by_force: bool = False) -> None:
        """Open a project file; on an error the present project stays.

        Parameters
        ----------
        path : Path
            The file; an older one is not changed by this.
        as_copy : bool
            Without its name: the first saving asks for another one. This needs no lock.
        by_force : bool
            Also take a lock from another machine.

        Raises
        ------
        ProjectInUseError
            When another window has it open.
        InputError
            When it cannot be read.
        """
        from studio.project import store  # with the models of the file, which the first paint need not wait for

        if as_copy:
            from studio.project.recovery import copy_of

            project = copy_of(store.load(path))
            self._let_go()
            self._replace(project)
            return
        lock = self._locked(path, by_force)
        stamp = Stamp.of(path)
        try:
            project = store.load(path)
        except BaseException:
            self._give_back(lock)
            raise
        self._let_go(lock)
        self.stamp = stamp
        self._replace(project)
        self.settings.add_recent(path)
        self.title_changed.emit()

    def take_over(self, project: Project, stamp: str = "") -> None:
        """Go on with a project that is not stored as it is now: it counts as changed.

        ``stamp`` is what its file held when the work on it began (`Stamp.digest`). Where another window has that file
        open by now, the work goes on without a name, and a message says so.
        """
        path = project.path
        lock, told = None, ""
        if path is not None:
            try:
                lock = self._locked(path)
            except ProjectInUseError as error:
                from studio.project.recovery import copy_of

                project = copy_of(project)
                told = f"{error.subject} {error.problem}; the restored work has no file yet"
        self._let_go(lock)
        self._replace(project)
        if project.path is not None and stamp:
            found = Stamp.of(project.path)
            self.stamp = found if found is not None and found.digest == stamp else Stamp(-1, 0, stamp)
        self.stack.resetClean()
        self.title_changed.emit()
        if told:
            self.message.emit("info", told)

    def save(self, path: Path | None = None) -> None:
        """Save under ``path``, or where the project lies; the file of an older version is kept beside it.

        Raises
        ------
        OSError, InputError
            The project and its unsaved state are then as before, and so is the file.
        """
        target = path or self.project.path
        if target is None:
            raise ValueError("a project without a path is saved under a name")
        from studio.project import store
        from studio.project.backup import keep_older
        from studio.project.thumbnail import picture_of

        lock = self._locked(target)
        try:
            self.saving.emit(target)
            store.remove_remains(target)
            kept = keep_older(target)
            store.save(self.project, target, picture=picture_of(self.project))
        except BaseException:
            self._give_back(lock)
            raise
        if lock is not self._lock:
            self._let_go(lock)
        self.stamp = Stamp.of(target)
        self.project.set_path(target)
        self._has_results = False
        self.stack.setClean()
        self.settings.add_recent(target)
        self.title_changed.emit()
        self.saved.emit()
        if kept is not None:
            self.message.emit("info", f"{target.name} was of an older version; it is kept as {kept.name}")

    def _locked(self, path: Path, by_force: bool = False) -> ProjectLock:
        """Return the lock of a project, which is the present one when that is the project that is open."""
        lock = ProjectLock(path)
        if self._lock is not None and self._lock.file == lock.file:
            return self._lock
        lock.take(by_force=by_force)
        return lock

    def _give_back(self, lock: ProjectLock) -> None:
        if lock is not self._lock:
            lock.release()

    def _let_go(self, following: ProjectLock | None = None) -> None:
        """Release the lock of the present project, unless the following one is the same, and forget its file."""
        if self._lock is not None and self._lock is not following:
            self._lock.release()
        self._lock, self.stamp = following, None

    def close(self) -> None:
        """Stop the tasks and let go of the project."""
        self.tasks.shutdown()
        self._let_go()
        self._adapter.release()

    def _on_changed(self, change: Change) -> None:
        self._has_results |= change.kind == "fit"
        self.changed.emit(change)

    def _on_clean(self, _clean: bool) -> None:
        self.title_changed.emit()

    def _on_failed(self, task: Task) -> None:
        self.message.emit("error", f"{task.title}: {task.error}")

    def _replace(self, project: Project) -> None:
        self.tasks.cancel_all()
        self._adapter.release()
        self._adapter.deleteLater()
        self.stack.clear()
        self.project = project
        self.stack.setClean()  # clearing an empty stack leaves it as it was: restored work that is given up had no step
        self._has_results = False
        self._adapter = QtProject(project, self)
        self._adapter.changed.connect(self._on_changed)
        self.replaced.emit()
        self.title_changed.emit()
