"""A frame number that is typed: from 1, in groups of three, flat until the pointer or the keys come to it."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QSpinBox

from widgets import theme


class FrameField(QSpinBox):
    """A number of a frame.

    Parameters
    ----------
    name, tip : str
        Accessible name and tooltip.
    strong : bool
        Whether it is written in the heavier hand.
    """

    def __init__(self, name: str, tip: str = "", *, strong: bool = True) -> None:
        super().__init__()
        self.setRange(1, 1)
        self.setKeyboardTracking(False)
        self.setAccessibleName(name)
        self.setToolTip(tip)
        self.setProperty("flat", "strong" if strong else "plain")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.fit(1)

    def fit(self, largest: int) -> None:
        """Make it as wide as the largest number needs."""
        text = self.textFromValue(largest)
        theme.fix(self, width=round(10 + 7.6 * len(text) - 4 * text.count("\u00a0")))

    def show_value(self, value: int) -> None:
        """Show a number without telling anybody."""
        self.blockSignals(True)
        self.setValue(value)
        self.blockSignals(False)

    def textFromValue(self, value: int) -> str:
        """Return the number in groups of three."""
        return f"{value:,}".replace(",", "\u00a0")

    def valueFromText(self, text: str) -> int:
        """Return the number that was typed."""
        return int("".join(c for c in text if c.isdigit()) or self.value())

    def validate(self, text: str, place: int) -> Any:
        """Take digits and the spaces between groups."""
        state = QValidator.State
        good = all(c.isdigit() or c in "\u00a0 " for c in text)
        return ((state.Acceptable if text.strip() else state.Intermediate) if good else state.Invalid), text, place
