"""Every style's gestures move the camera as they say, on the real viewer, and those of another style do nothing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import (
    QContextMenuEvent,
    QInputDevice,
    QMouseEvent,
    QNativeGestureEvent,
    QPointingDevice,
    QWheelEvent,
)
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.widgets.scene import synthetic
from widgets.scan.face_views import FACE, FaceViews
from widgets.scene import camera as hand
from widgets.viewers import navigation
from widgets.viewers.navigation import ALT, CTRL, NO_KEY, SHIFT, STYLES

NONE = Qt.MouseButton.NoButton
LEFT, MIDDLE, RIGHT = Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton
BUTTONS = {"left": LEFT, "middle": MIDDLE, "right": RIGHT}
MIDDLE_OF_FACE = (150.0, 120.0)


@pytest.fixture(scope="module")
def shared(qapp: QApplication) -> Iterator[FaceViews]:
    """One view for all tests of this file: making 3-D takes longer than all they do."""
    widget = FaceViews()
    widget.resize(300, 520)
    widget.show()
    for _ in range(3000):
        QApplication.processEvents()
        if widget.scene is not None:
            break
    assert widget.scene is not None
    layout = synthetic.template().layout("closed")
    widget.set_fit(synthetic.fit(), synthetic.scan(), fiducials=layout.fiducials)
    yield widget
    widget.close()
    widget.deleteLater()


@pytest.fixture
def views(shared: FaceViews) -> Iterator[FaceViews]:
    shared.set_orthographic(False)
    shared.view("three_quarter")
    yield shared
    shared.set_orthographic(False)
    shared.viewer._rest.stop()
    navigation.choose("studio")


def send(views: FaceViews, kind: QEvent.Type, place, button, buttons, keys) -> None:
    target, at = views.viewer.plotter, QPointF(*place)
    event = QMouseEvent(kind, at, QPointF(target.mapToGlobal(at.toPoint())), button, buttons, keys)
    QApplication.sendEvent(target, event)


def drag(views: FaceViews, button: Qt.MouseButton, keys, step=(40.0, -25.0), start=MIDDLE_OF_FACE) -> None:
    end = (start[0] + step[0], start[1] + step[1])
    send(views, QEvent.Type.MouseButtonPress, start, button, button, keys)
    for t in (0.5, 1.0):
        send(views, QEvent.Type.MouseMove, [a + t * s for a, s in zip(start, step, strict=True)], NONE, button, keys)
    send(views, QEvent.Type.MouseButtonRelease, end, button, NONE, keys)


def wheel(views: FaceViews, place, angle: QPoint, keys=NO_KEY, *, pixels=None, device=None) -> None:
    target, at = views.viewer.plotter, QPointF(*place)
    more = () if device is None else (Qt.MouseEventSource.MouseEventNotSynthesized, device)
    event = QWheelEvent(
        at, QPointF(target.mapToGlobal(at.toPoint())), pixels or QPoint(), angle, NONE, keys,
        Qt.ScrollPhase.NoScrollPhase, False, *more,
    )  # fmt: skip
    QApplication.sendEvent(target, event)


def touchpad() -> QPointingDevice:
    return QPointingDevice(
        "pad", 77, QInputDevice.DeviceType.TouchPad, QPointingDevice.PointerType.Finger,
        QInputDevice.Capability.Position, 5, 0,
    )  # fmt: skip


def state(views: FaceViews) -> np.ndarray:
    camera = views.viewer.camera
    return np.array([*camera.GetPosition(), *camera.GetFocalPoint(), *camera.GetViewUp(), camera.GetParallelScale()])


def seen(views: FaceViews, point: np.ndarray) -> np.ndarray:
    return hand.project(views.viewer.camera, point[None], *views.viewer.view_size(FACE))[0]


def under(views: FaceViews, place) -> np.ndarray:
    """Return the place in mm on the face that is seen at a place of the widget."""
    view, x, y = views.viewer.where(QPointF(*place))
    hit = views.viewer.pick(view, x, y)
    assert hit is not None
    return hit


def check(views: FaceViews, deed: str, before: np.ndarray, grip: np.ndarray, at: np.ndarray, step) -> None:
    """Check that the camera has moved from ``before`` as ``deed`` says, when ``grip`` was seen at ``at``."""
    after, pivot = state(views), views.sight.centre
    position, focal, up = after[:3], after[3:6], after[6:9]
    facing = (position - focal) / np.linalg.norm(position - focal)
    faced = (before[:3] - before[3:6]) / np.linalg.norm(before[:3] - before[3:6])
    right = np.cross(up, facing)
    assert abs(right[1]) < 1e-9 and up[1] > 0, "the horizon is level and +Y is up"
    if deed == "orbit":
        assert np.linalg.norm(position - pivot) == pytest.approx(np.linalg.norm(before[:3] - pivot), rel=1e-9)
        assert np.arctan2(facing[0], facing[2]) - np.arctan2(faced[0], faced[2]) == pytest.approx(
            -np.radians(0.42) * step[0], abs=1e-6
        )
        assert np.arcsin(facing[1]) - np.arcsin(faced[1]) == pytest.approx(np.radians(0.42) * step[1], abs=1e-6)
        return
    assert np.allclose(facing, faced, atol=1e-9), "it looks the same way"
    if deed == "pan":
        assert abs((position - before[:3]) @ facing) < 1e-6
        assert seen(views, grip) - at == pytest.approx(np.array([step[0], -step[1]]), abs=1e-6), "it follows the hand"
    elif deed == "zoom":
        assert np.linalg.norm(position - grip) < 0.95 * np.linalg.norm(before[:3] - grip)
        assert seen(views, grip) == pytest.approx(at, abs=1e-6), "what was under the pointer stays there"
    elif deed == "dolly":
        moved = before[:3] - position
        assert moved @ facing > 20
        assert np.linalg.norm(moved - (moved @ facing) * facing) < 1e-6, "along the line of sight"


GESTURES = [(style, gesture) for style in STYLES.values() for gesture in style.views if gesture.source in BUTTONS]


@pytest.mark.parametrize(("style", "gesture"), GESTURES, ids=[f"{s.id} {g.text}" for s, g in GESTURES])
def test_a_gesture_does_what_its_style_says(views: FaceViews, style, gesture) -> None:
    navigation.choose(style.id)
    before, grip = state(views), under(views, MIDDLE_OF_FACE)
    at = seen(views, grip)
    drag(views, BUTTONS[gesture.source], gesture.modifiers)
    check(views, gesture.deed, before, grip, at, (40.0, -25.0))


@pytest.mark.parametrize("style", STYLES.values(), ids=list(STYLES))
def test_every_other_gesture_does_nothing(views: FaceViews, style) -> None:
    navigation.choose(style.id)
    known = {(g.source, g.modifiers) for g in style.views}
    tried = 0
    before = state(views)
    for name, button in BUTTONS.items():
        for keys in (NO_KEY, SHIFT, CTRL, ALT, SHIFT | ALT, CTRL | SHIFT):
            if (name, keys) not in known:
                drag(views, button, keys)
                assert np.array_equal(state(views), before), f"{style.id}: {name} with {keys}"
                tried += 1
    assert tried >= 13


@pytest.mark.parametrize(("style", "deed"), [("studio", "zoom"), ("maya", "dolly"), ("blender", "zoom")])
def test_the_wheel_nears_what_the_style_says(views: FaceViews, style: str, deed: str) -> None:
    navigation.choose(style)
    place = (180.0, 150.0)
    before, grip = state(views), under(views, place)
    at = seen(views, grip)
    wheel(views, place, QPoint(0, 120))
    check(views, deed, before, grip, at, (0, 0))
    if deed == "dolly":
        assert np.abs(seen(views, grip) - at).max() > 1, "a dolly does not keep what is under the pointer"
    wheel(views, place, QPoint(0, -120))
    assert state(views)[:3] == pytest.approx(before[:3], abs=1e-6)


def test_two_fingers_turn_in_one_style_and_zoom_in_another(views: FaceViews) -> None:
    pad = touchpad()
    navigation.choose("blender")
    before, grip = state(views), under(views, MIDDLE_OF_FACE)
    at = seen(views, grip)
    wheel(views, MIDDLE_OF_FACE, QPoint(0, -80), pixels=QPoint(20, -10), device=pad)
    check(views, "orbit", before, grip, at, (20, -10))
    before, grip = state(views), under(views, MIDDLE_OF_FACE)
    at = seen(views, grip)
    wheel(views, MIDDLE_OF_FACE, QPoint(0, -80), SHIFT, pixels=QPoint(20, -10), device=pad)
    check(views, "pan", before, grip, at, (20, -10))
    navigation.choose("studio")
    before, grip = state(views), under(views, MIDDLE_OF_FACE)
    at = seen(views, grip)
    wheel(views, MIDDLE_OF_FACE, QPoint(0, 60), pixels=QPoint(0, 10), device=pad)
    assert seen(views, grip) == pytest.approx(at, abs=1e-6)
    assert np.linalg.norm(state(views)[:3] - grip) == pytest.approx(
        np.linalg.norm(before[:3] - grip) / 1.15**0.5, rel=1e-9
    )


@pytest.mark.parametrize("style", list(STYLES))
def test_a_pinch_zooms_between_the_fingers(views: FaceViews, style: str) -> None:
    navigation.choose(style)
    place = (130.0, 140.0)
    grip = under(views, place)
    at, away = seen(views, grip), np.linalg.norm(state(views)[:3] - grip)
    at_point = QPointF(*place)
    event = QNativeGestureEvent(
        Qt.NativeGestureType.ZoomNativeGesture, touchpad(), 2, at_point, at_point, at_point, 0.25, QPointF()
    )
    QApplication.sendEvent(views.viewer.plotter, event)
    assert seen(views, grip) == pytest.approx(at, abs=1e-6)
    assert np.linalg.norm(state(views)[:3] - grip) == pytest.approx(away / 1.25, rel=1e-9)


def test_a_turntable_never_rolls_and_never_passes_the_pole(views: FaceViews) -> None:
    navigation.choose("blender")
    rng = np.random.default_rng(3)
    for _ in range(30):
        drag(views, MIDDLE, NO_KEY, rng.uniform(-200, 200, 2))
        up, facing = state(views)[6:9], state(views)[:3] - state(views)[3:6]
        facing /= np.linalg.norm(facing)
        assert up[1] > 0 and abs(np.cross(up, facing)[1]) < 1e-9
        assert abs(np.degrees(np.arcsin(facing[1]))) < 88.01
    views.view("top")
    right = hand.axes(views.viewer.camera)[1]
    drag(views, MIDDLE, NO_KEY, (0.0, -6.0))
    assert hand.axes(views.viewer.camera)[1] == pytest.approx(right, abs=1e-9), "leaving the pole turns nothing over"


def test_only_the_button_that_began_a_drag_ends_it(views: FaceViews) -> None:
    send(views, QEvent.Type.MouseButtonPress, (150, 120), LEFT, LEFT, NO_KEY)
    send(views, QEvent.Type.MouseButtonPress, (150, 120), MIDDLE, LEFT | MIDDLE, NO_KEY)
    send(views, QEvent.Type.MouseButtonRelease, (150, 120), MIDDLE, LEFT, NO_KEY)
    before = state(views)
    send(views, QEvent.Type.MouseMove, (180, 120), NONE, LEFT, NO_KEY)
    assert not np.array_equal(state(views), before)
    send(views, QEvent.Type.MouseButtonRelease, (180, 120), LEFT, NONE, NO_KEY)
    before = state(views)
    send(views, QEvent.Type.MouseMove, (210, 120), NONE, NONE, NO_KEY)
    assert np.array_equal(state(views), before)


def test_without_perspective_gestures_hold_what_they_hold(views: FaceViews) -> None:
    nose = synthetic.fit().mesh.vertices[synthetic.template().layout("closed").fiducials["nose_tip"]]
    views.viewer.set_pivot(nose)
    place = seen(views, nose)
    with_depth = seen(views, nose - [0, 0, 60]) - place
    views.set_orthographic(True)
    assert seen(views, nose) == pytest.approx(place, abs=1e-6), "the pivot stays where it is"
    assert np.abs(seen(views, nose - [0, 0, 60]) - place - with_depth).max() > 0.2, "and depth does not shrink"
    size = views.viewer.view_size(FACE)
    for pixel in ((40.0, 60.0), (200.0, 140.0)):
        near, far = hand.ray(views.viewer.camera, *pixel, *size)
        assert hand.project(views.viewer.camera, np.stack([near, far]), *size) == pytest.approx(
            np.array([pixel, pixel]), abs=1e-6
        )
    for keys, deed in ((NO_KEY, "orbit"), (SHIFT, "pan")):
        grip = under(views, MIDDLE_OF_FACE)
        at, before = seen(views, grip), state(views)
        drag(views, LEFT, keys)
        if deed == "pan":
            assert seen(views, grip) - at == pytest.approx(np.array([40.0, 25.0]), abs=1e-6)
        assert state(views)[-1] == before[-1], f"{deed} keeps the scale"
    views.frame()
    grip = under(views, MIDDLE_OF_FACE)
    at, scale = seen(views, grip), state(views)[-1]
    wheel(views, MIDDLE_OF_FACE, QPoint(0, 240))
    assert seen(views, grip) == pytest.approx(at, abs=1e-6)
    assert state(views)[-1] == pytest.approx(scale / 1.15**2)
    near, far = views.viewer.camera.GetClippingRange()
    depths = (state(views)[:3] - synthetic.fit().mesh.vertices) @ hand.axes(views.viewer.camera)[0]
    assert near < depths.min() and depths.max() < far, "nothing is cut off however near"
    views.set_orthographic(False)
    assert not views.orthographic


@pytest.mark.parametrize("name", list(hand.VIEWS))
@pytest.mark.parametrize("flat", [False, True])
def test_every_standard_view_shows_the_whole_face_upright(views: FaceViews, name: str, flat: bool) -> None:
    views.set_orthographic(flat)
    views.view(name) if name in ("front", "left", "right", "back", "top", "bottom", "below") else views.frame()
    places = hand.project(views.viewer.camera, synthetic.fit().mesh.vertices, *views.viewer.view_size(FACE))
    width, height = views.viewer.view_size(FACE)
    assert (places > 0).all() and (places < [width, height]).all()
    span = places.max(axis=0) - places.min(axis=0)
    assert (span > 0.6 * np.array([width, height])).any(), "and fills the room"


def test_a_fiducial_is_framed_without_turning(views: FaceViews) -> None:
    views.view("three_quarter_left")
    direction = hand.axes(views.viewer.camera)[0]
    vertex = synthetic.template().layout("closed").fiducials["mouth_left"]
    place = synthetic.fit().mesh.vertices[vertex]
    for flat in (False, True):
        views.set_orthographic(flat)
        assert views.frame_fiducial("mouth_left")
        width, height = views.viewer.view_size(FACE)
        assert seen(views, place) == pytest.approx(np.array([width, height]) / 2, abs=2.0)
        assert hand.axes(views.viewer.camera)[0] == pytest.approx(direction, abs=1e-9)
        right = hand.axes(views.viewer.camera)[1]
        room = np.linalg.norm(seen(views, place + 32 * right) - seen(views, place))
        assert room == pytest.approx(0.5 * min(width, height), rel=0.2)
    assert not views.frame_fiducial("no_such_point")


def test_the_menu_key_of_the_mouse_is_free_unless_the_style_needs_it(views: FaceViews) -> None:
    asked: list[object] = []
    views.viewer.menu_requested.connect(asked.append)
    target = views.viewer.plotter
    for style, keys, wanted in (("studio", NO_KEY, 1), ("maya", ALT, 1), ("maya", NO_KEY, 2), ("blender", NO_KEY, 3)):
        navigation.choose(style)
        place = QPoint(100, 100)
        event = QContextMenuEvent(QContextMenuEvent.Reason.Mouse, place, target.mapToGlobal(place), keys)
        QApplication.sendEvent(target, event)
        assert len(asked) == wanted, style
        menu = QApplication.activePopupWidget()
        if menu is not None:
            menu.close()
    views.viewer.menu_requested.disconnect(asked.append)


def test_a_style_that_nobody_knows_is_refused(qtbot: QtBot) -> None:
    with pytest.raises(KeyError):
        navigation.choose("cad")
    assert navigation.current().id == "studio"
