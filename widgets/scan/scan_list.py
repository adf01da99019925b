"""The scans of a project: thumbnail, name with the letters that are held, how far it is, whether its fit is fresh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from PySide6.QtCore import (
    QAbstractListModel,
    QEvent,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QPointF,
    QRect,
    QRectF,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QFontMetrics, QImage, QKeyEvent, QPainter, QPainterPath, QPen
from PySide6.QtWidgets import (
    QAbstractItemView,
    QLineEdit,
    QListView,
    QMenu,
    QSizePolicy,
    QStackedLayout,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from widgets import theme
from widgets.canvases.pictures import Picture, to_image
from widgets.parts.buttons import KeyButton
from widgets.parts.empty import EmptyState
from widgets.parts.glyphs import draw_state_dot

ROW, THUMB_W, THUMB_H = 48, 52, 39
LEAST_NAME = 40
Index = QModelIndex | QPersistentModelIndex


@dataclass(frozen=True)
class ScanRow:
    """One scan as it is listed.

    Parameters
    ----------
    id, name : str
        Key, and the name that is read.
    note : str
        State in two or three words: ``fit fresh``, ``fiducials moved``, ``3 proposed``.
    held : str
        Letters of the name that are held while the mouth is scanned; underlined.
    placed, total : int
        Fiducials that are confirmed, and all of the scheme.
    state : str
        ``fresh``, ``stale`` or ``missing``.
    thumbnail : (h, w, 3) uint8, optional
        Any size; the middle is shown at 52 x 39.
    """

    id: str
    name: str
    note: str = ""
    held: str = ""
    placed: int = 0
    total: int = 20
    state: str = "missing"
    thumbnail: Picture | None = field(default=None, compare=False, repr=False)


class _Model(QAbstractListModel):
    renamed = Signal(str, str)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows: tuple[ScanRow, ...] = ()
        self._images: dict[str, tuple[int, QImage]] = {}

    def show(self, rows: Sequence[ScanRow]) -> None:
        same = [r.id for r in rows] == [r.id for r in self.rows]
        if same:
            self.rows = tuple(rows)
            if rows:
                self.dataChanged.emit(self.index(0), self.index(len(rows) - 1))
        else:
            self.beginResetModel()
            self.rows = tuple(rows)
            self.endResetModel()

    def rowCount(self, parent: Index | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        row = self.rows[index.row()]
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return row.name
        if role in (Qt.ItemDataRole.ToolTipRole, Qt.ItemDataRole.AccessibleTextRole):
            return f"{row.name}: {row.note}, {row.placed} of {row.total} fiducials"
        return None

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        name, row = str(value).strip(), self.rows[index.row()]
        if role != Qt.ItemDataRole.EditRole or not name or name == row.name:
            return False
        self.renamed.emit(row.id, name)
        return True

    def flags(self, index: Index) -> Qt.ItemFlag:
        return super().flags(index) | Qt.ItemFlag.ItemIsEditable

    def thumbnail(self, row: ScanRow, scale: float) -> QImage | None:
        if row.thumbnail is None:
            return None
        key, image = self._images.get(row.id, (0, QImage()))
        width, height = round(theme.px(THUMB_W) * scale), round(theme.px(THUMB_H) * scale)
        if key != id(row.thumbnail) or image.width() != width:
            image = to_image(row.thumbnail)
            cut = image.scaled(
                QSize(width, height),
                Qt.AspectRatioMode.KeepAspectRatioByExpanding,
                Qt.TransformationMode.SmoothTransformation,
            )
            image = cut.copy((cut.width() - width) // 2, (cut.height() - height) // 2, width, height)
            self._images[row.id] = (id(row.thumbnail), image)
        return image


class _Delegate(QStyledItemDelegate):
    def sizeHint(self, option: QStyleOptionViewItem, _index: Index) -> QSize:
        return QSize(option.rect.width(), theme.px(ROW))

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, _index: Index) -> QWidget:
        editor = QLineEdit(parent)
        editor.setAccessibleName("Name of the scan")
        return editor

    def updateEditorGeometry(self, editor: QWidget, option: QStyleOptionViewItem, _index: Index) -> None:
        left = theme.px(64)
        editor.setGeometry(
            option.rect.left() + left, option.rect.top() + 4, option.rect.width() - left - 8, theme.px(22)
        )

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        view = option.widget
        assert isinstance(view, _View)
        row, rect, current = view.rows.rows[index.row()], option.rect, theme.current()
        chosen = row.id == view.current
        if chosen:
            painter.fillRect(rect, current.colour("selection"))
            painter.fillRect(QRect(rect.left(), rect.top(), 2, rect.height()), current.colour("accent"))
        px, height = theme.px, rect.height()
        thumbnail = QRectF(rect.left() + 8, rect.top() + px(5), px(THUMB_W), px(THUMB_H))
        self._paint_thumbnail(painter, thumbnail, row, view)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        right, left = rect.right() + 1, rect.left() + 16 + px(THUMB_W)
        draw_state_dot(painter, QPointF(right - 11.5, rect.top() + height / 2 + 0.5), row.state, px(7))
        small = QFontMetrics(theme.font(theme.TABLE_PX))
        count = f"{row.placed} / {row.total}"
        width = small.horizontalAdvance(count)
        middle = Qt.AlignmentFlag.AlignVCenter
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(current.colour("text" if chosen else "dim"))
        room = right - 23 - width - 6 - left
        if room >= px(LEAST_NAME):
            painter.drawText(QRect(right - 23 - width, rect.top(), width + 2, height + 1), middle, count)
        else:  # the name goes before the count, which the tooltip has too
            room = right - 23 - left
        note = small.elidedText(row.note, Qt.TextElideMode.ElideRight, room + 4)
        painter.drawText(QRect(left, rect.top() + px(24), room + 8, px(17)), middle, note)
        painter.setFont(theme.font())
        metrics = QFontMetrics(theme.font())
        painter.setPen(current.colour("text"))
        name = metrics.elidedText(row.name, Qt.TextElideMode.ElideRight, room)
        painter.drawText(QRect(left, rect.top() + px(9), room + 4, px(16)), middle, name)
        start = row.name.lower().find(row.held.lower()) if row.held else -1
        if start >= 0:
            left += metrics.horizontalAdvance(row.name[:start])
            length = metrics.horizontalAdvance(row.name[start : start + len(row.held)])
            painter.fillRect(QRect(left, rect.top() + px(24), length, 1), current.colour("text"))

    def _paint_thumbnail(self, painter: QPainter, box: QRectF, row: ScanRow, view: _View) -> None:
        current = theme.current()
        clip = QPainterPath()
        clip.addRoundedRect(box, 2, 2)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillPath(clip, current.colour("window"))
        painter.setClipPath(clip)
        image = view.rows.thumbnail(row, view.devicePixelRatioF())
        if image is not None:
            painter.drawImage(box, image)
        else:
            painter.setPen(QPen(current.colour("line"), 1))
            painter.drawRoundedRect(box.adjusted(0.5, 0.5, -0.5, -0.5), 2, 2)
        painter.restore()


class _View(QListView):
    remove_requested = Signal(str)
    menu_requested = Signal(str, QPoint)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows = _Model(self)
        self.current: str | None = None
        self.setModel(self.rows)
        self.setItemDelegate(_Delegate(self))
        self.setAccessibleName("Scans")
        self.setUniformItemSizes(True)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setEditTriggers(QAbstractItemView.EditTrigger.EditKeyPressed)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Maximum)

    def sizeHint(self) -> QSize:
        return QSize(200, theme.px(ROW) * max(1, self.rows.rowCount()))

    def minimumSizeHint(self) -> QSize:
        return QSize(120, theme.px(ROW) * max(1, min(3, self.rows.rowCount())))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Delete and self.current is not None:
            event.accept()
            self.remove_requested.emit(self.current)
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) or event.text().isalpha():
            event.ignore()
        else:
            super().keyPressEvent(event)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            plain = event.modifiers() in (Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.KeypadModifier)
            if plain and event.key() == Qt.Key.Key_Delete and self.current is not None:
                event.accept()  # the key means a scan here, and a fiducial everywhere else
                return True
        if event.type() == QEvent.Type.ContextMenu:
            index = self.indexAt(self.viewport().mapFromGlobal(event.globalPos()))  # type: ignore[attr-defined]
            if index.isValid():
                self.menu_requested.emit(self.rows.rows[index.row()].id, event.globalPos())  # type: ignore[attr-defined]
                return True
        return super().event(event)


class ScanList(QWidget):
    """Lists the scans, offers to add one, and says what belongs here while there is none.

    Signals
    -------
    selected(str)
        The user chose a scan (id).
    add_requested()
        A scan is to be opened from a file.
    rename_requested(str, str)
        Id and new name.
    remove_requested(str)
        Id.
    """

    selected = Signal(str)
    add_requested = Signal()
    rename_requested = Signal(str, str)
    remove_requested = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._view = _View(self)
        self.add_button = KeyButton("Add scan…")
        self.add_button.setToolTip("Add a scan from a file (Ctrl+I)")
        self.empty = EmptyState(
            "No scan yet",
            "A range image of the face, as the scanner saw it: depth and colour of the same pixels. "
            "Six make a speaking face: a base and car, man, she, eel, too. Drop files here, or press + above.",
        )
        filled = QWidget()
        column = QVBoxLayout(filled)
        column.setContentsMargins(0, 0, 0, 8)
        column.setSpacing(8)
        column.addWidget(self._view)
        row = QVBoxLayout()
        row.setContentsMargins(8, 0, 8, 0)
        row.addWidget(self.add_button)
        column.addLayout(row)
        self._stack = QStackedLayout(self)
        self._stack.setContentsMargins(0, 0, 0, 0)
        self._stack.addWidget(self.empty)
        self._stack.addWidget(filled)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Maximum)
        self._quiet = False
        self._view.selectionModel().currentRowChanged.connect(self._row_changed)
        self._view.rows.renamed.connect(self.rename_requested)
        self._view.remove_requested.connect(self.remove_requested)
        self._view.menu_requested.connect(self._show_menu)
        self.add_button.clicked.connect(self.add_requested)
        theme.signals.changed.connect(self._tint)
        self._tint()

    @property
    def current(self) -> str | None:
        """Id of the scan that is marked."""
        return self._view.current

    @property
    def rows(self) -> tuple[ScanRow, ...]:
        """What is listed."""
        return self._view.rows.rows

    def set_scans(self, rows: Sequence[ScanRow]) -> None:
        """List scans; the mark stays where its scan is still there."""
        self._quiet = True
        self._view.rows.show(rows)
        self._stack.setCurrentIndex(1 if rows else 0)
        self._mark()
        self._quiet = False
        self._view.updateGeometry()
        self.updateGeometry()
        self._view.viewport().update()

    def set_current(self, scan_id: str | None) -> None:
        """Mark a scan without telling anybody."""
        self._view.current = scan_id
        self._quiet = True
        self._mark()
        self._quiet = False
        self._view.viewport().update()

    def edit_name(self, scan_id: str) -> None:
        """Let the user type another name for a scan."""
        ids = [row.id for row in self.rows]
        if scan_id in ids:
            self._view.edit(self._view.rows.index(ids.index(scan_id)))

    def menu(self, scan_id: str) -> QMenu:
        """Return the context menu of a scan."""
        menu = QMenu(self)
        menu.addAction("Rename\tF2", lambda: self.edit_name(scan_id))
        menu.addAction("Remove\tDel", lambda: self.remove_requested.emit(scan_id))
        return menu

    def _show_menu(self, scan_id: str, at: QPoint) -> None:
        menu = self.menu(scan_id)
        menu.exec(at)
        menu.deleteLater()

    def _mark(self) -> None:
        ids = [row.id for row in self.rows]
        if self._view.current in ids:
            index = self._view.rows.index(ids.index(str(self._view.current)))
            if index.row() != self._view.currentIndex().row():
                self._view.setCurrentIndex(index)
        else:
            self._view.setCurrentIndex(QModelIndex())

    def _row_changed(self, index: QModelIndex) -> None:
        if index.isValid() and not self._quiet:
            scan_id = self.rows[index.row()].id
            if scan_id != self._view.current:
                self._view.current = scan_id
                self._view.viewport().update()
                self.selected.emit(scan_id)

    def _tint(self) -> None:
        self.add_button.setIcon(theme.icon("plus", "dim"))
        self._view.scheduleDelayedItemsLayout()
        self._view.updateGeometry()
        self.updateGeometry()

    def sizeHint(self) -> QSize:
        """Return the room for all rows and the button, or for the empty state."""
        if not self.rows:
            return QSize(232, 220)
        return QSize(232, theme.px(ROW) * len(self.rows) + theme.px(40))
