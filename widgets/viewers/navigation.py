"""How a hand moves the camera: a table of styles, their gestures, and what each gesture does.

The table is all there is: 3-D views and pictures look up in it what a press, a wheel or two fingers mean, the window
takes the keys of the style from it, and the overview of shortcuts lists it. The style in use is one for the whole
program, like the theme; a change acts at once wherever the next gesture begins.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from PySide6.QtCore import QObject, Qt, Signal

Source = Literal["left", "middle", "right", "wheel", "fingers"]
"""A button that is held and dragged, the wheel, or two fingers on a touchpad."""
Deed = Literal["orbit", "pan", "zoom", "dolly"]
"""What a gesture does: turn around the pivot with a level horizon, shift the picture, near what is under the pointer,
or near the middle of the picture at the pivot's depth."""

DEEDS: dict[Deed, str] = {
    "orbit": "Turn around the face",
    "pan": "Shift the picture",
    "zoom": "Zoom to the pointer",
    "dolly": "Nearer or farther",
}
"""What each deed is called."""

_BUTTONS: dict[Qt.MouseButton, Source] = {
    Qt.MouseButton.LeftButton: "left",
    Qt.MouseButton.MiddleButton: "middle",
    Qt.MouseButton.RightButton: "right",
}
_NAMES: dict[Source, str] = {
    "left": "left drag", "middle": "middle drag", "right": "right drag", "wheel": "wheel", "fingers": "two fingers",
}  # fmt: skip
_MODIFIERS = (
    (Qt.KeyboardModifier.ControlModifier, "Ctrl"),
    (Qt.KeyboardModifier.AltModifier, "Alt"),
    (Qt.KeyboardModifier.ShiftModifier, "Shift"),
)
NO_KEY = Qt.KeyboardModifier.NoModifier
SHIFT, CTRL, ALT = (
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.AltModifier,
)


@dataclass(frozen=True)
class Gesture:
    """What a hand does, with which keys held, and what comes of it."""

    source: Source
    modifiers: Qt.KeyboardModifier
    deed: Deed

    @property
    def text(self) -> str:
        """The gesture in words, such as ``Alt + middle drag``."""
        held = [name for key, name in _MODIFIERS if self.modifiers & key]
        words = " + ".join([*held, _NAMES[self.source]])
        return words[0].upper() + words[1:]


@dataclass(frozen=True)
class NavigationStyle:
    """One way to move about.

    Attributes
    ----------
    id, title : str
        What settings and people call it.
    views : tuple of Gesture
        In 3-D views.
    pictures : tuple of Gesture
        In pictures; besides, the left button pans there while the space bar is held.
    keys : mapping of str to tuple of str
        Action -> its shortcuts in this style, the first one shown; other actions keep their own.
    """

    id: str
    title: str
    views: tuple[Gesture, ...]
    pictures: tuple[Gesture, ...]
    keys: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def in_view(self, source: Source | Qt.MouseButton, modifiers: Qt.KeyboardModifier) -> Deed | None:
        """Return what a gesture does in a 3-D view, None where it does nothing."""
        return _found(self.views, source, modifiers)

    def in_picture(self, source: Source | Qt.MouseButton, modifiers: Qt.KeyboardModifier) -> Deed | None:
        """Return what a gesture does in a picture, None where it does nothing."""
        return _found(self.pictures, source, modifiers)


G = Gesture
STUDIO = NavigationStyle(
    "studio",
    "Studio",
    (
        G("left", NO_KEY, "orbit"), G("middle", NO_KEY, "pan"), G("left", SHIFT, "pan"), G("wheel", NO_KEY, "zoom"),
        G("fingers", NO_KEY, "zoom"),
    ),
    (G("middle", NO_KEY, "pan"), G("wheel", NO_KEY, "zoom"), G("fingers", NO_KEY, "zoom")),
    {"view.frame": ("F",), "view.frame_selected": ("Shift+F",)},
)  # fmt: skip
MAYA = NavigationStyle(
    "maya",
    "Maya",
    (
        G("left", ALT, "orbit"), G("middle", ALT, "pan"), G("right", ALT, "dolly"), G("wheel", NO_KEY, "dolly"),
        G("fingers", NO_KEY, "dolly"),
    ),
    (G("middle", ALT, "pan"), G("right", ALT, "dolly"), G("wheel", NO_KEY, "zoom"), G("fingers", NO_KEY, "zoom")),
    {"view.frame": ("A", "Shift+F"), "view.frame_selected": ("F",)},
)  # fmt: skip
BLENDER = NavigationStyle(
    "blender",
    "Blender",
    (
        G("middle", NO_KEY, "orbit"), G("middle", SHIFT, "pan"), G("middle", CTRL, "zoom"), G("wheel", NO_KEY, "zoom"),
        G("fingers", NO_KEY, "orbit"), G("fingers", SHIFT, "pan"), G("fingers", CTRL, "zoom"),
    ),
    (
        G("middle", NO_KEY, "pan"), G("middle", SHIFT, "pan"), G("middle", CTRL, "zoom"), G("wheel", NO_KEY, "zoom"),
        G("fingers", NO_KEY, "pan"), G("fingers", SHIFT, "pan"), G("fingers", CTRL, "zoom"),
    ),
    {
        "view.frame": ("Home", "F"), "view.frame_selected": ("Num+.", "Num+,", "Shift+F"),
        "view.front": ("Num+1", "Ctrl+1"), "view.back": ("Ctrl+Num+1", "Ctrl+6"),
        "view.left": ("Num+3", "Ctrl+2"), "view.right": ("Ctrl+Num+3", "Ctrl+3"),
        "view.top": ("Num+7", "Ctrl+5"), "view.below": ("Ctrl+Num+7",),
        "view.orthographic": ("Num+5", "O"),
    },
)  # fmt: skip
STYLES: dict[str, NavigationStyle] = {style.id: style for style in (STUDIO, MAYA, BLENDER)}
"""Every style by its id, in the order of the menu."""


class _Signals(QObject):
    changed = Signal()


signals = _Signals()
_state = {"style": STUDIO}


def current() -> NavigationStyle:
    """Return the style in use."""
    return _state["style"]


def choose(style_id: str) -> None:
    """Use a style from now on; KeyError where there is none of this id."""
    style = STYLES[style_id]
    if style is not _state["style"]:
        _state["style"] = style
        signals.changed.emit()


def held(modifiers: Qt.KeyboardModifier) -> Qt.KeyboardModifier:
    """Return those modifiers that gestures know; the keypad's and a group switch tell nothing."""
    return modifiers & (SHIFT | CTRL | ALT)


def _found(
    gestures: tuple[Gesture, ...], source: Source | Qt.MouseButton, modifiers: Qt.KeyboardModifier
) -> Deed | None:
    name = _BUTTONS.get(source) if isinstance(source, Qt.MouseButton) else source
    wanted = held(modifiers)
    return next((g.deed for g in gestures if g.source == name and g.modifiers == wanted), None)
