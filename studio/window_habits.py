"""What belongs to the window and to no stage: preferences, text size, overview, log, zones, layouts, welcome page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication, QMenu

from studio.basis.tab import follow_basis_tab
from studio.layouts import Layouts
from studio.log import studio_log
from studio.log_dock import LogDock
from studio.theme import wear
from studio.welcome import Welcome
from studio.zones import Zones
from widgets import text_scale, theme

if TYPE_CHECKING:
    from studio.main_window import MainWindow

SCALE_STEP = 10


class WindowHabits(QObject):
    """Gives the window's own actions their deeds and follows the settings.

    Attributes
    ----------
    log, layouts, zones : QObject
        The log dock, the arrangements, the keyboard's way through the window.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self.log = LogDock(window)
        self.zones = Zones(window)
        self.layouts = Layouts(window)
        self.welcome: Welcome | None = None
        window.settings.changed.connect(self._on_setting)
        self._bind()

    def furnish(self) -> None:
        """Take the arrangement of now for the first one, and lay the welcome page; stages and docks are there."""
        window = self._window
        self.layouts.begin()
        if window.stage.empty_place is not None:
            self.welcome = Welcome(window, window.stage.empty_place)
        window.painted.connect(self._tell_notice)
        follow_basis_tab(window)

    def add_layout_menu(self, menu: QMenu) -> None:
        """Add the submenu of saved layouts."""
        self.layouts.add_menu(menu)

    def remember(self) -> None:
        """Note the arrangement for the next session."""
        self.layouts.remember()

    def close(self) -> None:
        """Stop listening."""
        self.log.close()

    def _bind(self) -> None:
        window, bind = self._window, self._window.actions_.bind

        def limit(reached: bool, word: str) -> str:
            return f"the text is as {word} as it goes" if reached else ""

        bind("edit.preferences", self.open_preferences)
        bind("help.overview", self.open_overview)
        bind("view.dark", self._choose_theme)
        bind("view.larger", lambda: self._scale(SCALE_STEP), lambda: limit(text_scale.factor() >= 2.0, "large"))
        bind("view.smaller", lambda: self._scale(-SCALE_STEP), lambda: limit(text_scale.factor() <= 0.8, "small"))
        bind("view.usual", lambda: window.settings.remove("look/text_scale"))
        bind("window.next_zone", lambda: self.zones.go(1))
        bind("window.last_zone", lambda: self.zones.go(-1))
        bind("window.save_layout", self.layouts.ask_and_save)
        bind("window.reset", self.layouts.reset)
        window.actions_["view.dark"].setChecked(theme.current().is_dark)

    def open_preferences(self) -> None:
        """Show the preferences."""
        from studio.preferences import open_preferences  # the first paint need not wait for it

        open_preferences(self._window.settings, self._window)

    def open_overview(self) -> None:
        """Show every action and gesture with its keys."""
        from studio.overview import OverviewDialog

        OverviewDialog(self._window.actions_, self._window).open()

    def _scale(self, step: int) -> None:
        settings = self._window.settings
        present = settings["look/text_scale"]
        wanted = (present // SCALE_STEP + (1 if step > 0 else -1 if present % SCALE_STEP == 0 else 0)) * SCALE_STEP
        settings["look/text_scale"] = min(max(wanted, 80), 200)

    def _choose_theme(self, dark: bool) -> None:
        self._window.settings["look/theme"] = "dark" if dark else "light"

    def _on_setting(self, key: str) -> None:
        app = QApplication.instance()
        if key in ("look/theme", "look/text_scale") and isinstance(app, QApplication):
            wear(app, self._window.settings)
            self._window.actions_.refresh()
            if key == "look/text_scale":
                self._window.widen_sides()

    def _tell_notice(self) -> None:
        notice = self._window.settings.notice
        if notice:
            self._window.settings.notice = ""
            studio_log.warning("%s", notice)
            self._window.message.tell("info", notice)
