"""The table of a clip's markers: how often each is seen, how far it sits from the face, what it is taken for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    Qt,
    Signal,
)
from PySide6.QtGui import QBrush, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

from widgets import theme
from widgets.basis.motion_import_values import FAR_MM, TrackRow
from widgets.parts.tables import ROW_HEIGHT

HEADERS = ("marker", "seen %", "to face mm", "role")
SELDOM = 0.9
LABEL, SEEN, AWAY, ROLE = range(4)
Index = QModelIndex | QPersistentModelIndex


class TracksModel(QAbstractTableModel):
    """The rows of the table; it changes nothing by itself."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows: tuple[TrackRow, ...] = ()

    def set_rows(self, rows: Sequence[TrackRow]) -> None:
        """Show other rows; a selection stays where the labels are the same."""
        same = [row.label for row in rows] == [row.label for row in self.rows]
        if not same:
            self.beginResetModel()
        self.rows = tuple(rows)
        if same and rows:
            self.dataChanged.emit(self.index(0, 0), self.index(len(rows) - 1, ROLE))
        elif not same:
            self.endResetModel()

    def rowCount(self, parent: Index | None = None) -> int:
        """Return how many markers there are."""
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, _parent: Index | None = None) -> int:
        """Return four: marker, seen, distance, role."""
        return len(HEADERS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return the header's text."""
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return HEADERS[section]
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.TextAlignmentRole:
            right = Qt.AlignmentFlag.AlignRight if section in (SEEN, AWAY) else Qt.AlignmentFlag.AlignLeft
            return right | Qt.AlignmentFlag.AlignVCenter
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return text, colour, alignment or tip of a cell."""
        row, column = self.rows[index.row()], index.column()
        if role == Qt.ItemDataRole.DisplayRole:
            away = "" if math.isnan(row.distance_mm) else f"{row.distance_mm:.1f}"
            return (row.label, f"{100 * row.seen:.1f}", away, row.role)[column]
        if role == Qt.ItemDataRole.TextAlignmentRole and column in (SEEN, AWAY):
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        if role == Qt.ItemDataRole.ForegroundRole:
            doubtful = (column == SEEN and row.seen < SELDOM) or (column == AWAY and row.distance_mm > FAR_MM)
            quiet = row.role == "unused" or (column == ROLE and row.role == "face")
            shown = "stale_text" if doubtful else "dim" if quiet else "text"
            return QBrush(theme.current().colour(shown))
        if role == Qt.ItemDataRole.ToolTipRole and column == AWAY and row.distance_mm > FAR_MM:
            return f"More than {FAR_MM:g} mm from the face: a wrong unit, place or pair?"
        if role == Qt.ItemDataRole.ToolTipRole and column == ROLE:
            return "Space or double click: face or head"
        return None


class TracksTable(QTableView):
    """Rows of 20 px; several may be selected.

    Signals
    -------
    toggled(tuple)
        Rows whose role the user wants turned from face to head or back.
    chosen(tuple)
        Rows that are selected now.
    """

    toggled = Signal(tuple)
    chosen = Signal(tuple)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.tracks = TracksModel(self)
        self.setModel(self.tracks)
        self.setAccessibleName("Markers")
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setTabKeyNavigation(False)
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        header.setSectionResizeMode(LABEL, QHeaderView.ResizeMode.Stretch)
        self.doubleClicked.connect(lambda index: self.toggled.emit((index.row(),)))
        self.selectionModel().selectionChanged.connect(self._tell)
        theme.signals.changed.connect(self._fit)
        self._fit()

    def show_rows(self, rows: Sequence[TrackRow]) -> None:
        """Show other rows."""
        self.tracks.set_rows(rows)

    def selected(self) -> tuple[int, ...]:
        """Return the selected rows."""
        return tuple(sorted(index.row() for index in self.selectionModel().selectedRows()))

    def select(self, row: int) -> None:
        """Select one row and bring it into sight."""
        index = self.tracks.index(row, 0)
        flags = QItemSelectionModel.SelectionFlag
        self.selectionModel().setCurrentIndex(index, flags.ClearAndSelect | flags.Rows)
        self.scrollTo(index)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Turn the role of the selected rows with the space bar."""
        if event.key() == Qt.Key.Key_Space and self.selected():
            self.toggled.emit(self.selected())
            return
        super().keyPressEvent(event)

    def _tell(self, _now: QItemSelection, _before: QItemSelection) -> None:
        self.chosen.emit(self.selected())

    def _fit(self) -> None:
        self.setFont(theme.font(theme.TABLE_PX))
        self.horizontalHeader().setFont(theme.font(theme.TABLE_PX))
        self.verticalHeader().setDefaultSectionSize(theme.px(ROW_HEIGHT))
        for column, width in ((SEEN, 60), (AWAY, 84), (ROLE, 64)):
            self.setColumnWidth(column, theme.px(width))
