"""Playback follows the clock on the wall; sliders and chips say what the hand did."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from widgets.parts.chips import Chips
from widgets.parts.frame_field import FrameField
from widgets.parts.playback import Playback
from widgets.parts.value_slider import ValueSlider

LEFT = Qt.MouseButton.LeftButton


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def player(clock: Clock, frames: int = 240, fps: float = 120.0) -> tuple[Playback, list[int], list[bool]]:
    made = Playback(clock=clock)
    made.set_clip(frames, fps)
    frames_told: list[int] = []
    told: list[bool] = []
    made.frame_changed.connect(frames_told.append)
    made.playing_changed.connect(told.append)
    return made, frames_told, told


def test_frames_are_skipped_not_slowed(qapp) -> None:
    clock = Clock()
    made, frames, told = player(clock)
    made.play()
    for seconds in (0.1, 0.25, 0.25 + 1e-4, 1.0):  # as late as a slow view lets it be
        clock.now = 100.0 + seconds
        made.tick()
    assert frames == [12, 30, 120]
    clock.now = 100.0 + 60.0
    made.tick()
    assert frames[-1] == 239 and told == [True, False] and not made.is_playing


def test_it_loops_and_goes_on_from_where_it_is_put(qapp) -> None:
    clock = Clock()
    made, frames, told = player(clock)
    made.loop = True
    made.play()
    clock.now += 2.0 + 0.5
    made.tick()
    assert frames == [60] and made.is_playing
    made.set_frame(200)
    clock.now += 0.1
    made.tick()
    assert frames[-1] == 212
    made.pause()
    assert told == [True, False]


def test_play_at_the_end_begins_anew_and_nothing_plays_without_frames(qapp) -> None:
    clock = Clock()
    made, frames, _ = player(clock)
    made.set_frame(239)
    made.play()
    assert frames == [0] and made.is_playing
    made.set_clip(0, 0.0)
    assert not made.is_playing and made.frame == 0
    made.play()
    assert not made.is_playing


def test_a_slider_tells_while_it_is_dragged_and_once_when_it_is_let_go(qtbot) -> None:
    slider = ValueSlider(-3.0, 3.0, 0.0, 0.1)
    qtbot.addWidget(slider)
    slider.resize(212, 20)
    slider.show()
    dragged, released = [], []
    slider.dragged.connect(dragged.append)
    slider.released.connect(released.append)
    QTest.mousePress(slider, LEFT, pos=QPoint(round(slider.x_of(0.0)), 10))
    for value in (0.6, 1.2, 1.5):
        QTest.mouseMove(slider, QPoint(round(slider.x_of(value)), 10))
    slider.set_value(-3.0)
    assert slider.value == pytest.approx(1.5, abs=0.02), "the hand goes first"
    QTest.mouseRelease(slider, LEFT, pos=QPoint(round(slider.x_of(1.5)), 10))
    assert len(dragged) == 3 and released == [slider.value]
    QTest.keyClick(slider, Qt.Key.Key_Right)
    assert released[-1] == pytest.approx(1.6)
    QTest.keyClick(slider, Qt.Key.Key_End)
    QTest.keyClick(slider, Qt.Key.Key_End)
    QTest.keyClick(slider, Qt.Key.Key_Backspace)
    assert released[2:] == [3.0, 0.0]
    slider.set_value(9.0)
    assert slider.value == 3.0 and len(released) == 4
    slider.set_band((-1.0, 2.0))
    slider.grab()


def test_a_click_beside_the_handle_brings_it(qtbot) -> None:
    slider = ValueSlider(0.0, 1.0, 0.0, 0.05, reset=1.0)
    qtbot.addWidget(slider)
    slider.resize(212, 20)
    assert slider.value == 1.0
    dragged, released = [], []
    slider.dragged.connect(dragged.append)
    slider.released.connect(released.append)
    QTest.mouseClick(slider, LEFT, pos=QPoint(round(slider.x_of(0.25)), 10))
    assert dragged == released == [pytest.approx(0.25, abs=0.01)]
    QTest.mouseDClick(slider, LEFT, pos=QPoint(100, 10))
    assert released[-1] == 1.0


def test_chips_that_do_not_fit_are_left_out(qtbot) -> None:
    chips = Chips("Worst frames")
    qtbot.addWidget(chips)
    chips.set_texts(["1\u00a0842", "3\u00a0256", "4\u00a0885"])
    chips.resize(chips.sizeHint())
    chosen = []
    chips.chosen.connect(chosen.append)
    QTest.mouseClick(chips, LEFT, pos=chips.box(1).center().toPoint())
    QTest.mouseClick(chips, LEFT, pos=chips.box(1).center().toPoint())
    QTest.keyClick(chips, Qt.Key.Key_Right)
    assert chosen == [1, 1, 2]
    chips.resize(chips.sizeHint().width() - 10, 24)
    assert chips.box(2).isEmpty() and not chips.box(1).isEmpty()
    chips.set_current(1)
    chips.grab()


def test_a_frame_is_typed_with_or_without_groups(qtbot) -> None:
    field = FrameField("Frame")
    qtbot.addWidget(field)
    field.setRange(1, 35_000)
    told = []
    field.valueChanged.connect(told.append)
    field.show_value(1842)
    assert field.text() == "1\u00a0842" and told == []
    for typed in ("12 000", "3256"):
        field.selectAll()
        QTest.keyClicks(field, typed)
        QTest.keyClick(field, Qt.Key.Key_Return)
    assert told == [12_000, 3256]
    field.selectAll()
    QTest.keyClicks(field, "x-9")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert field.value() == 9
