"""Proposals wait for a yes, a drag is one step that shows its effect at once, and looking around moves nothing."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from engine.landmarks import LandmarkState
from studio.scan.job import scheme_of
from tests.journeys.driver import LEFT, NO_KEY, Hand, bare_scan, send_move, truth

NAMES = scheme_of("closed").names
SHIFT, CTRL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def five(hand: Hand) -> Hand:
    """Return the hand of a window in which five fiducials of the base scan are placed."""
    hand.choose("scan.add", bare_scan("base"))
    for name in NAMES[:5]:
        hand.click(*truth()[name])
    hand.rest()
    return hand


def states(hand: Hand, state: LandmarkState) -> tuple[str, ...]:
    return hand.landmarks.names(state, order=NAMES)


def test_five_points_propose_the_rest_which_are_confirmed_one_by_one_and_all(five: Hand) -> None:
    project, stage = five.window.session.project, five.stage
    scan_id = stage.context.scan_id
    assert len(states(five, LandmarkState.PROPOSED)) == 15
    errors = [np.hypot(five.landmarks[n].x - truth()[n][0], five.landmarks[n].y - truth()[n][1]) for n in NAMES[5:]]
    assert np.median(errors) < 20 and max(errors) < 60
    assert stage.shown is not None and stage.shown.preview and (stage.shown.count, stage.shown.total) == (5, 20)
    assert project.state(scan_id).kind == "missing" and project.fit(scan_id) is None
    assert not five.window.actions_["scan.export_face"].isEnabled()
    assert "15" in five.window.actions_["scan.export_face"].toolTip()
    assert "15 proposed" in five.window.status.text.text()

    first = five.landmarks[NAMES[5]]
    assert stage.context.fiducial == NAMES[5]
    five.key(Qt.Key.Key_Return)
    assert states(five, LandmarkState.PLACED) == NAMES[:6]
    assert (five.landmarks[NAMES[5]].x, five.landmarks[NAMES[5]].y) == (first.x, first.y)
    assert stage.context.fiducial == NAMES[6]

    five.key(Qt.Key.Key_S)
    assert five.landmarks[NAMES[6]].state == LandmarkState.SKIPPED
    five.key(Qt.Key.Key_Return, SHIFT)
    five.rest()
    assert not states(five, LandmarkState.PROPOSED) and len(states(five, LandmarkState.PLACED)) == 19
    assert project.state(scan_id).kind == "fresh" and not stage.shown.preview

    for _ in range(3):
        five.key(Qt.Key.Key_Z, CTRL)
    five.rest()
    assert len(states(five, LandmarkState.PROPOSED)) == 15 and five.landmarks[NAMES[6]].state == LandmarkState.PROPOSED


def test_proposals_follow_while_points_are_placed_and_never_touch_decisions(five: Hand) -> None:
    five.stage.context.select_fiducial("chin")
    five.key(Qt.Key.Key_Return)
    five.stage.context.select_fiducial("chin")
    five.key(Qt.Key.Key_L)
    chin, before = five.landmarks["chin"], five.landmarks
    five.stage.context.select_fiducial("nose_tip")
    x, y = truth()["nose_tip"]
    five.click(x + 12, y + 9)
    after = five.landmarks
    assert after["chin"] == chin and after["chin"].locked
    assert all(after[name] == before[name] for name in NAMES[:5])
    moved = [name for name in states(five, LandmarkState.PROPOSED) if after[name] != before[name]]
    assert len(moved) >= 10


def test_a_drag_shows_its_effect_while_it_lasts_and_is_one_step(five: Hand) -> None:
    stack, stage = five.window.session.stack, five.stage
    name, start = NAMES[0], (five.landmarks[NAMES[0]].x, five.landmarks[NAMES[0]].y)
    end = (start[0] + 18.0, start[1] + 14.0)
    count, before = stack.count(), five.landmarks
    drawn = [five.template()]
    QTest.mousePress(five.canvas.viewport(), LEFT, NO_KEY, five.at(*start))
    for k in range(1, 9):
        five.move((start[0] + 18.0 * k / 8, start[1] + 14.0 * k / 8))
        drawn.append(five.template())
    assert stack.count() == count and five.landmarks == before
    assert all(np.abs(a - b).max() > 0.05 for a, b in zip(drawn[2:], drawn[1:], strict=False))
    five.release(end)
    assert stack.count() == count + 1
    assert np.hypot(five.landmarks[name].x - end[0], five.landmarks[name].y - end[1]) < 1.0
    np.testing.assert_allclose(five.template(), drawn[-1], atol=1e-9)
    five.rest()
    assert stage.shown.preview
    stack.undo()
    assert five.landmarks == before
    np.testing.assert_allclose(five.template(), drawn[0], atol=1e-9)


def test_escape_gives_a_drag_up(five: Hand) -> None:
    start = (five.landmarks[NAMES[1]].x, five.landmarks[NAMES[1]].y)
    before, count, drawn = five.landmarks, five.window.session.stack.count(), five.template()
    five.press_move(start, (start[0] + 20, start[1] + 20))
    assert np.abs(five.template() - drawn).max() > 1
    QTest.keyClick(five.canvas, Qt.Key.Key_Escape)
    np.testing.assert_allclose(five.template(), drawn, atol=1e-9)
    five.release((start[0] + 20, start[1] + 20))
    assert five.landmarks == before and five.window.session.stack.count() == count


def test_arrow_keys_nudge_by_fractions_of_a_pixel_as_one_step(five: Hand) -> None:
    name, stack = NAMES[2], five.window.session.stack
    five.stage.context.select_fiducial(name)
    old, count = five.landmarks[name], stack.count()
    for _ in range(3):
        five.key(Qt.Key.Key_Right)
    five.key(Qt.Key.Key_Up, SHIFT)
    new = five.landmarks[name]
    assert (new.x, new.y) == pytest.approx((old.x + 0.3, old.y - 1.0), abs=1e-9)
    assert stack.count() == count + 1
    stack.undo()
    assert five.landmarks[name] == old


def wheel(widget: object, at: QPoint, steps: int) -> None:
    position = QPointF(at)
    event = QWheelEvent(
        position, widget.mapToGlobal(position), QPoint(), QPoint(0, 120 * steps),  # type: ignore[attr-defined]
        Qt.MouseButton.NoButton, NO_KEY, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(widget, event)  # type: ignore[arg-type]


def test_looking_around_never_moves_a_point(five: Hand) -> None:
    before, count, canvas = five.landmarks, five.window.session.stack.count(), five.canvas
    placed = five.at(five.landmarks[NAMES[0]].x, five.landmarks[NAMES[0]].y)
    zoom = canvas.zoom
    wheel(canvas.viewport(), placed, 2)
    assert canvas.zoom > zoom
    middle = Qt.MouseButton.MiddleButton
    QTest.mousePress(canvas.viewport(), middle, NO_KEY, placed)
    send_move(canvas.viewport(), QPointF(placed) + QPointF(60, 40), middle)
    QTest.mouseRelease(canvas.viewport(), middle, NO_KEY, placed + QPoint(60, 40))

    views = five.stage.centre.views
    scene = views.viewer.plotter
    eye = np.array(views.viewer.camera.position)
    centre = QPoint(scene.width() // 2, scene.height() // 4)
    for button in (LEFT, middle):
        QTest.mousePress(scene, button, NO_KEY, centre)
        send_move(scene, QPointF(centre) + QPointF(50, 20), button)
        QTest.mouseRelease(scene, button, NO_KEY, centre + QPoint(50, 20))
    wheel(scene, centre, 1)
    five.rest()
    assert np.abs(np.array(views.viewer.camera.position) - eye).max() > 1
    five.act("view.frame")
    assert five.landmarks == before and five.window.session.stack.count() == count


def test_mirror_and_carry_over_propose(five: Hand) -> None:
    for name in ("eye_left_outer", "eye_left_inner"):
        five.stage.context.select_fiducial(name)
        five.click(*truth()[name])
    five.stage.context.select_fiducial("eye_right_outer")
    five.key(Qt.Key.Key_Delete)
    assert five.landmarks["eye_right_outer"].state == LandmarkState.UNSET
    five.key(Qt.Key.Key_M)
    mirrored = five.landmarks["eye_right_outer"]
    assert mirrored.state == LandmarkState.PROPOSED
    assert np.hypot(mirrored.x - truth()["eye_right_outer"][0], mirrored.y - truth()["eye_right_outer"][1]) < 8

    first = five.landmarks
    five.choose("scan.add", bare_scan("eel"))
    assert five.stage.context.item.name == "eel" and not five.landmarks.points
    five.key(Qt.Key.Key_C)
    five.rest()
    carried = five.landmarks
    assert five.stage.context.item.scheme == "open"  # nothing was placed, and the mouth is
    brows = [name for name in NAMES if name.startswith(("brow", "eye"))]
    for name in NAMES:
        assert carried[name].state == LandmarkState.PROPOSED
    moved = [np.hypot(carried[n].x - first[n].x, carried[n].y - first[n].y) for n in brows]
    assert np.median(moved) > 3
    assert five.stage.shown.preview and five.stage.shown.count == 0
