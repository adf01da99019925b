"""A performance's points over the head, from the front and from the side, one frame at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QHelpEvent,
    QImage,
    QLinearGradient,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QResizeEvent,
)
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from engine.mesh import FloatArray, TriangleMesh
from widgets import theme
from widgets.basis.head_shade import FRONT, SIDE, shade, smooth
from widgets.basis.motion_import_values import Role
from widgets.scene.materials import CLAY

_VIEWS = (("front", FRONT), ("side", SIDE))
_GAP, _MARGIN, _REACH = 2, 16, 9
_HEAD_MM, _SPARE = 260.0, 0.4


class MotionPreview(QWidget):
    """Two pictures side by side: face markers red discs, head markers squares, selected ones ringed.

    Signals
    -------
    picked(int)
        The user clicked a point.
    """

    picked = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._mesh: TriangleMesh | None = None
        self._points: FloatArray = np.zeros((0, 3))
        self._labels: tuple[str, ...] = ()
        self._roles: tuple[Role, ...] = ()
        self._selected: frozenset[int] = frozenset()
        self._note, self._pending = "", False
        self._low, self._high = np.full(3, np.inf), np.full(3, -np.inf)
        self._grounds: dict[str, QImage] = {}
        self.setMouseTracking(True)
        self.setAccessibleName("Points over the face, front and side")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        theme.signals.changed.connect(self._repaint)

    def sizeHint(self) -> QSize:
        """Return room for two heads."""
        return QSize(640, 460)

    def minimumSizeHint(self) -> QSize:
        """Return room for two small heads."""
        return QSize(360, 240)

    def show_mesh(self, mesh: TriangleMesh | None) -> None:
        """Show another head, or none."""
        if mesh is not self._mesh:
            self._mesh = mesh
            self._low, self._high = np.full(3, np.inf), np.full(3, -np.inf)
            if mesh is not None:
                self._low, self._high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
            self._repaint()

    def show_points(self, points: FloatArray, labels: Sequence[str] = (), roles: Sequence[Role] = ()) -> None:
        """Show points (n, 3), mm, in the rig's frame; NaN is not drawn."""
        self._points, self._labels, self._roles = np.asarray(points), tuple(labels), tuple(roles)
        self._take_in()
        self.update()

    def set_pending(self, pending: bool) -> None:
        """Draw points pale while they are not what the choice makes of them."""
        self._pending = pending
        self.update()

    def _take_in(self) -> None:
        """Make the frame so wide that the points are in it; those of a wrong unit may lie out of it."""
        seen = self._points[np.isfinite(self._points).all(axis=1)]
        if self._mesh is None or not len(seen):
            return
        low, high = self._mesh.vertices.min(axis=0), self._mesh.vertices.max(axis=0)
        spare = _SPARE * (high - low)
        wider = np.minimum(self._low, np.maximum(seen.min(axis=0), low - spare))
        higher = np.maximum(self._high, np.minimum(seen.max(axis=0), high + spare))
        if (wider < self._low).any() or (higher > self._high).any():
            self._low, self._high = wider, higher
            self._grounds.clear()

    def show_selected(self, indices: Sequence[int]) -> None:
        """Ring some points."""
        self._selected = frozenset(indices)
        self.update()

    def show_note(self, note: str) -> None:
        """Say in the middle why there are no points; empty where there are."""
        self._note = note
        self.update()

    def place_of(self, index: int, view: str = "front") -> QPointF:
        """Return where a point is drawn, pixels of this widget."""
        number = [name for name, _ in _VIEWS].index(view)
        return self._on_screen(self._points[index : index + 1], number)[0]

    def _repaint(self) -> None:
        self._grounds.clear()
        self.update()

    def resizeEvent(self, _event: QResizeEvent) -> None:
        """Forget pictures of another size."""
        self._grounds.clear()

    def _frame(self, number: int) -> QRectF:
        width = (self.width() - _GAP) / 2
        return QRectF(number * (width + _GAP), 0, width, self.height())

    def _middle(self, view: FloatArray) -> FloatArray:
        if self._mesh is None:
            return np.zeros(2)
        return np.asarray(((self._low + self._high) / 2 @ view.T)[:2])

    def _scale(self) -> float:
        frame = self._frame(0)
        across, up = _HEAD_MM, _HEAD_MM
        if self._mesh is not None:
            extent = self._high - self._low
            across, up = float(max(extent[0], extent[2])), float(extent[1])
        return max(0.01, min((frame.width() - 2 * _MARGIN) / across, (frame.height() - 2 * _MARGIN) / up))

    def _on_screen(self, points: FloatArray, number: int) -> list[QPointF]:
        view, frame, scale = _VIEWS[number][1], self._frame(number), self._scale()
        seen = points @ view.T
        middle = self._middle(view)
        across = frame.center().x() + (seen[:, 0] - middle[0]) * scale
        down = frame.center().y() - (seen[:, 1] - middle[1]) * scale
        return [QPointF(x, y) for x, y in zip(across.tolist(), down.tolist(), strict=True)]

    def _ground(self, number: int) -> QImage | None:
        if self._mesh is None:
            return None
        name, view = _VIEWS[number]
        if name not in self._grounds:
            frame = self._frame(number)
            size = (max(8, round(frame.width() / 2)), max(8, round(frame.height() / 2)))
            light = shade(self._mesh, view, size, self._scale() / 2, self._middle(view))
            light, cover = smooth(light)
            clay = QColor(CLAY.colour)
            share = (0.4 + 0.6 * light)[..., None]
            pixels = np.zeros((*light.shape, 4), np.uint8)
            pixels[..., :3] = np.array([clay.red(), clay.green(), clay.blue()]) * share
            pixels[..., 3] = 255 * cover
            high, wide = light.shape
            image = QImage(pixels.data, wide, high, 4 * wide, QImage.Format.Format_RGBA8888)
            self._grounds[name] = image.copy()
        return self._grounds[name]

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw both grounds, the points and the names of the views."""
        painter = QPainter(self)
        painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        current = theme.current()
        painter.fillRect(self.rect(), current.colour("window"))
        for number, (name, _view) in enumerate(_VIEWS):
            frame = self._frame(number)
            slope = QLinearGradient(frame.topLeft(), frame.bottomLeft())
            slope.setColorAt(0, current.colour("view_top"))
            slope.setColorAt(1, current.colour("view_bottom"))
            painter.fillRect(frame, slope)
            ground = self._ground(number)
            painter.setClipRect(frame)
            if ground is not None:
                painter.drawImage(frame, ground)
            painter.setOpacity(0.4 if self._pending else 1.0)
            self._paint_points(painter, number)
            painter.setOpacity(1.0)
            painter.setFont(theme.font(theme.TABLE_PX))
            painter.setPen(current.colour("dim"))
            painter.drawText(frame.adjusted(8, 6, -8, -6), Qt.AlignmentFlag.AlignLeft, name)
            painter.setClipping(False)
        if self._note:
            painter.setPen(current.colour("dim"))
            painter.setFont(theme.font())
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(QRectF(self.rect()).adjusted(32, 0, -32, 0), int(flags), self._note)

    def _paint_points(self, painter: QPainter, number: int) -> None:
        current = theme.current()
        there = np.flatnonzero(np.isfinite(self._points).all(axis=1)).tolist()
        places = self._on_screen(self._points, number)
        plain = len(self._roles) != len(self._points)
        rim = QPen(current.colour("window"), 1)
        for k in there:
            role: Role = "face" if plain else self._roles[k]
            painter.setPen(Qt.PenStyle.NoPen if plain else rim)
            painter.setBrush(current.colour("captured" if role == "face" else "text" if role == "head" else "missing"))
            if role == "head":
                painter.drawRect(QRectF(places[k].x() - 3.5, places[k].y() - 3.5, 7, 7))
            else:
                size = 1.2 if plain else 3.5
                painter.drawEllipse(places[k], size, size)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(current.colour("accent"), 1.8))
        for k in self._selected.intersection(there):
            painter.drawEllipse(places[k], 8, 8)

    def _at(self, position: QPointF) -> int | None:
        best, found = float(_REACH**2), None
        for number in range(len(_VIEWS)):
            if not self._labels or not self._frame(number).contains(position):
                continue
            for k, place in enumerate(self._on_screen(self._points, number)):
                away = (place.x() - position.x()) ** 2 + (place.y() - position.y()) ** 2
                if away < best:
                    best, found = away, k
        return found

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Pick the point under the mouse."""
        found = self._at(event.position())
        if event.button() == Qt.MouseButton.LeftButton and found is not None:
            self.picked.emit(found)

    def event(self, event: QEvent) -> bool:
        """Name the point under the mouse."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            found = self._at(QPointF(event.pos()))
            QToolTip.showText(event.globalPos(), "" if found is None else self._labels[found], self)
            return True
        return super().event(event)
