"""A basis evaluates as the paper writes it, refuses what does not fit, and cannot be changed from outside."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.mesh import TriangleMesh
from engine.shapes import ExpressionBasis, Rig, check_topology

RANDOM = np.random.default_rng(0)
NEUTRAL = RANDOM.normal(size=(6, 3))
SHAPES = RANDOM.normal(size=(3, 6, 3))
NAMES = ("jawOpen", "smile_L", "smile_R")
FACES = np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4]])


@settings(deadline=None)
@given(st.lists(st.floats(-10, 10), min_size=3, max_size=3), st.booleans())
def test_the_face_is_the_neutral_and_the_weighted_sum_of_displacements(weights: list[float], affine: bool) -> None:
    mean = RANDOM.normal(size=(6, 3)) if affine else None
    basis = ExpressionBasis(NEUTRAL, NAMES, SHAPES, mean)
    wanted = NEUTRAL + (mean if mean is not None else 0) + sum(w * e for w, e in zip(weights, SHAPES, strict=True))
    np.testing.assert_allclose(basis.evaluate(weights), wanted, atol=1e-12)
    np.testing.assert_allclose(basis.evaluate([weights, [0, 0, 0]])[0], wanted, atol=1e-12)


def test_many_frames_are_evaluated_at_once_in_their_own_arrangement() -> None:
    basis = ExpressionBasis(NEUTRAL, NAMES, SHAPES)
    weights = RANDOM.normal(size=(4, 2, 3))
    assert basis.evaluate(weights).shape == (4, 2, 6, 3)
    np.testing.assert_allclose(basis.evaluate(weights)[3, 1], basis.evaluate(weights[3, 1]), atol=1e-12)
    assert basis.evaluate(np.zeros((0, 3))).shape == (0, 6, 3)


def test_what_made_it_can_change_without_changing_it() -> None:
    neutral, shapes = NEUTRAL.copy(), SHAPES.copy()
    basis = ExpressionBasis(neutral, NAMES, shapes)
    neutral += 1
    shapes += 1
    np.testing.assert_array_equal(basis.neutral, NEUTRAL)
    np.testing.assert_array_equal(basis.shape("smile_L"), SHAPES[1])
    with pytest.raises(ValueError, match="read-only"):
        basis.shape("smile_L")[0, 0] = 1.0


WRONG: list[tuple[Callable[[], Any], str]] = [
    (lambda: ExpressionBasis(NEUTRAL[:, :2], NAMES, SHAPES), r"neutral: has shape \(6, 2\)"),
    (lambda: ExpressionBasis(NEUTRAL, NAMES, SHAPES[:, :5]), "have shape .3, 5, 3. for a neutral face of 6 vertices"),
    (lambda: ExpressionBasis(NEUTRAL, (), SHAPES[:0]), "basis: has no shapes; give at least one"),
    (lambda: ExpressionBasis(NEUTRAL, NAMES[:2], SHAPES), "names: are 2 for 3 shapes"),
    (lambda: ExpressionBasis(NEUTRAL, ("a", "b", "a"), SHAPES), "names: a stands for several shapes"),
    (lambda: ExpressionBasis(NEUTRAL, ("a", " ", "c"), SHAPES), "names: shape 2 has none"),
    (lambda: ExpressionBasis(NEUTRAL * np.nan, NAMES, SHAPES), "neutral: holds positions that are not finite"),
    (lambda: ExpressionBasis(NEUTRAL, NAMES, SHAPES / [[[1]], [[0]], [[1]]]), "shape smile_L: holds numbers that are"),
    (lambda: ExpressionBasis(NEUTRAL, NAMES, SHAPES, NEUTRAL[:5]), r"mean: has shape \(5, 3\)"),
    (lambda: ExpressionBasis(NEUTRAL, NAMES, SHAPES, NEUTRAL * np.inf), "mean: has shape .6, 3. or numbers that are"),
    (lambda: ExpressionBasis(NEUTRAL, NAMES, SHAPES).evaluate([1.0]), "weights: have shape .1,.; give one for each"),
    (lambda: ExpressionBasis(NEUTRAL, NAMES, SHAPES).shape("frown"), "shape 'frown': is not in the basis; it has jaw"),
    (
        lambda: Rig(TriangleMesh(NEUTRAL[:5], FACES), ExpressionBasis(NEUTRAL, NAMES, SHAPES)),
        "basis: has 6 vertices, its mesh 5; use shapes of the same topology",
    ),
    (lambda: check_topology("b.obj", 7, 6, "neutral.obj"), "b.obj: has 7 vertices, neutral.obj has 6; both must be"),
]


@pytest.mark.parametrize("make, message", WRONG)
def test_what_does_not_fit_is_said_in_one_line(make: Callable[[], Any], message: str) -> None:
    with np.errstate(all="ignore"), pytest.raises(InputError, match=message) as refused:
        make()
    assert "\n" not in str(refused.value)


def test_errors_are_measured_on_the_skin_where_there_is_one() -> None:
    basis = ExpressionBasis(NEUTRAL, NAMES, SHAPES)
    parts = {"skin": np.array([1]), "teeth": np.array([0, 2])}
    rig = Rig(TriangleMesh(NEUTRAL, FACES, parts=parts), basis)
    assert rig.skin.tolist() == [1, 2, 3] and rig.skin_name == "skin"
    whole = Rig(TriangleMesh(NEUTRAL, FACES), basis)
    # Vertex 5 is of no face: nothing shows it.
    assert whole.skin.tolist() == [0, 1, 2, 3, 4] and whole.skin_name == "all vertices"


def test_another_basis_takes_its_neutral_face_along() -> None:
    rig = Rig(TriangleMesh(NEUTRAL, FACES), ExpressionBasis(NEUTRAL, NAMES, SHAPES))
    other = rig.with_basis(ExpressionBasis(NEUTRAL + 1, ("a",), SHAPES[:1]))
    np.testing.assert_array_equal(other.mesh.vertices, NEUTRAL + 1)
    assert other.mesh.faces is rig.mesh.faces or np.array_equal(other.mesh.faces, rig.mesh.faces)
