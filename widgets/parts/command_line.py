"""The command that does the same from a terminal: one line to read, select and copy."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from PySide6.QtCore import QPoint, QSize, Signal
from PySide6.QtGui import QFontDatabase, QGuiApplication
from PySide6.QtWidgets import QHBoxLayout, QLineEdit, QSizePolicy, QToolTip, QWidget

from widgets import theme
from widgets.parts.buttons import IconButton


class CommandLine(QWidget):
    """A read-only line that shows a command as a shell takes it, with a button that copies it.

    Dialogs set it anew whenever one of their values changes. While a value is missing or wrong they show no command
    but why there is none, and nothing can be copied.

    Signals
    -------
    copied(str)
        The command went to the clipboard.
    """

    copied = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._command = ""
        self.field = QLineEdit(self)
        self.field.setReadOnly(True)
        self.field.setAccessibleName("Command line")
        self.field.setMinimumWidth(160)
        self.button = IconButton("copy", "Copy the command", parent=self)
        self.button.clicked.connect(self.copy)
        self.setFocusProxy(self.field)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(4)
        row.addWidget(self.field, 1)
        row.addWidget(self.button)
        theme.signals.changed.connect(self._dress)
        self._dress()
        self.set_command("", "")

    @property
    def command(self) -> str:
        """The command as it would be copied; empty while there is none."""
        return self._command

    def set_command(self, command: str | Sequence[str], missing: str = "") -> None:
        """Show a command, as words or as one line that is quoted already; where it is empty, show why: ``missing``."""
        self._command = command if isinstance(command, str) else shlex.join(command)
        self.field.setPlaceholderText(missing)
        self.field.setText(self._command)
        self.field.setCursorPosition(0)
        self.field.setToolTip(self._command or missing)
        self.button.set_available(bool(self._command), missing)

    def copy(self) -> None:
        """Put the command on the clipboard."""
        if self._command:
            QGuiApplication.clipboard().setText(self._command)
            QToolTip.showText(self.button.mapToGlobal(QPoint(0, self.button.height())), "Copied", self.button)
            self.copied.emit(self._command)

    def sizeHint(self) -> QSize:
        """Return room for a command of some length; a longer one is scrolled."""
        return QSize(420, max(super().sizeHint().height(), 24))

    def _dress(self) -> None:
        fixed = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
        fixed.setPixelSize(theme.font(theme.TABLE_PX).pixelSize())
        self.field.setFont(fixed)
        # The application's style sheet names a size for every widget, which would win over the font's.
        self.field.setStyleSheet(f'font-family: "{fixed.family()}"; font-size: {fixed.pixelSize()}px;')
