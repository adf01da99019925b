"""File menu of the window: new, open, recent, save; nothing is lost without being asked about."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMenu

from engine.errors import InputError
from engine.progress import Progress
from studio import dialogs
from studio import file_questions as questions
from studio.actions import Actions
from studio.project.document import SUFFIX, Project
from studio.project_lock import ProjectInUseError
from studio.restore import offer_lost
from studio.tasks import describe
from studio.waiting import waiting

if TYPE_CHECKING:
    from studio.main_window import MainWindow
    from studio.project.salvage import Salvaged


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
        actions.bind("file.restore", self.restore)

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
            self.open_path(path)

    def open_path(self, path: Path, *, as_copy: bool = False, by_force: bool = False) -> bool:
        """Open a project; one that is in use is asked about, and of a damaged one what can be read is offered."""
        try:
            with waiting():
                self._window.session.open(path, as_copy=as_copy, by_force=by_force)
        except ProjectInUseError as error:
            answer = questions.ask_in_use(self._window, path.name, error.problem, error.can_take)
            return answer != "cancel" and self.open_path(path, as_copy=answer == "copy", by_force=answer == "take")
        except (InputError, OSError) as error:
            self._window.message.tell("error", describe(error))
            self._look_for_rest(path, error)
            return False
        if as_copy:
            self._window.message.tell("info", f"This is a copy of {path.name}; saving it asks for another name")
        else:
            self._window.guard.offer_autosave()
        return True

    def reload(self) -> bool:
        """Read the project from its file again; what was done since is lost. Returns whether it was read."""
        path = self._window.session.project.path
        return path is not None and self.open_path(path)

    def save(self) -> bool:
        """Save the project; under a new name when it has none. Returns whether it is saved."""
        session = self._window.session
        if session.project.path is None:
            return self.save_as()
        if not session.changed_outside:
            return self._write(session.project.path)
        answer = questions.ask_changed_outside(self._window, session.name)
        if answer == "reload":
            self.reload()
            return False
        if answer == "copy":
            return self.save_as(copy=True)
        return answer == "overwrite" and self._write(session.project.path)

    def save_as(self, *, copy: bool = False) -> bool:
        """Ask for a name and save the project there. Returns whether it is saved."""
        session = self._window.session
        name = session.name if session.name.endswith(SUFFIX) else f"face{SUFFIX}"
        if copy:
            name = f"{name[: -len(SUFFIX)]} copy{SUFFIX}"
        path = dialogs.save_file(self._window, self._window.settings, "Save project", name, dialogs.PROJECT_FILTER)
        return path is not None and self._write(path)

    def _write(self, path: Path) -> bool:
        try:
            with waiting():
                self._window.session.save(path)
        except (InputError, OSError) as error:
            text = f"Not saved: {describe(error)}"
            self._window.message.tell("error", text, (("Save as...", self.save_as),))
            return False
        return True

    def _take_over(self, project: Project) -> None:
        if self.may_discard():
            self._window.session.take_over(project)

    def _look_for_rest(self, path: Path, error: Exception) -> None:
        """Look beside the window at what can be read of a file that cannot be opened, and offer it."""
        session, message = self._window.session, self._window.message

        def work(_progress: Progress) -> Salvaged:
            from studio.project.salvage import salvage

            return salvage(path)

        def done(found: Salvaged) -> None:
            text = f"{describe(error)}. {found.summary}"
            message.tell("error", text, (("Open what can be read", lambda: self._take_over(found.project)),))

        session.tasks.submit(
            "Looking at what can be read", work, done, failed=lambda _: None, key="salvage", quiet=True
        )

    def restore(self) -> None:
        """Show what sessions left that ended without saving."""
        if offer_lost(self._window) is None:
            self._window.message.tell("info", "There is no unsaved work to restore")

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
            self.open_path(path)

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
