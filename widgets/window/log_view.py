"""The log as a list: time, what was said, coloured by gravity; filtered, copied, saved."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from datetime import datetime
from typing import Protocol

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor, QGuiApplication, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QAbstractItemView, QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from widgets import theme
from widgets.parts.buttons import IconButton
from widgets.parts.segments import Segments
from widgets.scan.canvas_panel import ToolRow

LIMIT = 2000
GRAVITY = {"info": 0, "warning": 1, "error": 2}
ROLES = {"info": "text", "warning": "stale_text", "error": "captured"}


class Line(Protocol):
    """A line as the log keeps it."""

    @property
    def time(self) -> datetime:
        """When it was said."""

    @property
    def word(self) -> str:
        """``info``, ``warning`` or ``error``."""

    @property
    def source(self) -> str:
        """Who said it."""

    @property
    def text(self) -> str:
        """What was said."""


class LogView(QWidget):
    """Tool row and list of lines, the newest at the bottom; it holds the last 2,000.

    Signals
    -------
    save_requested()
        All lines are to be written to a file.
    clear_requested()
        The lines that are kept are not wanted any more.
    """

    save_requested = Signal()
    clear_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self._lines: deque[Line] = deque(maxlen=LIMIT)
        self.levels = Segments([("info", "All"), ("warning", "Warnings"), ("error", "Errors")], name="Lines shown")
        self.levels.set_tip("warning", "Warnings and errors")
        self.copy_button = IconButton("copy", "Copy the marked lines, or all")
        self.save_button = IconButton("save", "Save the log...")
        self.clear_button = IconButton("trash", "Clear the list; the log file keeps its lines")
        self.list = _List(self)
        tools = ToolRow(self, line=True)
        tools.row.addWidget(self.levels)
        tools.row.addStretch(1)
        for button in (self.copy_button, self.save_button, self.clear_button):
            tools.row.addWidget(button)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(tools)
        column.addWidget(self.list, 1)
        self.levels.chosen.connect(self._refill)
        self.copy_button.clicked.connect(self.copy)
        self.list.copy_pressed.connect(self.copy)
        self.save_button.clicked.connect(self.save_requested)
        self.clear_button.clicked.connect(self.clear_requested)
        theme.signals.changed.connect(self._refill)

    def set_lines(self, lines: Iterable[Line]) -> None:
        """Show other lines."""
        self._lines.clear()
        self._lines.extend(lines)
        self._refill()

    def add(self, line: Line) -> None:
        """Show one more line; the list follows it where its end was in sight."""
        bar = self.list.verticalScrollBar()
        at_end = bar.value() >= bar.maximum() - 4
        self._lines.append(line)
        self._append(line)
        while self.list.count() > LIMIT:
            self.list.takeItem(0)
        if at_end:
            self.list.scrollToBottom()

    @property
    def shown(self) -> tuple[str, ...]:
        """The lines that the level lets through, as they are read."""
        return tuple(self.list.item(row).text() for row in range(self.list.count()))

    def copy(self) -> None:
        """Put the marked lines on the clipboard, or all that are shown."""
        marked = sorted(self.list.row(item) for item in self.list.selectedItems())
        rows = marked or range(self.list.count())
        texts = [str(self.list.item(row).data(Qt.ItemDataRole.UserRole)) for row in rows]
        QGuiApplication.clipboard().setText("\n".join(texts))

    def _refill(self) -> None:
        self.list.clear()
        for line in self._lines:
            self._append(line)
        self.list.scrollToBottom()

    def _append(self, line: Line) -> None:
        if GRAVITY[line.word] < GRAVITY[self.levels.current]:
            return
        first = line.text.strip().splitlines()[0] if line.text.strip() else ""
        item = QListWidgetItem(f"{line.time:%H:%M:%S}  {first}")
        item.setForeground(QColor(getattr(theme.current(), ROLES[line.word])))
        item.setToolTip(f"{line.word}, {line.source}\n{line.text}")
        item.setData(Qt.ItemDataRole.UserRole, str(line))
        self.list.addItem(item)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(446, 140)

    def minimumSizeHint(self) -> QSize:
        """Return the room for the tools and two lines."""
        return QSize(160, theme.px(32 + 44))


class _List(QListWidget):
    copy_pressed = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAccessibleName("Log")
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setUniformItemSizes(True)
        self.setStyleSheet("QListWidget::item { padding: 1px 8px; }")
        self.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            self.copy_pressed.emit()
        elif event.text().isalpha() or event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            event.ignore()
        else:
            super().keyPressEvent(event)
