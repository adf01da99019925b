"""The title bar of a dock: name, a note beside it, the dock's own buttons, float and close."""

from __future__ import annotations

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent
from PySide6.QtWidgets import QDockWidget, QHBoxLayout, QSizePolicy, QWidget

from widgets import theme
from widgets.parts.buttons import IconButton

TITLE_HEIGHT = 28


class DockTitle(QWidget):
    """A title bar 28 px high: semibold name, dim note after 8 px, buttons of 20 px at the right.

    Parameters
    ----------
    title, note : str
        Name and note, e.g. ``Fiducials`` and ``17 / 20``.
    dock : QDockWidget, optional
        The dock it heads; without one there are no float and close buttons.
    """

    def __init__(self, title: str, note: str = "", dock: QDockWidget | None = None) -> None:
        super().__init__(dock)
        self._title, self._note = title, note
        self._title_width = 0
        theme.fix(self, height=TITLE_HEIGHT)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(8, 0, 6, 0)
        self._row.setSpacing(0)
        self._row.addStretch(1)
        self._actions = 0
        self._middle: QWidget | None = None
        self._indent = 0
        self.buttons: dict[str, IconButton] = {}
        if dock is not None:
            self.buttons["float"] = self._append("float", f"Float {title} or dock it again")
            self.buttons["close"] = self._append("close", f"Close {title} (reopen from the Window menu)")
            self.buttons["float"].clicked.connect(lambda: dock.setFloating(not dock.isFloating()))
            self.buttons["close"].clicked.connect(dock.close)
            dock.setTitleBarWidget(self)
        theme.signals.changed.connect(self._measure)
        theme.signals.changed.connect(self.update)
        self._measure()

    def _measure(self) -> None:
        """Note how wide the name is: the window asks at each of its layouts."""
        self._title_width = QFontMetrics(theme.font(bold=True)).horizontalAdvance(self._title)
        self.updateGeometry()

    def add_button(self, icon: str, tip: str) -> IconButton:
        """Add a button of 20 px before float and close and return it."""
        button = IconButton(icon, tip, edge=20, glyph=14)
        self._actions += 1
        self._row.insertWidget(self._actions + (0 if self._middle is None else 2), button)
        return button

    def set_middle(self, widget: QWidget, indent: int) -> None:
        """Give the bar a widget between name and buttons, ``indent`` px of 100 % from the left, in place of a note."""
        spacer = QWidget(self)
        spacer.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        theme.fix(spacer, width=indent)
        self._row.setStretch(0, 0)
        self._row.setContentsMargins(0, 0, 6, 0)
        self._row.insertWidget(0, spacer)
        self._row.insertWidget(1, widget, 1)
        self._middle, self._indent = widget, indent
        self._note = ""
        self.updateGeometry()

    @property
    def note(self) -> str:
        """The dim text after the name."""
        return self._note

    def set_note(self, note: str) -> None:
        """Show another note after the name."""
        if note != self._note and self._middle is None:
            self._note = note
            self.update()

    def _append(self, icon: str, tip: str) -> IconButton:
        button = IconButton(icon, tip, edge=20, glyph=14)
        self._row.addWidget(button)
        return button

    def sizeHint(self) -> QSize:
        """Return the same: a dock gives its title bar the height of this."""
        return self.minimumSizeHint()

    def minimumSizeHint(self) -> QSize:
        """Return the room for the name and the buttons; the note may be cut."""
        if self._middle is not None:
            width = theme.px(self._indent) + self._middle.minimumSizeHint().width()
        else:
            width = self._title_width
        return QSize(width + self._button_width() + 22, theme.px(TITLE_HEIGHT))

    def _button_width(self) -> int:
        return theme.px(20) * (self._actions + len(self.buttons))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw name and note on the panel's colour, and the line below."""
        current = theme.current()
        painter = QPainter(self)
        painter.fillRect(self.rect(), current.colour("panel"))
        painter.fillRect(QRect(0, self.height() - 1, self.width(), 1), current.colour("window"))
        bold = theme.font(bold=True)
        width = self._title_width
        painter.setFont(bold)
        painter.setPen(current.colour("text"))
        painter.drawText(QRect(8, 0, width + 4, self.height() - 1), Qt.AlignmentFlag.AlignVCenter, self._title)
        room = self.width() - width - 16 - 8 - self._button_width() - 6
        if self._note and room > 0:
            plain = theme.font()
            painter.setFont(plain)
            painter.setPen(current.colour("dim"))
            text = QFontMetrics(plain).elidedText(self._note, Qt.TextElideMode.ElideRight, room)
            painter.drawText(QRect(16 + width, 0, room, self.height() - 1), Qt.AlignmentFlag.AlignVCenter, text)
