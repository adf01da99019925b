"""Looks after the open project's file: notices what others do to it, and writes a copy beside it now and then."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QFileSystemWatcher, QObject, QTimer

from engine.progress import Progress
from studio import file_questions as questions
from studio.project.autosaved import OwnAutosaves, autosave_path, put_aside, undecided_autosaves
from studio.project.document import Change
from studio.tasks import describe
from studio.waiting import waiting

if TYPE_CHECKING:
    from studio.main_window import MainWindow

_MINUTE_MS = 60_000
_CALM_MS = 200


class FileGuard(QObject):
    """Watches over one window's project.

    A file that was changed, deleted or moved outside is mentioned when that happens, and looked at again when the
    window comes to the front (a watcher sees nothing of other machines). Every few minutes (``files/autosave_minutes``)
    a named project with new unsaved steps is written to a sibling, ``name.autosave.qface``: never to the file itself,
    which only *Save* replaces. What this session wrote there goes when the project is saved, or closed without saving.
    A sibling that another session left is offered; until somebody decides on it, nothing is written over it: it gets
    the name ``name.autosave-<time>.qface`` as soon as there is a step.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window, self._session = window, window.session
        self._told: object = None
        self._outdated = True  # whether something has changed since the last autosave
        self._found: Path | None = None  # what is offered
        self._adopted: Path | None = None
        self._gate = threading.Lock()
        self._own = OwnAutosaves(self._gate)
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
        self._session.changed.connect(self._on_change)
        self._session.saving.connect(self._on_saving)
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
        if not _is_file(path):
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
            offers = (("Reload", lambda: self._reload(path)), ("Keep mine", lambda: None))
            message.offer(f"{path.name} was changed by another program. Save will ask before it replaces that.", offers)

    def autosave(self) -> None:
        """Write the unsaved steps of a named project to its sibling, beside the window."""
        session, path = self._session, self._session.project.path
        if path is None or not (session.is_dirty and self._outdated) or session.changed_outside:
            return
        from studio.project.recovery import copy_of

        try:
            target = self._make_room(path)
        except OSError as error:
            session.message.emit("error", f"Not autosaved: {describe(error)}")
            return
        copy, own = copy_of(session.project), self._own
        self._outdated = False
        own.claim(target)

        def work(_progress: Progress) -> bool:
            return own.write(copy, target)

        def done(written: bool) -> None:
            if written:
                session.noted.emit(f"Autosaved to {target.name} at {time.strftime('%H:%M')}")

        def failed(error: BaseException) -> None:
            self._outdated = True
            session.message.emit("error", f"Not autosaved: {describe(error)}")

        session.tasks.submit("Autosaving", work, done, failed=failed, key="autosave", quiet=True)

    def offer_autosave(self) -> None:
        """Offer the latest sibling of the open project that somebody has still to decide on."""
        path = self._session.project.path
        siblings = () if path is None else undecided_autosaves(path)
        others = [pair for pair in siblings if pair[0] != self._adopted and pair[0] not in self._own]
        self._found = others[0][0] if others else None
        if path is None or not others:
            return
        when = time.strftime("%d %b, %H:%M", time.localtime(others[0][1]))
        offers = (
            ("Open the autosave", lambda: self._decide(path, self._open_autosave)),
            ("Delete it", lambda: self._decide(path, self._delete_autosave)),
        )
        self._window.message.offer(f"There is an autosave of {path.name} from {when} that nobody has opened.", offers)

    def adopt_autosave(self, found: Path | None = None) -> None:
        """Take a sibling, or the usual one, for what the open project holds: it goes when that is saved."""
        path = self._session.project.path
        if path is not None and self._session.stamp is not None:
            self._adopted = found or autosave_path(path)

    def close(self) -> None:
        """Stop, and delete what was written beside the project: it was saved or given up."""
        self._clock.stop()
        self._calm.stop()
        self._window.removeEventFilter(self)
        self._drop_own()

    def _decide(self, path: Path, deed: Callable[[Path, Path], None]) -> None:
        found = self._found
        if found is not None and path == self._session.project.path:  # else the answer came too late
            deed(path, found)

    def _open_autosave(self, path: Path, found: Path) -> None:
        from studio.project import store

        def take() -> None:
            with waiting():
                project = store.load(found)
                project.set_path(path)
                self._session.take_over(project, self._session.stamp_digest)
            self.adopt_autosave(found)

        if self._window.files.may_discard():
            self._window.attempt(take)
        self.offer_autosave()

    def _delete_autosave(self, _path: Path, found: Path) -> None:
        self._window.attempt(found.unlink, True)
        self.offer_autosave()

    def _make_room(self, path: Path) -> Path:
        """Return where the autosave of a project goes, after what others left there got another name."""
        target = autosave_path(path)
        if target not in self._own and target != self._adopted and target.exists():
            aside = put_aside(target)
            if self._found == target:
                self._found = aside
        return target

    def _reload(self, path: Path) -> None:
        session = self._session
        if path != session.project.path:
            return
        if not session.is_dirty or questions.ask_reload(self._window, session.name):
            self._window.files.reload()

    def _calm_later(self, *_values: object) -> None:
        if not self._calm.isActive():
            self._calm.start()

    def _follow(self) -> None:
        """Watch the file of the project that is open now, and its folder, where it comes back after a replacement."""
        path = self._session.project.path
        wanted = set() if path is None else {str(path.parent.resolve())}
        if path is not None and _is_file(path):
            wanted.add(str(path.resolve()))
        present = {*self._watcher.files(), *self._watcher.directories()}
        if present - wanted:
            self._watcher.removePaths(sorted(present - wanted))
        if wanted - present:
            self._watcher.addPaths(sorted(wanted - present))

    def _on_change(self, change: Change) -> None:
        if change.kind == "fit":
            return
        self._outdated = True
        path = self._session.project.path
        if path is not None and self._found == autosave_path(path):
            # The sibling's name is that of these steps from now on, also after a crash.
            with contextlib.suppress(OSError):
                self._make_room(path)

    def _on_saving(self, target: Path) -> None:
        if target == self._session.project.path:
            with contextlib.suppress(OSError):
                self._make_room(target)  # it would be older than the file, and never be offered again

    def _on_replaced(self) -> None:
        self._told, self._outdated = None, True
        self._found = self._adopted = None
        self._drop_own()
        self._follow()

    def _on_saved(self) -> None:
        self._told, self._outdated = None, False
        adopted, self._adopted = self._adopted, None
        if adopted is not None:
            self._window.attempt(adopted.unlink, True)
        self._drop_own()
        self._follow()
        self._window.message.withdraw()
        self.offer_autosave()

    def _drop_own(self) -> None:
        own, self._own = self._own, OwnAutosaves(self._gate)
        self._window.attempt(own.drop)

    def _on_setting(self, key: str) -> None:
        if key == "files/autosave_minutes":
            minutes = self._window.settings["files/autosave_minutes"]
            self._clock.stop()
            if minutes > 0:
                self._clock.start(minutes * _MINUTE_MS)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that this machine does not take
        return False
