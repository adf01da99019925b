"""Buttons of the house: icon buttons that follow the theme, push buttons that carry their key."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QRect, QSize, Qt
from PySide6.QtGui import QFontMetrics, QGuiApplication, QPainter, QPaintEvent
from PySide6.QtWidgets import QPushButton, QStyle, QStyleOptionButton, QStylePainter, QToolButton, QToolTip, QWidget

from widgets import theme


class IconButton(QToolButton):
    """A square button with a line icon, 24 px (20 in title bars); it tints itself when the theme changes.

    Parameters
    ----------
    icon : str
        Icon name for ``widgets.theme.icon``.
    tip : str
        What it does, with the shortcut in brackets; also its accessible name.
    checkable : bool
        Whether it stays down.
    edge, glyph : int
        Edge of the button and of the icon in pixels.
    """

    def __init__(
        self,
        icon: str,
        tip: str,
        *,
        checkable: bool = False,
        edge: int = 24,
        glyph: int = 16,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._icon, self._glyph, self._tip = icon, glyph, tip
        theme.fix(self, edge, edge)
        theme.fix_icon(self, glyph)
        self.setCheckable(checkable)
        self.setToolTip(tip)
        self.setAccessibleName(tip.split(" (")[0])
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.toggled.connect(self._tint)
        theme.signals.changed.connect(self._tint)
        self._tint()

    def set_icon_name(self, icon: str) -> None:
        """Show another icon."""
        self._icon = icon
        self._tint()

    def set_available(self, available: bool, reason: str = "") -> None:
        """Enable the button, or disable it and say why in the tooltip."""
        self.setEnabled(available)
        self.setToolTip(self._tip if available or not reason else f"{self._tip}\n{reason}")

    def _tint(self) -> None:
        role = "text" if self.isChecked() else "dim"
        self.setIcon(theme.icon(self._icon, role, self._glyph))


class KeyButton(QPushButton):
    """A push button whose key stands beside its text in a dimmer, smaller hand.

    Parameters
    ----------
    text : str
        What it does.
    key : str
        The shortcut as it is written on the button; the shortcut itself belongs to the window.
    primary : bool
        Whether it is the one accented action of its panel.
    """

    def __init__(self, text: str, key: str = "", *, primary: bool = False, parent: QWidget | None = None) -> None:
        super().__init__(text, parent)
        self._key = key
        self._tip = ""
        self.setProperty("primary", primary)
        self._dress()
        theme.signals.changed.connect(self._dress)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName(f"{text} ({key})" if key else text)

    def show_key(self, key: str) -> None:
        """Write another key on the button, or none."""
        self._key = key
        self.updateGeometry()
        self.update()

    def set_available(self, available: bool, reason: str = "") -> None:
        """Enable the button, or disable it and say why in the tooltip."""
        self.setEnabled(available)
        self.setToolTip(self._describe() if available or not reason else reason)

    def _dress(self) -> None:
        self.setFont(theme.font(bold=bool(self.property("primary"))))
        self.updateGeometry()

    def _describe(self) -> str:
        return f"{self.text()} ({self._key})" if self._key else self.text()

    def _key_width(self) -> int:
        return QFontMetrics(theme.font(theme.TABLE_PX)).horizontalAdvance(self._key) + theme.px(6) if self._key else 0

    def _text_font(self) -> QFontMetrics:
        return QFontMetrics(theme.font(bold=bool(self.property("primary"))))

    def sizeHint(self) -> QSize:
        """Return the room for text and key, 24 high at 100 %."""
        width = self._text_font().horizontalAdvance(self.text()) + self._key_width()
        return QSize(width + theme.px(20) + self._icon_width(), theme.px(24))

    def minimumSizeHint(self) -> QSize:
        """Return the room for the text: a button never cuts it, but leaves the key out where it is narrow."""
        return self.sizeHint() - QSize(self._key_width(), 0)

    def _icon_width(self) -> int:
        return 0 if self.icon().isNull() else theme.px(20)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the frame by style, then icon, text and key centred together."""
        painter = QStylePainter(self)
        option = QStyleOptionButton()
        self.initStyleOption(option)
        option.text = ""
        option.icon = type(option.icon)()
        painter.drawControl(QStyle.ControlElement.CE_PushButton, option)
        self._paint_content(painter)

    def _paint_content(self, painter: QPainter) -> None:
        current = theme.current()
        primary = bool(self.property("primary"))
        main, dim = ("on_accent", "on_accent") if primary else ("text", "dim")
        if not self.isEnabled():
            main = dim = "missing"
        text_width, icon_width = self._text_font().horizontalAdvance(self.text()), self._icon_width()
        key_width = self._key_width() if self.width() >= self.sizeHint().width() else 0
        left = (self.width() - text_width - key_width - icon_width) // 2
        if icon_width:
            edge = theme.px(16)
            self.icon().paint(painter, left, (self.height() - edge) // 2, edge, edge)
            left += icon_width
        painter.setFont(theme.font(bold=primary))
        painter.setPen(current.colour(main))
        painter.drawText(QRect(left, 0, text_width + 4, self.height()), Qt.AlignmentFlag.AlignVCenter, self.text())
        if key_width:
            painter.setFont(theme.font(theme.TABLE_PX))
            painter.setPen(current.colour(dim, 0.82 if primary and self.isEnabled() else 1.0))
            box = QRect(left + text_width + theme.px(6), 0, key_width, self.height())
            painter.drawText(box, Qt.AlignmentFlag.AlignVCenter, self._key)


class CopyButton(QToolButton):
    """A small value with its name, which a click puts on the clipboard; hidden while there is none."""

    def __init__(self, tip: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._value, self._tip = "", tip
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setToolTip(tip)
        self.clicked.connect(self._copy)
        theme.signals.changed.connect(self._dress)
        self._dress()
        self.hide()

    def set_value(self, name: str, value: str) -> None:
        """Show another value; empty: none."""
        self._value = value
        self.setText(f"{name} {value}")
        self.setAccessibleName(f"{self._tip}, {value}")
        self.setVisible(bool(value))

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self._value)
        QToolTip.showText(self.mapToGlobal(QPoint(0, self.height())), f"Copied {self._value}", self)

    def _dress(self) -> None:
        self.setFont(theme.font(theme.TABLE_PX))
        self.setIcon(theme.icon("copy", "dim", 14))
        self.setIconSize(QSize(theme.px(14), theme.px(14)))
