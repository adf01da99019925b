"""A strip over the work zone that says what went wrong and what to do, until it is read or the next thing is done."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSizePolicy, QToolButton, QWidget

from widgets import theme


class MessageBar(QWidget):
    """Shows one message at a time; it takes no focus and stops nothing.

    Signals
    -------
    told(str, str)
        Kind and text of a message, for those who keep them.
    """

    told = Signal(str, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("message_bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.kind = ""
        self._question: tuple[str, tuple[tuple[str, Callable[[], object]], ...]] | None = None
        self._asked = False  # whether it is the question that is shown
        self.text = QLabel(self)
        self.text.setWordWrap(True)
        self.text.setTextFormat(Qt.TextFormat.PlainText)
        self.text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.text.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
        self.button = QToolButton(self)
        theme.fix(self.button, 20, 20)
        theme.fix_icon(self.button, 16)
        self.button.setAutoRaise(True)
        self.button.setToolTip("Close this message")
        self.button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.button.clicked.connect(self._dismiss)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 6, 6, 6)
        row.setSpacing(8)
        self._offers = QHBoxLayout()
        self._offers.setSpacing(4)
        row.addWidget(self.text, 1)
        row.addLayout(self._offers)
        row.addWidget(self.button, 0, Qt.AlignmentFlag.AlignTop)
        self.hide()

    def tell(self, kind: str, text: str, offers: Sequence[tuple[str, Callable[[], object]]] = ()) -> None:
        """Show a message; ``kind`` is ``"info"`` or ``"error"``, ``offers`` are buttons and what they do."""
        self._clear_offers()
        self.told.emit(kind, text)
        self.kind = kind
        self.text.setText(text)
        self.refresh_theme()
        for label, deed in offers:
            button = QPushButton(label, self)
            button.clicked.connect(self._dismiss)
            button.clicked.connect(lambda _checked=False, deed=deed: deed())
            self._offers.addWidget(button)
        self.show()

    def offer(self, text: str, offers: Sequence[tuple[str, Callable[[], object]]]) -> None:
        """Ask something that can wait: it stands, behind any message, until one of the buttons is used."""
        self._question = (text, tuple(offers))
        if not self.kind:
            self.clear()

    def withdraw(self) -> None:
        """Take back the question and hide the message: what they were about is over."""
        self._question = None
        self.clear()

    def clear(self) -> None:
        """Hide the message; a question that waits is shown instead."""
        self._clear_offers()
        if self._question is None:
            self.kind = ""
            self.text.setText("")
            self.hide()
            return
        text, offers = self._question
        self.tell("info", text, offers)
        self._asked = True

    def _dismiss(self) -> None:
        if self._asked:
            self._question = None
        self.clear()

    @property
    def offers(self) -> tuple[QPushButton, ...]:
        """The buttons of the message."""
        items = [self._offers.itemAt(k) for k in range(self._offers.count())]
        return tuple(w for w in (item.widget() for item in items if item is not None) if isinstance(w, QPushButton))

    def _clear_offers(self) -> None:
        for button in self.offers:
            self._offers.removeWidget(button)
            button.hide()
            button.deleteLater()

    def refresh_theme(self) -> None:
        """Take the colours of the current theme."""
        colours = theme.current()
        edge = colours.captured if self.kind == "error" else colours.accent
        self.setStyleSheet(
            f"QWidget#message_bar {{ background: {colours.raised}; border-left: 3px solid {edge}; }}"
            f"QLabel {{ color: {colours.text}; background: transparent; }}"
        )
        self.button.setIcon(theme.icon("close", "dim"))
