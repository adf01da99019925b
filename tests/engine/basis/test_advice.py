"""Advice finds what was planted: the motion no shape has, the frames that show it, the shapes that drift."""

from __future__ import annotations

import numpy as np
import pytest

from engine.basis.advice import advise, keep_amount
from engine.basis.muscles import ELEMENTS, muscle_checklist
from engine.basis.principal import principal_basis
from engine.basis.project_checks import LOOKS_LIKE_ITSELF
from engine.basis.quasi_eigen import blend, project
from engine.basis.weights import solve_weights
from engine.errors import InputError
from engine.motion import MeshMotion
from engine.shapes import ExpressionBasis
from tests.engine.basis.answers import SKIN, likely_hand, random_hand
from tests.engine.basis.motions import dense, driven, factored


def planted() -> tuple[MeshMotion, ExpressionBasis, np.ndarray]:
    """Return a face whose left lower corner moves in frames 100 and 200, and a basis without that motion."""
    random = np.random.default_rng(0)
    neutral = random.uniform(-80, 80, (300, 3))
    shapes = random.normal(size=(5, 300, 3))
    corner = np.exp(-np.sum((neutral[:, :2] - [60, -60]) ** 2, axis=1) / 900)[:, None] * [4.0, 2.0, 0.0]
    shapes[4] = corner
    weights = random.uniform(0, 1, (300, 5))
    weights[:, 4] = 0
    weights[100, 4], weights[200, 4] = 1.0, 0.8
    rig = ExpressionBasis(neutral, list("abcde"), shapes)
    return MeshMotion.driven(rig, weights, 60.0), ExpressionBasis(neutral, list("abcd"), shapes[:4]), corner


@pytest.mark.parametrize("form", ["driven", "dense"])
def test_the_motion_that_no_shape_has_is_found(form):
    motion, hand, corner = planted()
    if form == "dense":
        motion = dense(motion)
    quasi = project(hand, principal_basis(motion, count=5))
    weights = solve_weights(quasi.basis, motion, vertices=np.arange(20, 300))
    found = advise(hand, quasi, motion, weights, vertices=np.arange(20, 300), count=2)
    first = found.uncovered[0]
    assert first.region == "lower left" and set(first.frames[:2]) == {100, 200} and first.frames[0] == 100
    assert first.share > 0.8
    cosine = np.sum(first.direction * corner) / np.linalg.norm(first.direction) / np.linalg.norm(corner)
    assert cosine > 0.95, "the direction is the missing motion, and its sign that of the frame that shows it"
    assert np.linalg.norm(corner[first.vertices], axis=1).min() > 0.4 * np.linalg.norm(corner, axis=1).max()
    assert first.vertices.min() >= 20
    assert "lower left" in found.sentences[0] and "frame 101, 201" in found.sentences[0]


def test_nothing_is_left_to_sculpt_where_nothing_is_lost():
    motion = planted()[0]
    rig = motion.basis
    quasi = project(rig, principal_basis(motion, count=5), affine=True)
    found = advise(rig, quasi, motion, solve_weights(quasi.basis, motion))
    assert found.uncovered == ()


def test_shares_of_all_directions_are_at_most_one_and_descend():
    motion = factored()
    hand = likely_hand(motion, 3)
    quasi = project(hand, principal_basis(motion, count=3, vertices=SKIN))
    weights = solve_weights(quasi.basis, motion, (0, 1), vertices=SKIN)
    found = advise(hand, quasi, motion, weights, vertices=SKIN, count=6)
    shares = [axis.share for axis in found.uncovered]
    assert len(shares) == 6 and shares == sorted(shares, reverse=True) and 0.5 < sum(shares) <= 1 + 1e-9
    for axis in found.uncovered:
        assert np.abs([cosine for _, cosine in axis.nearest]).max() <= 1 and len(axis.nearest) == 3


def test_the_amount_that_keeps_a_shape_recognisable():
    motion = driven()
    principal = principal_basis(motion, count=3)
    hand = random_hand(motion, 6)
    quasi = project(hand, principal)
    found = advise(hand, quasi, motion, solve_weights(quasi.basis, motion))
    assert [drift.name for drift in found.drifting] == [hand.names[i] for i in np.argsort(quasi.cosine)]
    amounts = np.array([next(d.amount for d in found.drifting if d.name == name) for name in hand.names])
    assert ((amounts > 0) & (amounts < 1)).all()
    shown = blend(hand, quasi.basis, amounts).displacements
    for before, after in zip(hand.displacements, shown, strict=True):
        cosine = np.sum(before * after) / np.linalg.norm(before) / np.linalg.norm(after)
        assert cosine == pytest.approx(LOOKS_LIKE_ITSELF, abs=1e-9)


def test_shapes_that_stay_themselves_may_go_all_the_way():
    hand = np.array([3.0, 0, 0])
    assert keep_amount(hand, np.array([2.0, 0.5, 0])) == 1 and keep_amount(hand, hand) == 1
    assert keep_amount(np.zeros(3), hand) == 1
    opposite = keep_amount(hand, -hand)
    assert 0 < opposite <= 1 / 2 + 1e-12


def test_weights_must_be_those_of_the_basis():
    motion, hand, _ = planted()
    with pytest.raises(InputError, match="weights"):
        advise(hand, project(hand, principal_basis(motion, count=3)), motion, np.zeros((300, 5)))


def test_the_checklist_has_six_and_twelve_elements():
    regions = [element.region for element in ELEMENTS]
    assert (regions.count("upper"), regions.count("lower")) == (6, 12)
    assert len({element.key for element in ELEMENTS}) == len({element.muscle for element in ELEMENTS}) == 18


@pytest.mark.parametrize(
    ("name", "keys"),
    [
        ("mouthSmile_L", {"smile"}),
        ("Lip_Corner_Puller", {"smile"}),
        ("AU12", {"smile"}),
        ("au_04_left", {"brow_down"}),
        ("browDown_R", {"brow_down"}),
        ("frown brow", {"brow_down"}),
        ("browInnerUp", {"brow_inner_up"}),
        ("eyeBlinkLeft", {"eye_blink"}),
        ("cheekSquint_L", {"eye_squint"}),
        ("mouthFrownLeft", {"corner_down"}),
        ("jawLeft", {"jaw_side"}),
        ("mouthLowerDown_L", {"lower_lip_down"}),
        ("mouthLeft", set()),
        ("eyeLookUpLeft", set()),
        ("Au1 + Au2", {"brow_inner_up", "brow_outer_up"}),
        ("L-Risorius", {"stretch"}),
        ("Zygomaticus major", {"smile"}),
        ("tongueOut", set()),
        ("sadness", set()),
        ("surprised", set()),
    ],
)
def test_names_are_understood(name, keys):
    found = muscle_checklist([name])
    assert {entry.element.key for entry in found if entry.found} == keys


def test_the_arkit_units_fill_the_checklist():
    from engine.shape_name_tables import ARKIT

    assert all(entry.found for entry in muscle_checklist(ARKIT))
