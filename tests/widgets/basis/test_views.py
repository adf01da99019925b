"""The views of the basis stage in a real window: what the hand does to them, and that nothing stays behind."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDoubleSpinBox, QLineEdit, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from tests.widgets.scene import made_head
from widgets import theme
from widgets.basis.views import BasisViews
from widgets.parts.picture import PictureOptions
from widgets.scan.range_editor import RangeEditor
from widgets.scene.basis_state import BY_HAND, BY_PCA, BY_QUASI, CHANGE, HAND, ORIGINAL, QUASI

NONE, LEFT = Qt.MouseButton.NoButton, Qt.MouseButton.LeftButton
NO_KEY = Qt.KeyboardModifier.NoModifier
HAND_SHAPE, QUASI_SHAPE = made_head.bump(made_head.HAND, 14.0), made_head.bump(made_head.QUASI, 14.0)
NEUTRAL = made_head.head().vertices


@pytest.fixture
def empty(qtbot: QtBot) -> Iterator[BasisViews]:
    widget = BasisViews()
    widget.resize(730, 510)
    widget.show()
    QApplication.processEvents()
    yield widget
    widget.close()
    widget.deleteLater()


@pytest.fixture
def views(empty: BasisViews, qtbot: QtBot) -> BasisViews:
    with qtbot.waitSignal(empty.ready, timeout=30_000):
        empty.set_rig(made_head.head(), made_head.skin_vertices())
    empty.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    empty.set_frame(41, NEUTRAL + HAND_SHAPE, NEUTRAL + 0.8 * HAND_SHAPE, NEUTRAL + 0.97 * HAND_SHAPE, (2.23, 0.17))
    return empty


def place_of(views: BasisViews, view: int, x: float, y: float) -> tuple[float, float]:
    """Return a pixel of a view, from its lower left, in pixels of the plotter from its upper left."""
    rect = views.viewer.rect_of(view)
    assert rect is not None
    return rect[0] + x, views.viewer.plotter.height() - (rect[1] + y)


def send(views: BasisViews, kind: QEvent.Type, x: float, y: float, button=NONE, buttons=NONE) -> None:
    target = views.viewer.plotter
    place = QPointF(x, y)
    event = QMouseEvent(kind, place, QPointF(target.mapToGlobal(place.toPoint())), button, buttons, NO_KEY)
    QApplication.sendEvent(target, event)


def drag(views: BasisViews, start, end) -> None:
    send(views, QEvent.Type.MouseButtonPress, *start, LEFT, LEFT)
    for t in (0.3, 0.6, 1.0):
        x, y = (a + t * (b - a) for a, b in zip(start, end, strict=True))
        send(views, QEvent.Type.MouseMove, x, y, NONE, LEFT)
    send(views, QEvent.Type.MouseButtonRelease, *end, LEFT, NONE)


def part(views: BasisViews, view: int, trim: int = 34) -> np.ndarray:
    """Return the pixels of a view as they are on screen, without the strips where words stand."""
    rect = views.viewer.rect_of(view)
    assert rect is not None
    left, bottom, width, height = map(int, rect)
    picture = views.viewer.picture().astype(int)
    top = picture.shape[0] - bottom - height
    return picture[top + trim : top + height - trim, left : left + width]


def unlike(first: np.ndarray, second: np.ndarray) -> float:
    """Return the share of pixels that differ plainly; two views do not rasterise an edge alike."""
    return float((np.abs(first - second).sum(axis=2) > 45).mean())


def eye(views: BasisViews) -> np.ndarray:
    return np.array(views.viewer.camera.GetPosition())


def test_without_a_rig_the_stage_is_calm_and_offers_to_open_one(empty: BasisViews, qtbot: QtBot) -> None:
    assert empty.scene is None and empty.viewer.plotter is None, "no graphics before there is something to see"
    assert empty.empty.isVisible() and not empty.tools.isEnabled()
    with qtbot.waitSignal(empty.open_requested):
        QTest.mouseClick(empty.empty.button, LEFT)
    empty.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    empty.set_frame(0, NEUTRAL, NEUTRAL, NEUTRAL, (0.0, 0.0))
    empty.set_mode("wipe")
    empty.set_mode("side")
    empty.set_message("Another rig", "has to be opened")


def test_what_was_set_before_the_3d_part_exists_is_shown_once_it_does(qtbot: QtBot) -> None:
    widget = BasisViews()
    widget.set_rig(made_head.head(), made_head.skin_vertices())
    widget.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    widget.set_range(0.5, 4.0)
    widget.set_wireframe(True)
    assert widget.scene is None
    widget.resize(598, 420)
    with qtbot.waitSignal(widget.ready, timeout=30_000):
        widget.show()
    assert widget.scene is not None and not widget.scene.empty
    assert widget.scene.state.wire and widget.range == (0.5, 4.0)
    assert (np.abs(part(widget, HAND) - part(widget, QUASI)).sum(axis=2) > 30).mean() > 0.01
    widget.close()
    widget.deleteLater()


def test_only_what_changed_is_drawn_and_the_picture_is_as_if_all_were(views: BasisViews) -> None:
    views.viewer._smooth(False)
    views.viewer.picture()
    for k in range(4):
        placed = NEUTRAL + (0.2 + 0.2 * k) * QUASI_SHAPE
        views.set_frame(k, placed, placed + 0.3, placed - 0.2, (1.0 + k, 0.1))
        partly = views.viewer._changed
        assert partly == {ORIGINAL, BY_HAND, BY_QUASI}
        seen = views.viewer.picture()
        views.viewer.redraw()
        assert (views.viewer.picture() == seen).all()
    views.set_shape("other", 0.5 * HAND_SHAPE, QUASI_SHAPE)
    assert views.viewer._changed == {HAND, QUASI, CHANGE}
    seen = views.viewer.picture()
    views.viewer.redraw()
    assert (views.viewer.picture() == seen).all()


def test_holding_space_flips_and_letting_go_flips_back_wherever_the_keys_are(views: BasisViews) -> None:
    views.viewer._smooth(False)
    hand, quasi, where = part(views, HAND), part(views, QUASI), eye(views)
    for target in (views.viewer.plotter, views):
        QTest.keyPress(target, Qt.Key.Key_Space)
        assert views.state.flipped
        flipped = part(views, HAND)
        assert unlike(flipped, quasi) < 0.002 < 0.02 < unlike(flipped, hand)
        assert (part(views, QUASI) == quasi).all()
        QTest.keyRelease(target, Qt.Key.Key_Space)
        assert not views.state.flipped and (part(views, HAND) == hand).all()
    assert (eye(views) == where).all()
    QTest.mousePress(views.tools.flip, LEFT)
    assert views.state.flipped
    QTest.mouseRelease(views.tools.flip, LEFT)
    assert not views.state.flipped


def test_a_space_bar_whose_release_is_not_heard_does_not_stay_down(views: BasisViews) -> None:
    QTest.keyPress(views.viewer.plotter, Qt.Key.Key_Space)
    QApplication.sendEvent(views, QEvent(QEvent.Type.WindowDeactivate))
    assert not views.state.flipped
    QTest.keyPress(views, Qt.Key.Key_Space, Qt.KeyboardModifier.ControlModifier)
    assert not views.state.flipped


def test_a_field_of_the_same_window_keeps_its_spaces(qtbot: QtBot) -> None:
    window = QWidget()
    field, views = QLineEdit(), BasisViews()
    box = QVBoxLayout(window)
    box.addWidget(field)
    box.addWidget(views)
    views.set_rig(made_head.head())
    window.resize(600, 460)
    with qtbot.waitSignal(views.ready, timeout=30_000):
        window.show()
    QTest.keyClicks(field, "a b")
    assert field.text() == "a b" and not views.state.flipped
    QTest.keyPress(window, Qt.Key.Key_Space)
    assert views.state.flipped
    views.hide()
    assert not views.state.flipped, "what is not seen holds nothing"
    views.close()
    window.close()
    window.deleteLater()


def test_every_mode_arranges_the_views_and_tells(views: BasisViews, qtbot: QtBot) -> None:
    for mode, wanted in (("overlay", {HAND, CHANGE}), ("wipe", {HAND, CHANGE}), ("side", {HAND, QUASI, CHANGE})):
        with qtbot.waitSignal(views.mode_changed) as told:
            QTest.mouseClick(views.tools.modes, LEFT, NO_KEY, views.tools.modes.box(mode).center().toPoint())
        assert told.args == [mode]
        assert {v for v in range(7) if views.viewer.rect_of(v)} == wanted | {ORIGINAL, BY_HAND, BY_QUASI}
    with pytest.raises(KeyError):
        views.set_mode("upside down")
    for key, signal, check in (
        ("heatmap", views.heatmap_changed, lambda: views.viewer.rect_of(CHANGE) is None),
        ("pca", views.pca_changed, lambda: views.viewer.rect_of(BY_PCA) is not None),
        ("wire", views.wireframe_changed, lambda: views.state.wire),
        ("markers", views.markers_changed, lambda: not views.state.markers),
        ("clip", views.clip_heat_changed, lambda: views.state.clip_heat),
    ):
        with qtbot.waitSignal(signal):
            QTest.mouseClick(views.tools.buttons[key], LEFT)
        assert check()


def test_modes_and_switches_do_not_move_a_camera_that_was_turned(views: BasisViews) -> None:
    drag(views, place_of(views, ORIGINAL, 100, 100), place_of(views, ORIGINAL, 150, 120))
    where = eye(views)
    for deed in (
        lambda: views.set_mode("wipe"),
        lambda: views.set_mode("side"),
        lambda: views.set_pca_visible(True),
        lambda: views.set_heatmap(False),
        lambda: views.set_shape("other", QUASI_SHAPE, HAND_SHAPE),
        lambda: views.set_frame(2, NEUTRAL, NEUTRAL, NEUTRAL, (0.0, 0.0)),
    ):
        deed()
        assert (eye(views) == where).all()
    views.frame("front")
    assert np.abs(eye(views)[0]) < 0.1 * eye(views)[2]


def test_the_wipe_follows_the_hand_and_the_camera_stays(views: BasisViews) -> None:
    views.set_mode("wipe")
    where = eye(views)
    width, height = views.viewer.view_size(HAND)
    drag(views, place_of(views, HAND, 0.5 * width, 60), place_of(views, HAND, 0.25 * width, 60))
    assert views.state.wipe == pytest.approx(0.25, abs=0.01) and (eye(views) == where).all()
    drag(views, place_of(views, HAND, 0.25 * width, 60), place_of(views, HAND, -400, 60))
    assert 0.0 < views.state.wipe < 0.05, "it stays where it can be taken again"
    drag(views, place_of(views, HAND, 0.6 * width, height / 2), place_of(views, HAND, 0.7 * width, height / 2))
    assert np.linalg.norm(eye(views) - where) > 10, "beside the line the hand turns the head"


def test_the_bars_range_is_dragged_typed_and_stays_when_shapes_change(views: BasisViews, qtbot: QtBot) -> None:
    assert views.scene is not None
    bar, where = views.scene.words.bars[CHANGE], eye(views)
    x = next(x for x in np.arange(0.0, views.viewer.view_size(CHANGE)[0]) if bar.handle_at(x, 29) == "high") + 4
    with qtbot.waitSignal(views.range_changed):
        drag(views, place_of(views, CHANGE, x, 29), place_of(views, CHANGE, x - 60, 29))
    low, high = views.range
    assert low == 0.0 and 1.5 < high < 2.5 and (eye(views) == where).all()
    views.set_shape("other", QUASI_SHAPE, HAND_SHAPE)
    assert views.range == (low, high)
    send(views, QEvent.Type.MouseButtonDblClick, *place_of(views, CHANGE, x - 90, 29), LEFT, LEFT)
    editor = QApplication.activePopupWidget()
    assert isinstance(editor, RangeEditor) and not editor.smooth.isVisible()
    box = editor.findChildren(QDoubleSpinBox)[1]
    box.setValue(5.0)
    assert views.range == (0.0, 5.0)
    editor.close()


def test_the_grid_draws_every_shape_and_a_click_chooses_one(views: BasisViews, qtbot: QtBot) -> None:
    names = [f"shape_{k}" for k in range(9)]
    views.set_grid([(name, 0.2 * k * HAND_SHAPE, QUASI_SHAPE if k else None, 0.9) for k, name in enumerate(names)])
    views.set_mode("grid")
    assert views.grid.isVisible()
    qtbot.waitUntil(lambda: views.grid.complete, timeout=20_000)
    assert len(views.grid._pictures) == 17, "one shape has no quasi-eigen form"
    with qtbot.waitSignal(views.shape_chosen) as told:
        QTest.mouseClick(views.grid.viewport(), LEFT, NO_KEY, views.grid.tile(4).center())
    assert told.args == ["shape_4"]
    with qtbot.waitSignal(views.shape_chosen) as told:
        QTest.keyClick(views.grid, Qt.Key.Key_Right)
    assert told.args == ["shape_5"]
    assert views.grid.index_at(QPoint(2, 2)) is None
    kept = dict(views.grid._pictures)
    views.set_grid(list(views.grid.rows)[:5])
    assert views.grid._pictures == {key: image for key, image in kept.items() if key[0] < 5}, "none is drawn again"
    image = views.image()
    assert image.width() >= views.grid.viewport().width()


def test_a_theme_dresses_views_and_tiles(views: BasisViews, qapp: QApplication) -> None:
    try:
        theme.apply(qapp, theme.LIGHT)
        colour = QColor(*(int(v) for v in part(views, ORIGINAL)[0, 2]))
        assert colour.lightness() > 180
    finally:
        theme.apply(qapp, theme.DARK)


def test_a_saved_picture_shows_what_is_seen(views: BasisViews) -> None:
    plain = views.image(PictureOptions(overlays=False, transparent=True))
    assert plain.hasAlphaChannel() and plain.pixelColor(3, 3).alpha() == 0
    double = views.image(PictureOptions(scale=2))
    assert double.width() == 2 * plain.width()
    seen = views.viewer.picture().astype(int)
    rows = views.image(PictureOptions(scale=1)).convertToFormat(double.Format.Format_RGB888)
    buffer = np.frombuffer(rows.constBits(), np.uint8).reshape(rows.height(), rows.bytesPerLine())
    drawn = buffer[:, : 3 * rows.width()].reshape(rows.height(), rows.width(), 3).astype(int)
    assert drawn.shape == seen.shape and (np.abs(drawn - seen).sum(axis=2) > 90).mean() < 0.03


def test_closed_views_leave_nothing_behind(qtbot: QtBot) -> None:
    widget = BasisViews()
    widget.set_rig(made_head.head())
    widget.resize(500, 400)
    with qtbot.waitSignal(widget.ready, timeout=30_000):
        widget.show()
    assert widget.scene is not None
    widget.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    widget.viewer.picture()
    held = [weakref.ref(widget.scene), weakref.ref(widget.scene.faces[HAND].surfaces[0])]
    widget.close()
    widget.set_shape("late", HAND_SHAPE, QUASI_SHAPE)
    widget.deleteLater()
    QApplication.processEvents()
    gc.collect()
    assert [ref() for ref in held] == [None, None]
