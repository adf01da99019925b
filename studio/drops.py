"""Files and folders dropped anywhere on the window: a project is opened, all else goes to the stage in view."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QDropEvent

from studio.project.document import SUFFIX

if TYPE_CHECKING:
    from studio.main_window import MainWindow


class DropTarget(QObject):
    """Makes a window accept files; what its widgets do not accept themselves reaches it."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        window.setAcceptDrops(True)
        window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Accept what has local files, and take them in when they are dropped."""
        kind = event.type()
        if kind not in (QEvent.Type.DragEnter, QEvent.Type.DragMove, QEvent.Type.Drop):
            return super().eventFilter(watched, event)
        paths = dropped_paths(event) if isinstance(event, QDropEvent) else []
        if not paths:
            return False
        event.acceptProposedAction()  # type: ignore[attr-defined]
        if kind == QEvent.Type.Drop:
            self.take(paths)
        return True

    def take(self, paths: list[Path]) -> None:
        """Open a project that was dropped alone, or let the stage take the files in."""
        window = self._window
        projects = [path for path in paths if path.suffix.lower() == SUFFIX]
        if not projects:
            window.attempt(window.stage.drop, paths)
        elif len(paths) == 1:
            if window.files.may_discard():
                window.open_project(projects[0])
        else:
            window.message.tell("error", "Drop one project alone, or scans and folders without a project")


def dropped_paths(event: QDropEvent) -> list[Path]:
    """Return the local files and folders that an event carries."""
    return [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
