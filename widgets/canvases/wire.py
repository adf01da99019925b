"""The template over the picture: thin lines that follow the hand, and the triangles that folded over."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from engine.mesh import FloatArray, IntArray
from widgets import theme

WIDTH = 0.8


class TemplateWire(QGraphicsItem):
    """All edges of the template in one item; positions are image pixels (centres at integers)."""

    def __init__(self) -> None:
        super().__init__()
        self._edges = np.zeros((0, 2), dtype=np.int64)
        self._vertices = np.zeros((0, 2))
        self._folded = np.zeros((0, 3), dtype=np.int64)
        self._lines: list[QLineF] = []
        self._bounds = QRectF()
        self._pen = QPen(QColor(255, 255, 255, round(0.30 * 255)), WIDTH)
        self._pen.setCosmetic(True)

    @property
    def vertices(self) -> FloatArray:
        """Positions (V, 2) in image pixels; empty without a template."""
        return self._vertices

    @property
    def lines(self) -> list[QLineF]:
        """The lines as they are painted, one an edge."""
        return self._lines

    def set_edges(self, edges: IntArray) -> None:
        """Take other edges (E, 2)."""
        self._edges = np.asarray(edges, dtype=np.int64).reshape(-1, 2)

    def set_vertices(self, vertices: FloatArray | None) -> None:
        """Take other positions (V, 2); ``None`` takes the template away."""
        self.prepareGeometryChange()
        self._vertices = np.zeros((0, 2)) if vertices is None else np.array(vertices, dtype=np.float64)
        if len(self._vertices) == 0 or not np.isfinite(self._vertices).all():
            self._lines, self._bounds = [], QRectF()
            self._vertices = np.zeros((0, 2))
            return
        if len(self._lines) != len(self._edges):
            self._lines = [QLineF() for _ in range(len(self._edges))]
        # The same lines every time: a thousand new objects a mouse move would wake the garbage collector in mid-drag.
        flat = iter(self._vertices[self._edges].ravel().tolist())
        for line, x1, y1, x2, y2 in zip(self._lines, flat, flat, flat, flat, strict=False):
            line.setLine(x1, y1, x2, y2)
        (left, top), (right, bottom) = self._vertices.min(axis=0), self._vertices.max(axis=0)
        self._bounds = QRectF(left - 1, top - 1, right - left + 2, bottom - top + 2)

    def set_folded(self, triangles: IntArray | None) -> None:
        """Show triangles (k, 3) vertex indices in red."""
        self._folded = np.zeros((0, 3), dtype=np.int64) if triangles is None else np.asarray(triangles, dtype=np.int64)
        self.update()

    @property
    def folded(self) -> IntArray:
        """Triangles (k, 3) that are shown in red."""
        return self._folded

    def boundingRect(self) -> QRectF:
        """Return the box of all positions, image pixels."""
        return self._bounds

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        """Draw the lines, then what folded."""
        if not self._lines:
            return
        self._pen.setWidthF(WIDTH * painter.device().devicePixelRatioF())
        painter.setPen(self._pen)
        painter.drawLines(self._lines)
        if len(self._folded):
            red = QColor(theme.overlay().captured)
            pen = QPen(red, 1.4)
            pen.setCosmetic(True)
            painter.setPen(pen)
            red.setAlphaF(0.45)
            painter.setBrush(red)
            for triangle in self._vertices[self._folded].tolist():
                painter.drawPolygon(QPolygonF([QPointF(*corner) for corner in triangle]))
