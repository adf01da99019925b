"""The basis stage without a rig: what belongs here, and a button that brings it."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from widgets import theme
from widgets.parts.buttons import KeyButton
from widgets.parts.section import DimLabel

_FIRST, _SECOND = "Open a hand-sculpted rig", "A GLB with morph targets, a folder of OBJ files, or an .npz"


class NoRig(QWidget):
    """Two lines and a button in the middle of an empty view.

    Signals
    -------
    open_requested()
    """

    open_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self._first, self._second = DimLabel(role="text", bold=True), DimLabel()
        self._second.setWordWrap(True)
        self.button = KeyButton("Open rig\u2026", primary=True)
        self.button.clicked.connect(self.open_requested)
        column = QVBoxLayout(self)
        column.setSpacing(8)
        column.addStretch(1)
        for label in (self._first, self._second):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
            column.addWidget(label)
        column.addSpacing(4)
        column.addWidget(self.button, 0, Qt.AlignmentFlag.AlignHCenter)
        column.addStretch(1)
        self.set_message()
        theme.signals.changed.connect(self._dress)
        self._dress()

    def set_message(self, first: str = _FIRST, second: str = _SECOND) -> None:
        """Write both lines."""
        self._first.setText(first)
        self._second.setText(second)

    def _dress(self) -> None:
        palette = self.palette()
        palette.setColor(self.backgroundRole(), theme.current().colour("view_bottom"))
        self.setPalette(palette)
