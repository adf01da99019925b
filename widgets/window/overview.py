"""Everything that can be done, with its keys: searched by words, run by Enter or a double click."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QModelIndex, QPersistentModelIndex, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QHelpEvent, QKeyEvent, QPainter, QPen
from PySide6.QtWidgets import (
    QAbstractItemView,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QToolTip,
    QVBoxLayout,
    QWidget,
)

from widgets import theme
from widgets.parts.section import DimLabel

WIDTH, HEIGHT = 720, 520
ROW, HEADING = 24, 30
_ENTRY = Qt.ItemDataRole.UserRole
Index = QModelIndex | QPersistentModelIndex


@dataclass(frozen=True)
class Entry:
    """One thing that can be done.

    Attributes
    ----------
    group, text, tip : str
        Where it belongs, what it is called, and a sentence about it.
    keys : tuple of str
        Shortcuts or gestures as people write them.
    id : str
        What ``chosen`` sends; empty for a gesture of the hand, which cannot be run.
    why : str
        Why it cannot be done just now; empty when it can.
    """

    group: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    id: str = ""
    why: str = ""

    def matches(self, words: Sequence[str]) -> bool:
        """Return whether every word occurs in group, text, sentence or keys."""
        text = " ".join((self.group, self.text, self.tip, *self.keys)).lower()
        return all(word in text for word in words)


class Overview(QWidget):
    """A search line over a list of entries by group; what cannot be done now is dim and says why.

    Signals
    -------
    chosen(str)
        Run the action with this id.
    """

    chosen = Signal(str)

    def __init__(self, entries: Sequence[Entry], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._entries = tuple(entries)
        self.search = _Search()
        self.search.setPlaceholderText("Search actions, keys and gestures; Enter runs the marked one")
        self.search.setAccessibleName("Search actions, keys and gestures")
        self.search.setClearButtonEnabled(True)
        self.list = _List()
        self.list.setAccessibleName("Actions and gestures")
        self.foot = DimLabel("")
        self.foot.setWordWrap(True)
        theme.fix(self.foot, height=32)
        box = QVBoxLayout(self)
        box.setContentsMargins(16, 16, 16, 8)
        box.setSpacing(8)
        box.addWidget(self.search)
        box.addWidget(self.list, 1)
        box.addWidget(self.foot)
        self.search.textChanged.connect(self._fill)
        self.search.returnPressed.connect(self._run)
        self.search.moved.connect(self._move)
        self.list.itemDoubleClicked.connect(lambda _item: self._run())
        self.list.entered_here.connect(self._run)
        self.list.currentItemChanged.connect(self._tell)
        self.setFocusProxy(self.search)
        self._fill()

    @property
    def shown(self) -> tuple[Entry, ...]:
        """The entries that the search leaves, in the order of the list."""
        items = [self.list.item(row).data(_ENTRY) for row in range(self.list.count())]
        return tuple(entry for entry in items if isinstance(entry, Entry))

    @property
    def current(self) -> Entry | None:
        """The marked entry."""
        item = self.list.currentItem()
        entry = None if item is None else item.data(_ENTRY)
        return entry if isinstance(entry, Entry) else None

    def _fill(self) -> None:
        words = self.search.text().lower().replace("+", "+ ").split()
        words = [word.strip("+") for word in words if word.strip("+")]
        found = [entry for entry in self._entries if entry.matches(words)]
        self.list.clear()
        for group in dict.fromkeys(entry.group for entry in found):
            heading = QListWidgetItem(group)
            heading.setFlags(Qt.ItemFlag.NoItemFlags)
            self.list.addItem(heading)
            for entry in found:
                if entry.group == group:
                    item = QListWidgetItem(entry.text)
                    item.setData(_ENTRY, entry)
                    item.setData(Qt.ItemDataRole.AccessibleTextRole, _spoken(entry))
                    self.list.addItem(item)
        runnable = [row for row in self._rows() if self._at(row).id and not self._at(row).why]
        rows = runnable or self._rows()
        self.list.setCurrentRow(rows[0] if rows else -1)
        self.list.scrollToTop()
        self._tell()

    def _rows(self) -> list[int]:
        return [row for row in range(self.list.count()) if isinstance(self.list.item(row).data(_ENTRY), Entry)]

    def _at(self, row: int) -> Entry:
        entry = self.list.item(row).data(_ENTRY)
        assert isinstance(entry, Entry)
        return entry

    def _move(self, step: int) -> None:
        rows = self._rows()
        if not rows:
            return
        at = rows.index(self.list.currentRow()) if self.list.currentRow() in rows else -1
        self.list.setCurrentRow(rows[min(max(at + step, 0), len(rows) - 1)])

    def _tell(self) -> None:
        entry = self.current
        if entry is None:
            self.foot.setText("Nothing has these words." if not self.list.count() else "")
        elif entry.why:
            self.foot.setText(f"Not now: {entry.why}")
        else:
            self.foot.setText(entry.tip or entry.text)

    def _run(self) -> None:
        entry = self.current
        if entry is not None and entry.id and not entry.why:
            self.chosen.emit(entry.id)


def _spoken(entry: Entry) -> str:
    words = [entry.text, ", ".join(entry.keys), f"not now: {entry.why}" if entry.why else ""]
    return ", ".join(word for word in words if word)


class _Search(QLineEdit):
    moved = Signal(int)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        steps = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1, Qt.Key.Key_PageDown: 10, Qt.Key.Key_PageUp: -10}
        step = steps.get(Qt.Key(event.key()))
        if step is None:
            super().keyPressEvent(event)
        else:
            self.moved.emit(step)


class _List(QListWidget):
    entered_here = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setItemDelegate(_Delegate(self))
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.entered_here.emit()
        else:
            super().keyPressEvent(event)

    def viewportEvent(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            item = self.itemAt(event.pos())
            entry = None if item is None else item.data(_ENTRY)
            text = (f"Not now: {entry.why}" if entry.why else entry.tip) if isinstance(entry, Entry) else ""
            QToolTip.showText(event.globalPos(), text, self)
            return True
        return super().viewportEvent(event)


class _Delegate(QStyledItemDelegate):
    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        heading = not isinstance(index.data(_ENTRY), Entry)
        return QSize(option.rect.width(), theme.px(HEADING if heading else ROW))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        entry, rect, current = index.data(_ENTRY), option.rect, theme.current()
        middle = Qt.AlignmentFlag.AlignVCenter
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if not isinstance(entry, Entry):
            painter.setFont(theme.font(bold=True))
            painter.setPen(current.colour("text"))
            painter.drawText(rect.adjusted(8, theme.px(6), 0, 0), middle, str(index.data()))
            painter.fillRect(QRect(rect.left(), rect.bottom(), rect.width(), 1), current.colour("line"))
            return
        view = option.widget
        chosen = isinstance(view, QListWidget) and view.currentIndex() == index
        if chosen:
            painter.fillRect(rect, current.colour("selection"))
            painter.fillRect(rect.left(), rect.top(), 2, rect.height(), current.colour("accent"))
        right = self._paint_keys(painter, rect, entry)
        painter.setFont(theme.font())
        metrics = QFontMetrics(theme.font())
        painter.setPen(current.colour("missing" if entry.why else "text"))
        box = QRect(rect.left() + 16, rect.top(), right - rect.left() - 24, rect.height())
        text = metrics.elidedText(entry.text, Qt.TextElideMode.ElideRight, box.width())
        painter.drawText(box, middle, text)
        note = f"not now: {entry.why}" if entry.why else entry.tip if entry.tip != entry.text else ""
        left = box.left() + metrics.horizontalAdvance(text) + 12
        small = theme.font(theme.TABLE_PX)
        painter.setFont(small)
        painter.setPen(current.colour("text" if chosen else "missing" if entry.why else "dim"))
        cut = QFontMetrics(small).elidedText(note, Qt.TextElideMode.ElideRight, max(right - 8 - left, 0))
        painter.drawText(QRect(left, rect.top(), max(right - left, 0), rect.height()), middle, cut)

    @staticmethod
    def _paint_keys(painter: QPainter, rect: QRect, entry: Entry) -> int:
        current, font = theme.current(), theme.font(theme.TABLE_PX)
        metrics, right = QFontMetrics(font), rect.right() - 8
        painter.setFont(font)
        height = theme.px(16)
        for key in reversed(entry.keys):
            width = max(theme.px(20), metrics.horizontalAdvance(key) + theme.px(12))
            box = QRectF(right - width + 0.5, rect.center().y() - height / 2 + 0.5, width - 1, height)
            painter.setPen(QPen(current.colour("line"), 1))
            painter.setBrush(current.colour("raised"))
            painter.drawRoundedRect(box, 3, 3)
            painter.setPen(current.colour("missing" if entry.why else "text"))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, key)
            right -= width + 4
        return right
