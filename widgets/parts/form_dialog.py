"""The frame of small dialogs: rows of a form, a line for what is wrong, buttons with the primary one at the right."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QFormLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from widgets import theme


class FormDialog(QDialog):
    """A window-modal dialog with a form; Esc cancels, Enter does what the primary button says.

    Parameters
    ----------
    title, verb : str
        Of the window and of the primary button.
    """

    def __init__(self, title: str, verb: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
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
        self.trouble.setStyleSheet(f"color: {theme.current().captured}")
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

    def add_row(self, text: str, field: QWidget) -> None:
        """Add a field under its name; an ampersand stands before the key that reaches it."""
        label = QLabel(text)
        label.setBuddy(field)
        self.form.addRow(label, field)

    def tell(self, problem: str) -> None:
        """Say what is wrong, or that nothing is where it is empty."""
        self.trouble.setText(problem)
        self.trouble.setVisible(bool(problem))
        self.adjustSize()
