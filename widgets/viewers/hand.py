"""The hand on a 3-D view: what mouse, wheel and fingers do to its camera, by the navigation style in use."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QInputDevice, QMouseEvent, QNativeGestureEvent, QWheelEvent

from widgets.viewers import navigation
from widgets.viewers.navigation import Deed

if TYPE_CHECKING:
    from widgets.viewers.mesh_viewer import MeshViewer

_TURN = np.radians(0.42)
"""Radians of orbit to a pixel of hand."""
_NEARER = 0.006
"""Share of the distance, as a logarithm, to a pixel of hand."""
_NOTCH = 1.15
"""How much one notch of the wheel nears."""


class Hand:
    """Turns mouse events on a viewer into moves of its camera; a tool of the viewer gets the left button first."""

    def __init__(self, viewer: MeshViewer) -> None:
        self._viewer = viewer
        self._drag: Deed | None = None
        self._tool_drag = False
        self._button = Qt.MouseButton.NoButton
        self._last = QPointF()
        self._grip: NDArray[np.float64] | None = None
        self._view = 0

    @property
    def busy(self) -> bool:
        """Whether a button is held that moves something."""
        return self._tool_drag or self._drag is not None

    def take(self, event: QEvent) -> bool:
        """Take an event of the viewer's interactor; returns whether it was one for the hand."""
        if isinstance(event, QNativeGestureEvent):
            return self._pinch(event)
        if isinstance(event, QWheelEvent):
            self._wheel(event)
            return True
        if not isinstance(event, QMouseEvent):
            return False
        handlers = {
            QEvent.Type.MouseButtonPress: self._press,
            QEvent.Type.MouseButtonRelease: self._release,
            QEvent.Type.MouseMove: self._move,
            QEvent.Type.MouseButtonDblClick: self._double_click,
        }
        handler = handlers.get(event.type())
        if handler is None:
            return False
        handler(event)
        event.accept()
        return True

    def _press(self, event: QMouseEvent) -> None:
        if self.busy:
            return
        viewer = self._viewer
        view, x, y = self._where(event.position())
        viewer.plotter.setFocus(Qt.FocusReason.MouseFocusReason)
        self._last, self._button = event.position(), event.button()
        deed = navigation.current().in_view(event.button(), event.modifiers())
        tool = viewer.tool
        if event.button() == Qt.MouseButton.LeftButton and tool is not None and tool.press(view, x, y):
            self._tool_drag = True
        elif deed is not None:
            self._drag = deed
            self._grip = self._target(view, x, y)
        viewer.left.emit()

    def _move(self, event: QMouseEvent) -> None:
        viewer, tool = self._viewer, self._viewer.tool
        if not self.busy:
            view, x, y = self._where(event.position())
            cursor = tool.cursor(view, x, y) if tool is not None else None
            viewer.plotter.setCursor(cursor if cursor is not None else Qt.CursorShape.ArrowCursor)
            viewer.hovered.emit(view, x, y)
            return
        step = event.position() - self._last
        self._last = event.position()
        if self._tool_drag:
            if tool is not None:
                _, x, y = self._where(event.position(), fixed=True)
                tool.drag(x, y)
                viewer.hasten()
        elif self._drag is not None:
            self._do(self._drag, step)

    def _do(self, deed: Deed, step: QPointF) -> None:
        """Follow a step of the hand in pixels of the layout, y down."""
        from widgets.scene import camera as hand

        viewer = self._viewer
        camera = viewer.camera
        if deed == "orbit":
            hand.orbit(camera, self._pivot(), -_TURN * step.x(), _TURN * step.y())
        elif deed == "pan" and self._grip is not None:
            height = viewer.view_size(self._view)[1]
            hand.pan(camera, step.x() * viewer.scale, -step.y() * viewer.scale, self._grip, height)
        elif deed == "zoom" and self._grip is not None:
            hand.zoom(camera, float(np.exp(-_NEARER * step.y())), self._grip)
        elif deed == "dolly":
            hand.zoom(camera, float(np.exp(_NEARER * (step.x() - step.y()))), self._ahead())
        viewer.hasten()
        viewer.camera_moved()

    def _release(self, event: QMouseEvent) -> None:
        if event.button() != self._button:
            return
        tool, held = self._viewer.tool, self._tool_drag
        self._drag, self._tool_drag, self._grip = None, False, None
        if held and tool is not None:
            tool.release()

    def _double_click(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton:
            # The second press of a fast pair: a drag may begin with it.
            self._press(event)
            return
        view, x, y = self._where(event.position())
        viewer = self._viewer
        if viewer.tool is not None and viewer.tool.double_click(view, x, y):
            return
        hit = viewer.pick(view, x, y)
        if hit is not None:
            viewer.set_pivot(hit)

    def _wheel(self, event: QWheelEvent) -> None:
        event.accept()
        device = event.pointingDevice()
        fingers = device is not None and device.type() == QInputDevice.DeviceType.TouchPad
        angle = event.angleDelta()
        deed = navigation.current().in_view("fingers" if fingers else "wheel", event.modifiers())
        if deed is None or self.busy:
            return
        if fingers and deed in ("orbit", "pan"):
            step = event.pixelDelta() if not event.pixelDelta().isNull() else angle / 8
            view, x, y = self._where(event.position())
            self._grip = self._target(view, x, y)
            self._do(deed, QPointF(step))
            self._grip = None
        else:
            self._near(_NOTCH ** ((angle.y() or angle.x()) / 120.0), event.position(), deed)

    def _pinch(self, event: QNativeGestureEvent) -> bool:
        if event.gestureType() != Qt.NativeGestureType.ZoomNativeGesture:
            return False
        self._near(max(1.0 + event.value(), 0.2), event.position(), "zoom")
        event.accept()
        return True

    def _near(self, factor: float, place: QPointF, deed: Deed) -> None:
        from widgets.scene.camera import zoom

        if factor == 1.0:
            return
        target = self._ahead() if deed == "dolly" else self._target(*self._where(place))
        zoom(self._viewer.camera, factor, target)
        self._viewer.hasten()
        self._viewer.camera_moved()

    def _pivot(self) -> NDArray[np.float64]:
        pivot = self._viewer.pivot
        return pivot if pivot is not None else np.array(self._viewer.camera.GetFocalPoint())

    def _ahead(self) -> NDArray[np.float64]:
        """Return the point in the middle of the picture at the pivot's depth."""
        from widgets.scene.camera import axes

        camera = self._viewer.camera
        focal = np.array(camera.GetFocalPoint())
        back = axes(camera)[0]
        return np.asarray(focal + float((self._pivot() - focal) @ back) * back)

    def _target(self, view: int, x: float, y: float) -> NDArray[np.float64]:
        """Return what a pixel shows; beside the subject, the place there at the focus's depth."""
        from widgets.scene.camera import on_plane

        viewer = self._viewer
        hit = viewer.pick(view, x, y)
        if hit is not None:
            return hit
        return on_plane(viewer.camera, viewer.segment(view, x, y), np.array(viewer.camera.GetFocalPoint()))

    def _where(self, place: QPointF, *, fixed: bool = False) -> tuple[int, float, float]:
        view, x, y = self._viewer.where(place, self._view if fixed else None)
        self._view = view
        return view, x, y


def menu_wanted(modifiers: Qt.KeyboardModifier) -> bool:
    """Return whether a right press opens a menu: where the style does nothing else with it."""
    return navigation.current().in_view("right", modifiers) is None
