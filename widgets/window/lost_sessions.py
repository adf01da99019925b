"""Sessions that ended without saying so: a picture, a name, when the last step was made, and what to do with each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QPainter, QPainterPath, QPixmap
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from widgets import theme

WIDTH, HEIGHT = 640, 440
ROW, PICTURE_W, PICTURE_H = 100, 112, 84
_ROLE = Qt.ItemDataRole.UserRole


@dataclass(frozen=True)
class LostRow:
    """One session as it is listed.

    Attributes
    ----------
    name, place : str
        Name and folder of the project; the folder says "never saved" where there is none.
    when, detail : str
        Time of the last step and what there is, in words.
    picture : bytes or None
        A PNG.
    damage : str
        What is wrong with it and what can be restored; empty when nothing is.
    restorable : bool
        Whether there is anything to restore.
    """

    name: str
    place: str
    when: str
    detail: str
    picture: bytes | None = None
    damage: str = ""
    restorable: bool = True


class LostSessionsPanel(QWidget):
    """The list with its three answers; Enter restores the row, Esc keeps all for later."""

    restore_requested = Signal(int)
    discard_requested = Signal(int)
    later_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.head = QLabel(self)
        self.head.setFont(theme.font(theme.NAME_PX, bold=True))
        self.note = QLabel(self)
        self.note.setWordWrap(True)
        self.note.setProperty("role", "dim")
        self.list = QListWidget(self)
        self.list.setObjectName("lost_sessions")
        self.list.setAccessibleName("Sessions that can be restored")
        self.list.setItemDelegate(_RowPainter(self.list))
        self.list.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.list.currentRowChanged.connect(self._on_row)
        self.list.itemDoubleClicked.connect(lambda _item: self._restore())
        self.question = QLabel(self)
        self.question.setWordWrap(True)
        self.discard = QPushButton("&Discard...", self)
        self.keep = QPushButton("&Keep for later", self)
        self.restore = QPushButton("&Restore", self)
        self.restore.setProperty("primary", True)
        self.restore.setDefault(True)
        self.discard.clicked.connect(self._on_discard)
        self.keep.clicked.connect(self._on_keep)
        self.restore.clicked.connect(self._restore)
        self._rows: tuple[LostRow, ...] = ()
        self._asking = False
        self._build()
        theme.signals.changed.connect(self._refresh)
        self._refresh()

    def _build(self) -> None:
        box = QVBoxLayout(self)
        box.setContentsMargins(16, 16, 16, 16)
        box.setSpacing(8)
        box.addWidget(self.head)
        box.addWidget(self.note)
        box.addWidget(self.list, 1)
        box.addWidget(self.question)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(self.discard)
        row.addStretch(1)
        row.addWidget(self.keep)
        row.addWidget(self.restore)
        box.addLayout(row)
        self.setTabOrder(self.list, self.discard)
        self.setTabOrder(self.discard, self.keep)
        self.setTabOrder(self.keep, self.restore)

    def show_rows(self, rows: Sequence[LostRow]) -> None:
        """List the sessions, the first one chosen."""
        self._rows = tuple(rows)
        several = len(self._rows) != 1
        self.head.setText(
            "Work that was not saved" if not several else f"{len(self._rows)} projects that were not saved"
        )
        self.note.setText(
            "The studio ended without saving. Restore opens the work as it was at its last step, still unsaved."
            + (" The others stay in this list." if several else "")
        )
        self.list.clear()
        for row in self._rows:
            item = QListWidgetItem(self.list)
            item.setData(_ROLE, row)
            words = (row.name, row.place, row.when, row.detail, row.damage)
            item.setData(Qt.ItemDataRole.AccessibleTextRole, ", ".join(word for word in words if word))
            item.setToolTip(row.place)
        self.list.setCurrentRow(0)
        self._ask(False)

    def tell(self, text: str) -> None:
        """Show what went wrong; empty: nothing."""
        self.question.setText(text)
        self.question.setVisible(bool(text))

    def _on_row(self, index: int) -> None:
        self._ask(False)
        found = 0 <= index < len(self._rows)
        self.restore.setEnabled(found and self._rows[index].restorable)
        self.discard.setEnabled(found)

    def _restore(self) -> None:
        if self.restore.isEnabled() and not self._asking:
            self.restore_requested.emit(self.list.currentRow())

    def _on_discard(self) -> None:
        if self._asking or not self._rows[self.list.currentRow()].restorable:
            index = self.list.currentRow()
            self._ask(False)
            self.discard_requested.emit(index)
        else:
            self._ask(True)

    def _on_keep(self) -> None:
        if self._asking:
            self._ask(False)
        else:
            self.later_requested.emit()

    def _ask(self, asking: bool) -> None:
        """Ask once whether a session is to be lost for good, or stop asking."""
        self._asking = asking
        index = self.list.currentRow()
        name = self._rows[index].name if 0 <= index < len(self._rows) else ""
        self.tell(f"Discard the unsaved work on {name} for good? It cannot be brought back." if asking else "")
        self.discard.setText("&Discard for good" if asking else "&Discard...")
        self.keep.setText("&Keep it" if asking else "&Keep for later")
        self.restore.setVisible(not asking)
        if asking:
            self.keep.setFocus()

    def _refresh(self) -> None:
        colours = theme.current()
        self.note.setStyleSheet(f"color: {colours.dim};")
        self.question.setStyleSheet(f"color: {colours.stale_text};")
        self.head.setFont(theme.font(theme.NAME_PX, bold=True))
        self.list.doItemsLayout()


class _RowPainter(QStyledItemDelegate):
    """Draws a row: the picture at the left, four lines beside it."""

    def sizeHint(self, _option: QStyleOptionViewItem, _index: QModelIndex | QPersistentModelIndex) -> QSize:
        return QSize(theme.px(200), theme.px(ROW))

    def paint(
        self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        row: LostRow = index.data(_ROLE)
        colours, px = theme.current(), theme.px
        area: QRect = option.rect.adjusted(0, 0, 0, -px(4))
        state = option.state
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        chosen = bool(state & QStyle.StateFlag.State_Selected)
        painter.setPen(colours.colour("accent") if chosen else colours.colour("line"))
        painter.setBrush(colours.colour("selection") if chosen else colours.colour("raised"))
        painter.drawRoundedRect(QRectF(area).adjusted(0.5, 0.5, -0.5, -0.5), 4, 4)
        self._picture(painter, QRect(area.left() + px(8), area.top() + px(6), px(PICTURE_W), px(PICTURE_H)), row)
        left = area.left() + px(8 + PICTURE_W + 12)
        text = QRect(left, area.top() + px(8), area.right() - px(8) - left, px(18))
        lines = [
            (row.name, theme.font(theme.NAME_PX, bold=True), colours.text),
            (row.place, theme.font(theme.TABLE_PX), colours.text if chosen else colours.dim),
            (row.when, theme.font(), colours.text),
            (row.damage or row.detail, theme.font(), colours.stale_text if row.damage else colours.text),
        ]
        for line, font, colour in lines:
            painter.setFont(font)
            painter.setPen(colour)
            shown = QFontMetrics(font).elidedText(line, Qt.TextElideMode.ElideMiddle, text.width())
            painter.drawText(text, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, shown)
            text.translate(0, px(20))
        painter.restore()

    @staticmethod
    def _picture(painter: QPainter, area: QRect, row: LostRow) -> None:
        colours = theme.current()
        frame = QPainterPath()
        frame.addRoundedRect(QRectF(area), 3, 3)
        painter.save()
        painter.setClipPath(frame)
        painter.fillRect(area, colours.colour("window"))
        picture = QPixmap()
        if row.picture is not None and picture.loadFromData(row.picture, "PNG"):
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
            painter.drawPixmap(area, picture)
        else:
            painter.setFont(theme.font(theme.TABLE_PX))
            painter.setPen(colours.colour("dim"))
            painter.drawText(area, Qt.AlignmentFlag.AlignCenter, "no picture")
        painter.restore()
