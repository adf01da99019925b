"""A view of one picture that zooms to the cursor and pans; it never touches what lies on the picture."""

from __future__ import annotations

import math

from PySide6.QtCore import QEvent, QPoint, QPointF, QRect, QRectF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QFocusEvent,
    QInputDevice,
    QKeyEvent,
    QLinearGradient,
    QMouseEvent,
    QNativeGestureEvent,
    QPainter,
    QPixmap,
    QResizeEvent,
    QTransform,
    QWheelEvent,
)
from PySide6.QtWidgets import QFrame, QGraphicsItem, QGraphicsPixmapItem, QGraphicsScene, QGraphicsView, QWidget

from widgets import theme
from widgets.viewers import navigation
from widgets.viewers.navigation import Deed

SMALLEST, LARGEST = 0.05, 40.0
SHARP_FROM = 4.0


class PanZoomView(QGraphicsView):
    """A picture whose pixel centres lie at whole scene coordinates.

    What buttons and wheel do is written in ``navigation``; besides, the left button pans while the space bar is held.

    ``nothing`` is what stands there while there is no picture.

    Signals
    -------
    zoom_changed(float)
        Screen pixels per image pixel.
    """

    zoom_changed = Signal(float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._scene = QGraphicsScene(self)
        self.setScene(self._scene)
        self._picture = QGraphicsPixmapItem()
        self._picture.setOffset(-0.5, -0.5)
        self._picture.setFlag(QGraphicsItem.GraphicsItemFlag.ItemHasNoContents)
        self._scene.addItem(self._picture)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setTransformationAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setResizeAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        self.setMouseTracking(True)
        self._pan_from: QPoint | None = None
        self._pan_begun = QPointF()
        self._deed: Deed = "pan"
        self._space = self._by_keys = False
        self._touched = False
        self._fit_pending = False
        self.nothing = ""
        self.sharpness = 1.0
        """How many times finer than the screen the ground is painted; for pictures of the view."""
        self._ground = QPixmap()
        self._ground_key: tuple[object, ...] = ()

    @property
    def zoom(self) -> float:
        """Screen pixels per image pixel."""
        return float(self.transform().m11())

    @property
    def is_panning(self) -> bool:
        """Whether the hand is moving the picture."""
        return self._pan_from is not None

    def to_picture(self, position: QPointF) -> QPointF:
        """Return the image position (pixel centres at integers) under a viewport position."""
        inverse, _ok = self.viewportTransform().inverted()
        return inverse.map(QPointF(position))

    def to_view(self, place: QPointF) -> QPointF:
        """Return the viewport position of an image position."""
        return self.viewportTransform().map(place)

    def set_zoom(self, zoom: float, about: QPointF | None = None) -> None:
        """Zoom to ``zoom`` screen pixels per image pixel and keep what is at ``about`` (viewport) where it is."""
        about = QPointF(self.viewport().rect().center()) if about is None else about
        self._touched = True
        place = self.to_picture(about)
        self._place(min(max(zoom, SMALLEST), LARGEST), place, about)

    def actual_size(self) -> None:
        """Show one image pixel as one screen pixel."""
        self.set_zoom(1.0)

    def frame_rect(self, rect: QRectF) -> None:
        """Show a part of the picture, image pixels, as large as it goes, in the middle."""
        if rect.isEmpty() or self.viewport().width() < 2:
            return
        view = self.viewport().rect()
        zoom = min(view.width() / rect.width(), view.height() / rect.height())
        self._place(min(max(zoom, SMALLEST), LARGEST), rect.center(), QPointF(view.width() / 2, view.height() / 2))

    def picture_rect(self) -> QRectF:
        """Return the whole picture, image pixels: half a pixel beyond the outer centres."""
        return self._picture.boundingRect()

    def bring_into_view(self, place: QPointF, margin: float) -> None:
        """Shift the picture until an image position is at least ``margin`` screen pixels from the edge."""
        at, view = self.to_view(place), QRectF(self.viewport().rect()).adjusted(margin, margin, -margin, -margin)
        inside = QPointF(min(max(at.x(), view.left()), view.right()), min(max(at.y(), view.top()), view.bottom()))
        if inside != at:
            self._touched = True
            self._place(self.zoom, place, inside)

    def content_rect(self) -> QRectF:
        """Return what ``fit_view`` shows, image pixels: here the whole picture."""
        return self._picture.boundingRect()

    def fit_view(self) -> None:
        """Frame the content, and keep it framed until the user moves the view."""
        self._touched = False
        self.frame_rect(self.content_rect())

    def toggle_fit(self) -> None:
        """Frame the content; where it is framed already, the whole picture."""
        before = self.viewportTransform()
        self.fit_view()
        after = self.viewportTransform()
        if all(abs(a - b) < 1e-3 for a, b in zip(_six(before), _six(after), strict=True)):
            self.frame_rect(self._picture.boundingRect())
            self._touched = True

    def frame_about(self, place: QPointF, radius: float) -> None:
        """Bring what lies within ``radius`` image pixels of a place into the middle, and leave it there."""
        self._touched = True
        self.frame_rect(QRectF(place.x() - radius, place.y() - radius, 2 * radius, 2 * radius))

    def frame_unless_moved(self) -> None:
        """Frame the content anew, but keep a view that the user has chosen."""
        if not self._touched:
            self.frame_rect(self.content_rect())

    def _place(self, zoom: float, place: QPointF, at: QPointF) -> None:
        old = self.zoom
        self.setTransform(QTransform.fromScale(zoom, zoom))
        off = self.to_view(place) - at
        self.horizontalScrollBar().setValue(self.horizontalScrollBar().value() + round(off.x()))
        self.verticalScrollBar().setValue(self.verticalScrollBar().value() + round(off.y()))
        if abs(old - zoom) > 1e-9:
            self.zoom_changed.emit(zoom)
        self.view_moved()

    def view_moved(self) -> None:
        """Follow a zoom or pan; for those who draw in screen pixels."""
        self.viewport().update()

    def _show_pixmap(self, pixmap: QPixmap) -> None:
        size_changed = pixmap.size() != self._picture.pixmap().size()
        self._picture.setPixmap(pixmap)
        if size_changed:
            width, height = pixmap.width(), pixmap.height()
            reach = 20 * max(width, height, 100)
            self.setSceneRect(QRectF(-reach, -reach, width + 2 * reach, height + 2 * reach))
            self._touched = False
            self._fit_later()

    def _fit_later(self) -> None:
        if not self._fit_pending:
            self._fit_pending = True
            QTimer.singleShot(0, self, self._fit_now)

    def _fit_now(self) -> None:
        self._fit_pending = False
        self.frame_unless_moved()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Frame the content again as long as the user has not moved the view; else keep the middle."""
        super().resizeEvent(event)
        if not self._touched:
            self.frame_rect(self.content_rect())
        elif event.oldSize().isValid():
            grown = event.size() - event.oldSize()
            self.horizontalScrollBar().setValue(self.horizontalScrollBar().value() - grown.width() // 2)
            self.verticalScrollBar().setValue(self.verticalScrollBar().value() - grown.height() // 2)
        self.view_moved()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom to the cursor, or whatever else wheel and fingers mean."""
        device = event.pointingDevice()
        fingers = device is not None and device.type() == QInputDevice.DeviceType.TouchPad
        deed = navigation.current().in_picture("fingers" if fingers else "wheel", event.modifiers())
        angle = event.angleDelta()
        if deed == "pan":
            self._shift(event.pixelDelta() if not event.pixelDelta().isNull() else angle / 8)
        elif deed is not None:
            self._near(1.2 ** ((angle.y() or angle.x()) / 120), event.position())
        event.accept()

    def viewportEvent(self, event: QEvent) -> bool:
        """Zoom where two fingers spread or close."""
        if isinstance(event, QNativeGestureEvent) and event.gestureType() == Qt.NativeGestureType.ZoomNativeGesture:
            self._near(max(1.0 + event.value(), 0.2), event.position())
            return True
        return super().viewportEvent(event)

    def start_pan(self, event: QMouseEvent) -> bool:
        """Begin to move the picture where the event asks for it, and say whether it did."""
        deed = navigation.current().in_picture(event.button(), event.modifiers())
        if self._space and event.button() == Qt.MouseButton.LeftButton:
            deed = "pan"
        if deed is None:
            return False
        self._deed, self._pan_begun = deed, event.position()
        self._pan_from = event.position().toPoint()
        self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor if deed == "pan" else Qt.CursorShape.SizeVerCursor)
        return True

    def continue_pan(self, event: QMouseEvent) -> None:
        """Follow the hand."""
        assert self._pan_from is not None
        here = event.position().toPoint()
        moved, self._pan_from = here - self._pan_from, here
        if self._deed == "pan":
            self._shift(moved)
        else:
            self._near(math.exp(0.006 * (moved.x() * (self._deed == "dolly") - moved.y())), self._pan_begun)

    def _shift(self, moved: QPoint) -> None:
        self._touched = True
        self.horizontalScrollBar().setValue(self.horizontalScrollBar().value() - moved.x())
        self.verticalScrollBar().setValue(self.verticalScrollBar().value() - moved.y())
        self.view_moved()

    def _near(self, factor: float, place: QPointF) -> None:
        if factor != 1.0:
            self.set_zoom(self.zoom * factor, place)

    def end_pan(self) -> None:
        """Let go of the picture."""
        self._pan_from = None
        self.viewport().unsetCursor()

    def drawBackground(self, painter: QPainter, _rect: QRectF | QRect) -> None:
        """Draw ground and picture; they are only painted anew when the view or the picture changed."""
        picture = self._picture.pixmap().cacheKey()
        key = (_six(self.viewportTransform()), self.viewport().size(), picture, theme.current(), self.sharpness)
        if key != self._ground_key:
            self._ground, self._ground_key = self._paint_ground(), key
        painter.save()
        painter.resetTransform()
        painter.drawPixmap(0, 0, self._ground)
        if self._picture.pixmap().isNull():
            painter.setFont(theme.font())
            painter.setPen(theme.overlay().colour("text"))
            painter.drawText(self.viewport().rect(), Qt.AlignmentFlag.AlignCenter, self.nothing)
        if self._by_keys:
            painter.setPen(theme.overlay().colour("accent"))
            painter.drawRect(self.viewport().rect().adjusted(0, 0, -1, -1))
        painter.restore()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Let the left button pan while the space bar is held; every other key belongs to others."""
        if event.key() == Qt.Key.Key_Space:
            self._space = True
        else:
            event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """End panning with the space bar."""
        if event.key() == Qt.Key.Key_Space and not event.isAutoRepeat():
            self._space = False
        super().keyReleaseEvent(event)

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Show a frame where the keys came here by the Tab key."""
        self._by_keys = event.reason() in (Qt.FocusReason.TabFocusReason, Qt.FocusReason.BacktabFocusReason)
        self.viewport().update()
        super().focusInEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Take the frame away and forget the space bar."""
        self._by_keys = self._space = False
        self.viewport().update()
        super().focusOutEvent(event)

    def _paint_ground(self) -> QPixmap:
        scale, size = self.devicePixelRatioF() * self.sharpness, self.viewport().size()
        result = QPixmap(size * scale)
        result.setDevicePixelRatio(scale)
        ground = QLinearGradient(0, 0, 0, size.height())
        ground.setColorAt(0, theme.current().colour("canvas_top"))
        ground.setColorAt(1, theme.current().colour("canvas_bottom"))
        painter = QPainter(result)
        painter.fillRect(self.viewport().rect(), ground)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, self.zoom < SHARP_FROM)
        painter.setTransform(self.viewportTransform(), combine=True)
        painter.drawPixmap(self._picture.offset(), self._picture.pixmap())
        painter.end()
        return result


def _six(transform: QTransform) -> tuple[float, ...]:
    return transform.m11(), transform.m12(), transform.m21(), transform.m22(), transform.dx(), transform.dy()
