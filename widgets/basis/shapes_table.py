"""The table of the shapes: thumbnail, name, change in mm, cosine to the hand shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from PySide6.QtCore import (
    QAbstractListModel,
    QByteArray,
    QMimeData,
    QModelIndex,
    QPersistentModelIndex,
    QRect,
    QRectF,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QFontMetrics, QImage, QPainter, QPainterPath, QPen
from PySide6.QtWidgets import QLineEdit, QStyle, QStyledItemDelegate, QStyleOptionViewItem, QWidget

from widgets import theme
from widgets.basis.words import DASH, figure, judged
from widgets.canvases.pictures import Picture, to_image

COSINE_LIMIT = 0.85
ROW, THUMB = 28, 26
MIME = "application/x-quasiface-shapes"
NAME_LEFT, MM_RIGHT, EDGE = 40, 60, 10
"""Where names begin; how far from the right end the numbers in mm end, and those of the cosine; pixels of 100 %."""
Index = QModelIndex | QPersistentModelIndex


@dataclass(frozen=True)
class ShapeRow:
    """One shape as it is listed.

    Parameters
    ----------
    name : str
        Unique in the rig.
    change_mm : float, optional
        RMS distance in mm between the shape in use and its hand shape.
    cosine : float, optional
        Cosine between them; NaN where the shape does not move.
    tip : str
        What else is known, a line or two.
    thumbnail : (h, w, 3) uint8, optional
        Any size; the middle is shown in a square.
    """

    name: str
    change_mm: float | None = None
    cosine: float | None = None
    tip: str = ""
    thumbnail: Picture | None = field(default=None, compare=False, repr=False)

    def drifts(self, limit: float) -> bool:
        """Whether its cosine is known and lies below ``limit``."""
        return self.cosine is not None and self.cosine < limit


def name_left(width: int) -> int:
    """Return where names begin in a table of this width: at its edge where pictures would leave them no room."""
    with_pictures = width - theme.px(NAME_LEFT + MM_RIGHT) >= theme.px(72)
    return theme.px(NAME_LEFT) if with_pictures else theme.px(EDGE)


def shows_mm(width: int) -> bool:
    """Whether a table of this width has room for the change in mm beside a name that can be read."""
    return width - theme.px(NAME_LEFT + MM_RIGHT + 30) >= theme.px(72)


class ShapesModel(QAbstractListModel):
    """The rows that are listed just now.

    Signals
    -------
    renamed(str, str)
        Name and the new one typed.
    moved(object, int)
        Tuple of names dragged, and the row before which they were dropped.
    """

    renamed = Signal(str, str)
    moved = Signal(object, int)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows: tuple[ShapeRow, ...] = ()
        self.limit = COSINE_LIMIT
        self.may_move = True
        self._images: dict[str, tuple[int, int, QImage]] = {}

    def show(self, rows: Sequence[ShapeRow]) -> None:
        """List rows."""
        if len(rows) == len(self.rows):  # a reset would close the field that a new name was typed in
            self.rows = tuple(rows)
            if rows:
                self.dataChanged.emit(self.index(0), self.index(len(rows) - 1))
        else:
            self.beginResetModel()
            self.rows = tuple(rows)
            self.endResetModel()

    def rowCount(self, parent: Index | None = None) -> int:
        """Return how many are listed."""
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return the name, and what a row says in words."""
        row = self.rows[index.row()]
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.EditRole):
            return row.name
        if role in (Qt.ItemDataRole.ToolTipRole, Qt.ItemDataRole.AccessibleTextRole):
            words = [row.name]
            if row.change_mm is not None:
                words.append(f"changed by {figure(row.change_mm)} mm RMS")
            if row.cosine is not None:
                word = f"cosine {judged(row.cosine, self.limit)} to the hand shape"
                words.append(word + (f", below {self.limit:.2f}" if row.drifts(self.limit) else ""))
            return "\n".join([*words, *([row.tip] if row.tip else [])])
        return None

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Tell that another name was typed."""
        name, row = str(value).strip(), self.rows[index.row()]
        if role != Qt.ItemDataRole.EditRole or not name or name == row.name:
            return False
        self.renamed.emit(row.name, name)
        return True

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Say that rows can be renamed and dragged, and dropped between rows."""
        if not index.isValid():
            return Qt.ItemFlag.ItemIsDropEnabled
        made = super().flags(index) | Qt.ItemFlag.ItemIsEditable
        return made | Qt.ItemFlag.ItemIsDragEnabled if self.may_move else made

    def supportedDropActions(self) -> Qt.DropAction:
        """Rows move."""
        return Qt.DropAction.MoveAction

    def mimeTypes(self) -> list[str]:
        """Return what may be dropped: rows of this table."""
        return [MIME]

    def mimeData(self, indexes: Sequence[QModelIndex]) -> QMimeData:
        """Return the names dragged, a line each, in the order of the table."""
        names = [self.rows[r].name for r in sorted(i.row() for i in indexes)]
        made = QMimeData()
        made.setData(MIME, QByteArray("\n".join(names).encode()))
        return made

    def dropMimeData(self, data: QMimeData, _action: Qt.DropAction, row: int, _column: int, parent: Index) -> bool:
        """Tell where rows were dropped; the rows themselves move when the rig has changed."""
        if not data.hasFormat(MIME) or not self.may_move:
            return False
        names = tuple(bytes(data.data(MIME).data()).decode().split("\n"))
        before = row if row >= 0 else parent.row() if parent.isValid() else len(self.rows)
        self.moved.emit(names, before)
        return False  # nothing is to be taken out: the table follows the rig

    def thumbnail(self, row: ShapeRow, edge: int) -> QImage | None:
        """Return the middle of a row's picture as a square."""
        if row.thumbnail is None:
            return None
        key, width, image = self._images.get(row.name, (0, 0, QImage()))
        if key != id(row.thumbnail) or width != edge:
            wide, smooth = Qt.AspectRatioMode.KeepAspectRatioByExpanding, Qt.TransformationMode.SmoothTransformation
            cut = to_image(row.thumbnail).scaled(QSize(edge, edge), wide, smooth)
            image = cut.copy((cut.width() - edge) // 2, (cut.height() - edge) // 2, edge, edge)
            self._images[row.name] = (id(row.thumbnail), edge, image)
        return image


class ShapesDelegate(QStyledItemDelegate):
    """Draws a row; the one that is looked at bears the accent at its left."""

    current: str | None = None

    def sizeHint(self, option: QStyleOptionViewItem, _index: Index) -> QSize:
        """Return the height of a row."""
        return QSize(option.rect.width(), theme.px(ROW))

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, _index: Index) -> QWidget:
        """Return the field of a name."""
        editor = QLineEdit(parent)
        editor.setAccessibleName("Name of the shape")
        return editor

    def updateEditorGeometry(self, editor: QWidget, option: QStyleOptionViewItem, _index: Index) -> None:
        """Lay the field over the name."""
        left, height = name_left(option.widget.width()) - 7, theme.px(22)
        top = option.rect.top() + (option.rect.height() - height) // 2
        editor.setGeometry(option.rect.left() + left, top, option.rect.width() - left - 4, height)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw thumbnail, name and both numbers."""
        model = index.model()
        assert isinstance(model, ShapesModel)
        row, rect, current, px = model.rows[index.row()], option.rect, theme.current(), theme.px
        selected = bool(option.state & QStyle.StateFlag.State_Selected)
        role = "selection" if selected else "alternate" if index.row() % 2 else "panel"
        painter.fillRect(rect, current.colour(role))
        if row.name == self.current:
            painter.fillRect(QRect(rect.left(), rect.top(), 2, rect.height()), current.colour("accent"))
        edge, start = px(THUMB), name_left(option.widget.width())
        if start > edge:
            self._paint_thumbnail(painter, QRectF(rect.left() + 8, rect.top() + 1, edge, edge), row, model)
        middle, right = Qt.AlignmentFlag.AlignVCenter, Qt.AlignmentFlag.AlignRight
        painter.setFont(theme.font())
        painter.setPen(current.colour("text"))
        left, end = rect.left() + start, option.widget.width()  # in line with the header, scroll bar or not
        numbers = row.change_mm is not None or row.cosine is not None
        text, drifts = judged(row.cosine, model.limit), row.drifts(model.limit)
        change, small = figure(row.change_mm), QFontMetrics(theme.font(theme.TABLE_PX))
        mark = px(12) + px(3) if drifts else 0
        mm_right = max(px(MM_RIGHT), px(EDGE) + small.horizontalAdvance(text) + mark + px(6))
        with_mm = shows_mm(end)
        taken = (mm_right + small.horizontalAdvance(change) if with_mm else mm_right - px(6)) + px(6)
        room = end - (taken if numbers else px(EDGE)) - left
        name = QFontMetrics(theme.font()).elidedText(row.name, Qt.TextElideMode.ElideMiddle, room)
        painter.drawText(QRect(left, rect.top(), room + 4, rect.height()), middle, name)
        if not numbers:
            return
        painter.setFont(theme.font(theme.TABLE_PX))
        whole = QRect(rect.left(), rect.top(), end, rect.height())
        if with_mm:
            painter.drawText(whole.adjusted(0, 0, -mm_right, 0), middle | right, change)
        painter.setPen(current.colour("stale_text" if drifts else "dim" if text == DASH else "text"))
        painter.drawText(whole.adjusted(0, 0, -px(EDGE), 0), middle | right, text)
        if drifts:
            sign, size = theme.icon("warning", "stale_text", 12), px(12)
            at = end - px(EDGE) - QFontMetrics(painter.font()).horizontalAdvance(text) - size - px(3)
            sign.paint(painter, at, rect.top() + (rect.height() - size) // 2, size, size)

    def _paint_thumbnail(self, painter: QPainter, box: QRectF, row: ShapeRow, model: ShapesModel) -> None:
        current = theme.current()
        image = model.thumbnail(row, round(box.width() * painter.device().devicePixelRatioF()))
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        path = QPainterPath()
        path.addRoundedRect(box, 2, 2)
        if image is None:
            painter.setPen(QPen(current.colour("line"), 1))
            painter.setBrush(current.colour("view_bottom"))
            painter.drawRoundedRect(box.adjusted(0.5, 0.5, -0.5, -0.5), 2, 2)
        else:
            painter.setClipPath(path)
            painter.drawImage(box, image)
        painter.restore()
