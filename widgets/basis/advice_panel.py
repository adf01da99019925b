"""What to do next about the basis: a sentence and the buttons that do it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from widgets import theme
from widgets.parts.buttons import IconButton, KeyButton
from widgets.parts.section import ShyLabel
from widgets.parts.sentence import Sentence

LEVELS = {"warn": ("warning", "stale_text"), "info": ("info", "dim"), "ok": ("done", "fresh_text")}
"""Level -> icon and its colour role."""


@dataclass(frozen=True)
class AdviceItem:
    """One piece of advice.

    Parameters
    ----------
    text : str
        A sentence.
    level : str
        ``warn``, ``info`` or ``ok``.
    actions : tuple of (str, str)
        Key that ``action_requested`` sends, and what the button reads.
    tip : str
        Why.
    """

    text: str
    level: str = "warn"
    actions: tuple[tuple[str, str], ...] = ()
    tip: str = ""


class AdvicePanel(QWidget):
    """Pieces of advice, the weightiest first.

    Signals
    -------
    action_requested(str)
        Key of the action.
    """

    action_requested = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self._items: tuple[AdviceItem, ...] = ()
        self._at, self._turned = 0, False
        self._mark = QLabel()
        self.text = Sentence()
        self.more = IconButton("next", "The next piece of advice", edge=20, glyph=14)
        self.count_label = ShyLabel("", theme.TABLE_PX)
        self.buttons: list[KeyButton] = []
        self._arrange()
        self.more.clicked.connect(self._turn)
        theme.signals.changed.connect(self._tint)
        self.set_advice(None)

    def _arrange(self) -> None:
        theme.fix(self._mark, width=18, height=18)
        top = QHBoxLayout()
        top.setContentsMargins(8, 4, 6, 0)
        top.setSpacing(4)
        top.addWidget(self._mark, 0, Qt.AlignmentFlag.AlignTop)
        top.addWidget(self.text, 1)
        self._row = QHBoxLayout()
        self._row.setContentsMargins(30, 4, 6, 6)
        self._row.setSpacing(8)
        self._side = QHBoxLayout()
        self._side.setSpacing(8)
        self._row.addLayout(self._side)
        self._row.addStretch(1)
        for widget in (self.count_label, self.more):
            self._row.addWidget(widget, 0, Qt.AlignmentFlag.AlignBottom)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(top)
        column.addLayout(self._row)
        column.addStretch(1)

    @property
    def items(self) -> tuple[AdviceItem, ...]:
        """All pieces of advice, the weightiest first."""
        return self._items

    def set_advice(self, items: Sequence[AdviceItem] | None) -> None:
        """Show advice: the first, unless the user turned to another that is still there; ``None`` without a basis."""
        texts = [item.text for item in self._items]
        shown = texts[self._at] if texts else ""
        if items is None:
            items = [AdviceItem("Advice on the shapes appears here when there is a basis.", "none")]
        self._items = tuple(items) or (AdviceItem("Nothing to do: the shapes hold, and every axis is reached.", "ok"),)
        kept = [k for k, item in enumerate(self._items) if item.text == shown] if self._turned else []
        self._at, self._turned = (kept[0], True) if kept else (0, False)
        self._show()

    def _turn(self) -> None:
        self._at, self._turned = (self._at + 1) % len(self._items), True
        self._show()

    def _show(self) -> None:
        item = self._items[self._at]
        self.text.set_text(item.text, item.tip, "text" if item.level in LEVELS else "dim")
        for button in self.buttons:
            self._side.removeWidget(button)
            button.hide()
            button.deleteLater()
        self._row.setContentsMargins(30 if item.level in LEVELS else 8, 4, 6, 6)
        self.buttons = []
        for key, text in item.actions:
            button = KeyButton(text)
            button.setToolTip(item.tip)
            button.clicked.connect(lambda _on=False, key=key: self.action_requested.emit(key))
            self._side.addWidget(button)
            self.buttons.append(button)
        several = len(self._items) > 1
        self.more.setVisible(several)
        self.count_label.setVisible(several)
        self.count_label.setText(f"{self._at + 1} / {len(self._items)}")
        self._tint()
        self._stack_buttons()
        self.updateGeometry()

    def _tint(self) -> None:
        icon, role = LEVELS.get(self._items[self._at].level, ("", ""))
        self._mark.setVisible(bool(icon))
        if icon:
            edge = theme.px(16)
            self._mark.setPixmap(theme.icon(icon, role).pixmap(edge, edge))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Put the buttons below each other where they have no room side by side."""
        super().resizeEvent(event)
        self._stack_buttons()

    def _stack_buttons(self) -> None:
        margins = self._row.contentsMargins()
        needed = sum(b.minimumSizeHint().width() + self._row.spacing() for b in self.buttons) + self.more.width()
        narrow = needed > self.width() - margins.left() - margins.right() and len(self.buttons) > 1
        way = QBoxLayout.Direction.TopToBottom if narrow else QBoxLayout.Direction.LeftToRight
        if way != self._side.direction():
            self._side.setDirection(way)

    def minimumSizeHint(self) -> QSize:
        """Return the room for one button's width, and the height of what is said."""
        layout = self.layout()
        widest = max((b.minimumSizeHint().width() for b in self.buttons), default=0)
        height = 0 if layout is None else layout.minimumSize().height()
        return QSize(max(theme.px(160), widest + theme.px(40)), height)
