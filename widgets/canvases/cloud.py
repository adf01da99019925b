"""Points in three dimensions, turned by hand and painted in two: a cloud by its density, and arrows in it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from PySide6.QtCore import QEvent, QLineF, QPoint, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QImage, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF, QWheelEvent
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from engine.mesh import FloatArray
from widgets import theme
from widgets.canvases.plot import MIDDLE, Plot, advance, swatch
from widgets.canvases.ticks import step_for

PLANES = {"1 · 2": (0.0, 0.0), "1 · 3": (0.0, 90.0), "2 · 3": (90.0, 0.0)}
"""Plane of two axes -> yaw and pitch that face it, degrees."""
START = (-32.0, 24.0)
_NEAR = 9.0
_CLICK = 4.0
_HEAD = 7.0
_LOW = 120
"""Height below which the legend would stand in the cloud."""


@dataclass(frozen=True)
class Arrow:
    """An arrow from ``tail`` to ``tip`` (3,), with its name; faint ones are there to compare with."""

    name: str
    tail: FloatArray = field(compare=False, repr=False)
    tip: FloatArray = field(compare=False, repr=False)
    role: str = "text"
    dashed: bool = False
    faint: bool = False


class CloudCanvas(Plot):
    """A cloud of numbered points and arrows about their origin.

    Left drag turns, wheel zooms, double click looks from the start again, a click on a point chooses it; arrow keys
    turn too.

    Signals
    -------
    point_chosen(int)
        Number of the point, as given.
    turned()
        The hand turned the cloud.
    """

    point_chosen = Signal(int)
    turned = Signal()

    def __init__(self, sentence: str = "", parent: QWidget | None = None) -> None:
        super().__init__(sentence, parent)
        self.points: FloatArray | None = None
        self.numbers: FloatArray = np.zeros(0)
        self.arrows: tuple[Arrow, ...] = ()
        self.legend: tuple[tuple[str, QPen], ...] = ()
        self.names = ("axis 1", "axis 2", "axis 3")
        self.ring = -1
        self.yaw, self.pitch = START
        self.zoom = 1.0
        self._radius = 1.0
        self._held: tuple[QPointF, QPointF, bool] | None = None
        self._hover = -1
        self._cloud: tuple[tuple[object, ...], QImage] | None = None
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Frames as a cloud over the first axes")

    # -- what is shown ---------------------------------------------------------------------------------------

    def set_points(self, points: FloatArray | None, numbers: FloatArray | None = None) -> None:
        """Show points (F, k), the first three of whose coordinates are drawn; ``numbers`` (F,) name them."""
        if points is None or not len(points):
            self.points, self.numbers = None, np.zeros(0)
        else:
            made = np.zeros((len(points), 3))
            made[:, : min(3, points.shape[1])] = points[:, :3]
            self.points = made
            self.numbers = np.arange(len(made), dtype=np.float64) if numbers is None else np.asarray(numbers)
        self._hover = -1
        self._fit()

    def set_arrows(self, arrows: Sequence[Arrow], legend: Sequence[tuple[str, QPen]] = ()) -> None:
        """Show arrows and what their colours mean; short ones are enlarged together, as it says beside the scale."""
        self.arrows, self.legend = tuple(arrows), tuple(legend)
        self.forget()

    def set_names(self, right: str, up: str, near: str) -> None:
        """Name the three coordinates."""
        self.names = (right, up, near)
        self.forget()

    def set_ring(self, number: int) -> None:
        """Ring the point of a number."""
        self.ring = number
        self.update()

    def look(self, yaw: float, pitch: float) -> None:
        """Look from another side, degrees."""
        self.yaw, self.pitch = (yaw + 180.0) % 360.0 - 180.0, min(max(pitch, -90.0), 90.0)
        self.update()

    def forget(self) -> None:
        """Paint the cloud anew."""
        self._cloud = None
        super().forget()

    @property
    def enlargement(self) -> float:
        """How many times longer than to scale arrows are drawn: a round number that lets the longest be seen."""
        longest = max((self._reach(a) for a in self.arrows if not (a.faint or a.dashed)), default=0.0)
        room = 0.75 * self._radius / longest if longest > 0 else 1.0
        fitting = [k for k in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100) if k <= room]
        return 1.0 if 1.0 <= room <= 3.0 else float(max(fitting, default=0.01))

    def _fit(self) -> None:
        far = [1e-9]
        if self.points is not None:
            far.append(float(np.percentile(np.linalg.norm(self.points, axis=1), 99.5)))
        self._radius = max(far)
        self.forget()

    def _reach(self, arrow: Arrow) -> float:
        return float(np.linalg.norm(arrow.tip - arrow.tail))

    # -- places ----------------------------------------------------------------------------------------------

    @property
    def rotation(self) -> FloatArray:
        """(3, 3): rows are the directions to the right, up and to the eye."""
        yaw, pitch = math.radians(self.yaw), math.radians(self.pitch)
        cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
        turn = np.array([[cy, 0.0, -sy], [0.0, 1.0, 0.0], [sy, 0.0, cy]])
        tilt = np.array([[1.0, 0.0, 0.0], [0.0, cp, -sp], [0.0, sp, cp]])
        made: FloatArray = tilt @ turn
        return made

    @property
    def scale(self) -> float:
        """Pixels of this widget to a unit of the points."""
        return 0.46 * min(self.width(), self.height() - theme.px(28)) / max(self._radius, 1e-9) * self.zoom

    def placed(self, points: FloatArray) -> FloatArray:
        """Return places (F, 2) of points (F, 3), pixels of this widget."""
        flat = np.asarray(points) @ self.rotation[:2].T
        made: FloatArray = np.array([self.width() / 2, self.height() / 2 + theme.px(6)]) + self.scale * flat * np.array(
            [1.0, -1.0]
        )
        return made

    def point_at(self, place: QPointF) -> int:
        """Return the index of the point nearest to a place, -1 where none is near."""
        if self.points is None:
            return -1
        away = ((self.placed(self.points) - np.array([place.x(), place.y()])) ** 2).sum(axis=1)
        found = int(away.argmin())
        return found if away[found] <= _NEAR**2 else -1

    # -- hands -----------------------------------------------------------------------------------------------

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take hold of the cloud."""
        if event.button() == Qt.MouseButton.LeftButton and self.points is not None:
            self._held = (event.position(), event.position(), False)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Turn the cloud, or say which point lies under the pointer."""
        if self._held is None:
            self._point_out(event)
            return
        began, last, moved = self._held
        here = event.position()
        moved = moved or (here - began).manhattanLength() > _CLICK
        if moved:
            step = here - last
            self.look(self.yaw + 0.5 * step.x(), self.pitch + 0.5 * step.y())
            self.turned.emit()
        self._held = (began, here, moved)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Let go; without a drag, choose the point under the pointer."""
        if event.button() != Qt.MouseButton.LeftButton or self._held is None:
            return
        clicked, self._held = not self._held[2], None
        found = self.point_at(event.position()) if clicked else -1
        if found >= 0:
            self.set_ring(int(self.numbers[found]))
            self.point_chosen.emit(int(self.numbers[found]))

    def mouseDoubleClickEvent(self, _event: QMouseEvent) -> None:
        """Look from the start again."""
        self.zoom = 1.0
        self.look(*START)
        self.turned.emit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom."""
        if self.points is not None:
            self.zoom = min(max(self.zoom * 1.2 ** (event.angleDelta().y() / 120.0), 0.3), 30.0)
            self.update()
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Turn by 10 degrees."""
        turns = {
            Qt.Key.Key_Left: (-10, 0), Qt.Key.Key_Right: (10, 0), Qt.Key.Key_Up: (0, -10), Qt.Key.Key_Down: (0, 10),
        }  # fmt: skip
        turn = turns.get(Qt.Key(event.key()))
        if turn is None:
            super().keyPressEvent(event)
        else:
            self.look(self.yaw + turn[0], self.pitch + turn[1])
            self.turned.emit()

    def leaveEvent(self, event: QEvent) -> None:
        """Let the point go."""
        self._hover = -1
        self.update()
        super().leaveEvent(event)

    def _point_out(self, event: QMouseEvent) -> None:
        found = self.point_at(event.position())
        if found != self._hover:
            self._hover = found
            self.update()
            if found < 0 or self.points is None:
                QToolTip.hideText()
            else:
                pairs = zip(self.names, self.points[found], strict=True)
                where = ", ".join(f"{name} {c:.3g}".replace("-", "−") for name, c in pairs)
                number = f"{int(self.numbers[found]) + 1:,}".replace(",", "\u00a0")
                text = f"frame {number}\n{where} mm\nA click goes there"
                QToolTip.showText(event.globalPosition().toPoint() + QPoint(8, 8), text, self)

    # -- drawing ---------------------------------------------------------------------------------------------

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw axes, cloud, arrows, the ringed point, scale and legend."""
        painter, current = QPainter(self), theme.current()
        painter.fillRect(self.rect(), current.colour("timeline"))
        if self.points is None:
            self.paint_sentence(painter, QRectF(self.rect()).adjusted(12, 0, -12, 0))
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._paint_axes(painter)
        painter.drawImage(QRectF(self.rect()), self._density(painter.device().devicePixelRatioF()))
        longer = self.enlargement
        for arrow in sorted(self.arrows, key=lambda arrow: not arrow.faint):
            self._paint_arrow(painter, arrow, 1.0 if arrow.dashed else longer)
        for number, role, radius in ((self._hover, "text", 3.5), (self._ringed(), "accent", 5.0)):
            if number >= 0:
                x, y = self.placed(self.points[number : number + 1])[0]
                painter.setBrush(Qt.BrushStyle.NoBrush)
                painter.setPen(QPen(current.colour(role), 1.8))
                painter.drawEllipse(QPointF(x, y), radius, radius)
        self._paint_scale(painter)
        if self.height() >= theme.px(_LOW):
            self._paint_legend(painter)
        if self.hasFocus():
            painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(current.colour("accent", 0.6), 1))
            painter.drawRect(self.rect().adjusted(0, 0, -1, -1))

    def _ringed(self) -> int:
        """Return the index of the point whose number comes nearest, where only some of the frames are drawn."""
        if self.ring < 0 or not len(self.numbers):
            return -1
        return int(np.abs(self.numbers - self.ring).argmin())

    def _density(self, ratio: float) -> QImage:
        """Return the cloud as a picture: the more points on a pixel, the more opaque."""
        assert self.points is not None
        key = (self.yaw, self.pitch, self.zoom, self.width(), self.height(), ratio, theme.current().name)
        if self._cloud is not None and self._cloud[0] == key:
            return self._cloud[1]
        wide, high = max(2, round(self.width() * ratio)), max(2, round(self.height() * ratio))
        at = np.floor(self.placed(self.points) * ratio - 0.5).astype(np.int64)
        x, y = at[:, 0], at[:, 1]
        inside = (x >= 0) & (x < wide - 1) & (y >= 0) & (y < high - 1)
        first = y[inside] * wide + x[inside]
        hits = np.zeros(wide * high)
        for step in (0, 1, wide, wide + 1):
            hits += np.bincount(first + step, minlength=wide * high)
        single = float(np.clip(900.0 / len(self.points), 0.14, 0.85))
        alpha = 1.0 - np.power(1.0 - single, hits)
        colour = theme.current().colour("missing")
        pixels = np.empty((high, wide, 4), dtype=np.uint8)
        for k, part in enumerate((colour.red(), colour.green(), colour.blue(), 255)):
            pixels[..., k] = np.round(part * alpha).reshape(high, wide)
        image = QImage(pixels.data, wide, high, 4 * wide, QImage.Format.Format_RGBA8888_Premultiplied).copy()
        self._cloud = (key, image)
        return image

    def _paint_axes(self, painter: QPainter) -> None:
        current = theme.current()
        ends = self.placed(np.concatenate([-np.eye(3), np.eye(3)]) * self._radius * 1.04)
        painter.setFont(theme.font(theme.AXIS_PX))
        for axis in range(3):
            (x0, y0), (x1, y1) = ends[axis], ends[axis + 3]
            if math.hypot(x1 - x0, y1 - y0) < 12:
                continue
            painter.setPen(QPen(current.colour("line"), 1))
            painter.drawLine(QLineF(x0, y0, x1, y1))
            painter.setPen(current.colour("dim"))
            text = self.names[axis]
            wide = advance(text, theme.AXIS_PX) + 2
            left = min(max(x1 + 3, 2.0), self.width() - wide - 2.0)
            top = min(max(y1 - theme.px(14), 1.0), self.height() - theme.px(14))
            painter.drawText(QRectF(left, top, wide, theme.px(14)), MIDDLE, text)

    def _paint_arrow(self, painter: QPainter, arrow: Arrow, longer: float) -> None:
        (x0, y0), (x1, y1) = self.placed(np.stack([arrow.tail, arrow.tail + longer * (arrow.tip - arrow.tail)]))
        length = math.hypot(x1 - x0, y1 - y0)
        colour = theme.current().colour(arrow.role, 0.22 if arrow.faint else 1.0)
        pen = QPen(colour, 1.0 if arrow.faint else 1.8)
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
        if arrow.dashed:
            pen.setDashPattern([3.0, 2.0])
        if length < 2.0:
            return
        along = QPointF((x1 - x0) / length, (y1 - y0) / length)
        across, tip, head = QPointF(-along.y(), along.x()), QPointF(x1, y1), min(_HEAD, length)
        neck = tip - along * head
        painter.setPen(pen)
        painter.drawLine(QPointF(x0, y0), tip if arrow.faint else neck)
        if arrow.faint:
            return
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(colour)
        painter.drawPolygon(QPolygonF([tip, neck + across * (0.42 * head), neck - across * (0.42 * head)]))

    def _paint_scale(self, painter: QPainter) -> None:
        """Draw a bar of a round length."""
        current, px = theme.current(), theme.px
        length = step_for(0.0, px(90) / self.scale, 2)
        longer = self.enlargement
        text = f"{length:g} mm" + (f", shapes × {longer:g}" if longer != 1.0 and self.arrows else "")
        wide, y = length * self.scale, self.height() - px(8) - 0.5
        painter.setPen(QPen(current.colour("dim"), 1))
        painter.drawPolyline(
            QPolygonF([QPointF(8.5, y - 3), QPointF(8.5, y), QPointF(8.5 + wide, y), QPointF(8.5 + wide, y - 3)])
        )
        painter.setFont(theme.font(theme.AXIS_PX))
        painter.drawText(QRectF(8.5 + wide + 5, y - px(11), px(160), px(14)), MIDDLE, text)

    def _paint_legend(self, painter: QPainter) -> None:
        px, x = theme.px, 8.0
        painter.setFont(theme.font(theme.TABLE_PX))
        for text, pen in self.legend:
            swatch(painter, x, px(12), pen)
            painter.setPen(theme.current().colour("dim"))
            x += px(16)
            painter.drawText(QRectF(x, px(4), px(160), px(16)), MIDDLE, text)
            x += advance(text) + px(14)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(theme.px(296), theme.px(240))

    def minimumSizeHint(self) -> QSize:
        """Return the least that can be turned."""
        return QSize(theme.px(160), theme.px(72))
