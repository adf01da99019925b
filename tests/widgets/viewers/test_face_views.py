"""The 3-D views in a real window: what the hand does to them, and that nothing stays behind."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication, QDoubleSpinBox
from pytestqt.qtbot import QtBot

from tests.widgets.scene import synthetic
from widgets import theme
from widgets.parts.picture import PictureOptions
from widgets.scan.face_views import DISTANCE, FACE, FaceViews
from widgets.scan.range_editor import RangeEditor

NONE, LEFT, MIDDLE = Qt.MouseButton.NoButton, Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton
NO_KEY, SHIFT = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def views(qtbot: QtBot) -> Iterator[FaceViews]:
    widget = FaceViews()
    widget.resize(300, 520)
    with qtbot.waitSignal(widget.ready, timeout=30_000):
        widget.show()
    yield widget
    widget.close()
    widget.deleteLater()


@pytest.fixture
def fitted(views: FaceViews) -> FaceViews:
    views.set_fit(synthetic.fit(), synthetic.scan())
    return views


def send(views: FaceViews, kind: QEvent.Type, x: float, y: float, button=NONE, buttons=NONE, keys=NO_KEY) -> None:
    target = views.viewer.plotter
    place = QPointF(x, y)
    event = QMouseEvent(kind, place, QPointF(target.mapToGlobal(place.toPoint())), button, buttons, keys)
    QApplication.sendEvent(target, event)


def drag(views: FaceViews, start, end, button=LEFT, keys=NO_KEY, let_go: bool = True) -> None:
    send(views, QEvent.Type.MouseButtonPress, *start, button, button, keys)
    for t in (0.25, 0.5, 0.75, 1.0):
        x, y = (a + t * (b - a) for a, b in zip(start, end, strict=True))
        send(views, QEvent.Type.MouseMove, x, y, NONE, button, keys)
    if let_go:
        send(views, QEvent.Type.MouseButtonRelease, *end, button, NONE, keys)


def wheel(views: FaceViews, x: float, y: float, steps: int) -> None:
    target = views.viewer.plotter
    place = QPointF(x, y)
    event = QWheelEvent(
        place, QPointF(target.mapToGlobal(place.toPoint())), QPoint(), QPoint(0, 120 * steps), NONE, NO_KEY,
        Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(target, event)


def rgba(image: QImage) -> np.ndarray:
    plain = image.convertToFormat(QImage.Format.Format_RGBA8888)
    rows = np.frombuffer(plain.constBits(), np.uint8).reshape(plain.height(), plain.bytesPerLine())
    return rows[:, : 4 * plain.width()].reshape(plain.height(), plain.width(), 4).copy()


def position(views: FaceViews) -> np.ndarray:
    return np.array(views.viewer.camera.GetPosition())


def bar_pixel(views: FaceViews, value: float) -> tuple[float, float]:
    """Return where a value stands on the colour bar, in pixels of the plotter from its upper left."""
    bar = views.bar
    assert bar is not None
    rect = views.viewer._rects[DISTANCE]
    xs = np.arange(0.0, rect[2])
    x = xs[np.argmin([abs(bar.value_at(x) - value) for x in xs])]
    return float(rect[0] + x), float(views.viewer.plotter.height() - (rect[1] + 29))


def test_what_was_set_before_the_window_was_shown_is_there_when_it_is(qtbot: QtBot) -> None:
    widget = FaceViews()
    widget.set_fit(synthetic.fit(), synthetic.scan())
    widget.set_mode("shaded")
    widget.set_range(0.1, 0.5)
    widget.set_wireframe(False)
    assert widget.scene is None and widget.viewer.plotter is None, "no graphics before the first paint"
    widget.resize(300, 520)
    with qtbot.waitSignal(widget.ready, timeout=30_000):
        widget.show()
    assert widget.scene is not None
    assert not widget.scene.empty
    assert (widget.scene.heat.low, widget.scene.heat.high) == (0.1, 0.5)
    picture = widget.picture()
    assert picture.shape[2] == 3 and picture.shape[0] > 400
    widget.close()
    widget.deleteLater()


def test_the_picture_shows_the_face_in_both_views(views: FaceViews) -> None:
    empty = views.picture().astype(int)
    views.set_fit(synthetic.fit(), synthetic.scan())
    full = views.picture().astype(int)
    assert empty.shape == full.shape
    changed = np.abs(full - empty).sum(axis=2) > 60
    half = changed.shape[0] // 2
    assert changed[:half].mean() > 0.2 and changed[half:].mean() > 0.2
    top, bottom = full[:half][changed[:half]], full[half:][changed[half:]]
    assert ((top[:, 1] > top[:, 0] + 30) | (top[:, 0] > top[:, 2] + 20)).mean() > 0.5, "the picture above"
    assert (np.abs(bottom[:, 2] - bottom[:, 0]) > 30).mean() > 0.3, "blue and yellow below"
    assert (bottom[:, 1] > bottom[:, [0, 2]].max(axis=1) + 30).mean() < 0.01, "and no green cheek"


def test_left_drag_orbits_around_the_face_without_roll(fitted: FaceViews) -> None:
    before, pivot = position(fitted), fitted.sight.centre
    drag(fitted, (150, 120), (210, 150))
    assert np.linalg.norm(position(fitted) - before) > 50
    assert np.linalg.norm(position(fitted) - pivot) == pytest.approx(np.linalg.norm(before - pivot), rel=1e-6)
    from widgets.scene.camera import axes

    assert abs(axes(fitted.viewer.camera)[1][1]) < 1e-9


def test_dragging_right_turns_the_near_side_to_the_right(fitted: FaceViews) -> None:
    from widgets.scene.camera import project

    fitted.view("front")
    nose = synthetic.fit().mesh.vertices[synthetic.template().layout("closed").fiducials["nose_tip"]]
    size = fitted.viewer.view_size(FACE)
    before = project(fitted.viewer.camera, nose[None], *size)[0]
    drag(fitted, (120, 120), (170, 120))
    assert project(fitted.viewer.camera, nose[None], *size)[0][0] > before[0] + 3


@pytest.mark.parametrize(("button", "keys"), [(MIDDLE, NO_KEY), (LEFT, SHIFT)])
def test_middle_or_shift_left_drag_pans(fitted: FaceViews, button: Qt.MouseButton, keys) -> None:
    before, direction = position(fitted), np.array(fitted.viewer.camera.GetDirectionOfProjection())
    drag(fitted, (150, 120), (180, 100), button, keys)
    assert np.allclose(fitted.viewer.camera.GetDirectionOfProjection(), direction, atol=1e-9)
    assert abs((position(fitted) - before) @ direction) < 1e-6 < np.linalg.norm(position(fitted) - before)


def test_the_wheel_zooms_and_the_cameras_are_one(fitted: FaceViews) -> None:
    before = np.linalg.norm(position(fitted) - fitted.sight.centre)
    wheel(fitted, 150, 120, 3)
    assert np.linalg.norm(position(fitted) - fitted.sight.centre) < before
    renderers = fitted.viewer.plotter.renderers
    assert renderers[FACE].GetActiveCamera() is renderers[DISTANCE].GetActiveCamera()


def test_a_double_click_sets_the_pivot_on_the_face(fitted: FaceViews) -> None:
    fitted.view("front")
    send(fitted, QEvent.Type.MouseButtonDblClick, 150, 110, LEFT, LEFT)
    pivot = fitted.viewer._pivot
    assert pivot is not None
    distance = np.linalg.norm(synthetic.fit().mesh.vertices - pivot, axis=1).min()
    assert distance < 6 and np.linalg.norm(pivot - fitted.sight.centre) > 0.5


def test_no_hand_on_the_views_edits_anything(fitted: FaceViews, qtbot: QtBot) -> None:
    signals = (fitted.mode_changed, fitted.wireframe_changed, fitted.points_changed, fitted.range_changed)
    heard: list[object] = []
    for signal in signals:
        signal.connect(lambda *values: heard.append(values))
    drag(fitted, (150, 120), (200, 100))
    drag(fitted, (150, 120), (200, 100), MIDDLE)
    wheel(fitted, 100, 100, -2)
    for key in "qwsrvpfi3eju":
        qtbot.keyClick(fitted.viewer.plotter, key)
    assert heard == []
    assert fitted.scene is not None and not fitted.scene.empty


def test_dragging_the_bars_handle_puts_the_range_and_it_stays(fitted: FaceViews) -> None:
    heard: list[tuple[float, float]] = []
    fitted.range_changed.connect(lambda low, high: heard.append((low, high)))
    before = position(fitted)
    drag(fitted, bar_pixel(fitted, 0.2), bar_pixel(fitted, 0.1))
    assert heard[-1] == fitted.range
    assert fitted.range[0] == 0.0 and fitted.range[1] == pytest.approx(0.1, abs=0.011)
    assert np.allclose(position(fitted), before), "the camera held still"
    kept = fitted.range
    fitted.set_fit(synthetic.fit(levels=2), synthetic.scan())
    fitted.set_fit(None)
    fitted.set_fit(synthetic.fit(), synthetic.scan())
    assert fitted.range == kept, "new data does not move it"
    assert fitted.scene is not None and (fitted.scene.heat.low, fitted.scene.heat.high) == kept


def test_while_a_handle_is_dragged_it_stays_under_the_hand(fitted: FaceViews) -> None:
    end = bar_pixel(fitted, 0.1)
    drag(fitted, bar_pixel(fitted, 0.2), end, let_go=False)
    assert fitted.bar is not None
    assert fitted.bar.axis == pytest.approx(0.2), "the bar holds still"
    assert fitted.bar.handle_at(end[0], 29) == "high"
    send(fitted, QEvent.Type.MouseButtonRelease, *end, LEFT)
    assert fitted.bar.axis == pytest.approx(fitted.range[1]), "and ends at its handle afterwards"


def test_a_handle_cannot_pass_the_other(fitted: FaceViews) -> None:
    drag(fitted, bar_pixel(fitted, 0.2), (5.0, bar_pixel(fitted, 0.2)[1]))
    low, high = fitted.range
    assert low < high


def test_the_range_can_be_typed(fitted: FaceViews, qtbot: QtBot) -> None:
    editor = RangeEditor(0.0, 0.2, (0.0, 0.2), fitted)
    editor.changed.connect(lambda low, high: fitted.bar_range(low, high, None))
    boxes = editor.findChildren(QDoubleSpinBox)
    assert [box.value() for box in boxes] == [0.0, 0.2]
    editor.high.setValue(1.5)
    editor.low.setValue(0.3)
    assert fitted.range == (0.3, 1.5)
    editor.low.setValue(9.0)
    assert editor.low.value() < editor.high.value()
    editor.close()


def test_hovering_reads_the_value_and_leaving_hides_it(fitted: FaceViews) -> None:
    fitted.view("front")
    send(fitted, QEvent.Type.MouseMove, 150, 120)
    assert fitted.scene is not None
    reading = fitted.scene._readings[FACE]
    assert reading.visible and reading._words.text.endswith("mm")
    number = float(reading._words.text.split()[0])
    assert 0 <= number <= np.nanmax(synthetic.fit().deviation_mm) + 0.005
    QApplication.sendEvent(fitted.viewer.plotter, QEvent(QEvent.Type.Leave))
    assert not reading.visible


def test_a_fiducials_name_stands_at_its_disc(fitted: FaceViews) -> None:
    from widgets.scene.camera import project

    layout = synthetic.template().layout("closed")
    fitted.set_fit(synthetic.fit(), synthetic.scan(), fiducials=layout.fiducials)
    fitted.view("front")
    size = fitted.viewer.view_size(FACE)
    place = synthetic.fit().mesh.vertices[layout.fiducials["nose_tip"]]
    x, y = project(fitted.viewer.camera, place[None], *size)[0]
    send(fitted, QEvent.Type.MouseMove, x, size[1] - y)
    assert fitted.scene is not None and fitted.scene._readings[FACE]._words.text == "nose_tip"
    fitted.set_fit(synthetic.fit(), synthetic.scan())
    send(fitted, QEvent.Type.MouseMove, x, size[1] - y)
    assert fitted.scene._readings[FACE]._words.text.endswith("mm"), "discs of the last face are gone"


def test_switches_change_the_picture_and_say_so(fitted: FaceViews, qtbot: QtBot) -> None:
    for key, signal in (
        ("wire", fitted.wireframe_changed), ("points", fitted.points_changed), ("heatmap", fitted.heatmap_changed),
    ):  # fmt: skip
        before = fitted.picture()
        with qtbot.waitSignal(signal) as blocker:
            qtbot.mouseClick(fitted.tools.buttons[key], LEFT)
        assert blocker.args == [False]
        assert (fitted.picture() != before).any(), key
    before = fitted.picture()
    with qtbot.waitSignal(fitted.mode_changed) as blocker:
        qtbot.mouseClick(fitted.tools.modes, LEFT, pos=fitted.tools.modes.box("shaded").center().toPoint())
    assert blocker.args == ["shaded"]
    assert (fitted.picture() != before).any()


def test_a_scan_without_colour_cannot_be_textured(views: FaceViews) -> None:
    views.set_fit(synthetic.fit(), synthetic.scan(colour=False))
    views.tools.modes.set_current("shaded")
    heard: list[str] = []
    views.mode_changed.connect(heard.append)
    views.tools.modes._choose("textured")
    assert heard == []


def test_the_camera_moves_only_by_hand(fitted: FaceViews) -> None:
    before = position(fitted)
    fitted.set_fit(synthetic.fit(levels=2), synthetic.scan())
    fitted.set_mode("shaded")
    fitted.set_heatmap(False)
    fitted.set_heatmap(True)
    fitted.set_preview_note("preview, 17 of 20 points")
    assert np.allclose(position(fitted), before, atol=0.1)
    drag(fitted, (150, 120), (200, 100))
    moved = position(fitted)
    fitted.resize(420, 640)
    fitted.set_fit(synthetic.fit(), synthetic.scan())
    assert np.allclose(position(fitted), moved), "once touched, not even resizing moves it"
    fitted.frame()
    assert not np.allclose(position(fitted), moved)


def test_the_picture_can_be_saved_and_copied(fitted: FaceViews) -> None:
    fitted.set_points(False)
    seen = fitted.picture()
    usual = fitted.image(PictureOptions())
    assert (usual.width(), usual.height()) == seen.shape[1::-1]
    twice = fitted.image(PictureOptions(scale=2))
    assert (twice.width(), twice.height()) == (2 * seen.shape[1], 2 * seen.shape[0])
    small = rgba(twice)[..., :3].reshape(seen.shape[0], 2, seen.shape[1], 2, 3).mean(axis=(1, 3))
    assert np.abs(small - seen).mean() < 4.0, "the same picture, in finer pixels"
    turned = fitted.image(PictureOptions(overlays=False))
    plate, name = slice(4, 22), slice(8, 90)
    assert rgba(usual)[plate, name, :3].max() > 200 > rgba(turned)[plate, name, :3].max() + 100, "no name in the corner"


def test_a_transparent_picture_has_the_face_and_nothing_else(fitted: FaceViews) -> None:
    fitted.set_points(False)
    pixels = rgba(fitted.image(PictureOptions(overlays=False, transparent=True)))
    height, width = pixels.shape[:2]
    assert (pixels[[2, 2, -3, -3], [2, -3, 2, -3], 3] == 0).all()
    assert (pixels[height // 2 - 3 : height // 2 + 3, 2, 3] == 0).all(), "nor between the views"
    assert pixels[height // 4, width // 2, 3] == 255
    solid = rgba(fitted.image(PictureOptions(overlays=False)))
    face = pixels[..., 3] == 255
    assert face.mean() > 0.15 and np.abs(pixels[face].astype(int) - solid[face]).mean() < 3
    edge = (pixels[..., 3] > 0) & ~face
    assert edge.sum() > 100 and (pixels[edge][:, :3].max(axis=1) > 20).mean() > 0.8, "the rim is no dark line"


def test_both_themes_dress_the_views(fitted: FaceViews, qapp: QApplication) -> None:
    try:
        theme.apply(qapp, theme.LIGHT)
        light = fitted.picture()
        theme.apply(qapp, theme.DARK)
        dark = fitted.picture()
    finally:
        theme.apply(qapp, theme.DARK)
    assert light[100, -3].mean() > 180 > 60 > dark[100, -3].mean()


def test_the_views_draw_nothing_while_nobody_asks(fitted: FaceViews, qtbot: QtBot) -> None:
    qtbot.wait(400)
    frames: list[int] = []
    window = fitted.viewer.plotter.render_window
    tag = window.AddObserver("EndEvent", lambda *_: frames.append(1))
    qtbot.wait(400)
    assert frames == []
    for _ in range(20):
        fitted.viewer.redraw()
    qtbot.wait(200)
    assert len(frames) == 1, "twenty requests make one frame"
    window.RemoveObserver(tag)


def test_closing_lets_go_of_everything(qtbot: QtBot) -> None:
    widget = FaceViews()
    widget.resize(300, 400)
    with qtbot.waitSignal(widget.ready, timeout=30_000):
        widget.show()
    widget.set_fit(synthetic.fit(), synthetic.scan())
    assert widget.scene is not None
    held = [weakref.ref(widget.scene), weakref.ref(widget.scene.faces[0].surface), weakref.ref(widget.viewer.plotter)]
    widget.close()
    widget.close()
    widget.deleteLater()
    for _ in range(3):
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
        QApplication.processEvents()
    gc.collect()
    assert [ref() is None for ref in held[:2]] == [True, True]
    assert widget.scene is None and widget.viewer.plotter is None


def test_closing_before_the_graphics_began_is_quiet(qtbot: QtBot) -> None:
    widget = FaceViews()
    widget.set_fit(synthetic.fit(), synthetic.scan())
    widget.close()
    qtbot.wait(50)
    assert widget.viewer.plotter is None
    widget.deleteLater()
