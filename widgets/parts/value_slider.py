"""A slider of real numbers: groove 2, handle 12, filled from its origin, with a shaded range where one is known."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from widgets import theme


class ValueSlider(QWidget):
    """A slider from ``low`` to ``high``.

    Drag, or click where the handle shall go; Ctrl-drag moves it a tenth as fast. Arrow keys step, Shift leaps,
    Home and End go to the ends, double click or Backspace back to where it belongs.

    Parameters
    ----------
    low, high : float
    origin : float
        Where it is filled from.
    reset : float, optional
        What double click and Backspace go back to; ``origin`` where left out.
    step : float
        What an arrow key moves.
    name : str
        Accessible name.

    Signals
    -------
    dragged(float)
        While the mouse moves it.
    released(float)
        When it is let go, or moved by keys or reset, and its value is another one.
    """

    dragged = Signal(float)
    released = Signal(float)

    def __init__(
        self,
        low: float,
        high: float,
        origin: float = 0.0,
        step: float = 0.05,
        name: str = "",
        reset: float | None = None,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.low, self.high, self.origin, self.step = low, high, origin, step
        self.reset = origin if reset is None else reset
        self._value = self._begun = self.reset
        self._band: tuple[float, float] | None = None
        self._drag: tuple[float, float] | None = None
        self._name, self._role = name, "accent"
        self.setAccessibleName(name)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        theme.fix(self, height=20)
        theme.signals.changed.connect(self.update)

    @property
    def value(self) -> float:
        """Where it stands."""
        return self._value

    @property
    def is_dragged(self) -> bool:
        """Whether the mouse holds it."""
        return self._drag is not None

    def set_value(self, value: float) -> None:
        """Put it somewhere without telling anybody; a hand that holds it goes first."""
        if not self.is_dragged:
            self._put(value)
            self._begun = self._value

    def set_band(self, band: tuple[float, float] | None) -> None:
        """Shade a range."""
        self._band = band
        self.update()

    def set_role(self, role: str) -> None:
        """Use another colour role for what is filled and for the handle."""
        self._role = role
        self.update()

    def x_of(self, value: float) -> float:
        """Return the place of a value, pixels of this widget."""
        half = theme.px(6)
        return half + (value - self.low) / (self.high - self.low) * max(1, self.width() - 2 * half)

    def _value_at(self, x: float) -> float:
        half = theme.px(6)
        return self.low + (x - half) / max(1, self.width() - 2 * half) * (self.high - self.low)

    def _put(self, value: float) -> None:
        self._value = min(max(value, self.low), self.high)
        self.setAccessibleDescription(f"{self._value:.2f}")
        self.update()

    def _settle(self, value: float) -> None:
        self._put(value)
        if self._value != self._begun:
            self._begun = self._value
            self.released.emit(self._value)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take the handle; beside it, bring it here first."""
        if event.button() != Qt.MouseButton.LeftButton:
            return
        x = event.position().x()
        near = abs(x - self.x_of(self._value)) <= theme.px(8)
        self._begun = self._value
        if not near:
            self._put(self._value_at(x))
            self.dragged.emit(self._value)
        self._drag = (x, self._value)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Move the handle with the hand."""
        if self._drag is None:
            return
        x, value = event.position().x(), self._value
        fine = 0.1 if event.modifiers() & Qt.KeyboardModifier.ControlModifier else 1.0
        moved = (self._value_at(x) - self._value_at(self._drag[0])) * fine
        goal = min(max(self._drag[1] + moved, self.low), self.high)
        if fine < 1.0:
            self._drag = (x, goal)
        if goal != value:
            self._put(goal)
            self.dragged.emit(self._value)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Let go."""
        if event.button() == Qt.MouseButton.LeftButton and self._drag is not None:
            self._drag = None
            self._settle(self._value)

    def mouseDoubleClickEvent(self, _event: QMouseEvent) -> None:
        """Go back to where it belongs."""
        self._drag = None
        self._settle(self.reset)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Step, leap, go to an end or back to where it belongs."""
        step = self.step * (5 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1)
        goals = {
            Qt.Key.Key_Left: self._value - step,
            Qt.Key.Key_Right: self._value + step,
            Qt.Key.Key_Home: self.low,
            Qt.Key.Key_End: self.high,
            Qt.Key.Key_Backspace: self.reset,
        }
        goal = goals.get(Qt.Key(event.key()))
        if goal is None:
            super().keyPressEvent(event)
        else:
            self._settle(round(goal / self.step) * self.step if event.key() in _STEPS else goal)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Leave the wheel to what scrolls around it."""
        event.ignore()

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show that the keys are here."""
        self.update()
        super().focusInEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Show that they are elsewhere."""
        self.update()
        super().focusOutEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw band, groove, what is filled, and the handle."""
        current, painter, px = theme.current(), QPainter(self), theme.px
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, left, right = self.height() / 2, self.x_of(self.low), self.x_of(self.high)
        there = self.isEnabled()
        if self._band is not None:
            ends = [min(max(self.x_of(v), left), right) for v in self._band]
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(current.colour("dim", 0.34))
            painter.drawRoundedRect(QRectF(ends[0], middle - px(5), ends[1] - ends[0], px(10)), 2, 2)
        groove = QPen(current.colour("missing" if self._band is not None else "line"), px(2))
        groove.setCapStyle(Qt.PenCapStyle.RoundCap)
        painter.setPen(groove)
        painter.drawLine(QPointF(left, middle), QPointF(right, middle))
        start, end = self.x_of(self.origin), self.x_of(self._value)
        if self.low < self.origin < self.high:
            painter.setPen(QPen(current.colour("dim"), 1))
            x = round(start) + 0.5
            painter.drawLine(QPointF(x, middle - px(4)), QPointF(x, middle + px(4)))
        groove.setColor(current.colour(self._role if there else "missing"))
        painter.setPen(groove)
        if abs(end - start) >= 1:
            painter.drawLine(QPointF(start, middle), QPointF(end, middle))
        painter.setPen(QPen(current.colour("panel"), 1.5))
        painter.setBrush(current.colour(self._role if there else "missing"))
        radius = px(6) if there else px(5)
        painter.drawEllipse(QPointF(end, middle), radius, radius)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(current.colour("text"), 1.2))
            painter.drawEllipse(QPointF(end, middle), radius - 1, radius - 1)

    def sizeHint(self) -> QSize:
        """Return a modest width."""
        return QSize(theme.px(120), theme.px(20))

    def minimumSizeHint(self) -> QSize:
        """Return what can still be aimed at."""
        return QSize(theme.px(48), theme.px(20))


_STEPS = (Qt.Key.Key_Left, Qt.Key.Key_Right)
