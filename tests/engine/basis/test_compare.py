"""The comparison in one pass equals its parts, and the slider's figure the exact one on its frames."""

from __future__ import annotations

import numpy as np
import pytest

from engine.basis.compare import compare, compare_again, deviation_basis
from engine.basis.error import reproduction_error
from engine.basis.live import LiveAlpha, even_frames
from engine.basis.principal import principal_basis
from engine.basis.quasi_eigen import blend, project
from engine.basis.weights import BOUNDS, solve_weights
from engine.errors import Cancelled, InputError
from engine.shapes import ExpressionBasis
from tests.engine.basis.answers import SKIN, likely_hand, random_hand, shares, true_alpha, true_errors
from tests.engine.basis.motions import FORMS, factored

SOME = ("factored", "driven about a mean", "dense, few frames", "streamed, few frames")


@pytest.mark.parametrize("form", SOME)
@pytest.mark.parametrize("affine", [False, True], ids=["linear", "affine"])
def test_equal_to_each_basis_on_its_own(form, affine):
    motion = FORMS[form]()
    hand, principal = likely_hand(motion, 6), principal_basis(motion, count=4, vertices=SKIN)
    quasi = project(hand, principal, affine)
    found = compare(hand, quasi, principal, motion, vertices=SKIN)
    assert found.bases["quasi_eigen"] is quasi.basis and found.bases["hand"] is hand
    for key, basis in found.bases.items():
        for name, bounds in BOUNDS.items():
            weights = found.weights[key][name]
            np.testing.assert_allclose(weights, solve_weights(basis, motion, bounds, vertices=SKIN), atol=1e-6)
            alone = reproduction_error(basis, motion, weights, vertices=SKIN)
            frames, pooled = true_alpha(motion, true_errors(motion, basis, weights), SKIN)
            error = found.errors[key][name]
            np.testing.assert_allclose(error.alpha_frames, frames, rtol=1e-9)
            np.testing.assert_allclose(error.alpha_pooled, pooled, rtol=1e-9)
            np.testing.assert_allclose(error.rms_vertices, alone.rms_vertices, rtol=1e-9)
            assert found.p99[key][name] == np.percentile(np.abs(weights), 99)
            assert found.largest[key][name] == np.abs(weights).max()
        tighter = [found.errors[key][name].rms_mm for name in ("free", "-1..2", "0..1")]
        assert tighter[0] <= tighter[1] * (1 + 1e-9) <= tighter[2] * (1 + 2e-9)


def test_a_weight_of_the_axes_is_a_standard_deviation():
    motion = factored()
    principal = principal_basis(motion, count=5)
    basis = deviation_basis(principal)
    np.testing.assert_allclose(basis.displacements, principal.axes * shares(principal)[:, None, None])
    np.testing.assert_allclose(solve_weights(basis, motion).std(axis=0), 1, rtol=1e-9)


def test_a_second_comparison_changes_the_quasi_eigen_basis_only():
    motion = factored()
    hand, principal = likely_hand(motion, 5), principal_basis(motion, count=4)
    quasi = project(hand, principal)
    first = compare(hand, quasi, principal, motion, ridge=1e-3)
    other = blend(hand, quasi.basis, np.full(5, 0.3))
    again, whole = compare_again(first, other, motion, ridge=1e-3), compare(hand, other, principal, motion, ridge=1e-3)
    for name in BOUNDS:
        assert again.errors["pca"][name] is first.errors["pca"][name]
        alphas = [found.errors["quasi_eigen"][name].alpha_mean for found in (again, whole, first)]
        assert alphas[0] == pytest.approx(alphas[1], rel=1e-9) and abs(alphas[0] - alphas[2]) > 1e-6


def test_the_proof_separates_likely_shapes_from_random_ones():
    """In bounds, shapes of the performance gain by projection; random ones stay far behind (a control)."""
    motion = factored(markers=6, fade=0.45)
    principal = principal_basis(motion, 0.995)
    count = principal.count + 6
    figures = []
    for hand in (likely_hand(motion, count, away=0.3), random_hand(motion, count, size=3.0)):
        quasi = project(hand, principal)
        found = compare(hand, quasi, principal, motion)
        alphas = [found.errors[key][name].alpha_mean for key, name in (("quasi_eigen", "-1..2"), ("pca", "free"))]
        figures.append((alphas[0] / alphas[1], float(np.median(quasi.cosine))))
    assert figures[0][1] > 0.85 > 0.5 > figures[1][1]
    assert figures[1][0] > 3 * figures[0][0]


@pytest.mark.parametrize("form", SOME)
@pytest.mark.parametrize("affine", [False, True], ids=["linear", "affine"])
@pytest.mark.parametrize("bounds", BOUNDS.values(), ids=BOUNDS)
def test_the_live_figure_is_exact_on_its_frames(form, affine, bounds):
    motion = FORMS[form]()
    hand, principal = likely_hand(motion, 5), principal_basis(motion, count=4, vertices=SKIN)
    quasi = project(hand, principal, affine)
    live = LiveAlpha(hand, quasi, motion, bounds, SKIN, 40)
    assert len(live.frames) == 40 and live.frames[0] == 0 and live.frames[-1] == len(motion) - 1
    for amounts in (np.zeros(5), np.ones(5), np.linspace(0, 1, 5)):
        basis = blend(hand, quasi.basis, amounts)
        weights = solve_weights(basis, motion, bounds, vertices=SKIN)[live.frames]
        np.testing.assert_allclose(live.weights(amounts), weights, atol=1e-6)
        positions = motion.neutral + motion.displacements(0, len(motion))
        neutral = motion.neutral[SKIN].mean(axis=0)
        error = np.linalg.norm((positions[live.frames] - basis.evaluate(weights))[:, SKIN], axis=(1, 2))
        placed = np.linalg.norm((positions[live.frames] - neutral)[:, SKIN], axis=(1, 2))
        wanted = 100 * np.mean(error / placed), 100 * np.linalg.norm(error) / np.linalg.norm(placed)
        np.testing.assert_allclose(live.alpha(amounts), wanted, rtol=1e-6)


def test_all_frames_are_the_exact_figure():
    motion = factored()
    hand, principal = likely_hand(motion, 5), principal_basis(motion, count=4)
    quasi = project(hand, principal)
    found = compare(hand, quasi, principal, motion)
    live = LiveAlpha(hand, quasi, motion, (-1, 2), frames=None)
    for amounts, key in ((np.zeros(5), "hand"), (np.ones(5), "quasi_eigen")):
        error = found.errors[key]["-1..2"]
        np.testing.assert_allclose(live.alpha(amounts), (error.alpha_mean, error.alpha_pooled), rtol=1e-9)
    assert even_frames(10, 20).tolist() == list(range(10)) and even_frames(9, 3).tolist() == [0, 4, 8]


def test_live_refuses_what_does_not_fit():
    motion = factored()
    hand = likely_hand(motion, 3)
    other = ExpressionBasis(hand.neutral, ["x", "y", "z"], hand.displacements)
    with pytest.raises(InputError, match="other shapes"):
        LiveAlpha(hand, other, motion)
    with pytest.raises(InputError, match="frames"):
        LiveAlpha(hand, hand, motion, frames=0)
    with pytest.raises(InputError, match="amounts"):
        LiveAlpha(hand, hand, motion).alpha(np.ones(2))


def test_comparing_stops_when_told_to_and_reports_in_order():
    motion = factored()
    hand, principal = likely_hand(motion, 5), principal_basis(motion, count=4)
    reports: list[float] = []
    compare(hand, project(hand, principal), principal, motion, progress=lambda fraction, text: reports.append(fraction))
    assert reports[0] == 0 and reports[-1] == 1 and (np.diff(reports) >= 0).all()

    def progress(fraction: float, text: str) -> None:
        if fraction > 0.5:
            raise Cancelled

    with pytest.raises(Cancelled):
        compare(hand, project(hand, principal), principal, motion, progress=progress)
