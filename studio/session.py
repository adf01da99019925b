"""The open project with its undo stack and its tasks, and what is done with it as a whole: new, open, save."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoStack

from studio.project.document import Change, Project
from studio.project.qt_project import QtProject
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
    """

    replaced = Signal()
    """Another project is open."""
    changed = Signal(object)
    """The project has changed (`Change`)."""
    title_changed = Signal()
    """Name or unsaved state are others."""
    message = Signal(str, str)
    """Something to tell the user: kind (``"info"`` or ``"error"``) and text."""

    def __init__(self, settings: Settings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.settings = settings
        self.stack = QUndoStack(self)
        self.tasks = TaskRunner(self)
        self.project = Project()
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

    def new(self) -> None:
        """Start an empty project."""
        self._replace(Project())

    def open(self, path: Path) -> None:
        """Open a project file; on `InputError` the present one stays."""
        from studio.project import store  # with the models of the file, which the first paint need not wait for

        self._replace(store.load(path))
        self.settings.add_recent(path)
        self.title_changed.emit()

    def take_over(self, project: Project) -> None:
        """Go on with a project that is not stored as it is now: it counts as changed."""
        self._replace(project)
        self.stack.resetClean()
        self.title_changed.emit()

    def save(self, path: Path | None = None) -> None:
        """Save under ``path``, or where the project lies.

        Raises
        ------
        OSError, InputError
            The project and its unsaved state are then as before.
        """
        target = path or self.project.path
        if target is None:
            raise ValueError("a project without a path is saved under a name")
        from studio.project import store

        store.save(self.project, target)
        self.project.set_path(target)
        self._has_results = False
        self.stack.setClean()
        self.settings.add_recent(target)
        self.title_changed.emit()

    def close(self) -> None:
        """Stop the tasks and let go of the project."""
        self.tasks.shutdown()
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
        self._has_results = False
        self._adapter = QtProject(project, self)
        self._adapter.changed.connect(self._on_changed)
        self.replaced.emit()
        self.title_changed.emit()
