"""Rigs and performances in a project: edited step by step, saved, lost and found again; large motion stays linked."""

from __future__ import annotations

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtGui import QUndoStack

from engine.errors import InputError
from engine.shape_edits import Combine, Duplicate, Mirror, Remove, Rename, Split, apply_edits
from studio.basis import loading
from studio.basis.commands import (
    AddMotion,
    AddRig,
    ChooseInput,
    EditShapes,
    RemoveItem,
    RenameItem,
    SetAmounts,
    SetBasisOptions,
    SetMotion,
)
from studio.basis.loading import load_motion, load_rig, read_linked
from studio.basis.options import MotionOptions
from studio.basis.results import Ingredients, analyse, changes, inputs_key, needs, prepare_motion
from studio.project import store
from studio.project.basis_state import BasisState
from studio.project.document import Project
from studio.project.recovery import journal_of, pieces_of, recover, write_journal
from studio.project.recovery_files import RecoveryFiles
from studio.project.salvage import salvage
from tests.studio.basis.small import FRAMES, NAMES, hand_rig, take, write_files


@pytest.fixture(autouse=True)
def _qt(qapp: object) -> None:
    """Commands need Qt."""


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path, Path]:
    return write_files(tmp_path)


@pytest.fixture
def project(files: tuple[Path, Path, Path]) -> Project:
    """A project with the rig and the performance, both chosen."""
    found = Project()
    for command in opening(found, *files[:2]):
        command.redo()
    return found


def opening(project: Project, rig: Path, motion: Path) -> list:
    hand, take = load_rig(rig), load_motion(motion)
    first, second = AddRig(project, hand.item, hand.content), AddMotion(project, take.item, take.data)
    first.redo()
    second.redo()
    chosen = [ChooseInput(project, "hand", hand.item.id), ChooseInput(project, "motion", take.item.id)]
    second.undo()
    first.undo()
    return [first, second, *chosen]


def everything(basis: BasisState) -> tuple:
    return basis.rigs.all, basis.motions.all, basis.setup


def test_every_edit_is_undone_and_redone_exactly(project: Project) -> None:
    basis, stack = project.basis, QUndoStack()
    hand, motion = basis.hand, basis.motion
    assert hand is not None and motion is not None
    seen = [everything(basis)]

    def do(command) -> None:
        stack.push(command)
        seen.append(everything(basis))

    do(RenameItem(project, hand.id, "artist's"))
    do(SetBasisOptions(project, {"coverage": 0.9, "train": (0, 50)}))
    do(SetAmounts(project, {"smile_L": 0.25, "jaw": 0.5}))
    do(EditShapes(project, hand.id, [Rename("smile_L", "grin_L")]))
    do(EditShapes(project, hand.id, [Mirror("grin_L", "grin_R"), Remove(("pucker",))]))
    do(SetMotion(project, replace(motion, options=MotionOptions(rest_frame=3))))
    do(ChooseInput(project, "driver", hand.id))
    do(RemoveItem(project, motion.id))
    assert basis.setup.amount("grin_L") == 0.25 and basis.setup.amount("smile_L") == 1.0
    assert basis.motion is None and needs(basis) == "open a performance"
    for expected in reversed(seen[:-1]):
        stack.undo()
        assert everything(basis) == expected
    for expected in seen[1:]:
        stack.redo()
        assert everything(basis) == expected
    rig = basis.rig(basis.rigs[hand.id])
    assert rig is not None and rig.basis.names == ("grin_L", "grin_R", "smile_R", "brow", "jaw")


def test_steps_of_one_slider_are_one_and_those_that_lead_back_are_none(project: Project) -> None:
    stack = QUndoStack()
    for value in (0.9, 0.6, 0.3):
        stack.push(SetAmounts(project, {"brow": value}))
    assert stack.count() == 1 and project.basis.setup.amount("brow") == 0.3
    stack.push(SetAmounts(project, {"jaw": 0.3}))
    assert stack.count() == 2
    for value in (0.99, 0.98):
        stack.push(SetBasisOptions(project, {"coverage": value}))
    assert stack.count() == 3
    stack.push(SetBasisOptions(project, {"ridge": 0.1}))
    assert stack.count() == 4
    stack.push(SetBasisOptions(project, {"ridge": 0.0}))
    assert stack.count() == 3, "a step that changes nothing in the end is taken off"


def test_what_cannot_be_is_refused_before_it_is_pushed(project: Project, files: tuple[Path, Path, Path]) -> None:
    basis = project.basis
    hand, motion = basis.hand, basis.motion
    assert hand is not None and motion is not None
    before = everything(basis)
    again = load_rig(files[0])
    for make, match in (
        (lambda: AddRig(project, again.item, again.content), "belongs to another rig"),
        (lambda: RenameItem(project, hand.id, " "), "is empty"),
        (lambda: ChooseInput(project, "motion", "nobody"), "is not in the project"),
        (lambda: SetBasisOptions(project, {"coverage": 2.0}), "coverage"),
        (lambda: SetBasisOptions(project, {"train": (5, 5)}), "train"),
        (lambda: SetAmounts(project, {"jaw": 1.5}), "choose 0"),
        (lambda: SetAmounts(project, {"jaw": float("nan")}), "choose 0"),
        (lambda: EditShapes(project, hand.id, [Rename("nobody", "x")]), "nobody"),
        (lambda: EditShapes(project, hand.id, [Rename("jaw", "brow")]), "brow"),
        (lambda: EditShapes(project, hand.id, [Remove(NAMES)]), "at least one|one shape|keep"),
        (lambda: SetMotion(project, replace(motion, id="nobody")), "is not in the project"),
        (lambda: RemoveItem(project, "nobody"), "is not in the project"),
    ):
        with pytest.raises(InputError, match=match):
            make()
    assert everything(basis) == before


def test_a_project_comes_back_with_edits_and_the_very_same_figures(project: Project, tmp_path: Path) -> None:
    hand = project.basis.hand
    assert hand is not None
    EditShapes(project, hand.id, [Combine((("smile_L", 0.5), ("jaw", 0.25)), "both"), Remove(("brow",))]).redo()
    SetAmounts(project, {"both": 0.4}).redo()
    path = store.save(project, tmp_path / "a.qface")
    again = store.load(path)
    assert everything(again.basis) == everything(project.basis)
    one, two = (found.basis.rig(found.basis.hand) for found in (project, again))
    np.testing.assert_array_equal(one.basis.displacements, two.basis.displacements)
    assert one.basis.names == two.basis.names
    first, second = (analyse(Ingredients.of(found.basis)) for found in (project, again))
    assert first.key == second.key
    for key, rows in first.result.comparison.errors.items():
        for bound, error in rows.items():
            np.testing.assert_array_equal(error.alpha_frames, second.result.comparison.errors[key][bound].alpha_frames)
    assert store.save(again, tmp_path / "b.qface").stat().st_size == path.stat().st_size


def test_a_project_without_rigs_says_nothing_of_them(tmp_path: Path) -> None:
    import json
    import sqlite3

    path = store.save(Project(), tmp_path / "empty.qface")
    connection = sqlite3.connect(path)
    header = json.loads(connection.execute("SELECT value FROM project WHERE key = 'header'").fetchone()[0])
    connection.close()
    assert header["basis"] is None and header["contents"] is None


def test_what_changes_a_basis_has_a_name_and_undo_finds_the_key_again(project: Project) -> None:
    stack, basis = QUndoStack(), project.basis
    hand, motion = basis.hand, basis.motion
    assert hand is not None and motion is not None
    first = inputs_key(basis)
    assert first is not None
    for command, words in (
        (EditShapes(project, hand.id, [Rename("jaw", "chin")]), ("shapes changed",)),
        (SetBasisOptions(project, {"count": 2}), ("options changed",)),
        (SetBasisOptions(project, {"bounds": "free"}), ()),
        (SetAmounts(project, {"brow": 0.5}), ()),
    ):
        stack.push(command)
        key = inputs_key(basis)
        assert key is not None and changes(first, key) == words, words
        stack.undo()
        assert inputs_key(basis) == first
    assert changes(first, replace(first, motion="x", driver="y")) == ("performance changed", "driving rig changed")


def test_large_motion_is_linked_found_again_where_the_project_went_and_asked_for_where_it_is_gone(
    files: tuple[Path, Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(loading, "LARGEST_EMBEDDED", 1000)
    project = Project()
    for command in opening(project, *files[:2]):
        command.redo()
    item = project.basis.motion
    assert item is not None and item.link is not None
    path = store.save(project, tmp_path / "linked.qface")
    assert path.stat().st_size < files[1].stat().st_size, "the motion is not in it"

    moved = tmp_path / "elsewhere"
    moved.mkdir()
    shutil.move(path, moved / "linked.qface")
    shutil.move(files[1], moved / "take.npz")
    again = store.load(moved / "linked.qface")
    found = again.basis.motion
    assert found is not None and found.link is not None and found.link.path == moved / "take.npz"
    assert needs(again.basis) == "", "it is read when it is needed"
    prepared = prepare_motion(Ingredients.of(again.basis))
    assert len(prepared.motion) == FRAMES
    np.testing.assert_array_equal(prepared.motion.frame(7), Ingredients.of(project.basis).data.vertices[7])

    os.utime(moved / "take.npz", ns=(1, 1))
    assert found.link.state() == "there", "touching changes nothing"
    data = bytearray((moved / "take.npz").read_bytes())
    data[len(data) // 2] ^= 1
    (moved / "take.npz").write_bytes(data)
    assert found.link.state() == "changed"
    assert "has changed since it was linked: choose the file again" in needs(again.basis)
    with pytest.raises(InputError, match="has changed"):
        read_linked(found)
    (moved / "take.npz").unlink()
    assert "take.npz is not where it was: choose the file again" in needs(again.basis)
    lost = store.load(moved / "linked.qface")
    assert lost.basis.motion is not None and inputs_key(lost.basis) is None


def test_a_crash_loses_no_rig_no_edit_and_no_performance(project: Project, tmp_path: Path) -> None:
    hand = project.basis.hand
    assert hand is not None
    EditShapes(project, hand.id, [Rename("jaw", "chin")]).redo()
    files = RecoveryFiles.of(tmp_path, "lost")
    files.folder.mkdir()
    write_journal(journal_of(project, 1.0, 1), files.journal)
    for _path, write in pieces_of(project, files):
        write()
    found = recover(files)
    assert found.lost == () and everything(found.project.basis) == everything(project.basis)

    # Pieces gone: from the files they came from; those gone too: the places stay, and what is lost is said.
    for path in (*files.pieces("rig"), *files.pieces("motion")):
        path.unlink()
    assert recover(files).lost == () and recover(files).project.basis.rig(hand) is not None
    (tmp_path / "take.npz").unlink()
    found = recover(files)
    assert found.lost == ("the motion of take, whose place is kept",)
    assert everything(found.project.basis) == everything(project.basis)
    assert needs(found.project.basis) == "the data of take are lost: choose its file again"

    # Journal gone: the items as they were when they were added.
    for _path, write in pieces_of(project, files):
        write()
    files.journal.write_text("{")
    found = recover(files)
    assert [item.name for item in found.project.basis.rigs] == ["artist"] and len(found.lost) == 1


def test_of_a_damaged_file_the_rest_is_saved(project: Project, tmp_path: Path) -> None:
    path = store.save(project, tmp_path / "a.qface")
    whole = path.read_bytes()
    (tmp_path / "take.npz").unlink()
    part = Ingredients.of(project.basis).data.vertices[20].tobytes()[:64]
    assert whole.count(part) == 1
    path.write_bytes(whole.replace(part, bytes([part[0] ^ 1]) + part[1:]))
    with pytest.raises(InputError, match="performance 'take'"):
        store.load(path)
    found = salvage(path)
    assert (found.more_whole, found.more) == (1, 2)
    assert found.summary.startswith("1 of 2 rigs and performances are whole; lost: the motion of take")
    np.testing.assert_array_equal(
        found.project.basis.rig(found.project.basis.hand).basis.displacements, hand_rig().basis.displacements
    )

    # What was saved of it opens again, and still asks for what is gone.
    again = store.load(store.save(found.project, tmp_path / "saved.qface"))
    assert everything(again.basis) == everything(found.project.basis)
    assert needs(again.basis) == "the data of take are lost: choose its file again"


def test_edits_of_a_rig_are_those_of_the_engine(project: Project) -> None:
    hand = project.basis.hand
    assert hand is not None
    edits = (Mirror("smile_L", "smile_R", replace=True), Rename("jaw", "chin"))
    EditShapes(project, hand.id, edits).redo()
    made = project.basis.rig(project.basis.rigs[hand.id])
    truth = apply_edits(hand_rig(), edits)
    assert made is not None and made.basis.names == truth.basis.names
    np.testing.assert_array_equal(made.basis.displacements, truth.basis.displacements)


def test_amounts_go_along_with_names_and_are_no_one_elses(project: Project) -> None:
    basis, stack = project.basis, QUndoStack()
    hand = basis.hand
    assert hand is not None
    SetAmounts(project, {"brow": 0.0, "jaw": 0.4, "smile_R": 0.2}).redo()
    before = dict(basis.setup.amounts)
    stack.push(EditShapes(project, hand.id, [Remove(("brow",)), Rename("pucker", "brow")]))
    assert basis.setup.amount("brow") == 1.0, "another shape of that name"
    stack.push(EditShapes(project, hand.id, [Split("jaw", "jaw_L", "jaw_R"), Mirror("smile_L", "smile_R", True)]))
    assert dict(basis.setup.amounts) == {"jaw_L": 0.4, "jaw_R": 0.4}
    stack.push(EditShapes(project, hand.id, [Duplicate("jaw_L", "jaw")]))
    assert dict(basis.setup.amounts) == {"jaw_L": 0.4, "jaw_R": 0.4}
    while stack.canUndo():
        stack.undo()
    assert dict(basis.setup.amounts) == before


def test_a_training_range_does_not_outlive_its_performance(project: Project, tmp_path: Path) -> None:
    basis, stack = project.basis, QUndoStack()
    np.savez(tmp_path / "short.npz", vertices=take()[:15], fps=24.0, unit=np.array("mm"))
    short = load_motion(tmp_path / "short.npz")
    AddMotion(project, short.item, short.data).redo()
    for train, left in (((2, 9), (2, 9)), ((20, 50), None)):
        SetBasisOptions(project, {"train": train}).redo()
        stack.push(ChooseInput(project, "motion", short.item.id))
        assert basis.setup.options.train == left and basis.setup.motion == short.item.id
        stack.undo()
        assert basis.setup.options.train == train and basis.setup.motion != short.item.id
