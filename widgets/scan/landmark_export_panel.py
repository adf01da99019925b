"""The content of the export dialog: which points the fiducials become, in a table, and what is lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QTableView,
    QVBoxLayout,
    QWidget,
)

from widgets import theme
from widgets.parts.buttons import KeyButton
from widgets.parts.command_line import CommandLine
from widgets.parts.section import DimLabel
from widgets.parts.segments import Segments
from widgets.parts.tables import ROW_HEIGHT

WIDTH, HEIGHT = 640, 560
HEADERS = ("point of the file", "fiducial", "x px", "y px")
Index = QModelIndex | QPersistentModelIndex
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


@dataclass(frozen=True)
class ExportRow:
    """One point of the file: its label, and the fiducial and pixels that it is written with; empty for a hole."""

    label: str
    fiducial: str = ""
    x: str = ""
    y: str = ""


class _Model(QAbstractTableModel):
    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows: tuple[ExportRow, ...] = ()

    def set_rows(self, rows: Sequence[ExportRow]) -> None:
        self.beginResetModel()
        self.rows = tuple(rows)
        self.endResetModel()

    def rowCount(self, parent: Index | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, _parent: Index | None = None) -> int:
        return len(HEADERS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return HEADERS[section]
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _RIGHT if section > 1 else _LEFT
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        row = self.rows[index.row()]
        if role == Qt.ItemDataRole.DisplayRole:
            return (row.label, row.fiducial or "-", row.x, row.y)[index.column()]
        if role == Qt.ItemDataRole.TextAlignmentRole and index.column() > 1:
            return _RIGHT
        if role == Qt.ItemDataRole.ForegroundRole and not row.fiducial:
            return theme.current().colour("dim")
        return None


class LandmarkExportPanel(QWidget):
    """Values in, wishes out.

    Signals
    -------
    mapping_chosen(str), origin_chosen(float), open_requested()
        How the points are to be named and counted.
    accepted(), rejected()
        Write the file, or think better of it.
    """

    mapping_chosen = Signal(str)
    origin_chosen = Signal(float)
    open_requested = Signal()
    accepted = Signal()
    rejected = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.mapping = QComboBox()
        self.mapping.setAccessibleName("Points")
        self.open_button = QPushButton("&Open...")
        self.open_button.setToolTip("Open a mapping (.toml or .json)")
        self.origin = Segments([("0", "0"), ("0.5", "1/2"), ("1", "1")], name="First pixel")
        self.origin.setToolTip("What the file is to call the centre of the top left pixel")
        self.table = QTableView()
        self.table.setAccessibleName("Points of the file")
        self._model = _Model(self)
        self.report = DimLabel("", theme.TABLE_PX, role="text")
        self.report.setWordWrap(True)
        self.command = CommandLine()
        self.cancel = KeyButton("Cancel", "Esc")
        self.accept = KeyButton("Export", primary=True)
        self.accept.setDefault(True)
        self._lay_out()
        self.mapping.activated.connect(lambda row: self.mapping_chosen.emit(str(self.mapping.itemData(row))))
        self.origin.chosen.connect(lambda key: self.origin_chosen.emit(float(key)))
        self.open_button.clicked.connect(self.open_requested)
        self.cancel.clicked.connect(self.rejected)
        self.accept.clicked.connect(self.accepted)
        theme.signals.changed.connect(self._dress)
        self._dress()

    def show_choice(self, mappings: Sequence[tuple[str, str]], mapping: str, origin: float) -> None:
        """Show the mappings as keys with texts, which one is chosen, and how pixels are counted."""
        self.mapping.clear()
        for key, text in mappings:
            self.mapping.addItem(text, key)
        self.mapping.setCurrentIndex(max(0, self.mapping.findData(mapping)))
        self.origin.set_current(f"{origin:g}")

    def show_rows(self, rows: Sequence[ExportRow]) -> None:
        """Show the points of the file."""
        self._model.set_rows(rows)

    def show_report(self, lines: Sequence[str], count: int, problem: str) -> None:
        """Say what is written and what is lost, or in ``problem`` why nothing can be."""
        self.report.set_role("captured" if problem else "text")
        self.report.setText(problem or "\n".join(lines))
        text = "Export 1 fiducial" if count == 1 else f"Export {count} fiducials"
        self.accept.setText(text)
        self.accept.setAccessibleName(text)
        self.accept.updateGeometry()
        self.accept.set_available(not problem, problem)

    def _lay_out(self) -> None:
        self.table.setModel(self._model)
        self.table.setShowGrid(False)
        self.table.setWordWrap(False)
        self.table.setAlternatingRowColors(True)
        self.table.setTabKeyNavigation(False)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.table.verticalHeader().hide()
        self.table.setStyleSheet("QTableView::item { padding: 0 8px; }")
        head = self.table.horizontalHeader()
        head.setHighlightSections(False)
        head.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        head.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        form = QGridLayout()
        form.setHorizontalSpacing(8)
        form.setVerticalSpacing(8)
        form.setColumnStretch(1, 1)
        for row, (text, buddy) in enumerate((("&Points", self.mapping), ("First pi&xel", self.origin))):
            label = QLabel(text)
            label.setBuddy(buddy)
            form.addWidget(label, row, 0)
        line = QHBoxLayout()
        line.setSpacing(8)
        line.addWidget(self.mapping, 1)
        line.addWidget(self.open_button)
        form.addLayout(line, 0, 1)
        form.addWidget(self.origin, 1, 1, Qt.AlignmentFlag.AlignLeft)
        foot = QHBoxLayout()
        foot.setSpacing(8)
        foot.addStretch(1)
        foot.addWidget(self.cancel)
        foot.addWidget(self.accept)
        box = QVBoxLayout(self)
        box.setContentsMargins(16, 16, 16, 16)
        box.setSpacing(8)
        box.addLayout(form)
        box.addWidget(self.table, 1)
        box.addWidget(self.report)
        box.addWidget(self.command)
        box.addSpacing(8)
        box.addLayout(foot)

    def _dress(self) -> None:
        self.table.verticalHeader().setDefaultSectionSize(theme.px(ROW_HEIGHT))
        for column, width in ((0, 148), (2, 84), (3, 84)):
            self.table.setColumnWidth(column, theme.px(width))
