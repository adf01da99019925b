"""The line of a dialog that names the file, or the folder of the files, to be written."""

from __future__ import annotations

import os
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QLineEdit, QPushButton, QWidget

from widgets import theme


class PathField(QWidget):
    """A file name that can be typed or chosen; an ending that is missing is put behind it.

    Parameters
    ----------
    title, file_filter : str
        Of the file dialog; the endings in the filter are those that a name may have. Without a filter a folder is
        asked for.
    button : str
        What the button that asks says.

    Attributes
    ----------
    proposed : str
        Where the file dialog starts while nothing is typed.

    Signals
    -------
    changed(str)
        The text, as it is typed.
    """

    changed = Signal(str)

    def __init__(
        self, title: str, file_filter: str, parent: QWidget | None = None, *, button: str = "&Choose\u2026"
    ) -> None:
        super().__init__(parent)
        self.proposed = ""
        self._title, self._filter = title, file_filter
        self.field = QLineEdit(self)
        self.field.setAccessibleName("File")
        self.field.setMinimumWidth(theme.px(240))
        self.field.textChanged.connect(self.changed)
        self.button = QPushButton(button, self)
        self.button.setAutoDefault(False)
        self.button.clicked.connect(self.choose)
        self.setFocusProxy(self.field)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(4)
        row.addWidget(self.field, 1)
        row.addWidget(self.button)

    def path(self, ending: str) -> Path | None:
        """Return the file that is named, with ``ending`` where it has none of its own kind; None where none is."""
        path = self.folder()
        if path is None or not path.name or self.field.text().strip().endswith(("/", os.sep)):
            return None
        return path if path.suffix.lower() == ending else path.with_name(path.name + ending)

    def folder(self) -> Path | None:
        """Return the folder that is named; None where none is."""
        text = self.field.text().strip()
        if not text or "\0" in text:
            return None
        try:
            return Path(text).expanduser()
        except RuntimeError:  # ~ before a user nobody knows
            return Path(text)

    def set_path(self, path: Path) -> None:
        """Name a file."""
        self.field.setText(str(path))

    def choose(self) -> None:
        """Ask for the file; the dialog itself asks before one is replaced, so this does not."""
        start = self.field.text() or self.proposed
        if self._filter:
            chosen, _ = QFileDialog.getSaveFileName(
                self, self._title, start, self._filter, options=QFileDialog.Option.DontConfirmOverwrite
            )
        else:
            chosen = QFileDialog.getExistingDirectory(self, self._title, start)
        if chosen:
            self.field.setText(chosen)
