"""What the user's own machine remembers: every setting declared once, with type, default, limits and text."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import platformdirs
from PySide6.QtCore import QByteArray, QObject, QSettings, Signal

APPLICATION = "quasiface"
RECENT_LIMIT = 8
VERSION = 1
"""Of the settings file; a file of a later one is put aside."""
LARGEST_FILE = 4_000_000
_VERSION_KEY = "file/version"


@dataclass(frozen=True)
class Setting:
    """One remembered value: its key, its type, its default, and a sentence that says what it is for.

    Attributes
    ----------
    title, section : str
        What the preferences call it, and the heading it stands under there; without a section it is not shown.
        Sections appear in the order in which they are declared.
    choices, labels : tuple
        The values it can take, where they are few, and what people call them (the values themselves when empty).
    minimum, maximum : float, optional
        Limits of a number, both included.
    unit : str
        Written behind the number.
    below : str
        Key of another value that this one must stay below.
    """

    key: str
    type: type
    default: Any
    text: str
    title: str = ""
    section: str = ""
    choices: tuple[Any, ...] = ()
    minimum: float | None = None
    maximum: float | None = None
    labels: tuple[str, ...] = ()
    unit: str = ""
    below: str = ""

    def label(self, value: Any) -> str:
        """Return what people call one of the choices."""
        return self.labels[self.choices.index(value)] if self.labels else str(value)

    def read(self, stored: Any) -> Any:
        """Return a stored value as the setting's type; the default where it is of another one or out of its limits."""
        try:
            value = self._typed(stored)
        except (TypeError, ValueError, OverflowError):
            return self.default
        return value if self.allows(value) else self.default

    def allows(self, value: Any) -> bool:
        """Return whether a value of the setting's type is one of its choices and within its limits."""
        if self.choices and value not in self.choices:
            return False
        if self.type in (int, float) and not math.isfinite(value):
            return False
        return (self.minimum is None or value >= self.minimum) and (self.maximum is None or value <= self.maximum)

    def _typed(self, stored: Any) -> Any:
        if stored is None:
            return self.default
        if self.type is list:
            return [str(item) for item in stored] if isinstance(stored, list) else [str(stored)] if stored else []
        if self.type is bool and isinstance(stored, str):
            return {"true": True, "false": False}.get(stored.lower(), self.default)
        return self.type(stored)


SETTINGS: tuple[Setting, ...] = (
    Setting(
        "look/theme", str, "dark", "Dark surfaces, or light ones.", "Theme", "Appearance",
        choices=("dark", "light"), labels=("Dark", "Light"),
    ),
    Setting(
        "look/text_scale", int, 100, "Size of letters, rows and icons (Ctrl+= larger, Ctrl+- smaller, Ctrl+0 100 %).",
        "Text scale", "Appearance", minimum=80, maximum=200, unit="%",
    ),
    Setting(
        "view/navigation", str, "studio", "How mouse and keys move about in 3-D and in pictures.",
        "Navigation", "3-D view", choices=("studio", "maya", "blender"), labels=("Studio", "Maya", "Blender"),
    ),
    Setting(
        "view/smooth", bool, True, "Colour the heatmap by the mean around each point; figures stay as measured.",
        "Smoothed heatmap", "Heatmap",
    ),
    Setting(
        "view/low", float, 0.0, "Distance to the scan that has the first colour of the heatmap.",
        "Heatmap from", "Heatmap", minimum=0.0, maximum=50.0, unit="mm", below="view/high",
    ),
    Setting(
        "view/high", float, 0.2, "Distance to the scan that has the last colour of the heatmap.",
        "Heatmap to", "Heatmap", minimum=0.01, maximum=50.0, unit="mm",
    ),
    Setting("window/geometry", QByteArray, QByteArray(), "Size and place of the window."),
    Setting("window/layout", QByteArray, QByteArray(), "Arrangement of the docks."),
    Setting("window/stage_layouts", str, "{}", "Arrangements of the docks of the other stages."),
    Setting("window/layouts", str, "{}", "Arrangements of the docks that were saved under a name."),
    Setting("window/work", QByteArray, QByteArray(), "Share of picture and 3-D in the work zone."),
    Setting(
        "files/autosave_minutes", int, 5,
        "How often unsaved steps are written to a copy beside the project, name.autosave.qface; 0 is never.",
        "Autosave every", "Files", minimum=0, maximum=60, unit="min",
    ),
    Setting("files/recent", list, [], "Projects opened last, the newest first."),
    Setting("files/folder", str, "", "Folder that the file dialogs start in."),
)  # fmt: skip
_BY_KEY = {setting.key: setting for setting in SETTINGS}


def declared(key: str) -> Setting:
    """Return the declaration of ``key``; KeyError where there is none."""
    return _BY_KEY[key]


def config_folder() -> Path:
    """Return the folder that settings are kept in, of this user on this machine."""
    return platformdirs.user_config_path(APPLICATION, appauthor=False)


class Settings(QObject):
    """The remembered values, read and written by key; a key that is not declared is a programming error.

    Parameters
    ----------
    path : Path, optional
        The file; by default ``studio.ini`` in the user's configuration folder.
    """

    changed = Signal(str)
    """The key of a value that is another one than before."""

    notice: str
    """What the user should be told about the file once; empty when nothing is wrong with it."""

    def __init__(self, path: Path | None = None) -> None:
        super().__init__()
        self.path = path or config_folder() / "studio.ini"
        self.notice = _put_aside(self.path)
        self._store = QSettings(str(self.path), QSettings.Format.IniFormat)

    def __getitem__(self, key: str) -> Any:
        return _BY_KEY[key].read(self._store.value(key))

    def __setitem__(self, key: str, value: Any) -> None:
        setting = _BY_KEY[key]
        if not setting.allows(value):
            raise ValueError(f"{key} cannot be {value!r}")
        before = self[key]
        self._store.setValue(key, value)
        if self[key] != before:
            self.changed.emit(key)

    def conflict(self, key: str, value: Any) -> str:
        """Say which other value stands against this one; empty when none does."""
        setting = _BY_KEY[key]
        if setting.below and value >= self[setting.below]:
            return (
                f"{setting.title} must be below {_BY_KEY[setting.below].title}, {self[setting.below]:g} {setting.unit}"
            )
        for other in SETTINGS:
            if other.below == key and value <= self[other.key]:
                return f"{setting.title} must be above {other.title}, {self[other.key]:g} {setting.unit}"
        return ""

    def remove(self, key: str) -> None:
        """Go back to the default of ``key``."""
        setting = _BY_KEY[key]
        before = self[key]
        self._store.remove(key)
        if setting.default != before:
            self.changed.emit(key)

    def add_recent(self, path: Path) -> None:
        """Put a project at the head of the recent ones."""
        text = str(path.resolve())
        self["files/recent"] = [text, *(item for item in self["files/recent"] if item != text)][:RECENT_LIMIT]

    def recent(self) -> tuple[Path, ...]:
        """Return the recent projects that are still there, the newest first."""
        return tuple(path for path in map(Path, self["files/recent"]) if path.is_file())

    def save(self) -> None:
        """Write what has changed to the file."""
        self._store.setValue(_VERSION_KEY, VERSION)
        self._store.sync()


def _put_aside(path: Path) -> str:
    """Rename a settings file that cannot be read to ``.bak`` and say so; empty where nothing is wrong."""
    try:
        if not path.is_file():
            return ""
        why = _fault(path)
        if not why:
            return ""
        path.replace(path.with_name(path.name + ".bak"))
    except OSError as error:
        return f"{path.name}: the settings cannot be read ({error.strerror}); the studio starts with its own"
    return f"{path.name}: the settings {why}; the studio starts with its own, the old ones are in {path.name}.bak"


def _fault(path: Path) -> str:
    if path.stat().st_size > LARGEST_FILE:
        return "are larger than any that the studio writes"
    try:
        lines = [line.strip() for line in path.read_bytes().decode("utf-8").splitlines()]
    except UnicodeDecodeError:
        return "are damaged"
    if any("\0" in line or (line and line[0] not in "[;#" and "=" not in line) for line in lines):
        return "are damaged"
    store = QSettings(str(path), QSettings.Format.IniFormat)
    if store.status() != QSettings.Status.NoError:
        return "are damaged"
    version = str(store.value(_VERSION_KEY, str(VERSION)))
    return "" if version.isdecimal() and int(version) <= VERSION else "are of another version of the studio"
