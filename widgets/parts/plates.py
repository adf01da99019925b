"""Small labels: plates that stand over a picture, and badges that show a key."""

from __future__ import annotations

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from widgets import theme


class OverlayPlate(QWidget):
    """A label on the dark plate over a picture, 18 high: semibold name, plain note; mouse events pass through."""

    def __init__(self, name: str = "", note: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._name, self._note = name, note
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        theme.signals.changed.connect(self._fit)
        self.set_text(name, note)

    def set_text(self, name: str, note: str = "") -> None:
        """Show another name and note; an empty plate hides."""
        self._name, self._note = name, note
        self.setAccessibleName(f"{name} {note}".strip())
        self.setVisible(bool(name or note))
        self.resize(self.sizeHint())
        self.update()

    def _fit(self) -> None:
        self.resize(self.sizeHint())

    def sizeHint(self) -> QSize:
        """Return the room for both texts."""
        name = QFontMetrics(theme.font(bold=True)).horizontalAdvance(self._name)
        note = QFontMetrics(theme.font()).horizontalAdvance(self._note)
        return QSize(name + note + (6 if self._name and self._note else 0) + 12, theme.px(18))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw plate, name and note."""
        palette = theme.overlay()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(palette.colour("plate", palette.plate_alpha))
        painter.drawRoundedRect(QRectF(self.rect()), 3, 3)
        x = 6
        for text, bold, role in ((self._name, True, "text"), (self._note, False, "text")):
            if text:
                font = theme.font(bold=bold)
                painter.setFont(font)
                painter.setPen(palette.colour(role))
                painter.drawText(QRectF(x, 0, self.width(), self.height()), Qt.AlignmentFlag.AlignVCenter, text)
                x += QFontMetrics(font).horizontalAdvance(text) + 6


class KeyBadge(QWidget):
    """A key as it is printed on the keyboard, in a small frame 16 high."""

    def __init__(self, key: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._key = key
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        theme.signals.changed.connect(self.updateGeometry)
        theme.signals.changed.connect(self.update)

    def set_key(self, key: str) -> None:
        """Show another key; an empty one hides the badge."""
        self._key = key
        self.setVisible(bool(key))
        self.updateGeometry()
        self.update()

    def sizeHint(self) -> QSize:
        """Return the room for the key."""
        return QSize(
            max(theme.px(20), QFontMetrics(theme.font(theme.TABLE_PX)).horizontalAdvance(self._key) + theme.px(12)),
            theme.px(16),
        )

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw frame and key."""
        current = theme.current()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(current.colour("line"), 1))
        painter.setBrush(current.colour("raised"))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5), 3, 3)
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(current.colour("text"))
        painter.drawText(QRectF(self.rect()), Qt.AlignmentFlag.AlignCenter, self._key)
