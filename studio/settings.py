"""What the user's own machine remembers: every setting declared once, with type, default and text."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import platformdirs
from PySide6.QtCore import QByteArray, QSettings

APPLICATION = "quasiface"
RECENT_LIMIT = 8


@dataclass(frozen=True)
class Setting:
    """One remembered value: its key, its type, its default, and a sentence that says what it is for."""

    key: str
    type: type
    default: Any
    text: str


SETTINGS: tuple[Setting, ...] = (
    Setting("look/theme", str, "dark", "Theme of the window: dark or light."),
    Setting("window/geometry", QByteArray, QByteArray(), "Size and place of the window."),
    Setting("window/layout", QByteArray, QByteArray(), "Arrangement of the docks."),
    Setting("window/work", QByteArray, QByteArray(), "Share of picture and 3-D in the work zone."),
    Setting("files/recent", list, [], "Projects opened last, the newest first."),
    Setting("files/folder", str, "", "Folder that the file dialogs start in."),
    Setting("view/low", float, 0.0, "Lower end of the distance colours, in mm."),
    Setting("view/high", float, 0.2, "Upper end of the distance colours, in mm."),
)
_BY_KEY = {setting.key: setting for setting in SETTINGS}


def config_folder() -> Path:
    """Return the folder that settings are kept in, of this user on this machine."""
    return platformdirs.user_config_path(APPLICATION, appauthor=False)


class Settings:
    """The remembered values, read and written by key; a key that is not declared is a programming error.

    Parameters
    ----------
    path : Path, optional
        The file; by default ``studio.ini`` in the user's configuration folder.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.path = path or config_folder() / "studio.ini"
        self._store = QSettings(str(self.path), QSettings.Format.IniFormat)

    def __getitem__(self, key: str) -> Any:
        setting = _BY_KEY[key]
        value = self._store.value(key)
        if setting.type is list:
            return [str(item) for item in value] if isinstance(value, list) else [str(value)] if value else []
        try:
            return setting.default if value is None else setting.type(value)
        except (TypeError, ValueError):
            return setting.default

    def __setitem__(self, key: str, value: Any) -> None:
        self._store.setValue(_BY_KEY[key].key, value)

    def remove(self, key: str) -> None:
        """Go back to the default of ``key``."""
        self._store.remove(_BY_KEY[key].key)

    def add_recent(self, path: Path) -> None:
        """Put a project at the head of the recent ones."""
        text = str(path.resolve())
        self["files/recent"] = [text, *(item for item in self["files/recent"] if item != text)][:RECENT_LIMIT]

    def recent(self) -> tuple[Path, ...]:
        """Return the recent projects that are still there, the newest first."""
        return tuple(path for path in map(Path, self["files/recent"]) if path.is_file())

    def save(self) -> None:
        """Write what has changed to the file."""
        self._store.sync()
