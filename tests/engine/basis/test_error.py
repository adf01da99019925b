"""Errors equal the plain dense computation, and the identities between bases hold."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.decomposition import PCA

from engine.basis.error import reproduction_error, spaced_peaks
from engine.basis.extremes import Histogram, error_extremes
from engine.basis.principal import principal_basis
from engine.basis.quasi_eigen import project
from engine.basis.weights import solve_weights
from engine.errors import Cancelled, InputError
from engine.motion import MeshMotion
from engine.shapes import ExpressionBasis
from tests.engine.basis.answers import SKIN, flat, likely_hand, random_hand, true_alpha, true_errors
from tests.engine.basis.motions import FORMS, dense, factored


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("vertices", [None, SKIN], ids=["all", "skin"])
@pytest.mark.parametrize("affine", [False, True], ids=["linear", "affine"])
def test_equal_to_the_dense_computation(form, vertices, affine):
    motion = FORMS[form]()
    basis = project(likely_hand(motion, 6), principal_basis(motion, count=4, vertices=vertices), affine).basis
    weights = solve_weights(basis, motion, (-1, 2), vertices=vertices)
    found = reproduction_error(basis, motion, weights, vertices=vertices)
    errors = true_errors(motion, basis, weights)
    frames, pooled = true_alpha(motion, errors, vertices)
    np.testing.assert_allclose(found.alpha_frames, frames, rtol=1e-10)
    np.testing.assert_allclose([found.alpha_mean, found.alpha_pooled], [frames.mean(), pooled], rtol=1e-10)
    error, moved = flat(errors, vertices), flat(motion.displacements(0, len(motion)), vertices)
    ratio = np.linalg.norm(error, axis=1) / np.linalg.norm(moved, axis=1)
    np.testing.assert_allclose(found.motion_frames, 100 * ratio, rtol=1e-10)
    np.testing.assert_allclose(found.motion_mean, 100 * ratio.mean(), rtol=1e-10)
    np.testing.assert_allclose(found.motion_pooled, 100 * np.linalg.norm(error) / np.linalg.norm(moved), rtol=1e-10)
    count = len(motion.neutral) if vertices is None else len(vertices)
    np.testing.assert_allclose(found.rms_mm, np.sqrt(np.mean(error**2) * 3), rtol=1e-10)
    np.testing.assert_allclose(found.rms_frames, np.linalg.norm(error, axis=1) / np.sqrt(count), rtol=1e-10)
    wanted = np.sqrt((errors**2).sum(axis=2).mean(axis=0))
    at = np.arange(len(wanted)) if vertices is None else vertices
    np.testing.assert_allclose(found.rms_vertices[at], wanted[at], rtol=1e-9)
    assert np.isnan(np.delete(found.rms_vertices, at)).all() and found.resting == 0
    np.testing.assert_allclose(found.origin, motion.neutral[at].mean(axis=0), atol=1e-12)

    sizes = np.linalg.norm(errors, axis=2)[:, at]
    most = error_extremes(basis, motion, weights, vertices=vertices, percentile=90)
    np.testing.assert_allclose(most.max_frames, sizes.max(axis=1), rtol=1e-9)
    np.testing.assert_allclose(most.max_vertices[at], sizes.max(axis=0), rtol=1e-9)
    np.testing.assert_allclose(most.percentile_frames, np.percentile(sizes, 90, axis=1), rtol=1e-5)
    assert abs(most.percentile_mm - np.percentile(sizes, 90)) <= most.bin_mm < sizes.max() / 20_000
    assert sizes[most.max_frame, np.flatnonzero(at == most.max_vertex)[0]] == sizes.max()
    assert most.max_mm == most.max_frames.max() and np.isnan(np.delete(most.max_vertices, at)).all()


@pytest.mark.parametrize("coverage", [0.6, 0.9, 0.995])
@pytest.mark.parametrize("form", FORMS)
def test_pooled_alpha_of_the_axes_follows_from_their_coverage(form, coverage):
    motion = FORMS[form]()
    principal = principal_basis(motion, coverage, vertices=SKIN)
    basis = principal.basis()
    found = reproduction_error(basis, motion, solve_weights(basis, motion, vertices=SKIN), vertices=SKIN)
    placed = flat(motion.neutral + motion.displacements(0, len(motion)) - motion.neutral[SKIN].mean(axis=0), SKIN)
    size = np.mean(np.sum(placed**2, axis=1))
    wanted = 100 * np.sqrt((1 - principal.coverage) * principal.total_variance / size)
    np.testing.assert_allclose(found.alpha_pooled, wanted, rtol=1e-6)


def test_axes_and_errors_are_those_of_scikit_learn():
    motion = factored()
    moved = flat(motion.displacements(0, len(motion)))
    theirs = PCA(5, svd_solver="full").fit(moved)
    left = moved - theirs.inverse_transform(theirs.transform(moved))
    basis = principal_basis(motion, count=5).basis()
    found = reproduction_error(basis, motion, solve_weights(basis, motion))
    np.testing.assert_allclose(found.rms_frames, np.linalg.norm(left, axis=1) / np.sqrt(120), rtol=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_affine_quasi_eigen_at_full_rank_is_pca(form):
    motion = FORMS[form]()
    principal = principal_basis(motion, count=5, vertices=SKIN)
    quasi = project(likely_hand(motion, 5), principal, affine=True)
    assert quasi.rank == 5
    axes = principal.basis()
    ours, theirs = (
        reproduction_error(basis, motion, solve_weights(basis, motion, vertices=SKIN), vertices=SKIN)
        for basis in (quasi.basis, axes)
    )
    np.testing.assert_allclose(ours.rms_frames, theirs.rms_frames, rtol=1e-6)
    np.testing.assert_allclose(ours.alpha_pooled, theirs.alpha_pooled, rtol=1e-9)
    np.testing.assert_allclose(quasi.span_coverage, principal.coverage, rtol=1e-9)
    linear = project(likely_hand(motion, 5), principal)
    other = reproduction_error(linear.basis, motion, solve_weights(linear.basis, motion, vertices=SKIN), vertices=SKIN)
    assert abs(other.alpha_pooled - theirs.alpha_pooled) > 1e-3, "linear and affine span different spaces"


def test_any_shapes_span_the_axes_with_free_weights_but_only_large_ones():
    """The reason why free weights alone prove nothing (a control)."""
    motion = factored(fade=0.6)
    principal = principal_basis(motion, count=8)
    alphas, sizes = [], []
    for hand in (likely_hand(motion, 9), random_hand(motion, 9, size=4.0)):
        quasi = project(hand, principal)
        weights = solve_weights(quasi.basis, motion)
        alphas.append(reproduction_error(quasi.basis, motion, weights).alpha_pooled)
        sizes.append(np.percentile(np.abs(weights), 99))
    axes = principal.basis()
    pca = reproduction_error(axes, motion, solve_weights(axes, motion)).alpha_pooled
    assert max(alphas) <= pca * (1 + 1e-9)
    assert sizes[1] > 5 * sizes[0]


def test_perfect_reproduction_is_zero_and_stays_exact():
    motion = factored(markers=3)
    basis = ExpressionBasis(motion.neutral, [f"f{k}" for k in range(9)], motion.displacements(0, 9))
    weights = solve_weights(basis, motion)
    found = reproduction_error(basis, motion, weights)
    assert found.alpha_mean < 1e-11 and found.rms_vertices.max() < 1e-10


def test_frames_at_rest_have_no_error_in_percent_of_their_motion():
    neutral = factored().neutral
    positions = np.repeat(neutral[None], 4, axis=0)
    positions[2] += [1.0, 0, 0]
    motion = MeshMotion.dense(positions, neutral, 30.0)
    basis = random_hand(factored(), 2)
    found = reproduction_error(basis, motion, np.zeros((4, 2)))
    assert found.resting == 3 and np.isnan(found.motion_frames[[0, 1, 3]]).all()
    assert found.motion_mean == pytest.approx(100) and found.motion_pooled == pytest.approx(100)
    still = reproduction_error(basis, motion.slice(0, 2), np.zeros((2, 2)))
    assert np.isnan(still.motion_mean) and still.alpha_mean == 0
    assert error_extremes(basis, motion.slice(0, 2), np.zeros((2, 2))).max_mm == 0


def test_worst_frames_are_apart_in_time():
    motion = factored()
    found = reproduction_error(random_hand(motion, 2), motion, np.zeros((len(motion), 2)))
    frames = found.worst_frames(5)
    assert frames[0] == np.argmax(found.rms_frames) and len(frames) == 5
    assert np.diff(np.sort(frames)).min() >= 60 and (np.diff(found.rms_frames[frames]) <= 0).all()
    assert len(found.worst_frames(100)) < 12, "half a second apart leaves room for few"
    assert (found.worst_frames(len(motion), 1) == np.argsort(-found.rms_frames, kind="stable")).all()
    assert spaced_peaks(np.array([0.0, 5, 4, 0, 3]), 9, 2).tolist() == [1, 4]


@pytest.mark.parametrize("weights", [np.zeros((3, 2)), np.zeros((320, 3)), np.full((320, 2), np.nan)])
@pytest.mark.parametrize("measure", [reproduction_error, error_extremes])
def test_weights_must_fit(measure, weights):
    with pytest.raises(InputError, match="weights"):
        measure(random_hand(factored(), 2), factored(), weights)


def test_extremes_refuse_and_stop():
    motion, basis = factored(), random_hand(factored(), 2)
    for percentile in (-1, 101, np.nan):
        with pytest.raises(InputError, match="percentile"):
            error_extremes(basis, motion, np.zeros((320, 2)), percentile=percentile)

    def progress(fraction: float, text: str) -> None:
        raise Cancelled

    for form in (motion, dense(motion)):
        with pytest.raises(Cancelled):
            error_extremes(basis, form, np.zeros((320, 2)), progress=progress)


@pytest.mark.parametrize("percentile", [0, 50, 95, 99.9, 100])
def test_the_histogram_grows_and_keeps_its_percentiles(percentile):
    values = np.random.default_rng(0).gamma(2.0, 1e-4, size=(40, 5000)) * np.geomspace(1, 1000, 40)[:, None]
    ways = []
    for rows in (values, values[::-1]):
        spectrum = Histogram()
        for row in rows:
            spectrum.add(row[None], float(row.max()))
        ways.append((spectrum.width, spectrum.percentile(percentile)))
    assert ways[0] == ways[1], "the order of chunks does not matter"
    width, found = ways[0]
    assert abs(found - np.percentile(values, percentile)) <= 1.5 * width and width < values.max() / 20_000


def test_frames_that_are_reproduced_are_not_named_as_worst():
    motion = factored()
    basis = ExpressionBasis(
        motion.neutral, ("a", "b"), np.random.default_rng(1).normal(size=(2, len(motion.neutral), 3))
    )
    weights = np.random.default_rng(2).uniform(size=(200, 2))
    driven = MeshMotion.driven(basis, weights, 30.0)
    assert not len(reproduction_error(basis, driven, weights).worst_frames())
    off = weights.copy()
    off[60] += 1
    assert reproduction_error(basis, driven, off).worst_frames().tolist() == [60]
