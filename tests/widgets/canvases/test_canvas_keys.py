"""The picture by keys alone: the crosshair, its steps, and what Enter does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

from engine.landmarks import LandmarkSet
from studio.scan.job import scheme_of
from widgets.canvases.image_canvas import ImageCanvas

SHIFT, CTRL, PLAIN = (
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.NoModifier,
)


@pytest.fixture
def canvas(qtbot: Any) -> ImageCanvas:
    canvas = ImageCanvas()
    qtbot.addWidget(canvas)
    canvas.resize(400, 300)
    canvas.set_image(np.full((240, 320, 3), 90, np.uint8))
    canvas.set_scheme(scheme_of("closed"))
    canvas.set_current("nose_tip")
    canvas.show()
    canvas.fit_view()
    canvas.setFocus()
    return canvas


def press(canvas: ImageCanvas, key: Qt.Key, modifier: Qt.KeyboardModifier = PLAIN, times: int = 1) -> None:
    for _ in range(times):
        QTest.keyClick(canvas, key, modifier)


def test_the_crosshair_appears_on_a_whole_pixel_in_the_middle_and_moves_by_one_ten_and_a_tenth(
    canvas: ImageCanvas,
) -> None:
    press(canvas, Qt.Key.Key_Right)
    start = canvas.keys.cross
    assert start is not None and (start.x() % 1, start.y() % 1) == (0.0, 0.0)
    assert abs(start.x() - 159.5) <= 2 and abs(start.y() - 119.5) <= 2
    press(canvas, Qt.Key.Key_Right, times=3)
    press(canvas, Qt.Key.Key_Up, SHIFT, times=2)
    press(canvas, Qt.Key.Key_Left, CTRL, times=4)
    placed: list[tuple[str, float, float]] = []
    canvas.place_requested.connect(lambda *values: placed.append(values))
    press(canvas, Qt.Key.Key_Return)
    name, x, y = placed[0]
    assert name == "nose_tip" and (x, y) == pytest.approx((start.x() + 2.6, start.y() - 20))


def test_the_crosshair_stays_in_the_picture_and_in_sight(canvas: ImageCanvas) -> None:
    canvas.set_zoom(6.0)
    press(canvas, Qt.Key.Key_Left, SHIFT, times=40)
    press(canvas, Qt.Key.Key_Down, SHIFT, times=40)
    cross = canvas.keys.cross
    assert cross is not None and (cross.x(), cross.y()) == (0.0, 239.0)
    assert canvas.viewport().rect().contains(canvas.to_view(cross).toPoint())
    assert canvas.loupe.isVisible() and (canvas.loupe.at - cross).manhattanLength() < 1e-9


def test_enter_without_a_crosshair_and_escape_place_nothing(canvas: ImageCanvas) -> None:
    placed: list[Any] = []
    canvas.place_requested.connect(lambda *values: placed.append(values))
    press(canvas, Qt.Key.Key_Return)
    press(canvas, Qt.Key.Key_Right)
    press(canvas, Qt.Key.Key_Escape)
    press(canvas, Qt.Key.Key_Return)
    assert not placed and canvas.keys.cross is None


def test_a_fiducial_with_a_place_is_nudged_and_has_no_crosshair(canvas: ImageCanvas) -> None:
    canvas.set_landmarks(LandmarkSet.placed({"nose_tip": (100.0, 100.0)}))
    nudges: list[tuple[str, float, float]] = []
    canvas.nudged.connect(lambda *values: nudges.append(values))
    press(canvas, Qt.Key.Key_Left)
    press(canvas, Qt.Key.Key_Down, SHIFT)
    assert nudges == [("nose_tip", -0.1, 0.0), ("nose_tip", 0.0, 1.0)]
    assert canvas.keys.cross is None and canvas.keys.shown is None


def test_the_mouse_takes_the_crosshair_away_and_plus_and_minus_zoom_about_it(canvas: ImageCanvas) -> None:
    press(canvas, Qt.Key.Key_Right, SHIFT)
    press(canvas, Qt.Key.Key_Right, SHIFT, times=3)
    cross, before = QPointF(canvas.keys.cross or QPointF()), canvas.zoom
    at = canvas.to_view(cross)
    press(canvas, Qt.Key.Key_Plus)
    assert canvas.zoom == pytest.approx(1.25 * before)
    assert (canvas.to_view(cross) - at).manhattanLength() < 2.0
    press(canvas, Qt.Key.Key_Minus)
    assert canvas.zoom == pytest.approx(before)
    QTest.mouseMove(canvas.viewport(), at.toPoint())
    assert canvas.keys.cross is None
