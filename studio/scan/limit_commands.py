"""The undoable edit of what fits are judged by."""

from __future__ import annotations

from PySide6.QtGui import QUndoCommand

from engine.scan.limits import Limits
from studio.project.document import Project


class SetLimits(QUndoCommand):
    """Judge the fits of a project by other limits."""

    def __init__(self, project: Project, limits: Limits, text: str = "") -> None:
        super().__init__(text or "Change limits")
        self._project = project
        self._old, self._new = project.limits, limits

    def redo(self) -> None:
        """Set the new limits."""
        self._project.set_limits(self._new)

    def undo(self) -> None:
        """Set the old limits."""
        self._project.set_limits(self._old)
