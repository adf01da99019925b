"""Weights are the optimum: scipy's bounded least squares is the reference, the optimality conditions the proof."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from engine.basis.principal import principal_basis
from engine.basis.quasi_eigen import project
from engine.basis.weights import BOUNDS, check_bounds, solve_reduced, solve_weights
from engine.errors import Cancelled, InputError
from engine.motion import MeshMotion
from engine.shapes import ExpressionBasis
from tests.engine.basis.answers import SKIN, flat, likely_hand, random_hand
from tests.engine.basis.motions import FORMS, factored


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("bounds", [(0.0, 1.0), (-1.0, 2.0), None, (None, 0.3), 0.25], ids=str)
def test_equal_to_the_reference_frame_by_frame(form, bounds):
    motion = FORMS[form]()
    hand = likely_hand(motion, 7)
    basis = ExpressionBasis(hand.neutral, hand.names, hand.displacements, mean=hand.displacements[0] / 3)
    found = solve_weights(basis, motion, bounds, vertices=SKIN)
    low, high = check_bounds(bounds) or (-np.inf, np.inf)
    matrix = flat(basis.displacements, SKIN).T
    for k in range(0, len(motion), 37):
        target = flat(motion.displacements(k, k + 1)[0] - basis.mean, SKIN)
        wanted = lsq_linear(matrix, target, (low, high), method="bvls", max_iter=500, tol=1e-14)
        np.testing.assert_allclose(found[k], wanted.x, atol=1e-6 * (1 + np.abs(wanted.x).max()))
        ours = np.sum((matrix @ found[k] - target) ** 2)
        assert ours <= 2 * wanted.cost * (1 + 1e-6) + 1e-12 * (target @ target)


@pytest.mark.parametrize("bounds", [(0.0, 1.0), (-1.0, 2.0), (None, 0.5), (-0.1, 0.2)], ids=str)
@pytest.mark.parametrize("ridge", [0.0, 1e-3])
def test_conditions_of_karush_kuhn_and_tucker(bounds, ridge):
    random = np.random.default_rng(5)
    shapes = random.normal(size=(18, 40)) * np.geomspace(1, 300, 18)[:, None]
    targets = np.cumsum(random.normal(size=(3000, 18)), axis=0) * 0.1 @ shapes + 30 * random.normal(size=(3000, 40))
    low, high = check_bounds(bounds)
    found = solve_reduced(targets, shapes, (low, high), ridge)
    scale = np.sum(shapes**2) / len(shapes)
    slope = (found @ shapes - targets) @ shapes.T + ridge * scale * found
    allowed = np.linalg.norm(targets, axis=1)[:, None] * np.linalg.norm(shapes, axis=1).max() * 1e-6
    assert (found >= low).all() and (found <= high).all()
    assert (np.abs(slope) <= allowed)[(found > low) & (found < high)].all()
    assert (slope >= -allowed)[found == low].all() and (slope <= allowed)[found == high].all()
    assert ((found == low) | (found == high)).mean() > 0.2, "bounds that nothing presses against prove nothing"


def test_dependent_shapes_take_the_smallest_weights_and_the_same_ones_each_time():
    motion = factored()
    hand = likely_hand(motion, 5)
    twice = ExpressionBasis(hand.neutral, [f"s{i}" for i in range(10)], np.tile(hand.displacements, (2, 1, 1)))
    free = solve_weights(twice, motion)
    moved = flat(motion.displacements(0, len(motion)))
    wanted = moved @ np.linalg.pinv(flat(twice.displacements), rcond=1e-12)
    np.testing.assert_allclose(free, wanted, atol=1e-9 * np.abs(wanted).max())
    np.testing.assert_allclose(free[:, :5], free[:, 5:], atol=1e-9)
    bounded = solve_weights(twice, motion, (0, 1))
    assert np.array_equal(bounded, solve_weights(twice, motion, (0, 1)))
    once = flat(hand.displacements).T
    for k in range(0, len(motion), 40):
        wanted_cost = 2 * lsq_linear(once, moved[k], (0, 2), method="bvls", tol=1e-14).cost
        cost = np.sum((moved[k] - bounded[k] @ flat(twice.displacements)) ** 2)
        assert cost <= wanted_cost * (1 + 1e-6)


def test_planted_weights_come_back():
    hand = random_hand(factored(), 12)
    planted = np.clip(np.random.default_rng(0).normal(0.4, 0.5, size=(200, 12)), 0, 1)
    frames = hand.evaluate(planted)
    np.testing.assert_allclose(solve_weights(hand, frames, (0, 1)), planted, atol=1e-7)
    np.testing.assert_allclose(solve_weights(hand, frames), planted, atol=1e-10)


@pytest.mark.parametrize("written", ["float32 metres", "5 decimals"])
@pytest.mark.parametrize("bounds", [None, (-1.0, 2.0)], ids=str)
def test_dependent_shapes_that_a_file_rounded_stay_dependent(written, bounds):
    motion = factored()
    some = likely_hand(motion, 6).displacements
    mixed = np.random.default_rng(8).normal(size=(11, 6)) * np.geomspace(1, 0.05, 11)[:, None]
    exact = ExpressionBasis(motion.neutral, [f"s{i}" for i in range(11)], np.tensordot(mixed, some, axes=1))
    if written == "5 decimals":
        rest = np.round(exact.neutral, 5)
        shapes = np.round(exact.neutral + exact.displacements, 5) - rest
    else:
        rest = (exact.neutral / 1e3).astype(np.float32) * 1e3
        shapes = (exact.displacements / 1e3).astype(np.float32).astype(np.float64) * 1e3
    rounded = ExpressionBasis(rest, exact.names, shapes)
    before, after = (solve_weights(basis, motion, bounds) for basis in (exact, rounded))
    p99 = [np.percentile(np.abs(weights), 99) for weights in (before, after)]
    assert p99[1] <= 1.1 * p99[0]
    np.testing.assert_allclose(after, before, atol=0.02 * p99[0])
    principal = principal_basis(motion, 1.0)
    ranks = [project(basis, principal, affine=True).rank for basis in (exact, rounded)]
    assert ranks[0] == ranks[1] == min(7, principal.count)


def test_errors_that_can_vanish_do_so_with_dependent_shapes_within_bounds():
    """Weights at their bounds, shapes that say the same, directions of very different size."""
    random = np.random.default_rng(4)
    directions = random.normal(size=(9, 60)) * np.geomspace(1, 1e-2, 9)[:, None]
    shapes = random.normal(size=(14, 9)) @ directions
    planted = np.clip(np.cumsum(random.normal(0, 0.1, size=(500, 14)), axis=0), 0, 1)
    targets = planted @ shapes
    found = solve_reduced(targets, shapes, (0.0, 1.0))
    left = np.linalg.norm(targets - found @ shapes, axis=1) / np.linalg.norm(targets, axis=1).max()
    assert left.max() < 1e-8 and ((found == 0) | (found == 1)).any()
    assert (np.linalg.norm(found, axis=1) <= np.linalg.norm(planted, axis=1) * (1 + 1e-6) + 1e-6).all()


def test_a_ridge_is_tikhonov_in_units_of_the_mean_shape():
    motion = factored()
    hand = likely_hand(motion, 6)
    matrix, moved = flat(hand.displacements), flat(motion.displacements(0, len(motion)))
    square = 0.01 * np.sum(matrix**2) / 6
    wanted = np.linalg.solve(matrix @ matrix.T + square * np.eye(6), matrix @ moved.T).T
    np.testing.assert_allclose(solve_weights(hand, motion, None, 0.01), wanted, atol=1e-10 * np.abs(wanted).max())
    larger = ExpressionBasis(hand.neutral * 10, hand.names, hand.displacements * 10)
    scaled = MeshMotion.factored(motion.phi, motion.markers * 10, motion.neutral * 10, motion.fps)
    np.testing.assert_allclose(solve_weights(larger, scaled, None, 0.01), wanted, atol=1e-10 * np.abs(wanted).max())


def test_shapes_that_do_not_move_weigh_nothing():
    still = ExpressionBasis(factored().neutral, ["a", "b"], np.zeros((2, 120, 3)))
    assert not solve_weights(still, factored()).any()
    assert (solve_weights(still, factored(), (0.2, 1)) == 0.2).all()
    one = ExpressionBasis(factored().neutral, ["a", "b"], np.stack([np.zeros((120, 3)), np.ones((120, 3))]))
    assert not solve_weights(one, factored(), (-1, 2))[:, 0].any()


@pytest.mark.parametrize(
    "bounds", [(1, 0), (0, 0), "01", (np.nan, 1), (0, np.inf), (0, 1, 2), -1.0, 0.0, np.nan], ids=str
)
def test_bounds_that_cannot_be(bounds):
    with pytest.raises(InputError, match="bounds"):
        solve_weights(random_hand(factored(), 2), factored(), bounds)


@pytest.mark.parametrize("ridge", [-1e-3, np.nan, np.inf])
def test_ridges_that_cannot_be(ridge):
    with pytest.raises(InputError, match="ridge"):
        solve_weights(random_hand(factored(), 2), factored(), None, ridge)


def test_bounds_that_all_reports_use():
    assert {name: check_bounds(bounds) for name, bounds in BOUNDS.items()} == {
        "0..1": (0, 1), "-1..2": (-1, 2), "free": None,
    }  # fmt: skip
    assert check_bounds((None, None)) is None and check_bounds(2) == (-2, 2)


def test_stops_when_told_to():
    def progress(fraction: float, text: str) -> None:
        if text == "Solving weights":
            raise Cancelled

    with pytest.raises(Cancelled):
        solve_weights(random_hand(factored(), 4), factored(), (0, 0.1), progress=progress)
