"""The fiducials of a scheme as a table that is typed into: order, name, group, side, mirror, vertex, hint."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, QPointF, Qt, Signal
from PySide6.QtGui import QKeyEvent, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QHeaderView,
    QLineEdit,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from engine.landmarks import LandmarkDefinition, Side
from engine.scheme_checks import Finding
from widgets import theme
from widgets.parts.tables import paint_row

FIELDS = ("order", "name", "group", "side", "mirror", "vertex", "hint")
ORDER, NAME, GROUP, SIDE, MIRROR, VERTEX, HINT = range(len(FIELDS))
WIDTHS = {ORDER: 40, NAME: 142, GROUP: 80, SIDE: 58, MIRROR: 142, VERTEX: 54}
_SOFT = (NAME, GROUP, MIRROR)
SHORTEST_HINT = 40
NO_MIRROR = "–"
Index = QModelIndex | QPersistentModelIndex


class SchemeModel(QAbstractTableModel):
    """The rows of a draft, each with the findings about it."""

    edited = Signal(int, str, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.marks: tuple[LandmarkDefinition, ...] = ()
        self.vertices: tuple[int | None, ...] = ()
        self.findings: dict[int, list[Finding]] = {}
        self.read_only = False

    def show(
        self,
        marks: Sequence[LandmarkDefinition],
        vertices: Sequence[int | None],
        findings: Sequence[Finding],
        read_only: bool,
    ) -> None:
        """Take other values; rows are only rebuilt when their number changes."""
        rebuilt = len(marks) != len(self.marks)
        if rebuilt:
            self.beginResetModel()
        self.marks, self.vertices, self.read_only = tuple(marks), tuple(vertices), read_only
        self.findings = {}
        for finding in findings:
            if finding.row is not None:
                self.findings.setdefault(finding.row, []).append(finding)
        if rebuilt:
            self.endResetModel()
        elif marks:
            self.dataChanged.emit(self.index(0, 0), self.index(len(marks) - 1, HINT))

    def rowCount(self, parent: Index | None = None) -> int:
        """Return how many fiducials there are."""
        return 0 if parent is not None and parent.isValid() else len(self.marks)

    def columnCount(self, _parent: Index | None = None) -> int:
        """Return one for every field."""
        return len(FIELDS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return the name of a field."""
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return "" if section == ORDER else FIELDS[section]
        return None

    def wrong(self, row: int, column: int) -> Finding | None:
        """Return what is wrong with a cell."""
        return next((f for f in self.findings.get(row, ()) if f.field == FIELDS[column]), None)

    def text(self, row: int, column: int) -> str:
        """Return what a cell reads."""
        mark = self.marks[row]
        if column == ORDER:
            return str(row + 1)
        if column == VERTEX:
            number = self.vertices[row] if mark.vertex is None else mark.vertex
            return "" if number is None else str(number)
        if column == MIRROR:
            return mark.mirror or NO_MIRROR
        return str(getattr(mark, FIELDS[column]))

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return text, and as a tooltip what is wrong."""
        row, column = index.row(), index.column()
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return self.text(row, column)
        if role in (Qt.ItemDataRole.ToolTipRole, Qt.ItemDataRole.AccessibleDescriptionRole):
            texts = [finding.text for finding in self.findings.get(row, ())]
            return "\n".join(texts) or (self.marks[row].hint if column == HINT else "")
        return None

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Return that everything but the order can be edited."""
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        return flags if self.read_only or index.column() == ORDER else flags | Qt.ItemFlag.ItemIsEditable

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Ask for another value; the table changes when the draft has."""
        text = str(value).strip()
        if role != Qt.ItemDataRole.EditRole or text == self.text(index.row(), index.column()):
            return False
        self.edited.emit(index.row(), FIELDS[index.column()], "" if text == NO_MIRROR else text)
        return True


class _Delegate(QStyledItemDelegate):
    def __init__(self, table: SchemeTable) -> None:
        super().__init__(table)
        self._table = table

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, index: Index) -> QWidget:
        model, choices = self._table.model(), ()  # type: tuple[SchemeModel, Sequence[str]]
        if index.column() == SIDE:
            choices = [str(side) for side in Side]
        elif index.column() == MIRROR:
            choices = [NO_MIRROR, *(mark.name for mark in model.marks)]
        if choices:
            box = QComboBox(parent)
            box.addItems(list(choices))
            box.activated.connect(lambda _index: self._leave(box))
            return box
        field = QLineEdit(parent)
        low, letters = theme.px(16), theme.px(theme.TABLE_PX)
        field.setStyleSheet(
            f"min-height: {low}px; max-height: {low + 2}px; padding: 0 2px; border-radius: 0; font-size: {letters}px;"
        )
        return field

    def _leave(self, box: QComboBox) -> None:
        self.commitData.emit(box)
        self.closeEditor.emit(box)

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        if isinstance(editor, QComboBox):
            editor.setCurrentText(str(index.data()))
        elif isinstance(editor, QLineEdit):
            editor.setText(str(index.data()))

    def setModelData(self, editor: QWidget, model: Any, index: Index) -> None:
        text = editor.currentText() if isinstance(editor, QComboBox) else editor.text()  # type: ignore[attr-defined]
        model.setData(index, text)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        table, current = self._table, theme.current()
        model, rect = table.model(), option.rect
        row, column = index.row(), index.column()
        chosen = row == table.currentIndex().row()
        paint_row(painter, rect, row, chosen)
        wrong = model.wrong(row, column)
        if column == ORDER:
            if chosen and table.hasFocus():
                painter.fillRect(rect.left(), rect.top(), 2, rect.height(), current.colour("accent"))
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            is_wrong = any(finding.is_error for finding in model.findings.get(row, ()))
            colour = current.colour("captured") if is_wrong else current.side(model.marks[row].side)
            painter.setPen(QPen(colour, 1.8))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawEllipse(QPointF(rect.left() + theme.px(12), rect.center().y() + 0.5), 3.6, 3.6)
        elif wrong is not None:
            painter.fillRect(rect.adjusted(0, rect.height() - 2, -4, 0), current.colour("captured"))
        if table.hasFocus() and index == table.currentIndex() and column != ORDER:
            painter.setPen(current.colour("accent"))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(rect.adjusted(-3, 0, -5, -1))
        faint = column in (ORDER, SIDE, HINT) and not chosen
        painter.setPen(current.colour("dim" if faint else "text"))
        painter.setFont(theme.font(theme.TABLE_PX))
        right = column in (ORDER, VERTEX)
        align = Qt.AlignmentFlag.AlignVCenter | (Qt.AlignmentFlag.AlignRight if right else Qt.AlignmentFlag.AlignLeft)
        room = rect.adjusted(0, 0, -8, 0)
        text = painter.fontMetrics().elidedText(str(index.data()), Qt.TextElideMode.ElideRight, room.width())
        painter.drawText(room, align, text)


class SchemeTable(QTableView):
    """Rows in clicking order; typing into a cell, or Return on it, edits it.

    Signals
    -------
    selected(int)
        The user chose a row.
    edited(int, str, str)
        Another text for a field of a row.
    move_requested(int)
        The chosen row is to go so many places down (Alt+Up, Alt+Down).
    delete_requested()
        The chosen row is to go (Del).
    """

    selected = Signal(int)
    edited = Signal(int, str, str)
    move_requested = Signal(int)
    delete_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("Fiducials of the scheme")
        self._model, self._quiet = SchemeModel(self), False
        self.setModel(self._model)
        self.setItemDelegate(_Delegate(self))
        self._model.edited.connect(self.edited)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        triggers = QAbstractItemView.EditTrigger
        self.setEditTriggers(triggers.DoubleClicked | triggers.EditKeyPressed | triggers.AnyKeyPressed)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.verticalHeader().hide()
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        header = self.horizontalHeader()
        header.setSectionsClickable(False)
        header.setHighlightSections(False)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        header.setMinimumSectionSize(20)
        for column in WIDTHS:
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
        header.setSectionResizeMode(HINT, QHeaderView.ResizeMode.Stretch)
        self.selectionModel().currentChanged.connect(self._on_current)
        theme.signals.changed.connect(self._dress)
        self._dress()

    def model(self) -> SchemeModel:
        """Return the rows."""
        return self._model

    def show_draft(
        self,
        marks: Sequence[LandmarkDefinition],
        vertices: Sequence[int | None],
        findings: Sequence[Finding],
        row: int,
        read_only: bool,
    ) -> None:
        """Show the rows of a draft and mark one, without telling anybody."""
        self._quiet = True
        self._model.show(marks, vertices, findings, read_only)
        if 0 <= row < len(marks) and row != self.currentIndex().row():
            self.setCurrentIndex(self._model.index(row, max(self.currentIndex().column(), NAME)))
        self._quiet = False
        self.viewport().update()

    def edit_field(self, row: int, field: str) -> None:
        """Open a cell for typing."""
        index = self._model.index(row, FIELDS.index(field))
        self.setCurrentIndex(index)
        self.setFocus()
        self.edit(index)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the row with Alt and the arrows, delete it with Del, edit the cell with Return."""
        alt = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
        if alt and event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self.move_requested.emit(-1 if event.key() == Qt.Key.Key_Up else 1)
        elif event.key() in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace):
            self.delete_requested.emit()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            # A field that is left by Return passes the key on to here.
            if self.state() != QAbstractItemView.State.EditingState and not self._model.read_only:
                self.edit(self.currentIndex())
        else:
            super().keyPressEvent(event)

    def _on_current(self, index: QModelIndex) -> None:
        self.viewport().update()
        if index.isValid() and not self._quiet:
            self.selected.emit(index.row())

    def _dress(self) -> None:
        self.verticalHeader().setMinimumSectionSize(theme.px(20))
        self.verticalHeader().setDefaultSectionSize(theme.px(20))
        self._share_room()
        self.viewport().update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Share the room: where it is short, names give some up, and no number is ever out of sight."""
        super().resizeEvent(event)
        self._share_room()

    def _share_room(self) -> None:
        firm = sum(theme.px(width) for column, width in WIDTHS.items() if column not in _SOFT)
        soft = sum(theme.px(WIDTHS[column]) for column in _SOFT)
        share = min(1.0, max(0.3, (self.viewport().width() - firm - theme.px(SHORTEST_HINT)) / soft))
        for column, width in WIDTHS.items():
            self.setColumnWidth(column, int(theme.px(width) * (share if column in _SOFT else 1.0)))
