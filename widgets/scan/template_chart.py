"""The flat template, large: every fiducial a ring, every vertex one click away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QLineF, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent, QMouseEvent, QPainter, QPen
from PySide6.QtWidgets import QWidget

from engine.landmarks import Side
from engine.mesh import IntArray
from engine.scan.template import FaceTemplate
from widgets import theme
from widgets.canvases.pan_zoom import PanZoomView
from widgets.parts.glyphs import draw_current

NUMBERS_FROM_PX = 26.0
"""Numbers are drawn where neighbouring vertices are this far apart on the screen."""

_SAME = 0.5
"""Vertices nearer to each other than this, template units, lie at one place (the two lips of a closed mouth)."""


@dataclass(frozen=True)
class Ring:
    """A fiducial on the chart: its name and side."""

    name: str
    side: Side


class TemplateChart(PanZoomView):
    """The template with its fiducials; wheel zooms, middle mouse or Space+drag pans.

    Signals
    -------
    vertex_clicked(int)
        The nearest vertex to a click; where two lie at one place, the next click takes the other one.
    vertex_hovered(int)
        The vertex that a click would take; -1 while the mouse is elsewhere.
    """

    vertex_clicked = Signal(int)
    vertex_hovered = Signal(int)

    def __init__(self, template: FaceTemplate, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("Template with the fiducials")
        self.setToolTip("")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._template = template
        self._edges: IntArray = template.edges
        self._rings: dict[int, Ring] = {}
        self._chosen: int | None = None
        self._over: int | None = None
        self._numbers = self._fixed = False
        self.set_layout(next(iter(template.layouts)))
        theme.signals.changed.connect(self.viewport().update)

    def set_layout(self, name: str) -> None:
        """Show a layout of the template."""
        self._vertices = self._template.layout(name).vertices
        low, high = self._vertices.min(axis=0), self._vertices.max(axis=0)
        lengths = np.linalg.norm(np.diff(self._vertices[self._edges], axis=1)[:, 0], axis=1)
        self._spacing = float(np.median(lengths))
        size = high - low
        self._bounds = QRectF(*(low - 0.06 * size).tolist(), *(1.12 * size).tolist())
        self.setSceneRect(self._bounds.adjusted(-20 * size[0], -20 * size[1], 20 * size[0], 20 * size[1]))
        self.frame_unless_moved()
        self.viewport().update()

    def set_rings(self, rings: Mapping[int, Ring], chosen: int | None) -> None:
        """Draw fiducials by vertex; ``chosen`` is the vertex of the one in hand."""
        self._rings, self._chosen = dict(rings), chosen
        self.viewport().update()

    def set_numbers(self, shown: bool) -> None:
        """Write the number of every vertex beside it, where there is room."""
        self._numbers = shown
        self.viewport().update()

    def set_read_only(self, fixed: bool) -> None:
        """Say whether a click assigns; it always tells the vertex."""
        self._fixed = fixed
        self.viewport().update()

    @property
    def numbers_readable(self) -> bool:
        """Whether the view is near enough for numbers."""
        return self._spacing * self.zoom >= NUMBERS_FROM_PX

    def content_rect(self) -> QRectF:
        """Return the template with a margin."""
        return self._bounds

    def picture_rect(self) -> QRectF:
        """Return the same: there is no picture beyond the template."""
        return self._bounds

    def place(self, vertex: int) -> QPointF:
        """Return where a vertex is drawn, viewport pixels."""
        return self.to_view(QPointF(*self._vertices[vertex].tolist()))

    def at(self, position: QPointF) -> int:
        """Return the vertex that a click at a viewport position takes."""
        here = self.to_picture(position)
        far = np.hypot(*(self._vertices - [here.x(), here.y()]).T)
        nearest = int(far.argmin())
        together = self._together(nearest)
        if self._chosen in together:
            return together[(together.index(self._chosen) + 1) % len(together)]
        return next((vertex for vertex in together if vertex in self._rings), nearest)

    def neighbour(self, vertex: int, dx: int, dy: int) -> int | None:
        """Return the vertex that an arrow key leads to along an edge, if any lies that way."""
        edges = self._edges[(self._edges == vertex).any(axis=1)]
        others = np.unique(edges[edges != vertex])
        steps = self._vertices[others] - self._vertices[vertex]
        along = steps @ np.array([dx, dy]) / np.maximum(np.linalg.norm(steps, axis=1), 1e-9)
        best = int(along.argmax())
        return int(others[best]) if along[best] > 0.5 else None

    def _together(self, vertex: int) -> list[int]:
        far = np.hypot(*(self._vertices - self._vertices[vertex]).T)
        return [int(other) for other in np.flatnonzero(far < _SAME)]

    # -- hand -----------------------------------------------------------------------------------------------------

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Take the nearest vertex, or start panning."""
        if self.start_pan(event):
            return
        if event.button() == Qt.MouseButton.LeftButton:
            self.vertex_clicked.emit(self.at(event.position()))
            self._hover(event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Pan, or show what a click would take."""
        if self.is_panning:
            self.continue_pan(event)
        else:
            self._hover(event.position())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Let go."""
        if self.is_panning:
            self.end_pan()

    def leaveEvent(self, event: QEvent) -> None:
        """Forget what was under the mouse."""
        self._over = None
        self.vertex_hovered.emit(-1)
        self.viewport().update()
        super().leaveEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Go along the edges with the arrow keys; F frames, plus and minus zoom, Space pans."""
        steps = {Qt.Key.Key_Left: (-1, 0), Qt.Key.Key_Right: (1, 0), Qt.Key.Key_Up: (0, -1), Qt.Key.Key_Down: (0, 1)}
        key = Qt.Key(event.key())
        if key in steps and not event.modifiers() & Qt.KeyboardModifier.AltModifier:
            following = None if self._chosen is None else self.neighbour(self._chosen, *steps[key])
            if following is not None:
                self.vertex_clicked.emit(following)
        elif key == Qt.Key.Key_F:
            self.fit_view()
        elif key in (Qt.Key.Key_Plus, Qt.Key.Key_Equal, Qt.Key.Key_Minus):
            about = None if self._chosen is None else self.place(self._chosen)
            self.set_zoom(self.zoom * (1 / 1.2 if key == Qt.Key.Key_Minus else 1.2), about)
        else:
            super().keyPressEvent(event)

    def _hover(self, position: QPointF) -> None:
        over = self.at(position)
        if over != self._over:
            self._over = over
            self.vertex_hovered.emit(over)
            self.viewport().update()

    # -- painting -------------------------------------------------------------------------------------------------

    def drawForeground(self, painter: QPainter, _rect: QRectF) -> None:  # type: ignore[override]
        """Draw wire, numbers, fiducials and what the mouse is over, in screen pixels."""
        ink = theme.overlay()
        painter.save()
        painter.resetTransform()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        transform = self.viewportTransform()
        points = self._vertices * [transform.m11(), transform.m22()] + [transform.dx(), transform.dy()]
        painter.setPen(QPen(ink.colour("text", 0.34), 0.8))
        painter.drawLines([QLineF(*line) for line in points[self._edges].reshape(-1, 4).tolist()])
        if self._numbers and self.numbers_readable:
            self._draw_numbers(painter, points)
        for vertex, ring in self._rings.items():
            centre = QPointF(*points[vertex].tolist())
            radius = theme.px(5) if vertex == self._chosen else theme.px(4)
            for pen in (QPen(Qt.GlobalColor.black, 4.2), QPen(ink.side(ring.side), 2.2)):
                painter.setPen(pen)
                painter.setBrush(Qt.BrushStyle.NoBrush)
                painter.drawEllipse(centre, radius, radius)
        if self._chosen is not None:
            draw_current(painter, QPointF(*points[self._chosen].tolist()), palette=ink, radius=theme.px(10))
        if self._over is not None:
            self._draw_hover(painter, QPointF(*points[self._over].tolist()), self._over)
        elif self._chosen is not None:
            self._plate(painter, QPointF(*points[self._chosen].tolist()), self._words(self._chosen), False)
        painter.restore()

    def _draw_numbers(self, painter: QPainter, points: np.ndarray) -> None:
        painter.setFont(theme.font(theme.AXIS_PX))
        painter.setPen(theme.overlay().colour("text", 0.8))
        seen = self.viewport().rect().adjusted(-20, -20, 20, 20)
        drawn: set[tuple[int, int]] = set()
        for vertex, (x, y) in enumerate(points.tolist()):
            spot = round(x), round(y)
            if seen.contains(*spot):
                low = spot in drawn  # the lower lip's number goes below that of the upper one
                drawn.add(spot)
                painter.drawText(QPointF(x + 4, y + (theme.px(theme.AXIS_PX) + 2 if low else -3)), str(vertex))

    def _draw_hover(self, painter: QPainter, centre: QPointF, vertex: int) -> None:
        ink = theme.overlay()
        if vertex not in self._rings and not self._fixed:
            painter.setPen(QPen(ink.colour("accent"), 1.6, Qt.PenStyle.DotLine))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawEllipse(centre, theme.px(7), theme.px(7))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(ink.colour("accent"))
        painter.drawEllipse(centre, theme.px(2), theme.px(2))
        self._plate(painter, centre, self._words(vertex), True)

    def _words(self, vertex: int) -> str:
        ring, (x, y) = self._rings.get(vertex), self._vertices[vertex]
        together = [str(other) for other in self._together(vertex) if other != vertex]
        also = f" (also here: {', '.join(together)})" if together else ""
        return (f"{ring.name}  ·  " if ring else "") + f"{vertex}{also}  ·  {x:.1f}, {y:.1f}"

    def _plate(self, painter: QPainter, centre: QPointF, text: str, strong: bool) -> None:
        ink = theme.overlay()
        painter.setFont(theme.font(theme.TABLE_PX, bold=strong))
        room = QFontMetrics(painter.font())
        width, height = room.horizontalAdvance(text) + 12, room.height() + 6
        x = min(max(centre.x() + 14, 4), self.viewport().width() - width - 4)
        y = min(max(centre.y() - height - 10, 4), self.viewport().height() - height - 4)
        box = QRectF(x, y, width, height)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(ink.colour("plate", 0.9))
        painter.drawRoundedRect(box, 3, 3)
        painter.setPen(ink.colour("text"))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
