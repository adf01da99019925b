"""Looks after the open project's file: notices what others do to it, and writes a copy beside it now and then."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QFileSystemWatcher, QObject, QTimer

from engine.progress import Progress
from studio import file_questions as questions
from studio.project.autosaved import autosave_path, later_autosave
from studio.tasks import describe

if TYPE_CHECKING:
    from studio.main_window import MainWindow

_MINUTE_MS = 60_000
_CALM_MS = 200


class FileGuard(QObject):
    """Watches over one window's project.

    A file that was changed, deleted or moved outside is mentioned when that happens, and looked at again when the
    window comes to the front (a watcher sees nothing of other machines). Every few minutes (``files/autosave_minutes``)
    a named project with new unsaved steps is written to a sibling, ``name.autosave.qface``: never to the file itself,
    which only *Save* replaces. The sibling goes when the project is saved, or closed without saving.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window, self._session = window, window.session
        self._told: object = None
        self._autosaved = -1
        self._sibling: Path | None = None
        self._watcher = QFileSystemWatcher(self)
        self._calm = QTimer(self)
        self._calm.setSingleShot(True)
        self._calm.setInterval(_CALM_MS)  # others may write in several steps
        self._calm.timeout.connect(self.look)
        self._clock = QTimer(self)
        self._clock.timeout.connect(self.autosave)
        self._watcher.fileChanged.connect(self._calm_later)
        self._watcher.directoryChanged.connect(self._calm_later)
        self._session.title_changed.connect(self._follow)
        self._session.replaced.connect(self._on_replaced)
        self._session.saved.connect(self._on_saved)
        window.settings.changed.connect(self._on_setting)
        window.installEventFilter(self)
        self._on_setting("files/autosave_minutes")

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Look at the file when the window comes to the front."""
        if event.type() == QEvent.Type.WindowActivate and watched is self._window:
            self._calm_later()
        return False

    def look(self) -> None:
        """Mention what happened to the file since it was read or written here; every state of it once."""
        session, message = self._session, self._window.message
        path = session.project.path
        if path is None or session.stamp is None:
            return
        if not path.is_file():
            if self._told != "gone":
                self._told = "gone"
                message.tell("info", f"{path.name} was deleted or moved by another program; Save writes it again")
            return
        if not session.changed_outside:
            self._told = None
            return
        try:
            state = path.stat().st_mtime_ns
        except OSError:
            return
        if state != self._told:
            self._told = state
            offers = (("Reload", self._reload), ("Keep mine", lambda: None))
            message.offer(f"{path.name} was changed by another program. Save will ask before it replaces that.", offers)

    def autosave(self) -> None:
        """Write the unsaved steps of a named project to its sibling, beside the window."""
        session = self._session
        path, step = session.project.path, session.stack.index()
        if path is None or not session.is_dirty or step == self._autosaved or session.changed_outside:
            return
        from studio.project import store
        from studio.project.recovery import copy_of
        from studio.project.thumbnail import picture_of

        copy, target = copy_of(session.project), autosave_path(path)
        self._autosaved, self._sibling = step, target

        def work(_progress: Progress) -> None:
            store.remove_remains(target)
            store.save(copy, target, picture=picture_of(copy))

        def done(_result: None) -> None:
            if self._sibling != target:  # saved or closed meanwhile
                target.unlink(missing_ok=True)
                return
            session.noted.emit(f"Autosaved to {target.name} at {time.strftime('%H:%M')}")

        def failed(error: BaseException) -> None:
            self._autosaved = -1
            session.message.emit("error", f"Not autosaved: {describe(error)}")

        session.tasks.submit("Autosaving", work, done, failed=failed, key="autosave", quiet=True)

    def offer_autosave(self) -> None:
        """Offer the sibling of a project that has just been opened, when it is later than the project."""
        path = self._session.project.path
        found = None if path is None else later_autosave(path)
        if path is None or found is None:
            return
        when = time.strftime("%d %b, %H:%M", time.localtime(found.stat().st_mtime))
        offers = (
            ("Open the autosave", lambda: self._open_autosave(path, found)),
            ("Delete it", lambda: found.unlink(missing_ok=True)),
        )
        self._window.message.offer(
            f"There is an autosave of {path.name} from {when} that is later than the file.", offers
        )

    def adopt_autosave(self) -> None:
        """Take the sibling of the open project for one of this window: its steps are all in what was restored."""
        path = self._session.project.path
        if path is not None and self._session.stamp is not None:
            self._sibling = autosave_path(path)

    def close(self) -> None:
        """Stop, and delete the sibling: what it holds was saved or given up."""
        self._clock.stop()
        self._calm.stop()
        self._window.removeEventFilter(self)
        self._drop_sibling()

    def _open_autosave(self, path: Path, found: Path) -> None:
        from studio.project import store

        def take() -> None:
            project = store.load(found)
            project.set_path(path)
            self._session.take_over(project, self._session.stamp_digest)
            self.adopt_autosave()

        if self._window.files.may_discard():
            self._window.attempt(take)

    def _reload(self) -> None:
        session = self._session
        if not session.is_dirty or questions.ask_reload(self._window, session.name):
            self._window.files.reload()

    def _calm_later(self, *_values: object) -> None:
        if not self._calm.isActive():
            self._calm.start()

    def _follow(self) -> None:
        """Watch the file of the project that is open now, and its folder, where it comes back after a replacement."""
        path = self._session.project.path
        wanted = set() if path is None else {str(path.parent.resolve())}
        if path is not None and path.is_file():
            wanted.add(str(path.resolve()))
        present = {*self._watcher.files(), *self._watcher.directories()}
        if present - wanted:
            self._watcher.removePaths(sorted(present - wanted))
        if wanted - present:
            self._watcher.addPaths(sorted(wanted - present))

    def _on_replaced(self) -> None:
        self._told, self._autosaved = None, -1
        self._drop_sibling()
        self._follow()

    def _on_saved(self) -> None:
        self._told, self._autosaved = None, -1
        self._drop_sibling()
        self._follow()

    def _drop_sibling(self) -> None:
        sibling, self._sibling = self._sibling, None
        if sibling is not None:
            self._window.attempt(sibling.unlink, True)

    def _on_setting(self, key: str) -> None:
        if key == "files/autosave_minutes":
            minutes = self._window.settings["files/autosave_minutes"]
            self._clock.stop()
            if minutes > 0:
                self._clock.start(minutes * _MINUTE_MS)
