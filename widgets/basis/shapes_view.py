"""The list under the header of the shapes: marks, drags and names, by mouse and keys."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QPoint, QRect, QSize, Qt, Signal
from PySide6.QtGui import QContextMenuEvent, QHelpEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QAbstractItemView, QListView, QSizePolicy, QToolTip, QWidget

from widgets import theme
from widgets.basis.shapes_table import EDGE, MM_RIGHT, ROW, ShapesDelegate, ShapesModel, name_left, shows_mm
from widgets.parts.tables import HEADER_HEIGHT, paint_header

ORDERS = ("rig", "name", "mm", "cosine")
"""What the rows may be sorted by: as in the rig, by name, largest change first, least cosine first."""
_TIPS = {
    "name": "Name of the shape; a click sorts by name, another gives the order of the rig",
    "mm": "RMS distance to the hand shape in mm; a click sorts the largest first",
    "cosine": "Cosine to the hand shape: 1 is the same direction of motion; a click sorts the least first",
}


class ShapesHeader(QWidget):
    """The header of the table; a click on a column sorts by it, another click gives the order of the rig.

    Signals
    -------
    order_chosen(str)
        One of ``ORDERS``.
    """

    order_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.order = "rig"
        theme.fix(self, height=HEADER_HEIGHT)
        theme.signals.changed.connect(self.update)
        self.setAccessibleName("Columns: name, mm, cosine")

    def column_at(self, x: float) -> str:
        """Return the column at a place."""
        from_right = self.width() - x
        if from_right < theme.px(MM_RIGHT) - 4:
            return "cosine"
        return "mm" if from_right < theme.px(100) and shows_mm(self.width()) else "name"

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Sort by the column under the mouse."""
        column = self.column_at(event.position().x())
        self.order = "rig" if column == self.order else column
        self.update()
        self.order_chosen.emit(self.order)

    def event(self, event: QEvent) -> bool:
        """Say what a column means."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            QToolTip.showText(event.globalPos(), _TIPS[self.column_at(event.pos().x())], self)
            return True
        return super().event(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the names of the columns, the one that sorts brighter."""
        painter, px, current = QPainter(self), theme.px, theme.current()
        paint_header(painter, self.rect())
        middle, right = Qt.AlignmentFlag.AlignVCenter, Qt.AlignmentFlag.AlignRight
        boxes = {
            "name": (QRect(name_left(self.width()), 0, px(100), self.height()), middle),
            "mm": (QRect(0, 0, self.width() - px(MM_RIGHT), self.height()), middle | right),
            "cosine": (QRect(0, 0, self.width() - px(EDGE), self.height()), middle | right),
        }
        if not shows_mm(self.width()):
            del boxes["mm"]
        for column, (box, flags) in boxes.items():
            painter.setPen(current.colour("accent_text" if column == self.order else "dim"))
            painter.drawText(box, flags, column)


class ShapesView(QListView):
    """The rows: several can be marked, one is looked at.

    Signals
    -------
    menu_requested(QPoint)
        At a global place.
    remove_requested()
        The marked shapes.
    """

    menu_requested = Signal(QPoint)
    remove_requested = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.shapes = ShapesModel(self)
        self.delegate = ShapesDelegate(self)
        self.setModel(self.shapes)
        self.setItemDelegate(self.delegate)
        self.setAccessibleName("Shapes")
        self.setUniformItemSizes(True)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        triggers = QAbstractItemView.EditTrigger
        self.setEditTriggers(triggers.EditKeyPressed | triggers.DoubleClicked)
        self.setDragDropMode(QAbstractItemView.DragDropMode.InternalMove)
        self.setDefaultDropAction(Qt.DropAction.MoveAction)
        self.setDragDropOverwriteMode(False)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def sizeHint(self) -> QSize:
        """Return the room for the rows."""
        return QSize(theme.px(200), theme.px(ROW) * max(1, self.shapes.rowCount()))

    def minimumSizeHint(self) -> QSize:
        """Return the room for two rows."""
        return QSize(theme.px(120), theme.px(ROW) * 2)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Remove by Del; letters are the window's shortcuts, not a search."""
        if event.key() == Qt.Key.Key_Delete and self.selectedIndexes():
            event.accept()
            self.remove_requested.emit()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space) or event.text().isalpha():
            event.ignore()
        else:
            super().keyPressEvent(event)

    def event(self, event: QEvent) -> bool:
        """Keep Del for the shapes while the keys are here."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            plain = event.modifiers() in (Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.KeypadModifier)
            if plain and event.key() == Qt.Key.Key_Delete and self.selectedIndexes():
                event.accept()
                return True
        return super().event(event)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Ask for the menu of the marked shapes; the one under the mouse is marked first."""
        by_mouse = event.reason() == QContextMenuEvent.Reason.Mouse
        place = event.pos() if by_mouse else self.visualRect(self.currentIndex()).center()
        index = self.indexAt(place)
        if index.isValid():
            if not self.selectionModel().isSelected(index):
                self.setCurrentIndex(index)
            self.menu_requested.emit(self.viewport().mapToGlobal(place))
