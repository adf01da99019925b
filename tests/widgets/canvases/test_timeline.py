"""Frames and places on a timeline answer each other; hands and keys go where they are meant to."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from widgets.canvases.timeline import NAMES, TimelineCanvas
from widgets.canvases.tracks import Curve, Track

LEFT, MIDDLE = Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton
FRAMES = 600


@pytest.fixture
def canvas(qtbot) -> TimelineCanvas:
    made = TimelineCanvas("nothing here")
    qtbot.addWidget(made)
    made.resize(900, 170)
    made.set_clip(FRAMES, 120)
    hand = 1.0 + np.sin(np.arange(FRAMES) / 30.0)
    hand[250] = 5.0
    made.set_tracks([Track("α", "%", (Curve("hand", hand), Curve("PCA", hand / 4, dashed=True))),
                     Track("RMS", "mm", (Curve("hand", hand * 2),))])  # fmt: skip
    made.set_marks([250])
    made.show()
    qtbot.waitExposed(made)
    return made


def wheel(canvas: TimelineCanvas, x: float, turn: int, keys=Qt.KeyboardModifier.NoModifier) -> None:
    place = QPointF(x, 80)
    event = QWheelEvent(place, canvas.mapToGlobal(place), QPoint(), QPoint(0, turn), Qt.MouseButton.NoButton, keys,
                        Qt.ScrollPhase.NoScrollPhase, False)  # fmt: skip
    QApplication.sendEvent(canvas, event)


def test_every_frame_is_found_again_at_its_place(canvas: TimelineCanvas) -> None:
    assert [canvas.frame_at(canvas.x_of(f)) for f in range(FRAMES)] == list(range(FRAMES))
    assert canvas.frame_at(-1e6) == 0 and canvas.frame_at(1e6) == FRAMES - 1
    assert canvas.x_of(0) == canvas.plot_box().left() and canvas.x_of(FRAMES - 1) == canvas.plot_box().right()


def test_a_drag_scrubs_anywhere_right_of_the_names_and_tells_each_frame_once(canvas: TimelineCanvas) -> None:
    told = []
    canvas.frame_changed.connect(told.append)
    QTest.mouseClick(canvas, LEFT, pos=QPoint(NAMES // 2, 60))
    assert told == []
    y = 10  # on the ruler
    QTest.mousePress(canvas, LEFT, pos=QPoint(round(canvas.x_of(100)), y))
    for frame in (200, 200, 300, 99999):
        x = min(round(canvas.x_of(min(frame, FRAMES - 1))), canvas.width() - 1)
        QTest.mouseMove(canvas, QPoint(x, y))
    QTest.mouseRelease(canvas, LEFT, pos=QPoint(880, y))
    assert told == sorted(set(told)) and told[0] == pytest.approx(100, abs=1) and told[-1] == FRAMES - 1
    QTest.mouseMove(canvas, QPoint(400, y))
    assert told[-1] == FRAMES - 1


def test_a_click_on_a_mark_goes_exactly_to_its_frame(canvas: TimelineCanvas) -> None:
    told = []
    canvas.frame_changed.connect(told.append)
    tip = canvas.mark_place(250)
    QTest.mouseClick(canvas, LEFT, pos=QPoint(round(tip.x()) + 5, round(tip.y()) - 3))
    assert told == [250]


def test_keys_step_leap_and_stop_at_the_ends(canvas: TimelineCanvas) -> None:
    told = []
    canvas.frame_changed.connect(told.append)
    key, shift = Qt.Key, Qt.KeyboardModifier.ShiftModifier
    QTest.keyClick(canvas, key.Key_Left)
    QTest.keyClick(canvas, key.Key_Right)
    QTest.keyClick(canvas, key.Key_Right, shift)
    for pressed in (key.Key_PageDown, key.Key_PageUp, key.Key_End, key.Key_Right, key.Key_Home):
        QTest.keyClick(canvas, pressed)
    assert told == [1, 11, 131, 11, FRAMES - 1, 0]


def test_the_wheel_zooms_at_the_pointer_and_the_middle_button_shifts(canvas: TimelineCanvas) -> None:
    x = canvas.x_of(400)
    wheel(canvas, x, 120)
    wheel(canvas, x, 120)
    low, high = canvas.view
    assert high - low == pytest.approx((FRAMES - 1) * 0.64)
    assert canvas.x_of(400) == pytest.approx(x, abs=1e-6)
    wheel(canvas, x, 120, Qt.KeyboardModifier.ShiftModifier)
    assert canvas.view[0] < low and canvas.view[1] - canvas.view[0] == pytest.approx(high - low)
    before = canvas.view
    QTest.mousePress(canvas, MIDDLE, pos=QPoint(600, 60))
    QTest.mouseMove(canvas, QPoint(560, 60))
    QTest.mouseRelease(canvas, MIDDLE, pos=QPoint(560, 60))
    assert canvas.view[0] > before[0]
    for _ in range(60):
        wheel(canvas, x, 120)
    assert canvas.view[1] - canvas.view[0] == pytest.approx(8.0)
    for _ in range(60):
        wheel(canvas, x, -120)
    assert canvas.view == (0.0, FRAMES - 1.0)


def test_a_zoomed_view_turns_the_page_when_the_playhead_leaves_it(canvas: TimelineCanvas) -> None:
    for _ in range(8):
        wheel(canvas, canvas.x_of(100), 120)
    width = canvas.view[1] - canvas.view[0]
    canvas.set_frame(500)
    low, high = canvas.view
    assert low <= 500 <= high and high - low == pytest.approx(width)


def test_scrubbing_draws_no_curve_again(canvas: TimelineCanvas, monkeypatch) -> None:
    canvas.grab()
    drawn = []
    monkeypatch.setattr(TimelineCanvas, "_paint_track", lambda *a: drawn.append(1))
    for frame in range(100, 140):
        canvas.set_frame(frame)
        canvas.repaint()
    assert not drawn
    canvas.forget()
    canvas.repaint()
    assert drawn


@pytest.mark.parametrize("frames", [0, 1, 2, 3])
def test_clips_of_hardly_any_frames_draw(qtbot, frames: int) -> None:
    canvas = TimelineCanvas("nothing here")
    qtbot.addWidget(canvas)
    canvas.resize(500, 120)
    canvas.set_clip(frames)
    nothing = np.full(frames, np.nan)
    canvas.set_tracks([Track("α", "%", (Curve("hand", nothing),))])
    canvas.set_marks(range(frames))
    canvas.grab()
    QTest.mouseClick(canvas, LEFT, pos=QPoint(400, 50))
    wheel(canvas, 400, 120)
    QTest.keyClick(canvas, Qt.Key.Key_End)
    assert canvas.frame in range(max(1, frames))
    assert canvas.cells()[0] == ["frame", "α hand %"] and len(canvas.cells()) == frames + 1
