"""What is said when the studio itself fails: in people's words first, the technical part below."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QPlainTextEdit, QPushButton, QVBoxLayout, QWidget

from widgets import theme
from widgets.parts.section import DimLabel

WIDTH, HEIGHT = 560, 380


class CrashPanel(QWidget):
    """What happened, that the work is kept, the report, and what can be done now.

    Parameters
    ----------
    what : str
        The fault in one line.
    kept : str
        What has become of the user's work.
    report : str
        Place of the report; empty where none could be written.
    details : str
        The report itself.

    Signals
    -------
    continued(), quit_requested(), save_requested(), copy_requested(), folder_requested()
        The buttons.
    """

    continued = Signal()
    quit_requested = Signal()
    save_requested = Signal()
    copy_requested = Signal()
    folder_requested = Signal()

    def __init__(self, what: str, kept: str, report: str, details: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        heading = DimLabel("Something went wrong in the studio", theme.NAME_PX, role="text", bold=True)
        words = DimLabel(
            "A step was not finished because of a fault in the program, not because of you. "
            f"{kept} You can go on; when the picture looks wrong, save under a new name and open it again.",
            role="text",
        )
        self.note = DimLabel(f"Report: {report}" if report else "The report could not be written; copy it instead.")
        self.note.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        for label in (words, self.note):
            label.setWordWrap(True)
        self.details = QPlainTextEdit(details)
        self.details.setReadOnly(True)
        self.details.setTabChangesFocus(True)
        self.details.setAccessibleName("Report")
        self.details.setFont(theme.font(theme.TABLE_PX))
        self.copy_button = QPushButton("Copy report")
        self.folder_button = QPushButton("Open folder")
        self.folder_button.setEnabled(bool(report))
        self.save_button = QPushButton("Save project as...")
        self.quit_button = QPushButton("Quit")
        self.continue_button = QPushButton("Continue")
        self.continue_button.setProperty("primary", True)
        self.continue_button.setDefault(True)
        box = QVBoxLayout(self)
        box.setContentsMargins(16, 16, 16, 16)
        box.setSpacing(8)
        box.addWidget(heading)
        box.addWidget(words)
        box.addWidget(DimLabel(what, theme.TABLE_PX, role="captured"))
        box.addWidget(self.details, 1)
        box.addWidget(self.note)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(self.copy_button)
        row.addWidget(self.folder_button)
        row.addStretch(1)
        for button in (self.save_button, self.quit_button, self.continue_button):
            row.addWidget(button)
        box.addLayout(row)
        self.copy_button.clicked.connect(self.copy_requested)
        self.folder_button.clicked.connect(self.folder_requested)
        self.save_button.clicked.connect(self.save_requested)
        self.quit_button.clicked.connect(self.quit_requested)
        self.continue_button.clicked.connect(self.continued)
        self.setFocusProxy(self.continue_button)

    def tell(self, text: str) -> None:
        """Say what came of a button."""
        self.note.setText(text)
