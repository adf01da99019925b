"""Axes are round, decimation keeps every peak, signed colours grow from the ground, plots answer what is asked."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QPainter, QPen
from PySide6.QtTest import QTest

from widgets import theme
from widgets.canvases.cloud import PLANES, Arrow, CloudCanvas
from widgets.canvases.curves import ScreePlot
from widgets.canvases.decimate import polyline
from widgets.canvases.diverging import diverging
from widgets.canvases.matrix import MatrixCanvas
from widgets.canvases.plot import draw_curve, polygon
from widgets.canvases.ticks import ceiling, tick_text, ticks

LEFT = Qt.MouseButton.LeftButton


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6), st.integers(1, 12))
def test_ticks_are_round_few_and_inside(low: float, span: float, most: int) -> None:
    values, step = ticks(low, low + span, most)
    assert len(values) <= most + 1
    mantissa = step / 10 ** math.floor(math.log10(step) + 1e-9)
    assert round(mantissa, 6) in (1, 2, 5, 10)
    assert all(low - 1e-6 * step <= v <= low + span + 1e-6 * step for v in values)
    assert all(abs(v / step - round(v / step)) < 1e-6 for v in values)


def test_ticks_say_as_many_decimals_as_their_step_has() -> None:
    assert [tick_text(v, 0.5) for v in (0.0, 0.5, -1.0)] == ["0.0", "0.5", "−1.0"]
    assert tick_text(2000.0, 1000.0) == "2000"
    assert ceiling(float("nan"), 3) == ceiling(0.0, 3) == 1.0
    assert ceiling(2.3, 3) >= 2.3


@given(st.integers(1, 5000), st.integers(1, 400), st.integers(0, 2**32 - 1))
def test_a_decimated_curve_keeps_every_extreme(length: int, columns: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=length)
    frames, drawn = polyline(values, 0, length - 1, columns)
    assert len(frames) == len(drawn) <= max(2 * columns, 4 * columns + 4)
    assert drawn.min() == values.min() and drawn.max() == values.max()
    assert (np.diff(frames) >= 0).all()
    # Each drawn value is where it is said to be, within the frames of one column.
    per = max(1.0, length / columns) + 1
    for frame, value in zip(frames, drawn, strict=True):
        near = values[max(0, int(frame - per)) : int(frame + per) + 1]
        assert value in near


def test_a_curve_that_is_seen_closely_is_drawn_whole_and_breaks_at_gaps() -> None:
    values = np.arange(100.0)
    values[50] = np.nan
    frames, drawn = polyline(values, 40, 60, 200)
    assert np.array_equal(frames, np.arange(39.0, 62.0))
    assert np.isnan(drawn[frames == 50]).all()
    wide = np.ones(1000)
    wide[400:600] = np.nan
    _, thinned = polyline(wide, 0, 999, 50)
    assert np.isnan(thinned).any() and np.isfinite(thinned).any()


def test_points_reach_qt_as_they_are(qapp) -> None:
    points = polygon(np.array([1.5, -2.0, 3.0]), np.array([0.0, 4.25, -1.0]))
    assert [(p.x(), p.y()) for p in points] == [(1.5, 0.0), (-2.0, 4.25), (3.0, -1.0)]
    assert len(polygon(np.zeros(0), np.zeros(0))) == 0


class _Recorder(QPainter):
    def __init__(self, image: QImage) -> None:
        super().__init__(image)
        self.lines: list[list[tuple[float, float]]] = []

    def drawPolyline(self, points) -> None:
        self.lines.append([(p.x(), p.y()) for p in points])


def test_a_long_curve_is_drawn_in_pieces_that_meet(qapp) -> None:
    x, y = np.arange(1000.0), np.sin(np.arange(1000.0))
    y[300] = np.inf
    image = QImage(10, 10, QImage.Format.Format_ARGB32)
    painter = _Recorder(image)
    draw_curve(painter, x, y)
    painter.end()
    starts = {line[0][0] for line in painter.lines}
    assert {0.0, 301.0} <= starts
    covered = [p for line in painter.lines for p in line]
    assert {p[0] for p in covered} == set(x) - {300.0}
    for before, after in zip(painter.lines, painter.lines[1:], strict=False):
        assert before[-1] == after[0] or before[-1][0] == 299.0


@pytest.mark.parametrize("kind", [theme.DARK, theme.LIGHT])
def test_signed_colours_grow_from_the_ground(qapp, kind) -> None:
    theme.apply(qapp, kind)
    try:
        shades = diverging(np.array([-1.0, -0.5, 0.0, 0.5, 1.0, 7.0, np.nan])).astype(float)
    finally:
        theme.apply(qapp, theme.DARK)
    away = np.abs(shades - shades[2]).sum(axis=1)
    assert away[2] == 0 and away[0] > away[1] > 60 and away[4] > away[3] > 60
    assert np.array_equal(shades[5], shades[4])
    violet, green = shades[0] - shades[2], shades[4] - shades[2]
    assert np.argmax(green if kind is theme.DARK else -shades[4]) != np.argmax(violet)


@pytest.mark.parametrize("points", [300, 3000])
def test_a_curve_is_as_wide_on_a_dense_screen(qapp, points: int) -> None:
    x = np.linspace(0, 100, points)
    wide = []
    for ratio in (1, 3):
        image = QImage(100 * ratio, 20 * ratio, QImage.Format.Format_ARGB32)
        image.setDevicePixelRatio(ratio)
        image.fill(Qt.GlobalColor.black)
        painter = QPainter(image)
        painter.setPen(QPen(Qt.GlobalColor.white, 1.0))
        draw_curve(painter, x, np.full(points, 10.5))
        assert painter.pen().widthF() == 1.0 and not painter.pen().isCosmetic()
        painter.end()
        wide.append(sum(image.pixelColor(50 * ratio, k).lightness() > 127 for k in range(20 * ratio)) / ratio)
    assert wide == [1.0, 1.0]


def test_a_matrix_says_what_lies_under_the_pointer(qtbot) -> None:
    matrix = MatrixCanvas("nothing")
    qtbot.addWidget(matrix)
    matrix.resize(120, 100)
    values = np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 0.0]])
    matrix.set_matrix(values, ("smile", "still"))
    assert np.allclose(matrix.shares, [[0.6, 0.8, 0.0], [0, 0, 0]])
    assert matrix.words(0, 1) == "smile, axis 2: 0.8 of its length, w = 4 mm"
    for row in range(2):
        for column in range(3):
            assert matrix.cell_at(matrix.cell(row, column).center()) == (row, column)
    assert matrix.cell_at(QPointF(10, 99)) is None
    rows, columns = [], []
    matrix.row_chosen.connect(rows.append)
    matrix.column_chosen.connect(columns.append)
    matrix.show()
    QTest.mouseClick(matrix, LEFT, pos=matrix.cell(1, 2).center().toPoint())
    QTest.keyClick(matrix, Qt.Key.Key_Left)
    QTest.keyClick(matrix, Qt.Key.Key_Up)
    QTest.keyClick(matrix, Qt.Key.Key_Up)
    assert rows == [1, 0] and columns == [2, 1]
    assert matrix.cells()[1] == ["smile", "3", "4", "0"]
    matrix.grab()
    matrix.set_matrix(None)
    assert matrix.cells() == [] and matrix.cell_at(QPointF(5, 5)) is None
    matrix.grab()


def test_the_scree_plot_shows_a_quarter_more_axes_than_were_chosen(qtbot) -> None:
    plot = ScreePlot("nothing")
    qtbot.addWidget(plot)
    plot.resize(160, 140)
    shares = 0.5 ** np.arange(1, 61)
    plot.set_spectrum(shares, np.cumsum(shares), 20, "20 axes, 0.995")
    assert plot.shown == 26
    assert plot.box().left() < plot.x_of(0) < plot.x_of(25) < plot.box().right()
    image = plot.grab().toImage()
    accent = theme.DARK.accent
    x, y = round(plot.x_of(19) - 0.5), round(plot.box().top() + 12)
    assert accent in {image.pixelColor(x + d, y).name() for d in (-1, 0, 1)}
    assert plot.cells()[1] == ["1", "0.5", "0.5"]
    plot.set_spectrum(None, None, 0, "")
    assert plot.shown == 0
    plot.grab()


def test_a_plane_shows_its_two_axes_as_they_are(qtbot) -> None:
    cloud = CloudCanvas()
    qtbot.addWidget(cloud)
    cloud.resize(240, 240)
    points = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [-1.0, 0, 0]])
    cloud.set_points(points)
    middle = cloud.placed(np.zeros((1, 3)))[0]
    seen = {"1 · 2": (0, 1), "1 · 3": (0, 2), "2 · 3": (1, 2)}
    for plane, angles in PLANES.items():
        cloud.look(*angles)
        shown = np.abs(cloud.placed(points[:3]) - middle) > 1
        assert [bool(row.any()) for row in shown] == [k in seen[plane] for k in range(3)], plane
    assert np.allclose(cloud.rotation @ cloud.rotation.T, np.eye(3))
    assert np.linalg.det(cloud.rotation) == pytest.approx(1.0)


def test_a_click_in_the_cloud_finds_the_frame_and_a_drag_turns_it(qtbot) -> None:
    cloud = CloudCanvas()
    qtbot.addWidget(cloud)
    cloud.resize(240, 240)
    rng = np.random.default_rng(2)
    numbers = np.arange(0, 400, 4)
    cloud.set_points(rng.normal(size=(100, 2)) * 10, numbers)
    cloud.set_arrows([Arrow("a", np.zeros(3), np.array([9.0, 0, 0])), Arrow("b", np.zeros(3), np.ones(3), faint=True)])
    chosen = []
    cloud.point_chosen.connect(chosen.append)
    cloud.show()
    x, y = cloud.placed(cloud.points)[17]
    QTest.mouseClick(cloud, LEFT, pos=QPoint(round(x), round(y)))
    near = cloud.point_at(QPointF(round(x), round(y)))
    assert chosen == [numbers[near]]
    before = cloud.yaw
    QTest.mousePress(cloud, LEFT, pos=QPoint(100, 100))
    QTest.mouseMove(cloud, QPoint(150, 100))
    QTest.mouseRelease(cloud, LEFT, pos=QPoint(150, 100))
    assert cloud.yaw == pytest.approx(before + 25.0) and len(chosen) == 1
    cloud.set_ring(68)
    cloud.grab()
    cloud.set_points(None)
    assert cloud.point_at(QPointF(10, 10)) == -1
    cloud.grab()
