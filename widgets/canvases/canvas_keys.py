"""The keys of the picture: nudging, and a crosshair that places a fiducial without the mouse."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QLineF, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QPainter, QPen

from widgets import theme

if TYPE_CHECKING:
    from widgets.canvases.image_canvas import ImageCanvas

HABITS: tuple[tuple[str, str], ...] = (
    ("Click", "Place the current fiducial"),
    ("Alt + click", "Place it on top of another one"),
    ("Drag", "Move a fiducial"),
    ("Shift + drag", "Move it five times finer"),
    ("Right click", "What can be done with a fiducial"),
    ("Space + drag", "Shift the picture"),
    ("Arrow keys", "Nudge the fiducial by 0.1 px; one without a place: move the crosshair by 1 px"),
    ("Shift + arrow keys", "Nudge the fiducial by 1 px; move the crosshair by 10 px"),
    ("Ctrl + arrow keys", "Move the crosshair by 0.1 px"),
    ("Enter", "Place the fiducial at the crosshair"),
    ("Esc", "Give up the drag, or hide the crosshair"),
    ("+", "Zoom in"),
    ("-", "Zoom out"),
    ("1", "One pixel of the picture to one of the screen"),
)
"""What the hand does in the picture and what comes of it, for the overview of shortcuts."""

ARROWS = {
    Qt.Key.Key_Left: (-1, 0),
    Qt.Key.Key_Right: (1, 0),
    Qt.Key.Key_Up: (0, -1),
    Qt.Key.Key_Down: (0, 1),
}
ZOOMS = {Qt.Key.Key_Plus: 1.25, Qt.Key.Key_Equal: 1.25, Qt.Key.Key_Minus: 0.8}
ARM, GAP, MARGIN = 22.0, 5.0, 32.0


class CanvasKeys:
    """What the keys mean to one canvas.

    Attributes
    ----------
    cross : QPointF or None
        The crosshair, image pixels; it is there only while the current fiducial has no place and the arrows are used.
    """

    def __init__(self, canvas: ImageCanvas) -> None:
        self._canvas = canvas
        self.cross: QPointF | None = None

    def press(self, event: QKeyEvent) -> bool:
        """Do what a key means and return whether it meant anything."""
        canvas, key = self._canvas, Qt.Key(event.key())
        control = event.modifiers() & Qt.KeyboardModifier.ControlModifier
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        if key in ARROWS and canvas.can_place_here():
            self._move(ARROWS[key], 10.0 if shift else 0.1 if control else 1.0)
        elif key in ARROWS:
            canvas.nudge(ARROWS[key], 1.0 if shift else 0.1)
        elif key in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.cross is not None and canvas.can_place_here():
            canvas.place_requested.emit(str(canvas.fiducials.current), self.cross.x(), self.cross.y())
        elif key == Qt.Key.Key_Escape and self.cross is not None:
            self.hide()
        elif key in ZOOMS and not control:
            canvas.set_zoom(canvas.zoom * ZOOMS[key], None if self.cross is None else canvas.to_view(self.cross))
        else:
            return False
        return True

    def hide(self) -> None:
        """Take the crosshair away."""
        if self.cross is not None:
            self.cross = None
            self._canvas.follow()

    @property
    def shown(self) -> QPointF | None:
        """Where the crosshair is seen, image pixels; None where it has nothing to place."""
        return self.cross if self.cross is not None and self._canvas.can_place_here() else None

    def paint(self, painter: QPainter) -> None:
        """Draw the crosshair; the painter is in screen pixels."""
        place = self.shown
        if place is None:
            return
        at = self._canvas.to_view(place)
        lines = [
            QLineF(at + QPointF(x * GAP, y * GAP), at + QPointF(x * ARM, y * ARM))
            for x, y in ((-1, 0), (1, 0), (0, -1), (0, 1))
        ]
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for pen in (QPen(theme.overlay().colour("plate"), 3.6), QPen(theme.overlay().colour("accent"), 1.8)):
            painter.setPen(pen)
            painter.drawLines(lines)

    def _move(self, direction: tuple[int, int], step: float) -> None:
        canvas = self._canvas
        if self.cross is None:
            self.cross = self._start()
        else:
            whole = canvas.picture_rect()
            x = min(max(self.cross.x() + direction[0] * step, whole.left() + 0.5), whole.right() - 0.5)
            y = min(max(self.cross.y() + direction[1] * step, whole.top() + 0.5), whole.bottom() - 0.5)
            self.cross = QPointF(x, y)
        canvas.bring_into_view(self.cross, MARGIN)
        canvas.follow()

    def _start(self) -> QPointF:
        """Return where the crosshair appears: in the middle of what is seen, on a whole pixel."""
        middle = self._canvas.to_picture(QPointF(self._canvas.viewport().rect().center()))
        whole = self._canvas.picture_rect()
        if not whole.contains(middle):
            middle = whole.center()
        return QPointF(round(middle.x()), round(middle.y()))
