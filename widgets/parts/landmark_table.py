"""The table of the fiducials: mark, name, x and y in pixels, the one whose turn it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QEvent, QModelIndex, QPersistentModelIndex, QPointF, QRect, Qt, Signal
from PySide6.QtGui import (
    QFocusEvent,
    QFontMetrics,
    QGuiApplication,
    QKeyEvent,
    QKeySequence,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QValidator,
)
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLineEdit,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from engine.landmarks import Landmark, LandmarkScheme, LandmarkSet, LandmarkState
from widgets import theme
from widgets.parts import picture
from widgets.parts.glyphs import draw_landmark
from widgets.parts.tables import paint_header, paint_row

MARK, NAME, X, Y = range(4)
HEADERS = ("", "name", "x px", "y px")
WIDTHS = {MARK: 28, X: 72, Y: 64}
NARROW = 270
Index = QModelIndex | QPersistentModelIndex


class LandmarkModel(QAbstractTableModel):
    """The rows: every landmark of a scheme in its order, or only those that are proposed."""

    edited = Signal(str, float, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.scheme: LandmarkScheme | None = None
        self.landmarks = LandmarkSet({})
        self.proposed_only = False
        self.vertices: Mapping[str, int] = {}
        self.names: tuple[str, ...] = ()

    def show(self, scheme: LandmarkScheme | None, landmarks: LandmarkSet, proposed_only: bool) -> None:
        """Take other values; rows are only rebuilt when their names change."""
        self.scheme, self.landmarks, self.proposed_only = scheme, landmarks, proposed_only
        names = () if scheme is None else scheme.names
        if proposed_only:
            names = landmarks.names(LandmarkState.PROPOSED, order=names)
        if names != self.names:
            self.beginResetModel()
            self.names = names
            self.endResetModel()
        elif names:
            self.dataChanged.emit(self.index(0, 0), self.index(len(names) - 1, Y))

    def rowCount(self, parent: Index | None = None) -> int:
        """Return how many landmarks are listed."""
        return 0 if parent is not None and parent.isValid() else len(self.names)

    def columnCount(self, _parent: Index | None = None) -> int:
        """Return four: mark, name, x, y."""
        return len(HEADERS)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return the header's text with its unit."""
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return HEADERS[section]
        return None

    def point(self, row: int) -> Landmark:
        """Return the landmark of a row."""
        return self.landmarks[self.names[row]]

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return text, tooltip or the words a screen reader says."""
        name, point = self.names[index.row()], self.point(index.row())
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            if index.column() == NAME:
                return name
            if index.column() in (X, Y) and point.is_set:
                return f"{point.x if index.column() == X else point.y:.1f}"
            return "skipped" if index.column() == Y and point.state is LandmarkState.SKIPPED else ""
        if role == Qt.ItemDataRole.ToolTipRole and self.scheme is not None:
            vertex = f", vertex {self.vertices[name]}" if name in self.vertices else ""
            return f"{name}, {_state_word(point)}{vertex}\n{self.scheme[name].hint}"
        if role == Qt.ItemDataRole.AccessibleTextRole:
            return f"{name}, {_state_word(point)}"
        return None

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Return that x and y of a set, unlocked landmark can be edited."""
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        point = self.point(index.row())
        if index.column() in (X, Y) and point.is_set and not point.locked:
            flags |= Qt.ItemFlag.ItemIsEditable
        return flags

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Ask for another place; the table changes when the project has."""
        try:
            number = float(str(value).replace(",", "."))
        except ValueError:
            return False
        point = self.point(index.row())
        old = point.x if index.column() == X else point.y
        if role != Qt.ItemDataRole.EditRole or abs(number - old) < 0.05:
            return False
        x, y = (number, point.y) if index.column() == X else (point.x, number)
        self.edited.emit(self.names[index.row()], x, y)
        return True


def _state_word(point: Landmark) -> str:
    return f"{point.state}, locked" if point.locked else str(point.state)


class _Number(QValidator):
    def validate(self, text: str, position: int) -> Any:
        allowed = text.strip().replace(",", ".")
        if allowed in ("", "-", "."):
            return QValidator.State.Intermediate, text, position
        try:
            fits = abs(float(allowed)) < 1e6
            return (QValidator.State.Acceptable if fits else QValidator.State.Invalid), text, position
        except ValueError:
            return QValidator.State.Invalid, text, position


class _Delegate(QStyledItemDelegate):
    def __init__(self, table: LandmarkTable) -> None:
        super().__init__(table)
        self._table = table

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, _index: Index) -> QWidget:
        editor = QLineEdit(parent)
        editor.setValidator(_Number(editor))
        editor.setFont(theme.font(theme.TABLE_PX))
        editor.setAlignment(Qt.AlignmentFlag.AlignRight)
        low, high, letters = theme.px(16), theme.px(18), theme.px(theme.TABLE_PX)
        editor.setStyleSheet(
            f"min-height: {low}px; max-height: {high}px; padding: 0 2px; border-radius: 0; font-size: {letters}px;"
        )
        return editor

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        table = self._table
        name, point = table.model().names[index.row()], table.model().point(index.row())
        current = theme.current()
        chosen = name == table.current
        rect = option.rect
        paint_row(painter, rect, index.row(), chosen)
        if index.column() == MARK:
            if chosen and table.hasFocus():
                painter.fillRect(rect.left(), rect.top(), 2, rect.height(), current.colour("accent"))
            scheme = table.model().scheme
            assert scheme is not None
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            centre = QPointF(rect.left() + theme.px(14), rect.center().y() + 0.5)
            radius = (3.8 if point.state is LandmarkState.PROPOSED else 3.1) * theme.px(20) / 20
            draw_landmark(painter, centre, point, scheme[name].side, palette=current, radius=radius, rim=False)
            return
        faint = point.state is not LandmarkState.PLACED and index.column() != NAME and not chosen
        painter.setPen(current.colour("dim" if faint else "text"))
        painter.setFont(theme.font(theme.TABLE_PX))
        if index.column() == NAME:
            painter.drawText(rect.adjusted(0, 0, -4, 0), Qt.AlignmentFlag.AlignVCenter, name)
        else:
            align = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight
            painter.drawText(rect.adjusted(0, 0, -8 if index.column() == Y else -4, 0), align, str(index.data() or ""))


class LandmarkTable(QTableView):
    """Marks, names and places of the fiducials; x and y can be typed over.

    Signals
    -------
    selected(str)
        The user chose a row.
    edited(str, float, float)
        The user typed another place, image pixels.
    unset_requested(str)
        Delete was pressed.
    """

    selected = Signal(str)
    edited = Signal(str, float, float)
    unset_requested = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("Fiducials")
        self._model = LandmarkModel(self)
        self._current: str | None = None
        self.setModel(self._model)
        self.setItemDelegate(_Delegate(self))
        self._model.edited.connect(self.edited)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        triggers = QAbstractItemView.EditTrigger
        self.setEditTriggers(triggers.DoubleClicked | triggers.EditKeyPressed)
        self.setShowGrid(False)
        self.setSortingEnabled(False)
        self.setTabKeyNavigation(False)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.verticalHeader().hide()
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.setHorizontalHeader(_Header(self))
        header = self.horizontalHeader()
        for column in WIDTHS:
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
        header.setSectionResizeMode(NAME, QHeaderView.ResizeMode.Stretch)
        self.selectionModel().currentRowChanged.connect(self._row_changed)
        picture.offer(self, "fiducials", "fiducial table", table=self.cells)
        theme.signals.changed.connect(self._dress)
        self._dress()
        self._quiet = False

    def cells(self) -> list[list[str]]:
        """Return headers, names, places and states as rows of cells, for a spreadsheet."""
        model = self._model
        rows = [[name, *(model.data(model.index(k, c)) for c in (X, Y))] for k, name in enumerate(model.names)]
        return [
            ["name", HEADERS[X], HEADERS[Y], "state"],
            *([*row, _state_word(model.point(k))] for k, row in enumerate(rows)),
        ]

    def _dress(self) -> None:
        self.verticalHeader().setMinimumSectionSize(theme.px(20))
        self.verticalHeader().setDefaultSectionSize(theme.px(20))
        self._share_width()
        self.viewport().update()

    def _share_width(self) -> None:
        """Give x and y their usual room, and no more than their figures need where the names would be cut."""
        narrow = self.width() < theme.px(NARROW)
        figure = QFontMetrics(theme.font(theme.TABLE_PX)).horizontalAdvance("0000.0") + 16
        for column, width in WIDTHS.items():
            self.setColumnWidth(column, figure if narrow and column != MARK else theme.px(width))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Share the width anew."""
        super().resizeEvent(event)
        self._share_width()

    def model(self) -> LandmarkModel:
        """Return the table's rows."""
        return self._model

    @property
    def current(self) -> str | None:
        """Name of the landmark whose turn it is."""
        return self._current

    def set_scheme(self, scheme: LandmarkScheme | None) -> None:
        """List the landmarks of a scheme."""
        self._show(scheme, self._model.landmarks, self._model.proposed_only)

    def set_vertices(self, vertices: Mapping[str, int]) -> None:
        """Take the template's vertex of each landmark, for the tooltips."""
        self._model.vertices = dict(vertices)

    def set_landmarks(self, landmarks: LandmarkSet) -> None:
        """Show where the landmarks are."""
        self._show(self._model.scheme, landmarks, self._model.proposed_only)

    def set_proposed_only(self, proposed_only: bool) -> None:
        """List all landmarks, or only those that wait to be confirmed."""
        self._show(self._model.scheme, self._model.landmarks, proposed_only)

    def set_current(self, name: str | None) -> None:
        """Mark a row without telling anybody, and bring it into sight."""
        self._current = name
        self._mark()
        self.viewport().update()

    def _show(self, scheme: LandmarkScheme | None, landmarks: LandmarkSet, proposed_only: bool) -> None:
        self._quiet = True
        self._model.show(scheme, landmarks, proposed_only)
        self._quiet = False
        self._mark()

    def _mark(self) -> None:
        self._quiet = True
        if self._current in self._model.names:
            index = self._model.index(self._model.names.index(self._current), max(self.currentIndex().column(), NAME))
            if index.row() != self.currentIndex().row():
                self.setCurrentIndex(index)
                self.scrollTo(index)
        else:
            self.clearSelection()
            self.setCurrentIndex(QModelIndex())
        self._quiet = False

    def _row_changed(self, index: QModelIndex) -> None:
        if index.isValid() and not self._quiet:
            name = self._model.names[index.row()]
            if name != self._current:
                self._current = name
                self.viewport().update()
                self.selected.emit(name)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the rows, or say why there are none."""
        super().paintEvent(event)
        if self._model.rowCount():
            return
        nothing = "Nothing waits to be confirmed." if self._model.proposed_only else "The points to click appear here."
        painter = QPainter(self.viewport())
        painter.setFont(theme.font())
        painter.setPen(theme.current().colour("dim"))
        painter.drawText(self.viewport().rect().adjusted(12, 12, -12, -12), Qt.TextFlag.TextWordWrap, nothing)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Unset with Delete, copy the table with Ctrl+C; Return and Tab go on to the window."""
        if event.key() in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace) and self._current is not None:
            self.unset_requested.emit(self._current)
        elif event.matches(QKeySequence.StandardKey.Copy):
            QGuiApplication.clipboard().setText(picture.tab_separated(self.cells()))
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) or event.text().isalpha():
            event.ignore()
        else:
            super().keyPressEvent(event)

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show that the keys go here."""
        super().focusInEvent(event)
        self.viewport().update()


class _Header(QHeaderView):
    def __init__(self, parent: QWidget) -> None:
        super().__init__(Qt.Orientation.Horizontal, parent)
        theme.fix(self, height=22)
        self.setSectionsClickable(False)
        self.setHighlightSections(False)
        self.setMinimumSectionSize(20)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self.viewport())
        boxes = [
            QRect(self.sectionViewportPosition(k), 0, self.sectionSize(k), self.height()) for k in range(len(HEADERS))
        ]
        paint_header(painter, self.rect())
        for k in (NAME, X, Y):
            right = Qt.AlignmentFlag.AlignRight if k != NAME else Qt.AlignmentFlag.AlignLeft
            inset = 8 if k == Y else 4 if k == X else 0
            painter.drawText(boxes[k].adjusted(0, 0, -inset, 0), Qt.AlignmentFlag.AlignVCenter | right, HEADERS[k])

    def event(self, event: QEvent) -> bool:
        return super().event(event)
