"""Opens the preferences: every value that has a section, applied at once."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from studio.settings import SETTINGS, Settings, declared
from widgets import theme
from widgets.window.preferences import HEIGHT, WIDTH, PreferencesPanel


class PreferencesDialog(QDialog):
    """The panel over the settings of this user: what is changed there is written and acts at once.

    Parameters
    ----------
    settings : Settings
        Read, written, and followed.
    """

    def __init__(self, settings: Settings, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("preferences")
        self.setWindowTitle("Preferences")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self._settings = settings
        self.panel = PreferencesPanel(SETTINGS, self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        for setting in SETTINGS:
            self.panel.show_value(setting.key, settings[setting.key])
        self.panel.changed.connect(self._take)
        self.panel.reset_requested.connect(self._reset)
        self.panel.closed.connect(self.accept)
        settings.changed.connect(self._show)
        self.finished.connect(lambda _result: settings.save())
        self._fit_room()

    def _fit_room(self) -> None:
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))

    def _take(self, key: str, value: Any) -> None:
        setting = declared(key)
        problem = self._settings.conflict(key, value)
        self.panel.tell(problem)
        if problem:
            self.panel.show_value(key, self._settings[key])
        elif setting.allows(value):
            self._settings[key] = value
        self.panel.show_value(key, self._settings[key])

    def _reset(self, key: str) -> None:
        self.panel.tell("")
        for setting in SETTINGS:
            if setting.section and key in ("", setting.key):
                self._settings.remove(setting.key)
                self.panel.show_value(setting.key, self._settings[setting.key])

    def _show(self, key: str) -> None:
        self.panel.show_value(key, self._settings[key])
        if key == "look/text_scale":
            self._fit_room()


def open_preferences(settings: Settings, parent: QWidget) -> PreferencesDialog:
    """Show the preferences over a window and return at once."""
    dialog = PreferencesDialog(settings, parent)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
    return dialog
