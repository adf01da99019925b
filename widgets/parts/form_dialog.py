"""The frame of small dialogs: rows of a form, a line for what is wrong, buttons with the primary one at the right."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QFormLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from engine.errors import InputError
from widgets import theme

LONGEST = 60
"""So many letters of a name that cannot be are shown."""


class FormDialog(QDialog):
    """A window-modal dialog with a form; Esc cancels, Enter does what the primary button says.

    Parameters
    ----------
    title, verb : str
        Of the window and of the primary button.
    """

    def __init__(self, title: str, verb: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._verb = verb
        self._agreed: tuple[Path, ...] = ()
        self.setWindowTitle(title)
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.form = QFormLayout()
        self.form.setHorizontalSpacing(16)
        self.form.setVerticalSpacing(8)
        self.form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self.form.setLabelAlignment(Qt.AlignmentFlag.AlignLeft)
        self.trouble = QLabel("")
        self.trouble.setWordWrap(True)
        self.trouble.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.trouble.hide()
        self.primary = QPushButton(verb)
        self.primary.setProperty("primary", True)
        self.primary.setDefault(True)
        self.cancel = QPushButton("Cancel")
        self.cancel.setAutoDefault(False)
        self.cancel.clicked.connect(self.reject)
        self.buttons = QHBoxLayout()
        self.buttons.setSpacing(8)
        self.buttons.addStretch(1)
        self.buttons.addWidget(self.cancel)
        self.buttons.addWidget(self.primary)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 16, 16, 16)
        column.setSpacing(16)
        column.addLayout(self.form)
        column.addWidget(self.trouble)
        column.addStretch(1)
        column.addLayout(self.buttons)
        theme.signals.changed.connect(self._tint)
        self._tint()

    def add_row(self, text: str, field: QWidget) -> None:
        """Add a field under its name; an ampersand stands before the key that reaches it."""
        label = QLabel(text)
        label.setBuddy(field)
        self.form.addRow(label, field)

    def may_replace(self, files: Sequence[Path]) -> bool:
        """Return whether files may be written: those that are there only once the button said so and was pressed."""
        try:
            there = tuple(file for file in files if file.exists())
        except OSError as error:
            name = Path(str(error.filename or files[0])).name
            subject = name if len(name) <= LONGEST else f"{name[:LONGEST]}\u2026"
            self.tell(
                str(InputError(subject, f"cannot be written ({error.strerror})", "choose another name or folder"))
            )
            return False
        if not there or there == self._agreed:
            return True
        self._agreed = there
        names = ", ".join(file.name for file in there)
        self.tell(f"{names} {'is' if len(there) == 1 else 'are'} already there.")
        self.primary.setText("Replace")
        return False

    def forget(self, _value: object = None) -> None:
        """Take back what was said and agreed: a value has changed."""
        self._agreed = ()
        self.tell("")
        self.primary.setText(self._verb)

    def tell(self, problem: str) -> None:
        """Say what is wrong, or that nothing is where it is empty."""
        self.trouble.setText(problem)
        self.trouble.setVisible(bool(problem))
        self.adjustSize()

    def _tint(self) -> None:
        self.trouble.setStyleSheet(f"color: {theme.current().captured}")
