"""What to do next about the basis: a sentence and the buttons that do it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget


@dataclass(frozen=True)
class AdviceItem:
    """One piece of advice.

    Parameters
    ----------
    text : str
        A sentence.
    level : str
        ``warn`` or ``info``.
    actions : tuple of (str, str)
        Key that ``action_requested`` sends, and what the button reads.
    tip : str
        Why.
    """

    text: str
    level: str = "warn"
    actions: tuple[tuple[str, str], ...] = ()
    tip: str = ""


class AdvicePanel(QWidget):
    """Pieces of advice, the weightiest first.

    Signals
    -------
    action_requested(str)
        Key of the action.
    """

    action_requested = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._items: tuple[AdviceItem, ...] = ()

    def set_advice(self, items: Sequence[AdviceItem] | None) -> None:
        """Show advice; none when all is well, ``None`` while there is no basis."""
        self._items = tuple(items or ())

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(296, 72)
