"""The grey bar of the depth picture: which depth is white, which is dark, each with a handle."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QLinearGradient, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from widgets import theme

WIDTH, HEIGHT, SIDE = 212, 42, 10


class DepthBar(QWidget):
    """A grey ramp over the range of depths with two handles; a double click lets the scan choose again.

    Signals
    -------
    range_changed(float, float)
        Near and far in mm, while a handle is dragged.
    reset_requested()
        The scan's own range is wanted.
    """

    range_changed = Signal(float, float)
    reset_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._limits, self._range = (0.0, 1.0), (0.0, 1.0)
        self._held: int | None = None
        self._active = 0
        theme.fix(self, WIDTH, HEIGHT)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Range of the depth picture")
        self.setToolTip("Drag the ends; double click: the scan's own range. Keys: arrows, space for the other end")
        self.setCursor(Qt.CursorShape.ArrowCursor)

    def set_limits(self, near: float, far: float) -> None:
        """Set the depths, mm, at the bar's ends."""
        self._limits = (near, max(far, near + 1.0))
        self.update()

    def set_range(self, near: float, far: float) -> None:
        """Show a range in mm without telling anybody."""
        self._range = (near, far)
        self.update()

    @property
    def range(self) -> tuple[float, float]:
        """Near and far in mm."""
        return self._range

    def _x(self, depth: float) -> float:
        low, high = self._limits
        share = min(max((depth - low) / (high - low), 0.0), 1.0)
        return SIDE + share * (self.width() - 2 * SIDE)

    def _depth(self, x: float) -> float:
        low, high = self._limits
        return low + min(max((x - SIDE) / (self.width() - 2 * SIDE), 0.0), 1.0) * (high - low)

    def _set(self, which: int, depth: float) -> None:
        near, far = self._range
        least = (self._limits[1] - self._limits[0]) / 200
        self._range = (min(depth, far - least), far) if which == 0 else (near, max(depth, near + least))
        self.update()
        self.range_changed.emit(*self._range)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take the nearer handle."""
        if event.button() == Qt.MouseButton.LeftButton:
            near, far = (abs(event.position().x() - self._x(d)) for d in self._range)
            self._held = self._active = 0 if near <= far else 1

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Move the handle."""
        if self._held is not None:
            self._set(self._held, self._depth(event.position().x()))

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:
        """Let go."""
        self._held = None

    def mouseDoubleClickEvent(self, _event: QMouseEvent) -> None:
        """Ask for the scan's own range."""
        self._held = None
        self.reset_requested.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move the active handle by one part in a hundred; the space bar takes the other."""
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        if event.key() == Qt.Key.Key_Space:
            self._active = 1 - self._active
            self.update()
        elif step is not None:
            self._set(self._active, self._range[self._active] + step * (self._limits[1] - self._limits[0]) / 100)
        else:
            event.ignore()

    def sizeHint(self) -> QSize:
        """Return the fixed size."""
        return QSize(theme.px(WIDTH), theme.px(HEIGHT))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw plate, ramp, handles and both depths."""
        palette = theme.overlay()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(palette.colour("plate", palette.plate_alpha))
        painter.drawRoundedRect(QRectF(self.rect()), 3, 3)
        near, far = (self._x(d) for d in self._range)
        unit = self.height() / HEIGHT
        groove = QRectF(SIDE, 9 * unit, self.width() - 2 * SIDE, 8 * unit)
        ramp = QLinearGradient(near, 0, max(far, near + 1), 0)
        ramp.setColorAt(0, QColor("#ffffff"))
        ramp.setColorAt(1, QColor("#181818"))
        painter.fillRect(groove, ramp)
        for which, x in enumerate((near, far)):
            active = self.hasFocus() and which == self._active
            painter.setPen(QPen(palette.colour("accent" if active else "view_bottom"), 1))
            painter.setBrush(palette.colour("middle"))
            painter.drawRoundedRect(QRectF(x - 3 * unit, 6 * unit, 6 * unit, 14 * unit), 2, 2)
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(palette.colour("text"))
        text = QRectF(SIDE, 22 * unit, self.width() - 2 * SIDE, 16 * unit)
        painter.drawText(text, Qt.AlignmentFlag.AlignVCenter, f"{self._range[0]:.0f}")
        right = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight
        painter.drawText(text, right, f"{self._range[1]:.0f} mm from the scanner")
        painter.setPen(QPen(palette.colour("dim"), 1))
        painter.drawLine(QPointF(SIDE, 20.5 * unit), QPointF(SIDE, 22.5 * unit))
