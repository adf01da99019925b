"""An empty place that says what belongs there and offers to bring it."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtWidgets import QVBoxLayout, QWidget

from widgets import theme
from widgets.parts.buttons import KeyButton
from widgets.parts.section import DimLabel


class EmptyState(QWidget):
    """A heading, a sentence, and buttons that do it.

    Parameters
    ----------
    heading, sentence : str
        What is not there yet, and what belongs there.
    actions : sequence of (text, key, primary)
        The buttons; ``buttons`` holds them in this order.
    """

    def __init__(
        self,
        heading: str,
        sentence: str,
        actions: Sequence[tuple[str, str, bool]] = (),
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        column = QVBoxLayout(self)
        column.setContentsMargins(12, 12, 12, 12)
        column.setSpacing(8)
        column.addWidget(DimLabel(heading, role="text", bold=True))
        text = DimLabel(sentence)
        text.setWordWrap(True)
        column.addWidget(text)
        self.buttons = [KeyButton(label, key, primary=primary) for label, key, primary in actions]
        for button in self.buttons:
            column.addWidget(button)
        column.addStretch(1)
        self.setFont(theme.font())
