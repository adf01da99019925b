"""A small dialog that asks for one of several names."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QWidget

from widgets.parts.form_dialog import FormDialog


class ChoiceDialog(FormDialog):
    """A list of names under a title; the primary button says which one.

    Parameters
    ----------
    title, verb, label : str
        Of the window, of the primary button, and before the list.
    items : sequence of (str, str)
        What ``picked`` sends, and what is read.
    present : str, optional
        The one that is chosen at first.

    Signals
    -------
    picked(str)
        The user chose this one.
    """

    picked = Signal(str)

    def __init__(
        self,
        title: str,
        verb: str,
        label: str,
        items: Sequence[tuple[str, str]],
        present: str | None = None,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(title, verb, parent)
        self.setObjectName("choice")
        self.names = QComboBox()
        self.names.setMinimumContentsLength(24)
        for key, name in items:
            self.names.addItem(name, key)
        self.names.setCurrentIndex(max(0, self.names.findData(present)))
        self.add_row(label, self.names)
        self.primary.clicked.connect(self._pick)
        self.names.setFocus()

    def _pick(self) -> None:
        self.accept()
        self.picked.emit(str(self.names.currentData()))
