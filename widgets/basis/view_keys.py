"""The space bar, held: wherever in the window nobody else wants it."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QWidget


class SpaceBar(QObject):
    """Hears key events of some widgets; those that a widget's own children take never come here.

    Signals
    -------
    held(bool)
        The space bar went down, or came up again; also up when the keys go elsewhere meanwhile, where its release
        would not be heard.
    """

    held = Signal(bool)

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._down = False

    def listen(self, widget: QWidget) -> None:
        """Hear a widget from now on."""
        widget.installEventFilter(self)

    def forget(self, widget: QWidget) -> None:
        """Hear a widget no longer; a bar that is held comes up."""
        widget.removeEventFilter(self)
        self._put(False)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take the space bar and nothing else."""
        kind = event.type()
        if kind in (QEvent.Type.FocusOut, QEvent.Type.WindowDeactivate):
            self._put(False)
        if kind not in (QEvent.Type.KeyPress, QEvent.Type.KeyRelease) or not isinstance(event, QKeyEvent):
            return False
        if event.key() != Qt.Key.Key_Space or event.modifiers() != Qt.KeyboardModifier.NoModifier:
            return False
        if not event.isAutoRepeat():
            self._put(kind == QEvent.Type.KeyPress)
        return True

    def _put(self, down: bool) -> None:
        if down != self._down:
            self._down = down
            self.held.emit(down)
