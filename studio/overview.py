"""The overview of shortcuts, which is also where any action is found and run."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from studio.actions import SPECS, Actions
from widgets import theme
from widgets.canvases.canvas_keys import HABITS
from widgets.viewers import navigation
from widgets.window.overview import HEIGHT, WIDTH, Entry, Overview


def entries(actions: Actions) -> tuple[Entry, ...]:
    """Return the actions of the stage in view with the keys they have now, by menu, then what the hand does there."""
    actions.refresh()
    found = []
    for spec in SPECS:
        if actions.is_here(spec.id):
            action = actions[spec.id]
            why = str(action.property("why") or "")
            text = actions.text(spec.id).replace("&", "").removesuffix("...")
            found.append(Entry(spec.menu.split("/")[0], text, keys_of(action), actions.tip(spec.id), spec.id, why))
    return (*found, *gestures(picture=actions.stage == "scan"))


def gestures(picture: bool = True) -> tuple[Entry, ...]:
    """Return what the hand does in the picture, where there is one, and in 3-D, in the navigation style of now."""
    style = navigation.current()
    habits = [Entry("In the picture", deed, (hand,)) for hand, deed in HABITS]
    moves = [Entry("In the picture", navigation.DEEDS[g.deed], (g.text,)) for g in style.pictures]
    views = [Entry(f"In 3-D, {style.title} style", navigation.DEEDS[g.deed], (g.text,)) for g in style.views]
    return (*habits, *moves, *views) if picture else tuple(views)


def keys_of(action: QAction) -> tuple[str, ...]:
    """Return the shortcuts of an action as the platform writes them, each once."""
    form = QKeySequence.SequenceFormat.NativeText
    return tuple(dict.fromkeys(key.toString(form).replace("Return", "Enter") for key in action.shortcuts()))


class OverviewDialog(QDialog):
    """The overview over a window; an action that is chosen runs once the dialog has closed."""

    def __init__(self, actions: Actions, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("overview")
        self.setWindowTitle("Shortcuts and commands")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._actions = actions
        self._wanted = ""
        self.panel = Overview(entries(actions), self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        self.panel.chosen.connect(self._choose)
        self.finished.connect(self._run)
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))

    def _choose(self, action_id: str) -> None:
        self._wanted = action_id
        self.accept()

    def _run(self) -> None:
        if self._wanted:
            self._actions[self._wanted].trigger()
