"""How the window is arranged: remembered, kept under names, and brought back where a screen is gone."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QByteArray, QObject, QRect, QSize, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QAbstractButton, QDockWidget, QMenu

from studio import dialogs
from studio.stages import STAGES

if TYPE_CHECKING:
    from studio.main_window import MainWindow

LAYOUT_VERSION = 1
LEAST_SEEN = QSize(160, 48)
LONGEST_NAME, MOST = 40, 20
_PART = "\n"
"""Parts stage and name; nobody types it into a name."""


class Layouts(QObject):
    """The arrangements of one window: the first one, that of the last session, and those with a name.

    Every stage has its own, as it has its own docks.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._menu: QMenu | None = None
        self._first: dict[str, QByteArray] = {}
        self._left: dict[str, QByteArray] = {}
        self._maximisers: list[tuple[QAbstractButton, Callable[[bool], object]]] = []

    def begin(self) -> None:
        """Take the arrangement of now for the first one, then go back to that of the last session, where it fits."""
        window, settings = self._window, self._window.settings
        self._first[window.stage_id] = self._state()
        if not settings["window/geometry"].isEmpty():
            window.restoreGeometry(settings["window/geometry"])
            bring_back(window)
        if not settings["window/layout"].isEmpty():
            window.restoreState(settings["window/layout"], LAYOUT_VERSION)
        for stage_id, state in _texts(settings["window/stage_layouts"]).items():
            self._left[stage_id] = _bytes(state)

    def release_by(self, button: QAbstractButton, fill: Callable[[bool], object]) -> None:
        """Take the button of a stage that lets its views fill the window, and what it does."""
        self._maximisers.append((button, fill))

    def _release(self) -> None:
        for button, fill in self._maximisers:
            if button.isChecked():
                button.setChecked(False)
                fill(False)

    def leave(self, stage_id: str) -> None:
        """Note how a stage that goes out of view was arranged; its views fill the window no more, its message goes."""
        self._release()
        self._window.message.clear()
        self._left[stage_id] = self._state()

    def enter(self, stage_id: str, first: bool) -> None:
        """Arrange the window as a stage was left; ``first``: it has just been made and stands as at first."""
        if first:
            self._first[stage_id] = self._state()
        if stage_id in self._left:
            self._window.restoreState(self._left[stage_id], LAYOUT_VERSION)
            self._window.hide_other_docks()

    def remember(self) -> None:
        """Note the arrangements for the next session."""
        settings, first = self._window.settings, next(iter(self._first))
        self.leave(self._window.stage_id)
        settings["window/geometry"] = self._window.saveGeometry()
        settings["window/layout"] = self._left.get(first, QByteArray())
        others = {key: _text(state) for key, state in self._left.items() if key != first}
        settings["window/stage_layouts"] = json.dumps(others)

    def reset(self) -> None:
        """Put every dock and every work zone back as it was at first."""
        self._release()
        self._window.restoreState(self._first[self._window.stage_id], LAYOUT_VERSION)
        self._window.hide_other_docks()
        self._window.arrange()
        for stage in self._window.stages.values():
            stage.reset_layout()

    def _state(self) -> QByteArray:
        return self._window.saveState(LAYOUT_VERSION)

    @property
    def named(self) -> dict[str, str]:
        """The saved arrangements of the stage in view: name -> state in base 64; what cannot be read is left out."""
        return {name: state for (stage_id, name), state in self._all().items() if stage_id == self._window.stage_id}

    def _all(self) -> dict[tuple[str, str], str]:
        """Return the states by stage and name; one without a stage is of the first."""
        found = {}
        for key, state in _texts(self._window.settings["window/layouts"]).items():
            stage_id, parted, name = key.partition(_PART)
            found[(stage_id, name) if parted else (STAGES[0].id, key)] = state
        return found

    def save(self, name: str) -> None:
        """Keep the present arrangement under a name; one of the same name is replaced."""
        self._release()
        key = (self._window.stage_id, name)
        kept = {other: state for other, state in self._all().items() if other != key}
        self._store({**dict(list(kept.items())[-MOST + 1 :]), key: _text(self._state())})

    def use(self, name: str) -> bool:
        """Arrange the window as it was saved under a name; False where that was of another version."""
        self._release()
        state = self.named.get(name)
        done = state is not None and self._window.restoreState(_bytes(state), LAYOUT_VERSION)
        self._window.hide_other_docks()
        if not done:
            self._window.message.tell("error", f"Layout “{name}” cannot be read; arrange the window and save it again")
        return done

    def remove(self, name: str) -> None:
        """Forget an arrangement."""
        key = (self._window.stage_id, name)
        self._store({other: state for other, state in self._all().items() if other != key})

    def ask_and_save(self) -> None:
        """Ask for a name and keep the present arrangement under it."""
        name = dialogs.ask_text(self._window, "Save layout", "Name of the layout", "")[:LONGEST_NAME]
        if name:
            self.save(name)
            self._window.message.tell("info", f"Saved the layout “{name}”; it is under Window, Layouts")

    def add_menu(self, menu: QMenu) -> None:
        """Add the submenu of saved layouts."""
        self._menu = QMenu("&Layouts", menu)
        menu.addMenu(self._menu)
        menu.aboutToShow.connect(self._fill)

    def _fill(self) -> None:
        if self._menu is None:
            return
        self._menu.clear()
        named = self.named
        self._menu.setEnabled(bool(named))
        for name in named:
            self._menu.addAction(name.replace("&", "&&"), partial(self.use, name))
        if named:
            self._menu.addSeparator()
            forget = self._menu.addMenu("&Remove")
            for name in named:
                forget.addAction(name.replace("&", "&&"), partial(self.remove, name))

    def _store(self, found: dict[tuple[str, str], str]) -> None:
        texts = {
            name if stage == STAGES[0].id else stage + _PART + name: state for (stage, name), state in found.items()
        }
        self._window.settings["window/layouts"] = json.dumps(texts)


def _text(state: QByteArray) -> str:
    return bytes(state.toBase64().data()).decode("ascii")


def _bytes(text: str) -> QByteArray:
    return QByteArray.fromBase64(QByteArray(text.encode("ascii", "replace")))


def _texts(stored: str) -> dict[str, str]:
    """Return the texts by name of a setting; what cannot be read is left out."""
    try:
        kept = json.loads(stored)
    except ValueError:
        return {}
    if not isinstance(kept, dict):
        return {}
    return {name: state for name, state in kept.items() if isinstance(name, str) and isinstance(state, str)}


def bring_back(window: MainWindow) -> None:
    """Move a window, and docks that float, to where at least a handle's breadth of them can be seen."""
    places = [screen.availableGeometry() for screen in QGuiApplication.screens()]
    maximised = bool(window.windowState() & (Qt.WindowState.WindowMaximized | Qt.WindowState.WindowFullScreen))
    place = seen_place(window.geometry(), places)
    if not maximised and place != window.geometry():
        window.setGeometry(place)
    for dock in window.findChildren(QDockWidget):
        if dock.isFloating():
            dock.setGeometry(seen_place(dock.geometry(), places))


def seen_place(wanted: QRect, screens: list[QRect]) -> QRect:
    """Return where a window goes that is wanted somewhere: there, if its upper edge can be taken hold of on a screen.

    Else it is moved into the first screen and made no larger than that.
    """
    edge = QRect(wanted.topLeft(), QSize(wanted.width(), LEAST_SEEN.height()))
    for screen in screens:
        seen = edge.intersected(screen)
        if seen.width() >= LEAST_SEEN.width() and seen.height() >= LEAST_SEEN.height() // 2:
            return wanted
    if not screens:
        return wanted
    size = wanted.size().boundedTo(screens[0].size())
    place = QRect(screens[0].topLeft(), size)
    place.moveCenter(screens[0].center())
    return place
