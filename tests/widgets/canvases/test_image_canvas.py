"""The hand on the picture: real mouse and key events, and what the canvas says about them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from engine.landmarks import LandmarkSet
from tests.widgets.conftest import LOCKED, PROPOSED, SKIPPED, UNSET
from widgets.canvases.image_canvas import ImageCanvas

LEFT, NONE = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
INTENTS = (
    "place_requested", "selected", "drag_moved", "moved", "drag_cancelled", "nudged", "unset_requested",
    "skip_requested", "lock_requested", "confirm_requested", "refused",
)  # fmt: skip


class Heard(list):
    """Everything the canvas said, in order: (signal, *values)."""

    def of(self, name: str) -> list[tuple]:
        return [said[1:] for said in self if said[0] == name]


@pytest.fixture
def canvas(qtbot, picture, scheme, landmarks) -> Iterator[ImageCanvas]:
    view = ImageCanvas()
    qtbot.addWidget(view)
    view.resize(640, 512)
    view.set_image(picture)
    view.set_scheme(scheme)
    view.set_landmarks(landmarks)
    view.show()
    qtbot.waitExposed(view)
    QApplication.processEvents()
    view.activateWindow()
    view.setFocus()
    return view


@pytest.fixture
def heard(canvas: ImageCanvas) -> Heard:
    said = Heard()
    for name in INTENTS:
        getattr(canvas, name).connect(lambda *values, name=name: said.append((name, *values)))
    return said


def at(canvas: ImageCanvas, place: tuple[float, float]) -> QPoint:
    return canvas.to_view(QPointF(*place)).toPoint()


def press(canvas: ImageCanvas, where: QPoint) -> None:
    QTest.mousePress(canvas.viewport(), LEFT, NONE, where)


def move(canvas: ImageCanvas, where: QPoint) -> None:
    QTest.mouseMove(canvas.viewport(), where)
    QApplication.processEvents()


def release(canvas: ImageCanvas, where: QPoint) -> None:
    QTest.mouseRelease(canvas.viewport(), LEFT, NONE, where)


@pytest.mark.parametrize("name", [UNSET, PROPOSED, SKIPPED])
def test_a_click_places_the_current_fiducial_there(canvas, heard, name) -> None:
    canvas.set_current(name)
    where = QPoint(37, 41) + at(canvas, (0, 0))
    QTest.mouseClick(canvas.viewport(), LEFT, NONE, where)
    (said,) = heard.of("place_requested")
    assert said[0] == name
    expected = canvas.to_picture(QPointF(where))
    assert said[1:] == pytest.approx((expected.x(), expected.y()), abs=1e-9)
    assert abs(expected.x() - 37 / canvas.zoom) < 1 / canvas.zoom
    assert not heard.of("moved")


def test_a_click_with_a_placed_fiducial_does_nothing(canvas, heard) -> None:
    canvas.set_current("forehead")
    QTest.mouseClick(canvas.viewport(), LEFT, NONE, at(canvas, (6, 150)))
    assert heard == []


def test_a_click_outside_the_picture_is_refused_with_a_reason(canvas, heard) -> None:
    canvas.set_current(UNSET)
    canvas.set_zoom(1.0)
    QTest.mouseClick(canvas.viewport(), LEFT, NONE, QPoint(5, 5))
    assert not heard.of("place_requested")
    assert heard.of("refused")[0][0] == UNSET


def test_pressing_a_fiducial_chooses_it_and_a_tiny_move_does_not_drag_it(canvas, heard, positions) -> None:
    where = at(canvas, positions["mouth_left"])
    press(canvas, where)
    move(canvas, where + QPoint(1, 1))
    release(canvas, where + QPoint(1, 1))
    assert heard == [("selected", "mouth_left")]


@pytest.mark.parametrize("zoom", [0.7, 1.75, 9.0])
def test_a_drag_says_once_where_it_ended_to_a_fraction_of_a_pixel(canvas, heard, positions, zoom) -> None:
    name, start = "nose_tip", positions["nose_tip"]
    canvas.set_zoom(zoom)
    where = at(canvas, start)
    press(canvas, where)
    for step in range(1, 6):
        move(canvas, where + QPoint(4 * step, -3 * step))
    release(canvas, where + QPoint(20, -15))
    (said,) = heard.of("moved")
    assert said[0] == name
    assert said[1:] == pytest.approx((start[0] + 20 / zoom, start[1] - 15 / zoom), abs=1e-9)
    drags = heard.of("drag_moved")
    assert len(drags) == 5
    assert drags[-1] == said
    assert heard.of("selected") == [(name,)]


def test_with_shift_a_drag_is_five_times_finer(canvas, heard, positions) -> None:
    start = positions["nose_tip"]
    where = at(canvas, start)
    press(canvas, where)
    _move_with(canvas, where + QPoint(20, 0), Qt.KeyboardModifier.ShiftModifier)
    release(canvas, where + QPoint(20, 0))
    (said,) = heard.of("moved")
    assert said[1] == pytest.approx(start[0] + 0.2 * 20 / canvas.zoom, abs=1e-9)


def _move_with(canvas, where: QPoint, modifiers) -> None:
    local = QPointF(where)
    event = QMouseEvent(
        QEvent.Type.MouseMove, local, canvas.viewport().mapToGlobal(local), Qt.MouseButton.NoButton, LEFT, modifiers
    )
    QApplication.sendEvent(canvas.viewport(), event)


def test_escape_gives_a_drag_up(canvas, heard, positions) -> None:
    where = at(canvas, positions["nose_tip"])
    press(canvas, where)
    move(canvas, where + QPoint(25, 5))
    assert canvas.fiducials.place("nose_tip") != QPointF(*positions["nose_tip"])
    QTest.keyClick(canvas, Qt.Key.Key_Escape)
    release(canvas, where + QPoint(25, 5))
    assert heard.of("drag_cancelled") == [("nose_tip",)]
    assert not heard.of("moved")
    assert canvas.fiducials.place("nose_tip") == QPointF(*positions["nose_tip"])


def test_escape_while_placing_places_nothing(canvas, heard) -> None:
    canvas.set_current(UNSET)
    where = at(canvas, (150, 20))
    press(canvas, where)
    assert canvas.loupe.isVisible()
    QTest.keyClick(canvas, Qt.Key.Key_Escape)
    release(canvas, where)
    assert heard == []


def test_a_locked_fiducial_is_chosen_but_stays(canvas, heard, positions) -> None:
    where = at(canvas, positions[LOCKED])
    press(canvas, where)
    for step in (10, 20, 30):
        move(canvas, where + QPoint(step, 0))
    release(canvas, where + QPoint(30, 0))
    QTest.keyClick(canvas, Qt.Key.Key_Left)
    canvas.set_current(LOCKED)
    QTest.keyClick(canvas, Qt.Key.Key_Left)
    assert [said[0] for said in heard] == ["selected", "refused", "refused"]
    assert canvas.fiducials.place(LOCKED) == QPointF(*positions[LOCKED])


def test_arrow_keys_nudge_by_a_tenth_and_with_shift_by_one_pixel(canvas, heard) -> None:
    canvas.set_current("nose_tip")
    QTest.keyClick(canvas, Qt.Key.Key_Right)
    QTest.keyClick(canvas, Qt.Key.Key_Up)
    QTest.keyClick(canvas, Qt.Key.Key_Down, Qt.KeyboardModifier.ShiftModifier)
    steps = [(0.1, 0.0), (0.0, -0.1), (0.0, 1.0)]
    assert heard == [("nudged", "nose_tip", *step) for step in steps]


def test_wheel_zooms_to_the_cursor_and_moves_no_fiducial(canvas, heard, positions, qtbot) -> None:
    canvas.set_current(UNSET)
    cursor = QPointF(at(canvas, positions["mouth_left"]))
    under = canvas.to_picture(cursor)
    zoom = canvas.zoom
    with qtbot.waitSignal(canvas.zoom_changed):
        _wheel(canvas, cursor, 3)
    assert canvas.zoom == pytest.approx(zoom * 1.2**3)
    off = canvas.to_view(under) - cursor
    assert max(abs(off.x()), abs(off.y())) <= 1.0
    assert heard == []


def _wheel(canvas, cursor: QPointF, steps: int) -> None:
    event = QWheelEvent(
        cursor, canvas.viewport().mapToGlobal(cursor), QPoint(), QPoint(0, 120 * steps), Qt.MouseButton.NoButton, NONE,
        Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(canvas.viewport(), event)


@pytest.mark.parametrize("with_space", [False, True])
def test_panning_starts_on_a_fiducial_and_moves_only_the_view(canvas, heard, positions, with_space) -> None:
    canvas.set_current(UNSET)
    canvas.set_zoom(5.0)
    where = at(canvas, positions["nose_tip"])
    button = LEFT if with_space else Qt.MouseButton.MiddleButton
    if with_space:
        QTest.keyPress(canvas, Qt.Key.Key_Space)
    QTest.mousePress(canvas.viewport(), button, NONE, where)
    QTest.mouseMove(canvas.viewport(), where + QPoint(30, 20))
    QApplication.processEvents()
    QTest.mouseRelease(canvas.viewport(), button, NONE, where + QPoint(30, 20))
    if with_space:
        QTest.keyRelease(canvas, Qt.Key.Key_Space)
    assert heard == []
    moved = at(canvas, positions["nose_tip"]) - where
    assert (moved.x(), moved.y()) == (30, 20)


def test_orders_of_the_context_menu_name_the_fiducial(canvas, heard) -> None:
    by_text = {action.text(): action for action in canvas.fiducial_menu(PROPOSED).actions()}
    assert by_text["Confirm"].isEnabled()
    assert not by_text["Lock"].isEnabled()
    for text in ("Confirm", "Skip", "Unset"):
        by_text[text].trigger()
    locked = {action.text(): action for action in canvas.fiducial_menu(LOCKED).actions()}
    assert not locked["Skip"].isEnabled()
    assert not locked["Unset"].isEnabled()
    locked["Unlock"].trigger()
    assert heard == [
        ("confirm_requested", PROPOSED), ("skip_requested", PROPOSED), ("unset_requested", PROPOSED),
        ("lock_requested", LOCKED, False),
    ]  # fmt: skip


def test_a_confirmed_fiducial_loses_its_ring(canvas, landmarks, positions) -> None:
    where = at(canvas, positions[PROPOSED])
    centre = canvas.viewport().grab().toImage().pixelColor(where)
    canvas.set_landmarks(landmarks.moved(PROPOSED, *positions[PROPOSED]))
    filled = canvas.viewport().grab().toImage().pixelColor(where)
    assert (filled.red(), filled.green(), filled.blue()) == (0x9B, 0x7C, 0xF2)
    assert centre != filled


def test_a_fiducial_in_the_hand_survives_news_from_the_project(canvas, heard, landmarks, positions) -> None:
    where = at(canvas, positions["nose_tip"])
    press(canvas, where)
    move(canvas, where + QPoint(25, 0))
    canvas.set_landmarks(landmarks.moved("chin", 50, 50))
    assert canvas.fiducials.place("nose_tip").x() == pytest.approx(positions["nose_tip"][0] + 25 / canvas.zoom)
    release(canvas, where + QPoint(25, 0))
    assert len(heard.of("moved")) == 1


def test_the_name_stands_in_the_view_and_over_no_other_fiducial(canvas, scheme, landmarks) -> None:
    view = QRectF(canvas.viewport().rect())
    for name in scheme.names:
        canvas.set_current(name)
        place = canvas.fiducials.place(name)
        box = canvas.fiducials.label_box(canvas.to_view, view)
        if place is None:
            assert box.isEmpty()
            continue
        assert view.contains(box)
        others = [canvas.fiducials.place(other) for other in scheme.names]
        assert not any(box.contains(canvas.to_view(other)) for other in others if other is not None)


def test_loupe_shows_the_pixels_it_names(canvas, picture, heard) -> None:
    canvas.set_current(UNSET)
    where = at(canvas, (100, 70))
    press(canvas, where)
    place = canvas.loupe.at
    shown = canvas.loupe.grab().toImage()
    column, row = round(place.x()) + 3, round(place.y()) + 2
    x, y = (61 + 8 * (c - p) for c, p in ((column, place.x()), (row, place.y())))
    pixel = shown.pixelColor(round(x), round(y))
    assert [pixel.red(), pixel.green(), pixel.blue()] == picture[row, column].tolist()
    assert canvas.loupe.accessibleName() == f"{place.x():.1f}, {place.y():.1f} px"
    release(canvas, where)
    assert len(heard.of("place_requested")) == 1


def test_loupe_leaves_the_corner_that_the_hand_needs(canvas) -> None:
    canvas.set_current(UNSET)
    corner = canvas.loupe.geometry
    press(canvas, QPoint(300, 400))
    right = corner().left()
    move(canvas, QPoint(580, 60))
    assert corner().left() < right
    assert not corner().contains(QPoint(580, 60))
    QTest.keyClick(canvas, Qt.Key.Key_Escape)
    release(canvas, QPoint(580, 60))


@pytest.mark.parametrize("pixel", [(0, 0), (199, 159), (77, 31)])
def test_pixel_centres_lie_at_whole_coordinates(canvas, picture, pixel) -> None:
    canvas.set_fiducials_visible(False)
    canvas.set_zoom(20.0)
    canvas.frame_rect(QRectF(pixel[0] - 5, pixel[1] - 5, 10, 10))
    shown = canvas.viewport().grab().toImage()
    for dx, dy in ((-0.4, -0.4), (0, 0), (0.4, 0.4)):
        colour = shown.pixelColor(canvas.to_view(QPointF(pixel[0] + dx, pixel[1] + dy)).toPoint())
        assert list(colour.getRgb()[:3]) == picture[pixel[1], pixel[0]].tolist()


def test_framing_twice_shows_the_whole_picture(canvas, template) -> None:
    flat = template.layouts["closed"].vertices
    canvas.set_template(template.edges, 60 + (flat - flat.min(axis=0)) / 6)
    canvas.fit_view()
    framed = canvas.zoom
    canvas.fit_view()
    assert canvas.zoom == framed
    QTest.keyClick(canvas, Qt.Key.Key_F)
    assert canvas.zoom < framed
    assert canvas.zoom == pytest.approx(min(640 / 200, 512 / 160))
    QTest.keyClick(canvas, Qt.Key.Key_1)
    assert canvas.zoom == 1.0


def test_views_show_depth_near_bright_and_what_is_missing(canvas, picture) -> None:
    depth = np.tile(np.linspace(500.0, 600.0, 200), (160, 1))
    valid, spikes = np.ones((160, 200), bool), np.zeros((160, 200), bool)
    valid[10:20, 10:30], spikes[100, 100] = False, True
    depth[~valid] = np.nan
    canvas.set_pictures(picture, depth, valid, spikes)
    canvas.set_view("depth")
    canvas.set_contrast(500, 600)
    grey = canvas.picture()[80, :, 0].astype(int)
    assert (np.diff(grey) <= 0).all()
    assert grey[0] == 255
    assert (canvas.picture()[12, 12] == 13).all()
    canvas.set_view("missing")
    marked = canvas.picture()
    assert marked[100, 100].tolist() == [224, 168, 35]
    assert len(np.unique(marked[10:20, 10:30].reshape(-1, 3), axis=0)) == 2
    assert canvas.contrast == (500, 600)


def test_the_user_s_contrast_stays_when_the_scan_changes(canvas, picture) -> None:
    depth = np.tile(np.linspace(500.0, 600.0, 200), (160, 1))
    canvas.set_pictures(picture, depth)
    canvas.set_contrast(520, 560)
    canvas.set_pictures(picture, depth + 300)
    assert canvas.contrast == (520, 560)
    canvas.reset_contrast()
    assert 799 < canvas.contrast[0] < 802


def test_every_array_is_left_as_it_was(canvas, picture, template) -> None:
    vertices = template.layouts["closed"].vertices
    before = vertices.copy()
    canvas.set_template(template.edges, vertices)
    canvas.set_folded(template.faces[:3])
    canvas.grab()
    assert (vertices == before).all()
    canvas.set_landmarks(LandmarkSet({}))
    canvas.set_image(None)
    canvas.grab()
