"""Undoable edits of a project's own fiducial schemes; the scans that use one change along in the same step."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtGui import QUndoCommand

from engine.landmarks import LandmarkScheme
from studio.project import schemes as rules
from studio.project.document import Project


class _SchemeCommand(QUndoCommand):
    """Sets what `edit` says."""

    def __init__(self, project: Project, edit: rules.SchemeEdit, text: str) -> None:
        super().__init__(text)
        self.edit = edit
        self._project = project
        self._old, self._new = rules.present(project, edit.scans), edit

    def redo(self) -> None:
        """Set the new schemes, and what the scans have with them."""
        self._new.apply(self._project)

    def undo(self) -> None:
        """Set the old ones."""
        self._old.apply(self._project)


class PutScheme(_SchemeCommand):
    """Add a scheme to the project, or put it in the place of its scheme ``replaces``.

    ``renames`` tells the new names of fiducials by their old ones; their points go along on every scan. ``InputError``
    when the scheme cannot be used or its name is taken.
    """

    def __init__(
        self,
        project: Project,
        scheme: LandmarkScheme,
        replaces: str | None = None,
        renames: Mapping[str, str] | None = None,
        text: str = "",
    ) -> None:
        edit = rules.put(project, scheme, replaces, renames or {})
        super().__init__(project, edit, text or f"{'Add' if replaces is None else 'Change'} scheme {scheme.name}")


class RemoveScheme(_SchemeCommand):
    """Take a scheme that no scan uses out of the project; InputError when one does."""

    def __init__(self, project: Project, name: str, text: str = "") -> None:
        super().__init__(project, rules.remove(project, name), text or f"Remove scheme {name}")
