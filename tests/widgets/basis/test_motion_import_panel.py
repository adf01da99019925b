"""The import of a performance: what is shown, what a click and a key ask for, and a preview that follows at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from engine.basis.markers import bind_markers
from engine.motion import MarkerClip, WeightCurves
from tests.engine.basis.planted_clip import HEAD, planted_clip, sample_pairs, sample_rig
from widgets import theme
from widgets.basis.motion_import_panel import HEIGHT, WIDTH, MotionImportPanel
from widgets.basis.motion_import_values import MotionChoice, MotionImportFacts, points_at, rows_of


@pytest.fixture(scope="module")
def facts():
    clip = planted_clip(frames=40).clip
    bound = bind_markers(sample_rig().mesh, clip, pairs=sample_pairs(), head=HEAD, rest_frame=0)
    return MotionImportFacts(
        "clip.c3d",
        clip,
        guessed=("forward",),
        assumed="mm, as in the file",
        head=HEAD,
        bound=bound,
        mesh=sample_rig().mesh,
        pairs=len(sample_pairs()),
        warnings=("3 positions are gaps",),
    )


@pytest.fixture
def panel(qtbot, facts):
    panel = MotionImportPanel()
    qtbot.addWidget(panel)
    panel.resize(WIDTH, HEIGHT)
    panel.show()
    panel.show_facts(facts)
    panel.asked = []
    panel.changed.connect(panel.asked.append)
    return panel


def role(panel, label):
    return next(row.role for row in panel.table.tracks.rows if row.label == label)


def test_what_was_read_is_shown(panel, facts):
    assert (panel.unit.currentText(), panel.up.currentText(), panel.forward.currentText()) == ("mm", "y", "z")
    assert panel.fps.value() == 120
    assert panel.marks["forward"].text() == "assumed"
    assert panel.marks["unit"].text() == ""
    assert "gaps" in panel.alarm.text()
    assert panel.table_note.text() == "66 on the face, 7 on the head"
    assert panel.asked == []
    assert panel.accept.isEnabled()


def test_points_lie_on_the_face_in_every_frame(facts):
    """With the head's motion taken out, a point is where its marker was captured on the rig; head markers rest."""
    for frame in (0, 17, 39):
        points = points_at(facts, MotionChoice(), frame)
        np.testing.assert_allclose(points[:66], facts.bound.captured[frame], atol=1e-6)
        np.testing.assert_allclose(points[66:], points_at(facts, MotionChoice(), 0)[66:], atol=1e-6)


def test_another_axis_is_previewed_at_once_and_asked_for(panel, facts, qtbot):
    before = panel.preview.place_of(0)
    panel.up.setFocus()
    qtbot.keyClicks(panel.up, "z")
    panel.up.activated.emit(panel.up.currentIndex())
    assert panel.asked == [MotionChoice(up="z", forward="-y")]
    assert panel.forward.currentText() == "-y"
    moved = panel.preview.place_of(0) - before
    assert abs(moved.x()) + abs(moved.y()) > 10
    # A frame whose file is turned that way lies as ours does.
    turned = MarkerClip(facts.data.labels, facts.data.positions @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0.0]]), 120)
    shown = points_at(replace(facts, data=turned, bound=None), MotionChoice(up="z", forward="-y"), 5)
    plain = points_at(replace(facts, bound=None), MotionChoice(), 5)
    np.testing.assert_allclose(shown, plain, atol=1e-6)


def test_a_unit_is_typed_and_nonsense_is_told(panel, qtbot):
    line = panel.unit.lineEdit()
    for typed, wanted in (("cm", "cm"), ("85.3", "85.3 mm")):
        line.selectAll()
        qtbot.keyClicks(line, typed)
        qtbot.keyClick(line, Qt.Key.Key_Return)
        assert panel.asked[-1].unit == wanted
    line.selectAll()
    qtbot.keyClicks(line, "furlong")
    qtbot.keyClick(line, Qt.Key.Key_Return)
    assert "furlong" in panel.alarm.text()
    assert len(panel.asked) == 2


def test_rest_frame_is_the_one_that_is_looked_at(panel, qtbot):
    panel.slider.setValue(24)
    assert panel.frame.value() == 25
    qtbot.mouseClick(panel.use_rest, Qt.MouseButton.LeftButton)
    assert panel.asked == [MotionChoice(rest_frame=24)]


def test_markers_become_head_and_face_by_click_and_key(panel, qtbot):
    panel.table.select(0)
    first = panel.table.tracks.rows[0].label
    qtbot.mouseClick(panel.as_head, Qt.MouseButton.LeftButton)
    assert role(panel, first) == "head"
    assert set(panel.asked[-1].head) == {first, *HEAD}
    qtbot.keyClick(panel.table, Qt.Key.Key_Space)
    assert role(panel, first) == "face"
    assert panel.asked[-1].head == HEAD
    qtbot.mouseClick(panel.propose, Qt.MouseButton.LeftButton)
    assert set(panel.asked[-1].head) == set(HEAD)


def test_a_click_on_a_point_selects_its_row(panel, qtbot):
    place = panel.preview.place_of(12).toPoint()
    qtbot.mouseClick(panel.preview, Qt.MouseButton.LeftButton, pos=QPoint(place.x(), place.y()))
    assert panel.table.selected() == (12,)


def test_accepting_gives_the_choice_and_escape_is_the_owners(panel, qtbot):
    panel.fps.setValue(60)
    with qtbot.waitSignal(panel.accepted) as done:
        qtbot.mouseClick(panel.accept, Qt.MouseButton.LeftButton)
    assert done.args == [MotionChoice(fps=60)]
    with qtbot.waitSignal(panel.rejected):
        qtbot.mouseClick(panel.cancel, Qt.MouseButton.LeftButton)


def test_a_problem_stands_in_the_way(panel, facts):
    panel.show_facts(replace(facts, problem="head markers: lie on one line; choose markers that do not"))
    assert not panel.accept.isEnabled()
    assert "one line" in panel.alarm.text()


def test_curves_show_only_what_matters_for_them(panel, facts):
    curves = WeightCurves(("a", "b"), np.zeros((5, 2)), 30)
    panel.show_facts(MotionImportFacts("c.csv", curves, unit="", up="", forward="", mesh=facts.mesh), MotionChoice())
    assert not panel.unit.isVisible()
    assert not panel.table.isVisible()
    assert panel.fps.isVisible()
    assert points_at(panel._facts, MotionChoice(), 0).shape == (0, 3)


def test_empty_frames_and_seldom_markers_are_told(panel, facts):
    positions = facts.data.positions.copy()
    positions[3] = np.nan
    positions[:20, 7] = np.nan
    clip = MarkerClip(facts.data.labels, positions, 120)
    sparse = replace(facts, data=clip, bound=None)
    assert rows_of(sparse, HEAD)[7].seen == pytest.approx(0.5)
    panel.show_facts(sparse)
    panel.slider.setValue(3)
    assert "no marker" in panel.preview._note
    panel.grab()


@pytest.mark.parametrize("name", ["dark", "light"])
def test_it_is_painted_in_both_themes(panel, qapp, name):
    theme.apply(qapp, theme.THEMES[name])
    picture = panel.preview.grab().toImage()
    red = theme.current().colour("captured")
    place = panel.preview.place_of(0).toPoint()
    found = picture.pixelColor(place.x(), place.y())
    assert max(abs(found.red() - red.red()), abs(found.green() - red.green()), abs(found.blue() - red.blue())) < 30
    theme.apply(qapp, theme.DARK)


def test_all_of_it_fits_a_small_screen(panel):
    assert panel.minimumSizeHint().width() <= 1280
    assert panel.minimumSizeHint().height() <= 760
