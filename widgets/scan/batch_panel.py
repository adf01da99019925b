"""Many scans fitted in one go: which, how, where the faces go; and what became of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QProgressBar,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from widgets import theme
from widgets.parts.command_line import CommandLine
from widgets.parts.path_field import PathField
from widgets.parts.tables import VERDICT_ROLES
from widgets.scan.region_table import WORDS

AS_SET = "as set for each scan"
LEVELS = 4
REPORT_FILTER = "Report (*.pdf)"


@dataclass(frozen=True)
class BatchRow:
    """A scan of the batch: ``ready`` when it can be fitted; ``text`` says what it lacks, does or became."""

    id: str
    name: str
    text: str
    ready: bool = True
    verdict: str = ""
    fraction: float | None = None


class BatchPanel(QWidget):
    """A table of scans over the options of the batch.

    Signals
    -------
    changed()
        A value was edited, a scan ticked or not.
    started(), cancelled(), closed()
        The buttons.
    """

    changed = Signal()
    started = Signal()
    cancelled = Signal()
    closed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._filling = False
        self._ids: list[str] = []
        self.table = QTableWidget(0, 3, self)
        self.table.setHorizontalHeaderLabels(["scan", "state", "verdict"])
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(theme.px(24))
        self.table.setAlternatingRowColors(True)
        self.table.setShowGrid(False)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setTabKeyNavigation(False)
        self.table.setAccessibleName("Scans of the batch")
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(2, QHeaderView.ResizeMode.ResizeToContents)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft)
        self.table.itemChanged.connect(self._edited)
        self.level = QComboBox()
        self.level.addItem(AS_SET, -1)
        for level in range(LEVELS):
            self.level.addItem(f"{level} for all", level)
        self.folder = PathField("Folder for the faces", "")
        self.folder.field.setPlaceholderText("no faces are written")
        self.report = PathField("Write report", REPORT_FILTER, button="C&hoose\u2026")
        self.report.field.setPlaceholderText("no report is written")
        self.format = QComboBox()
        self.format.addItems(["glb", "obj"])
        self.pattern = QLineEdit("{name}")
        self.pattern.setToolTip("{name}, {number}, {word} and {held} stand for those of each scan")
        self.command = CommandLine()
        self.bar = QProgressBar()
        self.bar.setTextVisible(False)
        self.bar.setMaximumHeight(4)
        self.note = QLabel("")
        self.note.setWordWrap(True)
        self.close_button, self.start_button = QPushButton("Close"), QPushButton("&Fit all")
        self.start_button.setProperty("primary", True)
        self.cancel_button = QPushButton("S&top")
        self._arrange()
        for signal in (self.level.currentIndexChanged, self.format.currentIndexChanged):
            signal.connect(self._edited)
        for field in (self.folder.field, self.report.field, self.pattern):
            field.textChanged.connect(self._edited)
        self.start_button.clicked.connect(self.started)
        self.cancel_button.clicked.connect(self.cancelled)
        self.close_button.clicked.connect(self.closed)
        self.set_running(False)

    def _arrange(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 16, 16, 16)
        column.setSpacing(8)
        column.addWidget(self.table, 1)
        column.addWidget(self.bar)
        grid = QGridLayout()
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(8)
        rows: tuple[tuple[str, QWidget], ...] = (
            ("&Level", self.level),
            ("Faces &to", self.folder),
            ("F&ormat", self.format),
            ("&Names", self.pattern),
            ("&Report", self.report),
            ("Command", self.command),
        )
        for row, (text, field) in enumerate(rows):
            label = QLabel(text)
            label.setBuddy(field)
            named = field.field if isinstance(field, PathField) else field
            named.setAccessibleName(text.replace("&", ""))
            grid.addWidget(label, row, 0)
            grid.addWidget(field, row, 1)
        grid.setColumnStretch(1, 1)
        column.addLayout(grid)
        column.addWidget(self.note)
        buttons = QHBoxLayout()
        buttons.setSpacing(8)
        buttons.addStretch(1)
        for last in (self.close_button, self.cancel_button, self.start_button):
            last.setAutoDefault(False)
            buttons.addWidget(last)
        self.start_button.setDefault(True)
        column.addLayout(buttons)

    def set_rows(self, rows: Sequence[BatchRow]) -> None:
        """Show the scans; ticks stay, and a scan that is new is ticked when it is ready."""
        self._filling = True
        ticked = {scan_id for scan_id in self._ids if scan_id in self.chosen()}
        known = set(self._ids)
        self._ids = [row.id for row in rows]
        self.table.setRowCount(len(rows))
        for number, row in enumerate(rows):
            self._put(number, row, row.ready and (row.id in ticked or row.id not in known))
        self._filling = False

    def set_row(self, row: BatchRow) -> None:
        """Show one scan anew."""
        if row.id in self._ids:
            number = self._ids.index(row.id)
            self._filling = True
            self._put(number, row, row.id in self.chosen())
            self._filling = False

    def chosen(self) -> tuple[str, ...]:
        """Return the ids of the scans that are ticked, in their order."""
        items = [(scan_id, self.table.item(row, 0)) for row, scan_id in enumerate(self._ids)]
        return tuple(i for i, item in items if item is not None and item.checkState() == Qt.CheckState.Checked)

    def set_running(self, running: bool) -> None:
        """Show that the batch runs: its options wait, it can be stopped."""
        for widget in (self.level, self.folder, self.format, self.pattern, self.report):
            widget.setEnabled(not running)
        self.start_button.setVisible(not running)
        self.cancel_button.setVisible(running)
        self.bar.setVisible(running)

    def set_progress(self, fraction: float) -> None:
        """Show how far the whole batch is, 0..1."""
        self.bar.setValue(round(100 * fraction))

    def show_note(self, text: str, *, trouble: bool = False) -> None:
        """Say something about the batch; as trouble it keeps it from being started."""
        self.note.setText(text)
        self.note.setStyleSheet(f"color: {getattr(theme.current(), 'captured' if trouble else 'dim')}")
        self.start_button.setEnabled(not trouble)

    def _put(self, number: int, row: BatchRow, ticked: bool) -> None:
        texts = (row.name, row.text, WORDS.get(row.verdict, ""))
        for column, text in enumerate(texts):
            item = self.table.item(number, column)
            if item is None:
                item = QTableWidgetItem()
                self.table.setItem(number, column, item)
            item.setText(text)
            item.setToolTip(text)
            flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
            if column == 0:
                item.setFlags(flags | Qt.ItemFlag.ItemIsUserCheckable if row.ready else Qt.ItemFlag.ItemIsSelectable)
                item.setCheckState(Qt.CheckState.Checked if ticked else Qt.CheckState.Unchecked)
            else:
                item.setFlags(flags)
            role = VERDICT_ROLES.get(row.verdict, "text") if column == 2 else "text" if row.ready else "dim"
            item.setForeground(QColor(getattr(theme.current(), role)))

    def _edited(self, *_values: object) -> None:
        if not self._filling:
            self.changed.emit()
