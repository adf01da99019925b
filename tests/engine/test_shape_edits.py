"""Edits of shapes: exact halves, planted mirrors, deterministic, and refusals that name the shape."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from engine.errors import InputError
from engine.mesh import TriangleMesh
from engine.mirror_map import mirror_map, mirrored
from engine.shape_edits import (
    Combine,
    Duplicate,
    Mirror,
    Remove,
    Rename,
    Reorder,
    Split,
    apply_edits,
    edit_from_json,
    edit_to_json,
)
from engine.shape_proposals import proposed_edits, rename_edits
from engine.shape_table import halved, left_share
from engine.shapes import ExpressionBasis, Rig
from tests.engine.mirror_samples import half_face

EDITS = (
    Rename("smile_L", "grin_L"),
    Reorder(("open", "grin_L", "smile_R")),
    Duplicate("open", "wide"),
    Mirror("grin_L", "smile_R", replace=True),
    Mirror("open", "open"),
    Split("open", "open_L", "open_R", 12.5),
    Combine((("wide", 0.5), ("grin_L", -2.0)), "both", keep=True),
    Combine((("wide", 1.0),), "wide", keep=False),
    Remove(("smile_R",)),
)


def rig(mean: bool = False) -> Rig:
    face = half_face()
    rng = np.random.default_rng(3)
    shapes = rng.normal(size=(3, len(face.mesh.vertices), 3))
    offset = rng.normal(size=shapes[0].shape) if mean else None
    basis = ExpressionBasis(face.mesh.vertices, ("smile_L", "smile_R", "open"), shapes, offset)
    return Rig(face.mesh, basis)


def test_edits_do_what_they_say_one_after_the_other() -> None:
    before = rig()
    after = apply_edits(before, EDITS).basis
    assert after.names == ("open_L", "open_R", "wide", "grin_L", "both")
    smile, opened = before.basis.shape("smile_L"), before.basis.shape("open")
    flipped = mirrored(opened, mirror_map(before.mesh))
    np.testing.assert_array_equal(after.shape("grin_L"), smile)
    np.testing.assert_array_equal(after.shape("wide"), opened)
    np.testing.assert_array_equal(after.shape("open_L") + after.shape("open_R"), flipped)
    np.testing.assert_allclose(after.shape("both"), 0.5 * opened - 2 * smile, rtol=1e-14)


@pytest.mark.parametrize("mean", [False, True])
def test_the_same_edits_give_the_same_bits_and_leave_the_rig_alone(mean: bool) -> None:
    before = rig(mean)
    kept = before.basis.displacements.copy()
    one, two = apply_edits(before, EDITS), apply_edits(rig(mean), EDITS, mirror_map(before.mesh))
    assert one.basis.names == two.basis.names
    assert one.basis.displacements.tobytes() == two.basis.displacements.tobytes()
    assert (one.basis.mean is None) != mean and not one.basis.displacements.flags.writeable
    np.testing.assert_array_equal(before.basis.displacements, kept)
    assert apply_edits(before, ()) is before


@pytest.mark.parametrize("edit", EDITS)
def test_edits_are_values_that_json_can_hold(edit: object) -> None:
    text = json.dumps(edit_to_json(edit))
    again = edit_from_json(json.loads(text))
    assert again == edit and hash(again) == hash(edit) and type(again) is type(edit)


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"kind": "bend", "name": "a"}, "'bend'"),
        ({"name": "a", "to": "b"}, "kind"),
        ({"kind": "rename", "name": "a"}, "to"),
        ({"kind": "rename", "name": "a", "to": " "}, "to"),
        ({"kind": "rename", "name": "a", "to": "b", "more": 1}, "more"),
        ({"kind": "split", "name": "a", "left": "l", "right": "r", "border_mm": -1}, "border_mm"),
        ({"kind": "combine", "terms": [["a", float("nan")]], "to": "c"}, "terms.0.1"),
        ({"kind": "remove", "names": []}, "names"),
    ],
)
def test_values_that_are_no_edit_name_the_field(values: dict, word: str) -> None:
    with pytest.raises(InputError) as told:
        edit_from_json(values)
    assert word in str(told.value) and "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (Rename("nose", "x"), ("'nose'", "not in the rig", "smile_L")),
        (Rename("open", "smile_L"), ("'smile_L'", "already")),
        (Rename("open", " "), ("cannot be called so",)),
        (Rename("open", "x" * 300), ("cannot be called so",)),
        (Reorder(("open", "smile_L")), ("'smile_R'", "not in the new order")),
        (Reorder(("open", "smile_L", "smile_R", "open")), ("'open'", "twice")),
        (Remove(("open", "smile_L", "smile_R")), ("all there are",)),
        (Remove(("nose",)), ("'nose'",)),
        (Duplicate("open", "open"), ("'open'", "already")),
        (Mirror("smile_L", "smile_R"), ("'smile_R'", "already")),
        (Split("open", "a", "a"), ("'a'", "both halves")),
        (Split("open", "smile_L", "b"), ("'smile_L'", "already")),
        (Combine((("open", 1.0), ("nose", 1.0)), "x"), ("'nose'",)),
        (Combine((("open", 1.0),), "open"), ("'open'", "already")),
        (Combine((("open", float("nan")),), "x"), ("shape x", "not finite")),
    ],
)
def test_what_cannot_be_done_names_the_shape(edit: object, words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as told:
        apply_edits(rig(), (edit,))
    assert all(word in str(told.value) for word in words), told.value


def test_names_and_places_after_each_kind() -> None:
    def names(*edits: object) -> tuple[str, ...]:
        return apply_edits(rig(), edits).basis.names

    assert names(Rename("smile_R", "x")) == ("smile_L", "x", "open")
    assert names(Duplicate("smile_L", "x")) == ("smile_L", "x", "smile_R", "open")
    assert names(Mirror("smile_L", "x")) == ("smile_L", "x", "smile_R", "open")
    assert names(Mirror("smile_L", "smile_R", True)) == ("smile_L", "smile_R", "open")
    assert names(Split("smile_L", "a", "b")) == ("a", "b", "smile_R", "open")
    assert names(Split("smile_L", "a", "b", keep=True)) == ("smile_L", "a", "b", "smile_R", "open")
    assert names(Split("smile_L", "smile_L", "b")) == ("smile_L", "b", "smile_R", "open")
    both = (("smile_L", 1.0), ("smile_R", 1.0))
    assert names(Combine(both, "x")) == ("smile_L", "smile_R", "x", "open")
    assert names(Combine(both, "smile_L", keep=False)) == ("smile_L", "open")
    assert names(Combine(both, "x", keep=False)) == ("x", "open")


NUMBERS = st.floats(-1e3, 1e3) | st.floats(-1e-300, 1e-300) | st.just(0.0)


@settings(max_examples=60, deadline=None)
@given(arrays.arrays(float, (7, 3), elements=NUMBERS), arrays.arrays(float, 7, elements=st.floats(0, 1)))
def test_halves_add_up_to_the_whole_to_the_last_bit(shape: np.ndarray, share: np.ndarray) -> None:
    first, second = halved(shape, share)
    np.testing.assert_array_equal(first + second, shape)
    np.testing.assert_allclose(first, share[:, None] * shape, rtol=1e-12, atol=1e-13 * np.abs(shape).max())


def test_the_left_half_is_the_subjects_and_fades_over_its_border() -> None:
    x = np.array([-50, -10, -5, 0, 5, 10, 50.0])
    share = left_share(x, 20.0)
    assert share.tolist() == [0, 0, 0.15625, 0.5, 0.84375, 1, 1]
    np.testing.assert_array_equal(left_share(x, 0.0), [0, 0, 0, 0.5, 1, 1, 1])
    split = apply_edits(rig(), (Split("open", "l", "r", 20.0),)).basis
    away = rig().mesh.vertices[:, 0]
    assert not split.shape("l")[away < -10.001].any() and not split.shape("r")[away > 10.001].any()
    np.testing.assert_array_equal(split.shape("l")[away > 10.001], rig().basis.shape("open")[away > 10.001])


def test_a_shape_mirrored_twice_is_itself_and_a_mirrored_half_is_the_other_half() -> None:
    before = rig()
    twice = apply_edits(before, (Mirror("open", "open"), Mirror("open", "open")))
    np.testing.assert_array_equal(twice.basis.displacements, before.basis.displacements)
    pairs = mirror_map(before.mesh)
    even = before.basis.shape("open") + mirrored(before.basis.shape("open"), pairs)
    start = before.with_basis(ExpressionBasis(before.basis.neutral, ("even",), even[None]))
    split = apply_edits(start, (Split("even", "l", "r", 30.0), Mirror("l", "other")))
    np.testing.assert_allclose(split.basis.shape("other"), split.basis.shape("r"), rtol=0, atol=1e-12)


def test_what_a_click_asks_for_gets_names_that_are_free() -> None:
    names = ("smile_L", "smile_R", "open", "open_L")
    assert proposed_edits("mirror", ("smile_L",), names) == (Mirror("smile_L", "smile_R", True),)
    assert proposed_edits("mirror", ("open_L",), names) == (Mirror("open_L", "open_R", False),)
    assert proposed_edits("mirror", ("open",), names) == (Mirror("open", "open mirrored", False),)
    assert proposed_edits("split", ("open",), names) == (Split("open", "open_L 2", "open_R"),)
    assert proposed_edits("combine", ("smile_L", "smile_R"), names)[0].to == "smile"
    assert proposed_edits("combine", ("open", "smile_R"), names)[0].to == "open + smile_R"
    assert [e.to for e in proposed_edits("duplicate", ("open", "smile_L"), names)] == ["open copy", "smile_L copy"]
    assert proposed_edits("remove", ("open", "smile_L"), names) == (Remove(("open", "smile_L")),)
    for kind, marked, word in (
        ("combine", ("open",), "is only one"),
        ("split", ("smile_L",), "'smile_R'"),
        ("mirror", (), "none is marked"),
        ("bend", ("open",), "'bend'"),
    ):
        with pytest.raises(InputError, match=word):
            proposed_edits(kind, marked, names)
    swapped = rename_edits({"smile_L": "smile_R", "smile_R": "smile_L", "open": "open"}, names)
    after = apply_edits(rig(), swapped).basis
    assert after.names == ("smile_R", "smile_L", "open")
    np.testing.assert_array_equal(after.shape("smile_R"), rig().basis.shape("smile_L"))


def test_edits_know_nothing_of_a_mesh_without_a_middle() -> None:
    mesh = TriangleMesh(np.eye(3) * 100, np.zeros((0, 3), dtype=int))
    bare = Rig(mesh, ExpressionBasis(mesh.vertices, ("a",), np.ones((1, 3, 3))))
    with pytest.raises(InputError, match="no faces"):
        apply_edits(bare, (Mirror("a", "b"),))
