"""The picture of a scan with the points of a file over it, numbered; clicking one says which it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRect, QRectF, Qt, Signal
from PySide6.QtGui import QFontMetrics, QHelpEvent, QKeyEvent, QMouseEvent, QPainter, QPen
from PySide6.QtWidgets import QToolTip, QWidget

from engine.landmarks import Landmark, LandmarkState, Side
from engine.mesh import FloatArray
from widgets import theme
from widgets.canvases.fiducial_layer import REACH
from widgets.canvases.scan_view import ScanView
from widgets.parts.glyphs import draw_current, draw_landmark

MOST_NUMBERS = 300
"""Of more points than this only those are numbered that make a fiducial."""

_PLACED = Landmark(0.0, 0.0, LandmarkState.PLACED)


class PointCanvas(ScanView):
    """Shows a file's points where they fall: those that make a fiducial in its side's colour, the others dim.

    Signals
    -------
    point_clicked(int)
        The index of the point that was pressed and let go.
    """

    point_clicked = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("point_canvas")
        self.setAccessibleName("Picture of the scan with the points of the file")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._points: FloatArray = np.empty((0, 2))
        self._labels: tuple[str, ...] = ()
        self._used: dict[int, tuple[Side, str]] = {}
        self._chosen: tuple[int, ...] = ()
        self._mean: QPointF | None = None
        self._pressed: int | None = None

    def set_points(self, points: FloatArray, labels: Sequence[str]) -> None:
        """Show points (n, 2), image pixels, NaN = not shown, with their names."""
        self._points, self._labels = np.asarray(points, dtype=np.float64), tuple(labels)
        self._used, self._chosen, self._mean = {}, (), None
        self.frame_unless_moved()
        self.viewport().update()

    def set_used(self, used: Mapping[int, tuple[Side, str]]) -> None:
        """Say which points make a fiducial: its side, and its name."""
        self._used = dict(used)
        self.viewport().update()

    def set_chosen(self, indices: Sequence[int]) -> None:
        """Ring the points of the fiducial that is selected; of several, their mean is marked too."""
        self._chosen = tuple(k for k in indices if 0 <= k < len(self._points) and np.isfinite(self._points[k]).all())
        self._mean = None
        if len(set(self._chosen)) > 1:
            x, y = self._points[list(self._chosen)].mean(axis=0)
            self._mean = QPointF(x, y)
        self.viewport().update()

    def content_rect(self) -> QRectF:
        """Return the box of the points on the picture with a margin; without them the whole picture."""
        whole = super().content_rect()
        seen = self._points[np.isfinite(self._points).all(axis=1)]
        seen = seen[[whole.contains(QPointF(x, y)) for x, y in seen.tolist()]] if len(seen) else seen
        if len(seen) < 2 or whole.isEmpty():
            return whole
        (left, top), (right, bottom) = seen.min(axis=0), seen.max(axis=0)
        margin = 0.15 * max(right - left, bottom - top, 1.0)
        box = QRectF(left, top, right - left, bottom - top).adjusted(-margin, -1.6 * margin, margin, margin)
        return box.intersected(whole)

    def point_at(self, position: QPointF) -> int | None:
        """Return the point nearest to a viewport position, within reach."""
        if not len(self._points):
            return None
        here = self.to_picture(position)
        distances = np.hypot(*(self._points - (here.x(), here.y())).T) * self.zoom
        distances[np.isnan(distances)] = np.inf
        nearest = int(distances.argmin())
        return nearest if distances[nearest] < REACH else None

    def _spot(self, index: int) -> QPointF | None:
        x, y = self._points[index]
        return self.to_view(QPointF(x, y)) if x == x and y == y else None

    # The hand -----------------------------------------------------------------------------------------------------

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Pan, or take the point under the mouse."""
        if not self.start_pan(event) and event.button() == Qt.MouseButton.LeftButton:
            self._pressed = self.point_at(event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Pan, or show that a point can be pressed."""
        if self.is_panning:
            self.continue_pan(event)
            return
        over = self.point_at(event.position()) is not None
        self.viewport().setCursor(Qt.CursorShape.PointingHandCursor if over else Qt.CursorShape.ArrowCursor)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Say which point was clicked."""
        if self.is_panning:
            self.end_pan()
            return
        pressed, self._pressed = self._pressed, None
        if pressed is not None and self.point_at(event.position()) == pressed:
            self.point_clicked.emit(pressed)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Frame with F, pan while the space bar is held; everything else belongs to the dialog."""
        if event.key() == Qt.Key.Key_F and not event.modifiers():
            self.toggle_fit()
        else:
            super().keyPressEvent(event)

    def viewportEvent(self, event: QEvent) -> bool:
        """Show the name of the point under the mouse and the fiducial it makes."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            index = self.point_at(QPointF(event.pos()))
            if index is None:
                QToolTip.hideText()
            else:
                made = self._used.get(index)
                name = self._labels[index] if index < len(self._labels) else ""
                text = f"point {index}" if name in ("", str(index)) else f"{name}, point {index}"
                QToolTip.showText(event.globalPos(), f"{text}\n{made[1]}" if made else text, self.viewport())
            return True
        return super().viewportEvent(event)

    # Drawing ------------------------------------------------------------------------------------------------------

    def drawForeground(self, painter: QPainter, _rect: QRectF | QRect) -> None:
        """Draw points and as many numbers as have room, the selected ones first."""
        painter.save()
        painter.resetTransform()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        palette = theme.overlay()
        for index in range(len(self._points)):
            place = self._spot(index)
            if place is None:
                continue
            if index in self._used:
                draw_landmark(painter, place, _PLACED, self._used[index][0], palette=palette)
            else:
                painter.setPen(QPen(palette.colour("plate"), 1))
                painter.setBrush(palette.colour("dim"))
                painter.drawEllipse(place, 2.6, 2.6)
        for index in self._chosen:
            place = self._spot(index)
            if place is not None:
                draw_current(painter, place, palette=palette)
        if self._mean is not None:
            self._draw_mean(painter, self.to_view(self._mean))
        self._draw_numbers(painter)
        painter.restore()

    def _draw_mean(self, painter: QPainter, at: QPointF) -> None:
        for width, role in ((3.4, "plate"), (1.6, "accent")):
            painter.setPen(QPen(theme.overlay().colour(role), width))
            painter.drawLine(at - QPointF(6, 0), at + QPointF(6, 0))
            painter.drawLine(at - QPointF(0, 6), at + QPointF(0, 6))

    def _draw_numbers(self, painter: QPainter) -> None:
        palette, font = theme.overlay(), theme.font(theme.AXIS_PX)
        metrics = QFontMetrics(font)
        painter.setFont(font)
        view = QRectF(self.viewport().rect())
        numbered: Sequence[int] = range(len(self._points))
        if len(numbered) > MOST_NUMBERS:
            numbered = sorted({*self._chosen, *self._used})[:MOST_NUMBERS]
        order = sorted(numbered, key=lambda k: (k not in self._chosen, k not in self._used, k))
        marks = [place for place in map(self._spot, numbered) if place is not None]
        taken = [QRectF(mark.x() - 3, mark.y() - 3, 6, 6) for mark in marks]
        for index in order:
            place = self._spot(index)
            if place is None or not view.contains(place):
                continue
            width, height = metrics.horizontalAdvance(str(index)) + 4.0, metrics.height() - 1.0
            box = next(
                (
                    box
                    for dx, dy in ((6, -height - 3), (6, 3), (-6 - width, -height - 3), (-6 - width, 3))
                    if not any(
                        (box := QRectF(place.x() + dx, place.y() + dy, width, height)).intersects(t) for t in taken
                    )
                ),
                None,
            )
            if box is None:
                continue
            taken.append(box)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(palette.colour("plate", 0.78))
            painter.drawRoundedRect(box, 2, 2)
            role = "accent" if index in self._chosen else "text" if index in self._used else "dim"
            painter.setPen(palette.colour(role))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, str(index))
