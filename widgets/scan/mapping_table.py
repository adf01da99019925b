"""The table of a mapping: which point of a file makes which fiducial, typed, picked from a list, or clicked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    Qt,
    QTimer,
    Signal,
)
from PySide6.QtGui import QBrush, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QComboBox, QHeaderView, QStyledItemDelegate, QTableView, QWidget

from engine.landmarks import Side
from widgets import theme
from widgets.parts.tables import ROW_HEIGHT

NAME, SOURCE, STATE = range(3)
HEADERS = ("fiducial", "point of the file", "state")
Index = QModelIndex | QPersistentModelIndex

ROLES = {"ok": "fresh_text", "on a hole": "stale_text", "outside": "captured", "hidden": "captured"}
"""Colour roles of the states; the others are dim."""


@dataclass(frozen=True)
class MappingRow:
    """One fiducial: its name, side and hint, the file's points as they are typed, and where it falls."""

    name: str
    side: Side
    source: str = ""
    state: str = ""
    hint: str = ""


class MappingModel(QAbstractTableModel):
    """The rows; an edited source is asked for, and shown once it is accepted.

    Signals
    -------
    edited(str, str)
        A fiducial, and the points that the user typed for it.
    """

    edited = Signal(str, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows: tuple[MappingRow, ...] = ()

    def set_rows(self, rows: Sequence[MappingRow]) -> None:
        """Show other rows; a selection stays where the names are the same."""
        same = [row.name for row in rows] == [row.name for row in self.rows]
        if not same:
            self.beginResetModel()
        self.rows = tuple(rows)
        if same:
            self.dataChanged.emit(self.index(0, 0), self.index(len(rows) - 1, STATE))
        else:
            self.endResetModel()

    def rowCount(self, parent: Index | None = None) -> int:
        """Return how many fiducials the scheme has."""
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, _parent: Index | None = None) -> int:
        """Return three: fiducial, point, state."""
        return len(HEADERS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return the header's text."""
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return HEADERS[section]
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return text, colour, tooltip, or what a screen reader says."""
        row, column = self.rows[index.row()], index.column()
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return (row.name, row.source, row.state)[column]
        if role == Qt.ItemDataRole.ForegroundRole and column == STATE:
            return QBrush(theme.current().colour(ROLES.get(row.state, "dim")))
        if role == Qt.ItemDataRole.ToolTipRole:
            return row.hint if column == NAME else f"{row.source or 'no point'}: {row.state}"
        if role == Qt.ItemDataRole.AccessibleTextRole:
            return f"{row.name}, {row.source or 'no point'}, {row.state}"
        return None

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Return that the points can be edited."""
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        return flags | Qt.ItemFlag.ItemIsEditable if index.column() == SOURCE else flags

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Ask for other points."""
        row, text = self.rows[index.row()], str(value).strip()
        if role != Qt.ItemDataRole.EditRole or text == row.source:
            return False
        self.edited.emit(row.name, text)
        return True


class _Chooser(QStyledItemDelegate):
    """Types points, or picks one of the file's."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.labels: tuple[str, ...] = ()
        self._open: QComboBox | None = None
        self.closeEditor.connect(self._forget)

    def createEditor(self, parent: QWidget, _option: Any, _index: Index) -> QWidget:
        box = QComboBox(parent)
        box.setEditable(True)
        box.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        box.addItems(["", *self.labels])
        # Enter in the field says so too, and is dealt with already once the timer runs; a pick from the list is not.
        box.activated.connect(lambda _row: QTimer.singleShot(0, box, lambda: self._done(box)))
        self._open = box
        return box

    def _done(self, box: QComboBox) -> None:
        if self._open is box:
            self.commitData.emit(box)
            self.closeEditor.emit(box, QStyledItemDelegate.EndEditHint.NoHint)

    def _forget(self) -> None:
        self._open = None

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        if isinstance(editor, QComboBox):
            editor.setCurrentText(str(index.data(Qt.ItemDataRole.EditRole)))
            line = editor.lineEdit()
            if line is not None:
                line.selectAll()

    def setModelData(self, editor: QWidget, model: Any, index: Index) -> None:
        if isinstance(editor, QComboBox):
            model.setData(index, editor.currentText(), Qt.ItemDataRole.EditRole)


class MappingTable(QTableView):
    """Fiducials with the points that make them; Del leaves one out, Enter or F2 types.

    Signals
    -------
    edited(str, str)
        A fiducial, and the points that the user wants; empty to leave it out.
    chosen(str)
        The fiducial whose row is selected.
    """

    edited = Signal(str, str)
    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("mapping_table")
        self.setAccessibleName("Fiducials and the points that make them")
        self.rows = MappingModel(self)
        self._chooser = _Chooser(self)
        self.setModel(self.rows)
        self.setItemDelegateForColumn(SOURCE, self._chooser)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(
            QAbstractItemView.EditTrigger.DoubleClicked
            | QAbstractItemView.EditTrigger.EditKeyPressed
            | QAbstractItemView.EditTrigger.AnyKeyPressed
        )
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setTabKeyNavigation(False)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        head = self.horizontalHeader()
        head.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        head.setSectionResizeMode(SOURCE, QHeaderView.ResizeMode.Stretch)
        head.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        head.setHighlightSections(False)
        self.verticalHeader().hide()
        self.setStyleSheet("QTableView::item { padding: 0 8px; }")
        self.rows.edited.connect(self.edited)
        self.selectionModel().currentRowChanged.connect(self._tell)
        theme.signals.changed.connect(self._dress)
        self._dress()

    def _dress(self) -> None:
        self.verticalHeader().setDefaultSectionSize(theme.px(ROW_HEIGHT))
        self.setColumnWidth(NAME, theme.px(148))
        self.setColumnWidth(STATE, theme.px(84))

    @property
    def current(self) -> str | None:
        """The fiducial whose row is selected."""
        row = self.currentIndex().row()
        return self.rows.rows[row].name if 0 <= row < len(self.rows.rows) else None

    def set_rows(self, rows: Sequence[MappingRow]) -> None:
        """Show other rows."""
        self.rows.set_rows(rows)

    def set_labels(self, labels: Sequence[str]) -> None:
        """Say which points can be picked from the list."""
        self._chooser.labels = tuple(labels)

    def choose(self, name: str) -> None:
        """Select the row of a fiducial."""
        names = [row.name for row in self.rows.rows]
        if name in names:
            index = self.rows.index(names.index(name), SOURCE)
            flags = QItemSelectionModel.SelectionFlag.ClearAndSelect | QItemSelectionModel.SelectionFlag.Rows
            self.selectionModel().setCurrentIndex(index, flags)
            self.scrollTo(index)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Leave the selected fiducial out with Del, type with Enter; Escape belongs to the dialog."""
        name = self.current
        editing = self.state() == QAbstractItemView.State.EditingState
        if name is not None and not editing and event.key() in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace):
            self.edited.emit(name, "")
        elif name is not None and not editing and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.edit(self.rows.index(self.currentIndex().row(), SOURCE))
        else:
            super().keyPressEvent(event)

    def _tell(self, current: QModelIndex, _previous: QModelIndex) -> None:
        if current.isValid():
            self.chosen.emit(self.rows.rows[current.row()].name)
