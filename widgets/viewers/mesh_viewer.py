"""The one place where a 3-D picture meets Qt: linked views, a hand on the camera, nothing else."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, QTimer, Signal
from PySide6.QtGui import QColor, QContextMenuEvent, QImage, QKeyEvent, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtOpenGLWidgets import QOpenGLWidget
from PySide6.QtWidgets import QVBoxLayout, QWidget

from widgets.viewers.arrangement import Cell, in_a_grid, in_a_run
from widgets.viewers.hand import Hand, menu_wanted
from widgets.viewers.tool import Tool

GAP_PX = 2
DPI = 72
"""Dots an inch at which points of a font are pixels of the screen."""
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software", "microsoft basic render")
_REST_MS = 140

Picker = Callable[[tuple[NDArray[np.float64], NDArray[np.float64]]], "NDArray[np.float64] | None"]


class MeshViewer(QWidget):
    """Linked 3-D views over one ``pyvistaqt.QtInteractor``, which is made after the window has been painted.

    What the hand does to the camera is written in ``navigation``; a double click sets the pivot. It has no timer of
    its own: a frame is drawn when somebody asks, and many requests before the next frame make one.
    """

    ready = Signal()
    """The plotter exists; build the scene now."""
    camera_changed = Signal()
    resized = Signal()
    hovered = Signal(int, float, float)
    """View and pixel from its lower left while no button is down."""
    left = Signal()
    menu_requested = Signal(QPoint)
    """A menu is wanted at a global place."""

    def __init__(self, views: int = 1, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._count = views
        self._shown = list(range(views))
        self._cells: dict[int, Cell] | None = None
        self._changed: set[int] | None = set()
        self._rects: dict[int, tuple[float, float, float, float]] = {}
        self._interactor: Any = None
        self._gap: Any = None
        self._begun, self._closed = False, False
        self._software = False
        self._bounds: Sequence[float] | None = None
        self._pivot: NDArray[np.float64] | None = None
        self._picker: Picker | None = None
        self._tool: Tool | None = None
        self._hand = Hand(self)
        self._window_colour = (0.118, 0.122, 0.133)
        self._rest = QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(_REST_MS)
        self._rest.timeout.connect(self._refine)
        self._box = QVBoxLayout(self)
        self._box.setContentsMargins(0, 0, 0, 0)
        # The first GL widget in a window makes Qt rebuild that window: have one before it is shown.
        self._forerunner: QOpenGLWidget | None = QOpenGLWidget(self)
        self._forerunner.setFixedSize(1, 1)
        self.setMinimumSize(160, 120)

    @property
    def plotter(self) -> Any:
        """The pyvista plotter, None until ``ready``."""
        return self._interactor

    @property
    def views(self) -> int:
        """How many views there are, seen or not."""
        return self._count

    @property
    def camera(self) -> Any:
        """The camera all views share."""
        return self._interactor.renderers[0].camera

    @property
    def tool(self) -> Tool | None:
        """What gets the left button before the camera."""
        return self._tool

    @property
    def pivot(self) -> NDArray[np.float64] | None:
        """The point in mm that the camera turns around; None is the middle of the picture."""
        return self._pivot

    @property
    def scale(self) -> float:
        """Screen pixels to a pixel of the layout."""
        return self.devicePixelRatioF()

    @property
    def software(self) -> bool:
        """Whether pictures are drawn by the processor."""
        return self._software

    def start(self) -> None:
        """Make the plotter now; does nothing the second time or after ``close``."""
        if self._interactor is not None or self._closed:
            return
        from pyvistaqt import QtInteractor

        interactor = QtInteractor(self, auto_update=False, multi_samples=0, shape=(self._count, 1), border=False)
        interactor.setAcceptDrops(False)
        interactor.iren.clear_key_event_callbacks()
        interactor.link_views()
        interactor.installEventFilter(self)
        self._interactor = interactor
        window: Any = interactor.render_window
        # Text is measured in pixels of the screen; the widget scales it once more whenever it is resized.
        window.AddObserver("StartEvent", lambda drawn, _event: drawn.SetDPI(DPI))
        window.AddObserver("StartEvent", lambda _drawn, _event: self._leave_out())
        self._software = _is_software(window)
        window.SetMultiSamples(0 if self._software else 8)
        self._smooth(self._software)
        self._add_gap()
        self._box.addWidget(interactor)
        if self._forerunner is not None:
            self._forerunner.deleteLater()
            self._forerunner = None
        interactor.show()
        self._box.activate()
        self._arrange()
        self.ready.emit()
        self.redraw()

    @property
    def window_colour(self) -> tuple[float, float, float]:
        """The colour between the views, RGB 0..1."""
        return self._window_colour

    def rect_of(self, view: int) -> tuple[float, float, float, float] | None:
        """Return left, bottom, width and height of a view in screen pixels; None while it is not shown."""
        return self._rects.get(view)

    def set_window_colour(self, colour: tuple[float, float, float]) -> None:
        """Set the colour between the views, RGB 0..1."""
        self._window_colour = colour
        if self._gap is not None:
            self._gap.SetBackground(*colour)

    def set_shown(self, views: Sequence[int]) -> None:
        """Choose which views are seen; they share the room in one run."""
        self._shown, self._cells = list(views), None
        self._arrange()

    def set_cells(self, cells: Mapping[int, Cell]) -> None:
        """Choose which views are seen and where each stands in a grid."""
        self._shown, self._cells = list(cells), dict(cells)
        self._arrange()

    def set_picker(self, picker: Picker | None) -> None:
        """Set what finds the place in mm where a line of sight meets the subject."""
        self._picker = picker

    def set_tool(self, tool: Tool | None) -> None:
        """Set what gets the mouse before the camera."""
        self._tool = tool

    def set_bounds(self, bounds: Sequence[float] | None) -> None:
        """Set the box (x, y, z ranges, mm) that near and far plane must hold."""
        self._bounds = bounds
        self._clip()

    def set_pivot(self, pivot: NDArray[np.float64] | None) -> None:
        """Set the point in mm to orbit around; None is the middle of the picture."""
        self._pivot = None if pivot is None else np.array(pivot, dtype=np.float64)

    def view_size(self, view: int) -> tuple[float, float]:
        """Return width and height of a view in screen pixels."""
        rect = self._rects.get(view)
        return (max(rect[2], 1.0), max(rect[3], 1.0)) if rect else (1.0, 1.0)

    def segment(self, view: int, x: float, y: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the line of sight in mm through a pixel from a view's lower left."""
        from widgets.scene.camera import ray

        return ray(self.camera, x, y, *self.view_size(view))

    def pick(self, view: int, x: float, y: float) -> NDArray[np.float64] | None:
        """Return the place in mm that a pixel from a view's lower left shows; None beside the subject."""
        return self._picker(self.segment(view, x, y)) if self._picker is not None else None

    def where(self, place: QPointF, view: int | None = None) -> tuple[int, float, float]:
        """Return the view under a place of the widget, or ``view``, and its pixel from that view's lower left."""
        x, y = place.x() * self.scale, (self._interactor.height() - place.y()) * self.scale
        if view is None:
            inside = [v for v, r in self._rects.items() if r[0] <= x <= r[0] + r[2] and r[1] <= y <= r[1] + r[3]]
            view = inside[0] if inside else self._shown[0]
        rect = self._rects[view]
        return view, x - rect[0], y - rect[1]

    @property
    def orthographic(self) -> bool:
        """Whether the picture is drawn without perspective."""
        return self._interactor is not None and bool(self.camera.GetParallelProjection())

    def set_orthographic(self, on: bool) -> None:
        """Draw without perspective, or with it; what lies at the pivot's depth keeps its size."""
        from widgets.scene import camera as hand

        if self._interactor is None or on == self.orthographic:
            return
        if self._pivot is not None:
            hand.set_focus(self.camera, self._pivot)
        hand.set_orthographic(self.camera, on)
        self.camera_moved()

    def camera_moved(self) -> None:
        """Say that the camera was placed by somebody else: clip, tell, draw."""
        self._clip()
        self.camera_changed.emit()
        self.redraw()

    def redraw(self, views: Collection[int] | None = None) -> None:
        """Ask for a frame, of some views where only they have changed; requests before the next paint make one."""
        if self._interactor is not None and not self._closed:
            self._changed = None if views is None or self._changed is None else self._changed | set(views)
            self._interactor.update()

    def hasten(self, views: Collection[int] | None = None) -> None:
        """Ask for a frame that follows the hand: a processor that draws leaves out smoothing until the hand rests."""
        if self._interactor is not None and self._software:
            self._smooth(False)
            self._rest.start()
        self.redraw(views)

    def picture(self) -> NDArray[np.uint8]:
        """Return what is seen now, (H, W, 3) uint8, in screen pixels."""
        if self._interactor is None:
            self.start()
        image = self._interactor.grabFramebuffer().convertToFormat(QImage.Format.Format_RGB888)
        rows = np.frombuffer(image.constBits(), dtype=np.uint8).reshape(image.height(), image.bytesPerLine())
        return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).copy()

    def close(self) -> bool:
        """Let go of the plotter and its graphics memory; the widget shows nothing any more."""
        if not self._closed:
            self._closed = True
            self._rest.stop()
            self._tool = self._picker = None
            if self._interactor is not None:
                interactor, self._interactor = self._interactor, None
                interactor.removeEventFilter(self)
                if self._gap is not None:
                    interactor.render_window.RemoveRenderer(self._gap)
                    self._gap = None
                interactor.close()
                self._box.removeWidget(interactor)
                interactor.deleteLater()
        return super().close()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Fill the ground, and make the plotter once the whole window has been painted."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor.fromRgbF(*self._window_colour))
        painter.end()
        if not self._begun and not self._closed:
            self._begun = True
            QTimer.singleShot(0, self, self.start)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Lay the views out again."""
        super().resizeEvent(event)
        self._arrange()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take every mouse, wheel and key event before VTK sees it."""
        # Events still come while Python takes the object apart.
        interactor = self.__dict__.get("_interactor")
        if interactor is None or watched is not interactor:
            return False
        kind = event.type()
        if kind == QEvent.Type.Resize:
            self._arrange()
            return False
        if isinstance(event, QKeyEvent):
            event.ignore()
            return True
        if isinstance(event, QContextMenuEvent):
            if not self._hand.busy and menu_wanted(event.modifiers()):
                self.menu_requested.emit(event.globalPos())
            return True
        if self._hand.take(event):
            return True
        if kind == QEvent.Type.Leave:
            self.left.emit()
            return True
        return kind == QEvent.Type.Enter

    # The room.

    def _refine(self) -> None:
        if self._hand.busy:
            self._rest.start()
        elif self._interactor is not None:
            self._smooth(True)
            self.redraw()

    def _leave_out(self) -> None:
        """Let views that have not changed since the last frame keep their pixels in this one."""
        changed, self._changed = self._changed, set()
        if self._interactor is None or self._gap is None:
            return
        # A frame that nobody here has asked for, such as after the window was covered, is drawn whole.
        whole = not changed
        self._gap.SetDraw(whole)
        for view, renderer in enumerate(self._interactor.renderers):
            renderer.SetDraw(view in self._rects and (whole or view in (changed or ())))

    def _smooth(self, smooth: bool) -> None:
        for renderer in self._interactor.renderers:
            renderer.SetUseFXAA(smooth)

    def _add_gap(self) -> None:
        from vtkmodules.vtkRenderingCore import vtkRenderer

        window = self._interactor.render_window
        self._gap = vtkRenderer()
        self._gap.SetBackground(*self._window_colour)
        self._gap.InteractiveOff()
        for renderer in self._interactor.renderers:
            window.RemoveRenderer(renderer)
        # Renderers of one layer clear their own part in turn: the one behind all fills what is between them.
        window.AddRenderer(self._gap)
        for renderer in self._interactor.renderers:
            window.AddRenderer(renderer)

    def _arrange(self) -> None:
        if self._interactor is None:
            return
        width = max(round(self._interactor.width() * self.scale), 1)
        height = max(round(self._interactor.height() * self.scale), 1)
        gap = round(GAP_PX * self.scale)
        if self._cells is None:
            self._rects = in_a_run(self._shown, width, height, gap)
        else:
            self._rects = in_a_grid(self._cells, width, height, gap)
        for view, renderer in enumerate(self._interactor.renderers):
            rect = self._rects.get(view)
            renderer.SetDraw(rect is not None)
            if rect is not None:
                x, y, w, h = rect
                renderer.SetViewport(x / width, y / height, (x + w) / width, (y + h) / height)
        self.resized.emit()
        self.redraw()

    def _clip(self) -> None:
        from widgets.scene.camera import clip

        if self._interactor is not None and self._bounds is not None:
            clip(self.camera, self._bounds)


def _is_software(window: Any) -> bool:
    report = str(window.ReportCapabilities() or "").lower()
    line = next((row for row in report.splitlines() if "renderer string" in row), "")
    return any(word in line for word in _SOFTWARE)
