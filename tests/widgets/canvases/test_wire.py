"""The template's lines: every edge once, where the vertices are, and what folded in red."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtGui import QColor, QImage, QPainter

from widgets.canvases.pictures import to_image
from widgets.canvases.wire import TemplateWire


def test_lines_are_where_the_vertices_are(template) -> None:
    wire, edges = TemplateWire(), template.edges
    wire.set_edges(edges)
    rng = np.random.default_rng(2)
    for _ in range(3):
        vertices = rng.normal(200, 60, (len(template.mirror), 2))
        wire.set_vertices(vertices)
        painted = np.array([(line.x1(), line.y1(), line.x2(), line.y2()) for line in wire.lines])
        np.testing.assert_array_equal(painted, vertices[edges].reshape(-1, 4))
        (left, top), (right, bottom) = vertices.min(axis=0), vertices.max(axis=0)
        box = wire.boundingRect()
        assert box.left() <= left and box.right() >= right and box.top() <= top and box.bottom() >= bottom


def test_no_template_and_broken_positions_paint_nothing(template) -> None:
    wire = TemplateWire()
    wire.set_edges(template.edges)
    vertices = np.full((len(template.mirror), 2), 5.0)
    vertices[7] = np.nan
    for given in (None, vertices):
        wire.set_vertices(given)
        assert wire.lines == []
        assert wire.boundingRect().isEmpty()


def test_folded_triangles_are_red_and_others_are_not(qapp) -> None:
    wire = TemplateWire()
    wire.set_edges(np.array([[0, 1], [1, 2], [0, 2], [1, 3], [2, 3]]))
    wire.set_vertices(np.array([[10.0, 10], [50, 10], [10, 50], [50, 50]]))
    wire.set_folded(np.array([[0, 1, 2]]))
    image = QImage(60, 60, QImage.Format.Format_RGB32)
    image.fill(QColor("black"))
    painter = QPainter(image)
    wire.paint(painter, None)
    painter.end()
    inside, beside = image.pixelColor(20, 20), image.pixelColor(42, 42)
    assert inside.red() > 80 and inside.red() > 2 * inside.green()
    assert beside == QColor("black")


@pytest.mark.parametrize("shape", [(3, 5, 3), (480, 640, 3)])
def test_pictures_reach_qt_byte_for_byte(qapp, shape) -> None:
    picture = np.random.default_rng(1).integers(0, 255, shape, dtype=np.uint8)
    image = to_image(picture)
    picture_again = [image.pixelColor(x, y).getRgb()[:3] for x, y in ((0, 0), (shape[1] - 1, shape[0] - 1), (2, 1))]
    assert picture_again == [tuple(picture[y, x].tolist()) for x, y in ((0, 0), (shape[1] - 1, shape[0] - 1), (2, 1))]
