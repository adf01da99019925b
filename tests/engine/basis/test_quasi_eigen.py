"""Projection as in equations 3 and 4, and what it says about shapes that it cannot use."""

from __future__ import annotations

import numpy as np
import pytest

from engine.basis.principal import principal_basis
from engine.basis.quasi_eigen import augment, blend, project
from engine.basis.weights import solve_weights
from engine.errors import InputError
from engine.shapes import ExpressionBasis
from tests.engine.basis.answers import SKIN, flat, likely_hand, random_hand, shares, true_errors
from tests.engine.basis.motions import FORMS, dense, driven, factored


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("affine", [False, True], ids=["linear", "affine"])
def test_equations_3_and_4(form, affine):
    motion = FORMS[form]()
    principal, hand = principal_basis(motion, count=4, vertices=SKIN), likely_hand(motion, 7)
    found = project(hand, principal, affine)
    axes, mean = flat(principal.axes, SKIN), flat(principal.mean, SKIN)
    w = np.array([[axis @ (shape - mean) for axis in axes] for shape in flat(hand.displacements, SKIN)])
    faces = principal.mean + np.tensordot(w, principal.axes, axes=1)
    np.testing.assert_allclose(found.projection, w, atol=1e-10)
    shown = found.basis.displacements + (found.basis.mean if affine else 0)
    np.testing.assert_allclose(shown, faces, atol=1e-10)
    assert (found.basis.mean is not None) == affine and found.basis.names == hand.names
    before, after = flat(hand.displacements, SKIN), flat(faces, SKIN)
    apart, size = np.linalg.norm(before - after, axis=1), np.linalg.norm(before, axis=1)
    np.testing.assert_allclose(found.residual_mm, apart / np.sqrt(len(SKIN)), rtol=1e-10)
    np.testing.assert_allclose(found.residual_fraction, apart / size, rtol=1e-10)
    cosine = np.sum(before * after, axis=1) / size / np.linalg.norm(after, axis=1)
    np.testing.assert_allclose(found.cosine, cosine, atol=1e-12)
    np.testing.assert_allclose(found.singular_values, np.linalg.svd(w / shares(principal))[1], rtol=1e-9)
    assert found.rank == 4 and found.missing == ()


def test_the_projection_is_the_nearest_point_of_the_performance_space():
    motion = factored()
    principal, hand = principal_basis(motion, count=5), random_hand(motion, 3)
    found = project(hand, principal)
    left = flat(hand.displacements - found.basis.displacements)
    np.testing.assert_allclose(left @ flat(principal.axes).T, 0, atol=1e-9)


def test_faces_of_the_performance_are_left_as_they_are():
    motion = factored(markers=4)
    principal = principal_basis(motion, count=12)
    hand = ExpressionBasis(motion.neutral, ["a", "b", "c"], motion.displacements(5, 8))
    found = project(hand, principal)
    np.testing.assert_allclose(found.basis.displacements, hand.displacements, atol=1e-9)
    np.testing.assert_allclose(found.cosine, 1, atol=1e-12)
    assert found.residual_mm.max() < 1e-9


@pytest.mark.parametrize("affine", [False, True], ids=["linear", "affine"])
@pytest.mark.parametrize("shapes", [2, 5, 6, 9])
@pytest.mark.parametrize("form", ["factored", "driven", "dense"])
def test_span_coverage_is_what_free_weights_reproduce(form, affine, shapes):
    motion = FORMS[form]()
    principal = principal_basis(motion, count=5, vertices=SKIN)
    quasi = project(likely_hand(motion, shapes), principal, affine)
    weights = solve_weights(quasi.basis, motion, vertices=SKIN)
    left = np.sum(flat(true_errors(motion, quasi.basis, weights), SKIN) ** 2) / len(motion)
    # Free weights of a linear basis may catch a little that no axis holds: the mean's own direction.
    wanted = 1 - left / principal.total_variance
    mean = flat(principal.mean, SKIN)
    beside = mean - mean @ flat(principal.axes, SKIN).T @ flat(principal.axes, SKIN)
    moved = flat(motion.displacements(0, len(motion)), SKIN) - mean
    caught = 0.0 if affine else np.mean((moved @ beside) ** 2) / max(beside @ beside, 1e-300) / principal.total_variance
    assert wanted - caught - 1e-9 <= quasi.span_coverage <= max(wanted, 0) + 1e-9


def test_a_shape_given_twice_loses_rank_though_no_axis_is_missing():
    motion = factored()
    hand, principal = likely_hand(motion, 5), principal_basis(motion, count=5)
    assert project(hand, principal).rank == 5
    shapes = np.concatenate([hand.displacements[:4], hand.displacements[:1]])
    twice = ExpressionBasis(motion.neutral, ["a", "b", "c", "d", "again"], shapes)
    found = project(twice, principal, affine=True)
    assert found.rank == 4 and found.missing == () and found.span_coverage < principal.coverage - 1e-6
    assert found.singular_values[-1] < 1e-12 * found.singular_values[0]
    told = " ".join(found.warnings)
    assert "again is the same shape as a" in told and "rank 4 of 5" in told


def test_an_axis_that_nobody_touches_is_found_and_added():
    motion = factored()
    principal = principal_basis(motion, count=4)
    place = np.array([[1.0, 0.3, 0, -1], [0.2, -1, 0, 0.5], [0.4, 0.1, 0, 1], [-1, 1, 0, 0.3]]) * 5
    hand = ExpressionBasis(motion.neutral, list("abcd"), principal.mean + np.tensordot(place, principal.axes, axes=1))
    found = project(hand, principal, affine=True)
    assert found.missing == (2,) and found.rank == 3 and "axis 3" in " ".join(found.warnings)
    more = augment(hand, principal, found.missing)
    assert more.names[-1] == "axis 3" and len(more) == 5
    again = project(more, principal, affine=True)
    assert again.missing == () and again.rank == 4
    assert abs(again.span_coverage - principal.coverage) < 1e-12
    np.testing.assert_allclose(again.projection[-1], [0, 0, 2 * shares(principal)[2], 0], atol=1e-9)
    assert again.cosine[-1] > 1 - 1e-12
    named = augment(augment(hand, principal, [0]), principal, [0])
    assert named.names[-2:] == ("axis 1", "axis 1 (2)")
    assert augment(hand, principal, []) is hand
    for axes in ([4], [-1], [1, 1]):
        with pytest.raises(InputError, match="axes"):
            augment(hand, principal, axes)


def test_warnings_in_plain_words():
    motion = factored()
    principal = principal_basis(motion, count=6)
    shapes = random_hand(motion, 3).displacements.copy()
    shapes[1] = 0
    hand = ExpressionBasis(motion.neutral + np.array([0.0, 1.0, 0.0]), ["odd", "still", "other"], shapes)
    found = project(hand, principal)
    told = " ".join(found.warnings)
    assert (
        np.isnan(found.cosine[1]) and np.isnan(found.residual_fraction[1]) and np.isfinite(found.cosine[[0, 2]]).all()
    )
    assert "A shape does not move the measured part of the face: still." in told
    assert "2 of 3 shapes no longer look like themselves" in told
    assert "3 shapes cannot span 6 axes and the mean: sculpt at least 4 more" in told
    assert "1.00 mm RMS apart" in told
    assert "sculpt at least 3 more" in " ".join(project(hand, principal, affine=True).warnings)
    close = ExpressionBasis(motion.neutral, tuple("abcdefg"), motion.displacements(0, 7))
    assert project(close, principal_basis(motion, count=6)).warnings == ()


def test_shapes_off_the_metric_move_as_the_performance_does():
    motion = factored()
    principal = principal_basis(motion, count=20, vertices=SKIN)
    seen = ExpressionBasis(motion.neutral, ["a", "b"], motion.displacements(3, 5))
    hand = seen.displacements.copy()
    hand[:, 90:] = 0
    found = project(ExpressionBasis(motion.neutral, ["a", "b"], hand), principal)
    off = np.linalg.norm(found.basis.displacements[:, 90:] - seen.displacements[:, 90:])
    assert off < 0.2 * np.linalg.norm(seen.displacements[:, 90:])


@pytest.mark.parametrize("affine", [False, True], ids=["linear", "affine"])
def test_blending_leads_from_hand_to_quasi_eigen(affine):
    motion = driven()
    hand, principal = likely_hand(motion, 4), principal_basis(motion, count=3)
    quasi = project(hand, principal, affine).basis
    np.testing.assert_array_equal(blend(hand, quasi, np.zeros(4)).displacements, hand.displacements)
    full = blend(hand, quasi, np.ones(4))
    np.testing.assert_allclose(full.displacements, quasi.displacements, atol=1e-12)
    assert (full.mean is None) == (not affine)
    part = blend(hand, quasi, [0.25, 0, 1, 0.5])
    shown = [basis.displacements + (0 if basis.mean is None else basis.mean) for basis in (part, hand, quasi)]
    np.testing.assert_allclose(shown[0][0], 0.75 * shown[1][0] + 0.25 * shown[2][0], atol=1e-12)
    np.testing.assert_allclose(shown[0][1], shown[1][1], atol=1e-12)
    for amounts in ([0.5] * 3, [0, 0, 0, 1.1], [0, 0, 0, np.nan], [-0.1, 0, 0, 0]):
        with pytest.raises(InputError, match="amounts"):
            blend(hand, quasi, amounts)
    with pytest.raises(InputError, match="other shapes"):
        blend(hand, ExpressionBasis(hand.neutral, list("abcd"), quasi.displacements), np.ones(4))


def test_an_affine_hand_basis_counts_from_the_neutral_face():
    motion = factored()
    hand, principal = likely_hand(motion, 4), principal_basis(motion, count=3)
    mean = hand.displacements.mean(axis=0)
    about = ExpressionBasis(hand.neutral, hand.names, hand.displacements - mean, mean)
    np.testing.assert_allclose(project(about, principal).projection, project(hand, principal).projection, atol=1e-10)


def test_another_topology_is_told_with_both_counts():
    with pytest.raises(InputError, match=r"90 vertices.*120"):
        project(random_hand(factored(vertices=90), 2), principal_basis(dense(factored()), count=2))
