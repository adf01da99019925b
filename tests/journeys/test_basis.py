"""A rig and a performance become a quasi-eigen basis in the real window: opened, edited, undone, kept, exported."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QWidget

from engine.basis.compare import compare
from engine.basis.principal import principal_basis
from engine.basis.quasi_eigen import project as project_shapes
from engine.files.rig import read_rig
from engine.motion import MeshMotion
from tests.journeys.conftest import close
from tests.journeys.driver import Hand, send_move
from tests.studio.basis.small import FPS, FRAMES, NAMES, hand_rig, take, write_files

BOUNDS = "-1..2"


def open_stage(hand: Hand) -> Any:
    """Show the basis stage and wait for its 3-D."""
    hand.window.show_stage("basis")
    stage = hand.stage
    rest(hand)
    return stage


def rest(hand: Hand) -> None:
    """Wait until nothing is worked out any more."""
    for _ in range(3):
        hand.rest()


def figures(stage: Any) -> dict[str, dict[str, float]]:
    """Return the mean alpha of every basis under all bounds, as the stage has it."""
    errors = stage.follower.blend.comparison.errors
    return {key: {bound: error.alpha_mean for bound, error in rows.items()} for key, rows in errors.items()}


def wanted(coverage: float = 0.995) -> dict[str, dict[str, float]]:
    """Return the same straight from the engine."""
    rig = hand_rig()
    motion = MeshMotion.dense(take(), rig.basis.neutral, FPS)
    principal = principal_basis(motion, coverage, vertices=rig.skin)
    found = compare(rig.basis, project_shapes(rig.basis, principal), principal, motion, vertices=rig.skin)
    return {key: {bound: error.alpha_mean for bound, error in rows.items()} for key, rows in found.errors.items()}


def assert_figures(found: dict[str, dict[str, float]], expected: dict[str, dict[str, float]]) -> None:
    for key, rows in expected.items():
        for bound, value in rows.items():
            assert found[key][bound] == pytest.approx(value, rel=1e-9, abs=1e-9), (key, bound)


@pytest.mark.timeout(240)
def test_from_rig_and_performance_to_an_exported_basis(hand: Hand, hands: Callable[[], Hand], tmp_path: Path) -> None:
    rig_file, take_file, _curves = write_files(tmp_path)
    stage, window = open_stage(hand), hand.window
    context, stack = stage.context, window.session.stack
    assert window.status.text.text() == "open a hand-sculpted rig, or the sample"

    # Dropped, read, and at once there are figures: those of the engine.
    hand.drop(rig_file, take_file)
    rest(hand)
    assert [item.name for item in context.basis.rigs] == ["artist"] and context.names == NAMES
    assert stack.count() == 1, "one step"
    assert stage.teller.state.kind == "fresh", stage.teller.state
    assert_figures(figures(stage), wanted())
    assert [row.name for row in stage.centre.shapes.rows] == list(NAMES)
    assert all(row.cosine is not None and row.thumbnail is not None for row in stage.centre.shapes.rows)

    # Another coverage gives other figures; undo finds the old ones without working anything out.
    stage.centre.motion.coverage_changed.emit(0.8)
    rest(hand)
    assert context.setup.options.coverage == 0.8
    assert_figures(figures(stage), wanted(0.8))
    tasks = len(window.session.tasks.tasks)
    hand.act("edit.undo")
    assert stage.teller.state.kind == "fresh" or not rest(hand)
    rest(hand)
    assert_figures(figures(stage), wanted())
    assert not [t for t in window.session.tasks.tasks[tasks:] if t.key == "basis analysis"]

    # A slider is dragged: the error is told while it moves, and is exact when it is let go.
    context.select_shape("jaw")
    drag_slider(hand, stage.centre.shape.slider, 1.0, 0.5)
    amount = context.setup.amount("jaw")
    assert 0.0 < amount < 1.0 and stack.count() == 2
    rest(hand)
    blend = stage.follower.blend
    assert dict(blend.amounts) == {"jaw": amount}
    at = NAMES.index("jaw")
    quasi = stage.follower.analysis.result.quasi.basis.displacements
    mixed = (1 - amount) * hand_rig().basis.displacements[at] + amount * quasi[at]
    np.testing.assert_allclose(blend.basis.displacements[at], mixed, atol=1e-12)
    assert figures(stage)["hand"][BOUNDS] == pytest.approx(wanted()["hand"][BOUNDS])
    assert figures(stage)["quasi_eigen"][BOUNDS] != pytest.approx(wanted()["quasi_eigen"][BOUNDS])

    # Scrubbed: the views show that frame and how it is reproduced.
    stage.centre.timeline.frame_changed.emit(33)
    shown = stage.display.frames.picture(context.frame)
    assert context.frame == 33 and shown.index == 33
    np.testing.assert_allclose(shown.original, take()[33], atol=1e-9)
    error = blend.comparison.errors["quasi_eigen"][BOUNDS]
    skin = hand_rig().skin
    apart = np.sqrt(np.mean(np.sum((shown.by_quasi - shown.original)[skin] ** 2, axis=1)))
    assert apart == pytest.approx(error.rms_frames[33], rel=1e-6)
    hand.act("basis.worst")
    assert context.frame in stage.display.worst and context.frame != 33 == shown.index

    # Renamed and mirrored; the amount goes along with the name.
    stage.centre.shapes.rename_requested.emit("jaw", "chin")
    context.select_shape("smile_L")
    hand.act("basis.mirror")
    rest(hand)
    assert context.names == ("smile_L", "smile_R", "brow", "chin", "pucker")
    assert context.setup.amount("chin") == amount
    rig = context.rig
    left, right = (rig.basis.displacements[context.names.index(name)] for name in ("smile_L", "smile_R"))
    assert np.linalg.norm(right, axis=1).max() == pytest.approx(np.linalg.norm(left, axis=1).max())
    assert stage.teller.state.kind == "fresh"

    # Saved and reopened in a fresh window: the same values, the same figures.
    path = tmp_path / "basis.qface"
    hand.choose("file.save_as", path)
    before, setup = figures(stage), context.setup
    edits = context.hand.edits
    close(hand)
    second = hands()
    second.choose("file.open", path)
    stage = open_stage(second)
    window, context, stack = second.window, stage.context, second.window.session.stack
    assert context.setup == setup and context.hand.edits == edits and not window.isWindowModified()
    assert stage.teller.state.kind == "fresh"
    for key, rows in figures(stage).items():
        for bound, value in rows.items():
            assert value == pytest.approx(before[key][bound], rel=1e-6), (key, bound)

    # Exported: others read the same names and displacements.
    second.choose("basis.export", tmp_path / "out.glb")
    back = read_rig(tmp_path / "out.glb")
    assert back.rig.basis.names == context.names
    np.testing.assert_allclose(back.rig.basis.displacements, stage.follower.blend.basis.displacements, atol=2e-4)
    second.choose("basis.export_weights", tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_text().splitlines()[0] == "frame,time_s," + ",".join(context.names)
    assert len((tmp_path / "out.csv").read_text().splitlines()) == FRAMES + 1


def test_everything_is_undone_to_nothing_and_done_again(hand: Hand, tmp_path: Path) -> None:
    rig_file, take_file, _curves = write_files(tmp_path)
    stage, stack = open_stage(hand), hand.window.session.stack
    hand.drop(rig_file, take_file)
    rest(hand)
    stage.centre.motion.count_changed.emit(3)
    stage.set_amounts({"brow": 0.0})
    stage.editor.edit("duplicate", ("brow",))
    rest(hand)
    basis = stage.context.basis
    then = (basis.rigs.all, basis.motions.all, basis.setup)
    while stack.canUndo():
        hand.act("edit.undo")
    rest(hand)
    assert basis.is_empty and stage.teller.state.reason == "open a hand-sculpted rig"
    assert stage.follower.analysis is None and stage.centre.shapes.rows == ()
    while stack.canRedo():
        hand.act("edit.redo")
    rest(hand)
    assert (basis.rigs.all, basis.motions.all, basis.setup) == then
    assert stage.teller.state.kind == "fresh" and stage.follower.analysis.result.principal.count == 3


def test_what_does_not_fit_is_said_and_the_stage_goes_on(hand: Hand, tmp_path: Path) -> None:
    rig_file, take_file, curves = write_files(tmp_path)
    stage, message = open_stage(hand), hand.window.message
    broken = tmp_path / "broken.npz"
    np.savez(broken, vertices=take()[:, :-3], fps=FPS, unit=np.array("mm"))
    hand.drop(rig_file, broken)
    rest(hand)
    assert "topology" in message.text.text() and stage.teller.state.kind == "missing"
    assert "topology" in stage.teller.state.reason
    hand.drop(take_file)
    rest(hand)
    assert stage.teller.state.kind == "fresh"
    text = tmp_path / "notes.md"
    text.write_text("nothing")
    hand.drop(text)
    assert "neither a rig nor a performance" in message.text.text()
    hand.drop(curves)
    rest(hand)
    assert stage.context.motion.kind == "weights" and stage.teller.state.kind == "fresh"
    assert figures(stage)["hand"]["0..1"] == pytest.approx(0.0, abs=1e-6), "the rig drives itself"

    # Read otherwise, over a preview: one step, and undone.
    stage.choose_motion(stage.context.basis.motions.all[-2].id)
    rest(hand)
    steps, before = hand.window.session.stack.count(), stage.context.motion
    dialog = stage.motion_settings.open()
    rest(hand)
    assert dialog.panel.choice.fps is None
    dialog.panel.fps.setValue(60.0)
    rest(hand)
    dialog.panel.accept.click()
    rest(hand)
    assert stage.context.motion.fps == 60.0 and stage.context.motion.name == before.name
    assert hand.window.session.stack.count() == steps + 1 and stage.teller.state.kind == "fresh"
    assert stage.follower.prepared.motion.fps == 60.0
    hand.act("edit.undo")
    rest(hand)
    assert stage.context.motion == before and stage.follower.prepared.motion.fps == FPS


def test_nothing_old_is_shown_as_fresh(hand: Hand, tmp_path: Path) -> None:
    rig_file, take_file, _curves = write_files(tmp_path)
    stage, window = open_stage(hand), hand.window
    hand.drop(rig_file, take_file)
    rest(hand)
    follower, tasks, timeline = stage.follower, window.session.tasks, stage.centre.timeline

    # Between the slider and its figures nothing may leave; cancelled, they can be asked for again.
    timeline.canvas._look(5, 15)
    stage.set_amounts({"jaw": 0.5})
    assert follower.blend is None and stage.teller.state.kind == "stale" and stage.exports.reason()
    QTest.qWait(15)
    for task in [task for task in tasks.active if task.key == "basis blend"]:
        tasks.cancel(task)
    rest(hand)
    if follower.blend is None:
        assert stage.teller.state.kind == "stale" and window.actions_["basis.analyse"].isEnabled()
        hand.act("basis.analyse")
        rest(hand)
    assert dict(follower.blend.amounts) == {"jaw": 0.5} and stage.teller.state.kind == "fresh"
    assert timeline.canvas.view == (5, 15), "the same clip stays as it is looked at"

    # More axes while an amount is set; changed and undone at once: all that belongs to it comes.
    stage.set_options({"coverage": 0.6})
    rest(hand)
    stage.set_options({"coverage": 0.999})
    rest(hand)
    assert stage.teller.state.kind == "fresh"
    stage.set_options({"coverage": 0.93})
    QTest.qWait(30)
    hand.act("edit.undo")
    rest(hand)
    assert None not in (follower.live, follower.advice, follower.extremes, follower.blend)

    # The grid has the names and cosines of now; a shape takes the place of an eigenface though it was in view.
    stage.centre.views.set_mode("grid")
    stage.editor.rename("jaw", "chin")
    rest(hand)
    assert [row[0] for row in stage.centre.views.grid.rows] == list(stage.context.names)
    analysis = stage.display.analysis
    cosines = analysis.measures.cosine(stage.display.amounts(analysis))
    assert [row[3] for row in stage.centre.views.grid.rows] == list(cosines)
    stage.centre.views.set_mode("side")
    stage.show_axis(0)
    assert stage.display.eigenface
    stage.select_shape(stage.context.shape)
    assert not stage.display.eigenface

    # A performance that does not fit: the one before does not play in its place.
    broken = tmp_path / "broken.npz"
    np.savez(broken, vertices=take()[:20, :-3], fps=24.0, unit=np.array("mm"))
    hand.drop(broken)
    rest(hand)
    assert follower.prepared is None and timeline.canvas.frames == 0 and timeline.canvas.tracks == ()


def drag_slider(hand: Hand, slider: QWidget, start: float, end: float) -> None:
    """Drag the handle of a slider from one share of its range to another, telling on the way."""

    def place(share: float) -> QPoint:
        margin = 6
        return QPoint(round(margin + share * (slider.width() - 2 * margin)), slider.height() // 2)

    QTest.mousePress(slider, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, place(start))
    for k in range(1, 7):
        send_move(slider, QPointF(place(start + (end - start) * k / 6)), Qt.MouseButton.LeftButton)
    QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, place(end))
