"""The navigation style of the settings, worn by every view and by the keys of the window."""

from __future__ import annotations

from PySide6.QtCore import QObject

from studio.actions import Actions
from studio.settings import Settings
from widgets.viewers import navigation

KEY = "view/navigation"


class NavigationKeys(QObject):
    """Puts the style of the settings into use, and its keys on the actions, at once whenever it changes."""

    def __init__(self, settings: Settings, actions: Actions, parent: QObject) -> None:
        super().__init__(parent)
        self._settings, self._actions = settings, actions
        settings.changed.connect(self._on_setting)
        navigation.signals.changed.connect(self.wear)
        navigation.choose(settings[KEY])
        self.wear()

    def close(self) -> None:
        """Follow no more."""
        self._settings.changed.disconnect(self._on_setting)
        navigation.signals.changed.disconnect(self.wear)

    def _on_setting(self, key: str) -> None:
        if key == KEY:
            navigation.choose(self._settings[KEY])

    def wear(self) -> None:
        """Put the keys of the present style on the actions."""
        keys = navigation.current().keys
        for name in dict.fromkeys(name for style in navigation.STYLES.values() for name in style.keys):
            if name in self._actions:
                self._actions.set_shortcuts(name, keys.get(name))
