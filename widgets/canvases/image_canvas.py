"""The picture of a scan with its fiducials: placed, dragged and nudged here, but only asked for, never kept."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtCore import QEvent, QPoint, QPointF, QRect, QRectF, Qt, Signal
from PySide6.QtGui import (
    QContextMenuEvent,
    QFocusEvent,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPixmap,
    QResizeEvent,
)
from PySide6.QtWidgets import QApplication, QMenu, QToolTip, QWidget

from engine.landmarks import LandmarkScheme, LandmarkSet, LandmarkState
from engine.mesh import FloatArray, IntArray
from widgets.canvases.canvas_keys import CanvasKeys
from widgets.canvases.fiducial_layer import FiducialLayer, Press
from widgets.canvases.fiducial_menu import fiducial_menu
from widgets.canvases.loupe import Loupe
from widgets.canvases.scan_view import ScanView
from widgets.canvases.wire import TemplateWire

DRAG_FROM_PX = 3.0
SLOW = 0.2


class ImageCanvas(ScanView):
    """Shows a scan's picture, template and fiducials and says what the user wants done with them.

    Positions are image pixels, origin top left, centres at integers.

    Signals
    -------
    place_requested(str, float, float)
        A click where the current fiducial, which is not placed yet, belongs.
    selected(str)
        A fiducial was pressed.
    drag_moved(str, float, float)
        The hand moves a fiducial; nothing is decided yet.
    moved(str, float, float)
        The hand let go of it; sent once a drag.
    drag_cancelled(str)
        Escape or a lost focus ended the drag; the fiducial is where it was.
    nudged(str, float, float)
        Arrow keys: by how many pixels.
    unset_requested(str), skip_requested(str), lock_requested(str, bool), confirm_requested(str)
        From the context menu.
    refused(str, str)
        A fiducial, and why nothing happens to it.
    view_changed(str), contrast_changed(float, float), zoom_changed(float)
        What is shown, between which depths in mm, at which scale.
    """

    place_requested = Signal(str, float, float)
    selected = Signal(str)
    drag_moved = Signal(str, float, float)
    moved = Signal(str, float, float)
    drag_cancelled = Signal(str)
    nudged = Signal(str, float, float)
    unset_requested = Signal(str)
    skip_requested = Signal(str)
    lock_requested = Signal(str, bool)
    confirm_requested = Signal(str)
    refused = Signal(str, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("image_canvas")
        self.setAccessibleName("Image of the scan")
        self.nothing = "The picture of the scan appears here,\nand the fiducials are clicked in it."
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._wire = TemplateWire()
        self._scene.addItem(self._wire)
        self.fiducials = FiducialLayer()
        self.loupe = Loupe(self)
        self._keep_loupe = False
        self._hover: QPointF | None = None
        self._press: Press | None = None
        self.keys = CanvasKeys(self)

    # What is shown ------------------------------------------------------------------------------------------------

    def _show_pixmap(self, pixmap: QPixmap) -> None:
        super()._show_pixmap(pixmap)
        self.loupe.set_picture(pixmap)
        self.follow()

    def set_scheme(self, scheme: LandmarkScheme | None) -> None:
        """Take the scheme that says which fiducials there are."""
        self.fiducials.scheme = scheme
        self.follow()

    def set_landmarks(self, landmarks: LandmarkSet) -> None:
        """Show fiducials; one that is being dragged stays in the hand."""
        self.fiducials.landmarks = landmarks
        if self._press is None or not self._press.dragging:
            self.fiducials.held = None
        self.follow()

    def set_current(self, name: str | None) -> None:
        """Mark the fiducial whose turn it is."""
        self.fiducials.current = name
        self.follow()

    def set_template(self, edges: IntArray | None, vertices: FloatArray | None) -> None:
        """Show the template: edges (E, 2) vertex indices, vertices (V, 2) image pixels; ``None`` shows none."""
        if edges is not None:
            self._wire.set_edges(edges)
        self._wire.set_vertices(vertices)
        self.viewport().update()

    def set_template_vertices(self, vertices: FloatArray | None) -> None:
        """Move the template, edges as they are; fast enough for every mouse move."""
        self._wire.set_vertices(vertices)
        self.viewport().update()

    @property
    def template_vertices(self) -> FloatArray:
        """Where the template's vertices (V, 2) are drawn, image pixels; empty while there is none."""
        return self._wire.vertices

    def set_folded(self, triangles: IntArray | None) -> None:
        """Show triangles (k, 3) vertex indices in red: there the template folded over."""
        self._wire.set_folded(triangles)
        self.viewport().update()

    def set_wire_visible(self, visible: bool) -> None:
        """Show or hide the template."""
        self._wire.setVisible(visible)

    def set_fiducials_visible(self, visible: bool) -> None:
        """Show or hide the fiducials; hidden ones cannot be taken."""
        self.fiducials.visible = visible
        self.follow()

    def set_loupe_kept(self, kept: bool) -> None:
        """Keep the loupe in sight, or show it only while a fiducial is placed, checked or dragged."""
        self._keep_loupe = kept
        self.follow()

    def content_rect(self) -> QRectF:
        """Return the template's box, else the measured part, else the picture, with a margin; image pixels."""
        whole = super().content_rect()
        vertices = self._wire.vertices
        if len(vertices) and self._wire.isVisible():
            (left, top), (right, bottom) = vertices.min(axis=0), vertices.max(axis=0)
            box, margin = QRectF(left, top, right - left, bottom - top), 0.085
        elif self._valid is not None and self._valid.any():
            rows, columns = np.flatnonzero(self._valid.any(axis=1)), np.flatnonzero(self._valid.any(axis=0))
            corners = [float(v) for v in (columns[0], rows[0], np.ptp(columns), np.ptp(rows))]
            box, margin = QRectF(*corners), 0.02
        else:
            return whole
        dx, dy = margin * box.width(), margin * box.height()
        return box.adjusted(-dx, -dy, dx, dy).intersected(whole)

    # The hand -----------------------------------------------------------------------------------------------------

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take a fiducial, begin to place the current one, or pan."""
        if self._press is not None or self.is_panning:
            if event.button() == Qt.MouseButton.RightButton:
                self.cancel()
            return
        if self.start_pan(event) or event.button() != Qt.MouseButton.LeftButton:
            return
        position = event.position()
        free = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
        name = None if free else self.fiducials.at(position, self.to_view)
        if name is not None:
            place = self.fiducials.place(name) or self.to_picture(position)
            # A click on the ring whose turn it is means the pixel under the pointer, not the proposal.
            here = self.to_picture(position) if name == self.fiducials.current and self._can_place() else None
            self._press = Press(name, position, position, place, placing=False, clicked=here)
            self.selected.emit(name)
        elif self._can_place():
            assert self.fiducials.current is not None
            here = self.to_picture(position)
            self._press = Press(self.fiducials.current, position, position, here, placing=True)
        self.follow()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Drag what the hand holds, pan, or look where the hand is."""
        self.keys.cross = None
        self._hover = event.position()
        if self.is_panning:
            self.continue_pan(event)
            return
        press = self._press
        if press is None:
            over = self.fiducials.at(event.position(), self.to_view)
            placing = over is None and self._can_place()
            cursor = Qt.CursorShape.CrossCursor if placing else Qt.CursorShape.ArrowCursor
            self.viewport().setCursor(Qt.CursorShape.PointingHandCursor if over else cursor)
        elif press.placing:
            press.place = self.to_picture(event.position())
        else:
            self._drag(press, event)
        self.follow()

    def _drag(self, press: Press, event: QMouseEvent) -> None:
        off = event.position() - press.start
        if not press.dragging and (off.x() ** 2 + off.y() ** 2) ** 0.5 < DRAG_FROM_PX:
            return
        if self.fiducials.landmarks[press.name].locked:
            self._press = None
            self.refused.emit(press.name, "is locked; unlock it to move it")
            return
        press.dragging = True
        slow = SLOW if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1.0
        press.place = press.place + (event.position() - press.last) * (slow / self.zoom)
        press.last = event.position()
        self.fiducials.held = (press.name, press.place)
        self.drag_moved.emit(press.name, press.place.x(), press.place.y())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Let go: place, or finish the drag."""
        if self.is_panning:
            self.end_pan()
            return
        if self._press is None or event.button() != Qt.MouseButton.LeftButton:
            return
        press, self._press = self._press, None
        if press.placing:
            if self._picture.boundingRect().contains(press.place):
                self.place_requested.emit(press.name, press.place.x(), press.place.y())
            else:
                self.refused.emit(press.name, "lies outside the picture; click inside it")
        elif press.dragging:
            self.moved.emit(press.name, press.place.x(), press.place.y())
        elif press.clicked is not None:
            self.place_requested.emit(press.name, press.clicked.x(), press.clicked.y())
        self.fiducials.held = None
        self.follow()

    def cancel(self) -> None:
        """Give up a drag or a placing; the fiducial stays where it was."""
        press, self._press = self._press, None
        self.fiducials.held = None
        if press is not None and press.dragging:
            self.drag_cancelled.emit(press.name)
        self.follow()

    def _can_place(self) -> bool:
        layer = self.fiducials
        if layer.scheme is None or layer.current not in layer.scheme or not layer.visible:
            return False
        point = layer.landmarks[str(layer.current)]
        return point.state is not LandmarkState.PLACED and not point.locked and not self._picture.pixmap().isNull()

    # Keys and menus -----------------------------------------------------------------------------------------------

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Cancel with escape, frame with F, 1 : 1 with 1; arrows, Enter, plus and minus as `CanvasKeys` says."""
        key = Qt.Key(event.key())
        if key == Qt.Key.Key_Space:
            super().keyPressEvent(event)
            if not self.is_panning and self._press is None:
                self.viewport().setCursor(Qt.CursorShape.OpenHandCursor)
        elif key == Qt.Key.Key_Escape and self._press is not None:
            self.cancel()
        elif self._press is None and self.keys.press(event):
            event.accept()
        elif key == Qt.Key.Key_F and not event.modifiers():
            self.toggle_fit()
        elif key == Qt.Key.Key_1 and not event.modifiers():
            self.actual_size()
        else:
            event.ignore()

    def can_place_here(self) -> bool:
        """Return whether the current fiducial has no place yet and can be given one."""
        return self._can_place() and self.fiducials.place(str(self.fiducials.current)) is None

    def nudge(self, direction: tuple[int, int], step: float) -> None:
        """Ask for the current fiducial to be moved by ``step`` image pixels."""
        name = self.fiducials.current
        if name is None or not self.fiducials.landmarks[name].is_set:
            return
        if self.fiducials.landmarks[name].locked:
            self.refused.emit(name, "is locked; unlock it to move it")
            return
        self.nudged.emit(name, direction[0] * step, direction[1] * step)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Stop panning with the space bar, and show that."""
        super().keyReleaseEvent(event)
        if event.key() == Qt.Key.Key_Space and not event.isAutoRepeat() and not self.is_panning:
            self.viewport().unsetCursor()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """End a drag where the window loses the keys to another."""
        if self._press is not None and event.reason() == Qt.FocusReason.ActiveWindowFocusReason:
            self.cancel()
        super().focusOutEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Stop looking where the hand was."""
        self._hover = None
        self.follow()
        super().leaveEvent(event)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Offer what can be done with the fiducial under the mouse."""
        by_key = event.reason() == QContextMenuEvent.Reason.Keyboard
        name = self.fiducials.current if by_key else self.fiducials.at(QPointF(event.pos()), self.to_view)
        if name is None or self._press is not None:
            event.setAccepted(self._press is not None or self.is_panning)
            return
        self.selected.emit(name)
        menu = self.fiducial_menu(name)
        menu.exec(event.globalPos())
        menu.deleteLater()

    def fiducial_menu(self, name: str) -> QMenu:
        """Return the context menu of a fiducial."""
        orders = {
            "confirm": partial(self.confirm_requested.emit, name),
            "skip": partial(self.skip_requested.emit, name),
            "unset": partial(self.unset_requested.emit, name),
            "lock": partial(self.lock_requested.emit, name),
        }
        return fiducial_menu(self, self.fiducials.landmarks[name], orders)

    def viewportEvent(self, event: QEvent) -> bool:
        """Show the name of the fiducial under the mouse."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            name = self.fiducials.at(QPointF(event.pos()), self.to_view)
            if name is None:
                QToolTip.hideText()
            else:
                point = self.fiducials.landmarks[name]
                state = "locked" if point.locked else str(point.state)
                QToolTip.showText(event.globalPos(), f"{name}, {state}", self.viewport())
            return True
        return super().viewportEvent(event)

    # Following ----------------------------------------------------------------------------------------------------

    def view_moved(self) -> None:
        """Follow a zoom or pan."""
        super().view_moved()
        self.follow()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the loupe in its corner."""
        super().resizeEvent(event)
        self.follow()

    def drawForeground(self, painter: QPainter, _rect: QRectF | QRect) -> None:
        """Draw the fiducials in screen pixels."""
        painter.save()
        painter.resetTransform()
        self.fiducials.paint(painter, self.to_view, QRectF(self.viewport().rect()))
        self.keys.paint(painter)
        painter.restore()

    def follow(self) -> None:
        """Bring loupe, marks and crosshair up to date with what is shown."""
        if not hasattr(self, "keys"):
            return
        cross = self.keys.shown
        place = cross if cross is not None else self._loupe_place()
        self.loupe.setVisible(place is not None)
        if place is not None:
            self.loupe.look_at(place)
            self.loupe.move(self._loupe_corner(place))
        self.viewport().update()

    def _loupe_place(self) -> QPointF | None:
        layer, press = self.fiducials, self._press
        if self._picture.pixmap().isNull() or not layer.visible:
            return None
        if press is not None and (press.placing or press.dragging):
            return press.place
        hovered = None if self._hover is None or self.is_panning else self.to_picture(self._hover)
        if layer.current is None:
            return hovered if self._keep_loupe else None
        place = layer.place(layer.current)
        if place is None:
            return hovered
        proposed = layer.landmarks[layer.current].state is LandmarkState.PROPOSED
        return place if proposed or self._keep_loupe else None

    def _loupe_corner(self, place: QPointF) -> QPoint:
        right = self.width() - self.loupe.width() - 8
        at = self.to_view(place)
        hand = QApplication.mouseButtons() != Qt.MouseButton.NoButton and self._hover is not None
        taken = QRectF(right, 8, self.loupe.width(), self.loupe.height()).adjusted(-24, -24, 24, 24)
        hidden = taken.contains(at) or (hand and self._hover is not None and taken.contains(self._hover))
        return QPoint(8 if hidden else right, 30 if hidden else 8)
