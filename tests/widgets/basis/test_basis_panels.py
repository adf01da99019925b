"""The docks beside the views show what they are given, judge by their limits, and say what the user wants."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from engine.basis.muscles import muscle_checklist
from widgets.basis.advice_panel import AdviceItem, AdvicePanel
from widgets.basis.cloud_panel import CloudPanel
from widgets.basis.eigen_panel import EigenPanel
from widgets.basis.error_panel import BasisFigures, ErrorPanel, check_rows
from widgets.basis.guide_panel import GuidePanel
from widgets.basis.motion_panel import BasisChoices, MotionFacts, MotionPanel
from widgets.basis.projection_panel import ProjectionPanel
from widgets.basis.shape_panel import ShapeFacts, ShapePanel
from widgets.basis.words import BASES, BOUNDS, figure

LEFT = Qt.MouseButton.LeftButton
ALPHA = {
    "hand": {"0..1": (1.46, 1.6), "-1..2": (0.98, 1.1), "free": (0.71, 0.8)},
    "quasi_eigen": {"0..1": (0.31, 0.4), "-1..2": (0.22, 0.3), "free": (0.21, 0.3)},
    "pca": {"free": (0.2, 0.25)},
}


def collect(*signals) -> list[tuple]:
    told: list[tuple] = []
    for signal in signals:
        signal.connect(lambda *values: told.append(values))
    return told


def test_numbers_are_read_as_they_are_written() -> None:
    assert [figure(v) for v in (None, float("nan"), float("inf"), -0.5, 1.234, 2e7)] == [
        "–", "–", "–", "−0.50", "1.23", "2.00e+07",
    ]  # fmt: skip


# -- one shape ------------------------------------------------------------------------------------------------


def test_the_slider_of_a_shape_tells_while_it_moves_and_when_it_is_let_go(qtbot) -> None:
    panel = ShapePanel()
    qtbot.addWidget(panel)
    panel.resize(296, 140)
    panel.show()
    assert panel.empty.isVisible() and panel.note == ""
    panel.set_shape(ShapeFacts("smile", 1.0, 0.53, 0.21, 0.123, 0.93), count=3)
    assert panel.note == "smile and 2 more"
    dragged, released = collect(panel.amount_dragged), collect(panel.amount_set)
    slider = panel.slider
    QTest.mousePress(slider, LEFT, pos=QPoint(round(slider.x_of(1.0)), 10))
    QTest.mouseMove(slider, QPoint(round(slider.x_of(0.5)), 10))
    assert panel.number.text() == f"{slider.value:.2f}"
    panel.set_shape(ShapeFacts("smile", 1.0, cosine=0.93))
    assert slider.value == pytest.approx(0.5, abs=0.02), "the preview does not take the handle away"
    QTest.mouseRelease(slider, LEFT, pos=QPoint(round(slider.x_of(0.5)), 10))
    assert len(dragged) == 1 and released == [(slider.value,)]
    panel.set_live_alpha(0.224, 0.25)
    assert panel.table.rows[0].value == "0.22" and "0.25" in panel.table.rows[0].tip
    panel.set_live_alpha(None)
    assert "α" not in panel.table.rows[0].name


@pytest.mark.parametrize(("cosine", "limit", "verdict"), [(0.93, 0.85, "ok"), (0.71, 0.85, "warn"), (0.71, 0.7, "ok"),
                                                          (float("nan"), 0.85, ""), (None, 0.85, "")])  # fmt: skip
def test_the_cosine_is_judged_by_its_limit(qtbot, cosine, limit, verdict) -> None:
    panel = ShapePanel()
    qtbot.addWidget(panel)
    panel.set_shape(ShapeFacts("smile", 1.0, 0.5, 0.2, 0.1, cosine))
    panel.set_cosine_limit(limit)
    row = next(row for row in panel.table.rows if row.name == "cosine")
    assert row.verdict == verdict and f"{limit:.2f}" in row.limit


# -- errors ---------------------------------------------------------------------------------------------------


def test_the_table_of_alpha_shows_mean_or_pooled_and_a_click_chooses_bounds(qtbot) -> None:
    panel = ErrorPanel()
    qtbot.addWidget(panel)
    panel.resize(296, 300)
    panel.show()
    assert panel.empty.isVisible() and panel.note == ""
    panel.set_alpha(ALPHA)
    panel.set_measure("face skin", 6000)
    assert panel.note == "face skin, mean of 6\u00a0000"
    assert "face skin" in panel.origin_label.text() and "centroid" in panel.origin_label.text()
    cells = panel.table.cells()
    assert cells[1] == [BASES["hand"], "1.46", "0.98", "0.71"] and cells[3] == ["PCA", "–", "–", "0.20"]
    told = collect(panel.bounds_chosen, panel.statistic_chosen)
    QTest.mouseClick(panel.table, LEFT, pos=panel.table.column_box("free").center())
    QTest.keyClick(panel.table, Qt.Key.Key_Left)
    QTest.mouseClick(panel.statistic, LEFT, pos=panel.statistic.box("pooled").center().toPoint())
    assert told == [("free",), ("-1..2",), ("pooled",)]
    assert panel.table.cells()[1][2] == "1.10" and "pooled" in panel.note
    panel.set_bounds("0..1")
    panel.set_statistic("mean")
    assert panel.bounds == "0..1" and len(told) == 3
    assert list(BOUNDS) == ["0..1", "-1..2", "free"]


def test_checks_pass_and_fail_at_their_limits() -> None:
    good = BasisFigures(3.5, 1.3, 3.0, 0.85, 22, 24, 22)
    bad = BasisFigures(3.49, 1.31, 3.01, 0.84, 21, 24, 22)
    assert [row.verdict for row in check_rows(good)] == ["ok"] * 5
    assert [row.verdict for row in check_rows(bad)] == ["warn"] * 5
    assert check_rows(bad)[-1].value == "21 / 22"
    assert [row.verdict for row in check_rows(BasisFigures())] == [""] * 5
    assert {row.value for row in check_rows(BasisFigures())} == {"–"}


# -- the performance ------------------------------------------------------------------------------------------


@pytest.fixture
def motion(qtbot) -> MotionPanel:
    panel = MotionPanel()
    qtbot.addWidget(panel)
    panel.resize(232, 420)
    panel.show()
    panel.set_motion(MotionFacts("speech.c3d", 6000, 120.0, "markers", 66, 7, ("12 gaps filled", "unit mm assumed")))
    panel.set_choices(BasisChoices())
    panel.set_axes(22, 0.9952)
    return panel


def test_the_facts_of_a_performance_are_read(motion: MotionPanel) -> None:
    assert motion.frames_value.text == "6\u00a0000 at 120 fps"
    assert motion.markers_value.text == "66 face, 7 head"
    assert "unit mm assumed" in motion.notes_value.toolTip()
    assert motion.axes_note.text() == "22 axes"
    assert (motion.first.value(), motion.last.value()) == (1, 6000)
    assert not motion.driver.isVisible()
    motion.set_motion(MotionFacts("face.csv", 900, 60.0, "weights", needs_driver=True))
    assert motion.driver.isVisible() and not motion.markers_value.isVisible()
    motion.set_motion(None)
    assert motion.empty.isVisible() and not motion.section.isVisible()


def test_a_training_range_is_told_from_0_and_never_empty(motion: MotionPanel) -> None:
    told = collect(motion.train_changed)
    motion.first.setValue(101)
    motion.last.setValue(200)
    motion.first.setValue(5000)
    assert told == [(100, 6000), (100, 200), (198, 200)]
    motion.set_choices(BasisChoices(train=(9, 50)))
    assert (motion.first.value(), motion.last.value()) == (10, 50) and len(told) == 3


def test_axes_go_by_coverage_or_by_count(motion: MotionPanel) -> None:
    told = collect(motion.coverage_changed, motion.count_changed)
    motion.coverage.setValue(0.99)
    QTest.mouseClick(motion.by, LEFT, pos=motion.by.box("count").center().toPoint())
    assert motion.count.isVisible() and motion.count.value() == 22 and motion.axes_note.text() == "0.9952"
    motion.count.setValue(30)
    assert told == [(0.99,), (22,), (30,)]
    motion.set_choices(BasisChoices(coverage=0.95))
    assert motion.coverage.isVisible() and motion.coverage.text() == "0.95" and len(told) == 3


def test_bounds_kind_ridge_and_driver_are_told(motion: MotionPanel) -> None:
    told = collect(motion.bounds_chosen, motion.affine_chosen, motion.ridge_changed, motion.driver_chosen)
    QTest.mouseClick(motion.bounds, LEFT, pos=motion.bounds.box("free").center().toPoint())
    QTest.mouseClick(motion.affine, LEFT, pos=motion.affine.box("affine").center().toPoint())
    motion.ridge.setValue(0.25)
    motion.set_rigs([("a", "Head"), ("b", "Other")], "b")
    assert motion.driver.currentText() == "Other"
    motion.driver.setCurrentIndex(0)
    motion.driver.activated.emit(0)
    assert told == [("free",), (True,), (0.25,), ("a",)]
    asked = collect(motion.open_requested, motion.settings_requested)
    QTest.mouseClick(motion.open_button, LEFT)
    QTest.mouseClick(motion.settings_button, LEFT)
    assert len(asked) == 2


# -- projection, advice, eigenfaces, cloud --------------------------------------------------------------------


def test_the_projection_names_what_was_clicked(qtbot) -> None:
    panel = ProjectionPanel()
    qtbot.addWidget(panel)
    panel.resize(296, 160)
    panel.show()
    assert panel.note == ""
    panel.set_projection(np.eye(4, 3), ("a", "b", "c", "d"))
    panel.set_spectrum(np.array([8.0, 1.0, 1.0]), None, 2)
    assert panel.note == "W, 4 shapes × 3 axes"
    assert np.allclose(panel.scree.cumulative, [0.8, 0.9, 1.0]) and np.allclose(panel.scree.shares, [0.8, 0.1, 0.1])
    told = collect(panel.shape_chosen, panel.axis_chosen)
    QTest.mouseClick(panel.matrix, LEFT, pos=panel.matrix.cell(2, 1).center().toPoint())
    assert told == [(1,), ("c",)]
    panel.set_projection(np.eye(4, 3), ("c", "b", "a", "d"))
    assert panel.matrix.row == 0, "the mark stays with its shape"
    panel.set_projection(np.eye(4, 1), ("a", "b", "d", "e"))
    assert (panel.matrix.row, panel.matrix.column) == (-1, -1)
    panel.set_projection(None)
    panel.set_spectrum(None)
    panel.grab()


def test_advice_is_read_one_by_one_and_its_buttons_act(qtbot) -> None:
    panel = AdvicePanel()
    qtbot.addWidget(panel)
    panel.resize(296, 90)
    panel.show()
    panel.set_advice([AdviceItem("brow_lower drifts", "warn", (("keep", "Keep 40 % of hand"), ("axis", "Show axis 6"))),
                      AdviceItem("Axis 19 is reached by no shape", "info", (("axis19", "Show axis 19"),))])  # fmt: skip
    QApplication.processEvents()
    told = collect(panel.action_requested)
    for button in panel.buttons:
        assert button.width() >= button.minimumSizeHint().width() and button.geometry().right() < panel.width()
        QTest.mouseClick(button, LEFT)
    QTest.mouseClick(panel.more, LEFT)
    assert panel.text.text().startswith("Axis 19")
    QTest.mouseClick(panel.buttons[0], LEFT)
    assert told == [("keep",), ("axis",), ("axis19",)]
    panel.set_advice(panel.items)
    assert panel.text.text().startswith("Axis 19"), "what is read stays"
    panel.set_advice([])
    assert "Nothing to do" in panel.text.text() and not panel.buttons
    panel.set_advice(None)
    assert "appears here" in panel.text.text()


def test_eigenfaces_tell_all_values_while_one_moves(qtbot) -> None:
    panel = EigenPanel()
    qtbot.addWidget(panel)
    panel.resize(296, 240)
    panel.show()
    assert panel.empty.isVisible()
    panel.set_axes(np.array([9.0, 4.0, 1.0]), np.array([0.6, 0.3, 0.1]), np.array([[-2, 2], [-1, 3], [-9, 9.0]]))
    assert panel.note == "3 axes" and not panel.empty.isVisible()
    told, axes = collect(panel.values_set), collect(panel.axis_chosen)
    slider = panel.rows[1].slider
    slider.setFocus()
    QTest.keyClick(slider, Qt.Key.Key_Right)
    assert np.allclose(told[0][0], [0, 0.1, 0]) and axes == [(1,)]
    panel.set_values(np.array([1.0, -2.0, 7.0]))
    assert np.allclose(panel.values, [1.0, -2.0, 3.0]) and len(told) == 1
    QTest.mouseClick(panel.reset_button, LEFT)
    QTest.mouseClick(panel.reset_button, LEFT)
    assert len(told) == 2 and not told[-1][0].any()
    panel.grab()
    panel.set_axes(np.ones(1))
    assert panel.note == "1 axis" and len(panel.rows) == 1


def test_the_cloud_singles_out_a_shape(qtbot) -> None:
    panel = CloudPanel()
    qtbot.addWidget(panel)
    panel.resize(296, 280)
    panel.show()
    panel.set_cloud(np.random.default_rng(1).normal(size=(50, 2)), np.arange(50) * 10)
    hand = np.array([[5.0, 0.0], [0.0, 5.0]])
    panel.set_directions({"hand": hand, "quasi_eigen": hand / 2, "pca": np.eye(2)}, ("a", "b"), np.array([1.0, 1.0]))
    assert not any(arrow.faint for arrow in panel.canvas.arrows) and len(panel.canvas.arrows) == 6
    panel.set_current("b")
    assert {a.name for a in panel.canvas.arrows if not a.faint} == {"b", "axis 1", "axis 2"}
    assert all(np.array_equal(a.tail, [1, 1, 0]) for a in panel.canvas.arrows if a.name == "b")
    shadow = panel.canvas.arrows
    panel.set_directions({"quasi_eigen": hand / 2}, ("a", "b"), outside=np.array([3.0, 4.0]))
    QTest.mouseClick(panel.view, LEFT, pos=panel.view.box("outside").center().toPoint())
    by_hand, quasi = (next(a for a in panel.canvas.arrows if a.name == "b" and a.role == r) for r in
                      ("text", "reconstructed_text"))  # fmt: skip
    assert np.array_equal(by_hand.tip, [0.0, 4.0, 2.5]) and np.array_equal(quasi.tip, [0.0, 0.0, 2.5])
    assert panel.canvas.names == ("axis 1", "outside", "axis 2")
    panel.set_directions({"hand": hand, "quasi_eigen": hand / 2, "pca": np.eye(2)}, ("a", "b"), np.array([1.0, 1.0]))
    assert panel.view.current == "3-D" and len(panel.canvas.arrows) == len(shadow)
    told = collect(panel.frame_chosen)
    x, y = panel.canvas.placed(panel.canvas.points)[7]
    QTest.mouseClick(panel.canvas, LEFT, pos=QPoint(round(x), round(y)))
    assert len(told) == 1 and told[0][0] % 10 == 0
    QTest.mouseClick(panel.view, LEFT, pos=panel.view.box("2 · 3").center().toPoint())
    assert panel.canvas.yaw == 90.0
    QTest.mousePress(panel.canvas, LEFT, pos=QPoint(60, 60))
    QTest.mouseMove(panel.canvas, QPoint(90, 60))
    QTest.mouseRelease(panel.canvas, LEFT, pos=QPoint(90, 60))
    assert panel.view.current == "3-D"


def test_the_guide_says_which_muscles_have_a_shape(qtbot) -> None:
    panel = GuidePanel()
    qtbot.addWidget(panel)
    panel.resize(296, 480)
    panel.show()
    assert panel.empty.isVisible() and panel.note == ""
    entries = muscle_checklist(("jawOpen", "mouthSmileLeft", "mouthSmileRight"))
    panel.set_checklist(entries)
    assert panel.note == f"{sum(e.found for e in entries)} of 18" and not panel.empty.isVisible()
    told = collect(panel.shape_chosen)
    lines = panel.checklist.lines
    assert next(line for line in lines if isinstance(line, str)).startswith("upper face")
    smile = next(k for k, e in enumerate(lines) if not isinstance(e, str) and "mouthSmileLeft" in e.shapes)
    QTest.mouseClick(panel.checklist, LEFT, pos=panel.checklist.box(smile).center())
    none = next(k for k, e in enumerate(lines) if not isinstance(e, str) and not e.found)
    QTest.mouseClick(panel.checklist, LEFT, pos=panel.checklist.box(none).center())
    assert told == [("mouthSmileLeft",)] and panel.checklist.current == none
    QTest.keyClick(panel.checklist, Qt.Key.Key_Down)
    assert panel.checklist.current > none
    assert len(panel.checklist.cells()) == 19
    panel.grab()
