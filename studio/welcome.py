"""Keeps the page of an empty project: there while no scan is, with recent projects and their pictures."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtGui import QImage, QImageReader
from PySide6.QtWidgets import QApplication, QWidget

import resources
from engine.progress import Progress
from widgets.window.welcome import RecentProject, WelcomePage

if TYPE_CHECKING:
    from studio.main_window import MainWindow

SAMPLE_PICTURE = ("subject", "base_colour.png")
PICTURE_HEIGHT = 192


class Welcome(QObject):
    """Lays the page over a part of the work zone while the project has no scan.

    The pictures are read beside the window after its first paint.

    Parameters
    ----------
    window : MainWindow
        Gives project, actions and recent files.
    place : QWidget
        What the page covers.
    """

    def __init__(self, window: MainWindow, place: QWidget) -> None:
        super().__init__(window)
        self._window, self._place = window, place
        actions = window.actions_
        self.page = WelcomePage(actions.shortcut_text("scan.add"), actions.shortcut_text("file.open"), place)
        self.page.sample_requested.connect(actions["scan.sample"].trigger)
        self.page.add_requested.connect(actions["scan.add"].trigger)
        self.page.open_requested.connect(actions["file.open"].trigger)
        self.page.recent_requested.connect(window.files.open_recent)
        place.installEventFilter(self)
        session = window.session
        session.changed.connect(self._follow)
        session.replaced.connect(self._follow)
        session.title_changed.connect(self._follow)
        window.painted.connect(self._load_pictures)
        self._painted = False
        self._follow()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Cover the place, whatever its size."""
        if event.type() == QEvent.Type.Resize and watched is self._place:
            self.page.setGeometry(self._place.rect())
        return False

    def _follow(self, *_values: object) -> None:
        empty = not self._window.session.project.scans
        if empty:
            self.page.set_recent([RecentProject(path, _saved(path)) for path in self._window.settings.recent()])
            self.page.setGeometry(self._place.rect())
            self.page.raise_()
            if self._painted:
                self._load_pictures()
        focus = QApplication.focusWidget()
        lost = not empty and self.page.isVisible() and (focus is None or self.page.isAncestorOf(focus))
        self.page.setVisible(empty)
        for child in self._place.findChildren(QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly):
            if child is not self.page:
                child.setEnabled(not empty)  # what is covered takes no keys
        if lost:
            self._place.setFocus()

    def _load_pictures(self) -> None:
        self._painted = True
        paths = self._window.settings.recent()
        with_sample = not self.page.sample.has_picture
        if self._window.session.project.scans or not (with_sample or paths):
            return

        def work(_progress: Progress) -> list[tuple[Path | None, QImage]]:
            from studio.project.thumbnail import thumbnail_of

            found: list[tuple[Path | None, QImage]] = [(None, sample_picture())] if with_sample else []
            for path in paths:
                data = thumbnail_of(path)
                if data is not None:
                    found.append((path, QImage.fromData(data)))
            return found

        self._window.session.tasks.submit(
            "Reading pictures", work, self._show, failed=lambda _error: None, key="welcome", quiet=True
        )

    def _show(self, pictures: list[tuple[Path | None, QImage]]) -> None:
        for path, picture in pictures:
            if path is None:
                self.page.set_sample_picture(picture)
            else:
                self.page.set_thumbnail(path, picture)


def sample_picture() -> QImage:
    """Return the face of the bundled sample, small; nothing where it is not installed."""
    reader = QImageReader(str(resources.sample_path(*SAMPLE_PICTURE)))
    size = reader.size()
    if size.isValid():
        reader.setScaledSize(QSize(size.width() * PICTURE_HEIGHT // size.height(), PICTURE_HEIGHT))
    return reader.read()


def _saved(path: Path) -> datetime | None:
    try:
        return datetime.fromtimestamp(path.stat().st_mtime)
    except OSError:
        return None
