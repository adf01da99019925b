"""Names of shapes and curves that no file could hold are mended while they are read, and what cannot be is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.errors import InputError
from engine.name_text import LONGEST_NAME, clean_names, is_name
from engine.shape_edits import Rename, apply_edits
from engine.shapes import ExpressionBasis, Rig
from studio.basis.commands import AddRig
from studio.basis.loading import load_rig
from studio.project import store
from studio.project.basis_items import RigContent, RigItem
from studio.project.document import Project
from studio.project.recovery import journal_of, read_journal, write_journal
from tests.studio.basis.small import NAMES, hand_rig

LONG = "x" * (LONGEST_NAME + 50)


def named(*names: str) -> Rig:
    rig = hand_rig()
    basis = ExpressionBasis(rig.basis.neutral, (*names, *NAMES[len(names) :]), rig.basis.displacements)
    return Rig(rig.mesh, basis)


def test_names_are_cut_to_the_limit_stay_apart_and_are_counted() -> None:
    assert clean_names(NAMES) == (NAMES, 0)
    names, changed = clean_names((LONG, LONG + "y", "a\udce9", "a\ufffd", "jaw"))
    assert changed == 3 and len(set(names)) == 5 and all(map(is_name, names)) and names[3:] == ("a\ufffd", "jaw")
    assert names[0] == LONG[:LONGEST_NAME]


def test_a_rig_of_long_names_is_read_edited_saved_and_journaled(tmp_path: Path) -> None:
    rig = named(LONG, LONG + "y")
    arrays = {"neutral": rig.basis.neutral, "faces": rig.mesh.faces, "displacements": rig.basis.displacements}
    long = np.array([name.encode() for name in rig.basis.names])
    np.savez(tmp_path / "a.npz", names=long, unit=np.array("mm"), **arrays)
    loaded = load_rig(tmp_path / "a.npz")
    assert any("2 shape names are longer than 256 letters" in remark for remark in loaded.remarks)
    project = Project()
    AddRig(project, loaded.item, loaded.content).redo()
    first = loaded.content.rig.basis.names[0]
    project.basis.rigs.put(replace(loaded.item, edits=(Rename(first, "z" * LONGEST_NAME),)))
    again = store.load(store.save(project, tmp_path / "a.qface"))
    assert again.basis.rig(again.basis.rigs.all[0]).basis.names[0] == "z" * LONGEST_NAME
    write_journal(journal_of(project, 1.0, 1), tmp_path / "journal")
    assert read_journal(tmp_path / "journal").basis.rigs[0].item() == project.basis.rigs.all[0]


@pytest.mark.parametrize("name", ["a\udce9", LONG, " "])
def test_an_edit_refuses_what_no_file_can_hold(name: str) -> None:
    with pytest.raises(InputError, match="cannot be called so"):
        apply_edits(hand_rig(), (Rename("jaw", name),))


def test_a_value_that_no_project_has_is_named_when_it_is_saved_and_the_old_file_stays(tmp_path: Path) -> None:
    path = store.save(Project(), tmp_path / "a.qface")
    before = path.read_bytes()
    content = RigContent(named("a\udce9"))
    project = Project()
    AddRig(project, RigItem("rig-1", "a", content.key), content).redo()
    with pytest.raises(InputError, match=r"names\.0"):
        store.save(project, path)
    assert path.read_bytes() == before
