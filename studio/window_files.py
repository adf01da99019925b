"""File menu of the window: new, open, recent, save; never without asking where something would be lost."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMenu

from studio import dialogs
from studio.actions import Actions
from studio.project.document import SUFFIX

if TYPE_CHECKING:
    from studio.main_window import MainWindow


class FileActions(QObject):
    """What the File menu does with the project as a whole."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._recent: QMenu | None = None

    def bind(self, actions: Actions) -> None:
        """Give the declared actions of this file their deeds."""
        actions.bind("file.new", self.new)
        actions.bind("file.open", self.open)
        actions.bind("file.save", self.save, lambda: "" if self._can_save() else "nothing has changed")
        actions.bind("file.save_as", self.save_as)

    def _can_save(self) -> bool:
        session = self._window.session
        return session.is_dirty or session.has_results or session.project.path is None

    def add_recent_menu(self, menu: QMenu) -> None:
        """Add the submenu of recent projects."""
        self._recent = QMenu("Open &recent", menu)
        self._recent.setToolTipsVisible(True)
        menu.addMenu(self._recent)
        menu.aboutToShow.connect(self._fill_recent)

    def new(self) -> None:
        """Start an empty project, after asking about unsaved changes."""
        if self.may_discard():
            self._window.session.new()

    def open(self) -> None:
        """Ask for a project and open it."""
        if not self.may_discard():
            return
        path = dialogs.open_file(self._window, self._window.settings, "Open project", dialogs.PROJECT_FILTER)
        if path is not None:
            self._window.open_project(path)

    def save(self) -> bool:
        """Save the project; under a new name when it has none. Returns whether it is saved."""
        if self._window.session.project.path is None:
            return self.save_as()
        return self._window.attempt(self._window.session.save)

    def save_as(self) -> bool:
        """Ask for a name and save the project there. Returns whether it is saved."""
        session = self._window.session
        name = session.name if session.name.endswith(SUFFIX) else f"face{SUFFIX}"
        path = dialogs.save_file(self._window, self._window.settings, "Save project", name, dialogs.PROJECT_FILTER)
        return path is not None and self._window.attempt(session.save, path)

    def may_discard(self) -> bool:
        """Ask what to do with unsaved changes; False when the user wants to stay."""
        session = self._window.session
        if not session.is_dirty:
            return True
        answer = dialogs.ask_unsaved(self._window, session.name)
        return answer == "discard" or (answer == "save" and self.save())

    def open_recent(self, path: Path) -> None:
        """Open a project of the list, after asking about unsaved changes."""
        if self.may_discard():
            self._window.open_project(path)

    def _fill_recent(self) -> None:
        if self._recent is None:
            return
        self._recent.clear()
        paths = self._window.settings.recent()
        self._recent.setEnabled(bool(paths))
        for path in paths:
            action = self._recent.addAction(path.name)
            action.setToolTip(str(path))
            action.triggered.connect(lambda _checked=False, path=path: self.open_recent(path))
