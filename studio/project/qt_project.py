"""The open project as Qt sees it: its plain callbacks become a signal."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from studio.project.document import Change, Project


class QtProject(QObject):
    """Forward the changes of one project as ``changed`` until ``release``.

    A project knows nothing of Qt; the undo stack that its commands are pushed to lives beside it
    (``studio.session.Session``), and so does the question whether anything is to be saved.
    """

    changed = Signal(object)
    """The ``document.Change`` that has just happened."""

    def __init__(self, project: Project, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.project = project
        self._unsubscribe = project.subscribe(self._forward)

    def release(self) -> None:
        """Listen no longer; may be called twice."""
        self._unsubscribe()

    def _forward(self, change: Change) -> None:
        self.changed.emit(change)
