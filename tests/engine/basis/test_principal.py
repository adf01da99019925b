"""Principal axes in every form of motion against numpy's SVD and scikit-learn."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.decomposition import PCA

from engine.basis.principal import principal_basis
from engine.motion import MeshMotion
from tests.engine.basis.motions import FORMS, Reference, dense, driven, factored, misaligned, streamed

METRIC = np.arange(5, 120, 2)


@pytest.mark.parametrize("vertices", [None, METRIC[METRIC < 80]], ids=["all", "subset"])
@pytest.mark.parametrize("form", FORMS)
def test_every_form_gives_the_answer_of_a_plain_svd(form: str, vertices: np.ndarray | None) -> None:
    motion = FORMS[form]()
    found, wanted = principal_basis(motion, 0.98, vertices=vertices), Reference(motion, vertices)
    shares = np.cumsum(wanted.eigenvalues) / wanted.total
    assert found.count == int(np.argmax(shares >= 0.98)) + 1 > 2
    assert found.coverage == pytest.approx(shares[found.count - 1], rel=1e-9)
    assert found.total_variance == pytest.approx(wanted.total, rel=1e-9)
    np.testing.assert_allclose(found.mean, wanted.mean, atol=1e-10)
    known = len(found.eigenvalues)
    assert known >= found.count
    np.testing.assert_allclose(found.eigenvalues[: found.count], wanted.eigenvalues[: found.count], rtol=1e-9)
    np.testing.assert_allclose(found.eigenvalues, wanted.eigenvalues[:known], rtol=1e-4)
    # On all vertices, those off the metric included: the same combination of centred frames.
    assert misaligned(found.axes, wanted.axes[: found.count]) < 1e-7


@pytest.mark.parametrize("vertices", [None, METRIC], ids=["all", "subset"])
def test_positions_in_single_precision_are_analysed_as_exactly_as_they_are_given(vertices: np.ndarray | None) -> None:
    motion = dense(factored(frames=700, vertices=400, fade=0.7), np.float32)
    found, wanted = principal_basis(motion, 0.99, vertices=vertices), Reference(motion, vertices)
    assert motion.vertices is not None and motion.vertices.dtype == np.float32
    np.testing.assert_allclose(found.eigenvalues[: found.count], wanted.eigenvalues[: found.count], rtol=1e-6)
    np.testing.assert_allclose(found.mean, wanted.mean, atol=2e-6)
    assert found.coverage == pytest.approx(wanted.eigenvalues[: found.count].sum() / wanted.total, rel=1e-6)
    assert misaligned(found.axes, wanted.axes[: found.count]) < 4e-6


def test_variances_that_single_precision_cannot_tell_from_nothing_are_computed_in_double() -> None:
    motion = dense(factored(frames=600, vertices=300, markers=6, fade=0.02), np.float32)
    found, wanted = principal_basis(motion, count=9), Reference(motion)
    assert wanted.eigenvalues[8] < 1e-6 * wanted.eigenvalues[0]
    np.testing.assert_allclose(found.eigenvalues[:9], wanted.eigenvalues[:9], rtol=1e-7)


def test_the_answer_is_that_of_scikit_learn() -> None:
    motion = driven(frames=300)
    rows = motion.displacements(0, 300).reshape(300, -1)
    peer = PCA(n_components=8, svd_solver="full").fit(rows)
    found = principal_basis(motion, count=8)
    np.testing.assert_allclose(found.mean.ravel(), peer.mean_, atol=1e-10)
    # Theirs divides by L - 1, the paper's (1/L) D D^T by L.
    np.testing.assert_allclose(found.eigenvalues[:8], peer.explained_variance_ * 299 / 300, rtol=1e-9)
    np.testing.assert_allclose(found.cumulative[:8], np.cumsum(peer.explained_variance_ratio_), rtol=1e-9)
    assert misaligned(found.axes, peer.components_.reshape(8, -1, 3)) < 1e-7


@pytest.mark.parametrize("form", FORMS)
def test_axes_are_orthonormal_and_what_they_leave_is_what_the_coverage_says(form: str) -> None:
    motion, vertices = FORMS[form](), np.arange(3, 70)
    found = principal_basis(motion, 0.9, vertices=vertices)
    metric = found.axes[:, vertices].reshape(found.count, -1)
    np.testing.assert_allclose(metric @ metric.T, np.eye(found.count), atol=1e-10)
    moved = motion.displacements(0, len(motion))
    coordinates = found.coordinates(moved)
    left = (moved - found.mean - np.tensordot(coordinates, found.axes, axes=1))[:, vertices]
    # METHODS: the pooled error of the affine reconstruction on its own training frames.
    assert np.sum(left**2) / len(moved) == pytest.approx((1 - found.coverage) * found.total_variance, rel=1e-9)
    np.testing.assert_allclose((coordinates**2).mean(axis=0), found.eigenvalues[: found.count], rtol=1e-9)
    rebuilt = found.basis().evaluate(coordinates)[:, vertices]
    np.testing.assert_allclose(rebuilt, (found.neutral + moved)[:, vertices] - left, atol=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_the_same_motion_gives_the_same_bits_and_the_largest_component_is_positive(form: str) -> None:
    motion = FORMS[form]()
    first, second = principal_basis(motion, count=4), principal_basis(FORMS[form](), count=4)
    assert np.array_equal(first.axes, second.axes) and np.array_equal(first.eigenvalues, second.eigenvalues)
    flat = first.axes.reshape(4, -1)
    assert (flat[np.arange(4), np.abs(flat).argmax(axis=1)] > 0).all()


def test_signs_agree_between_forms_where_left_and_right_move_alike() -> None:
    # The largest components are a pair of opposite ones, equal but for rounding: either could be the largest.
    random = np.random.default_rng(3)
    half = random.normal(size=(40, 5))
    phi, markers = np.vstack([half, -half]), random.normal(size=(300, 5, 3))
    motion = MeshMotion.factored(phi, markers, random.normal(size=(80, 3)), 120.0)
    one, other = principal_basis(motion, count=6), principal_basis(dense(motion, np.float32), count=6)
    assert (np.einsum("mij,mij->m", one.axes, other.axes) > 0.999).all()


def test_only_the_training_range_is_learnt_from() -> None:
    motion = factored(frames=400)
    for form in (motion, dense(motion), streamed(motion)):
        found, wanted = principal_basis(form, count=5, train=(30, 390)), Reference(motion, train=(30, 390))
        assert found.train == (30, 390) and found.frames == 360
        assert misaligned(found.axes, wanted.axes[:5]) < 1e-7
        assert misaligned(found.axes, Reference(motion).axes[:5]) > 1e-3


def test_a_badly_conditioned_spread_keeps_the_axes_that_its_square_loses() -> None:
    random = np.random.default_rng(1)
    left = np.linalg.qr(random.normal(size=(60, 4)))[0]
    right = np.linalg.qr(random.normal(size=(4, 4)))[0]
    phi = left * 10.0 ** np.array([0, -3, -6, -9]) @ right.T
    # Motion that is equally large along every column of ``left``.
    markers = np.einsum("kj,ljc->lkc", right * 10.0 ** np.array([0, 3, 6, 9]), random.normal(size=(200, 4, 3)))
    motion = MeshMotion.factored(phi, markers, np.zeros((60, 3)), 120.0)
    found = principal_basis(motion, 1.0)
    planted = np.linalg.qr(np.kron(left, np.eye(3)))[0]
    axes = found.axes.reshape(found.count, -1)
    assert found.count == 12
    assert np.linalg.norm(axes.T - planted @ (planted.T @ axes.T)) < 1e-5
    square = np.linalg.cholesky(phi.T @ phi + 1e-30 * np.eye(4)) if _positive(phi.T @ phi) else np.zeros((4, 4))
    moved = np.einsum("kj,lkc->ljc", square, markers).reshape(200, -1)
    values = np.linalg.svd(moved - moved.mean(axis=0), compute_uv=False) ** 2 / 200
    assert not np.allclose(values, found.eigenvalues, rtol=1e-2)


def _positive(matrix: np.ndarray) -> bool:
    return bool(np.linalg.eigvalsh(matrix)[0] > 0)


def test_markers_that_move_no_vertex_of_the_metric_still_move_the_others_as_the_frames_do() -> None:
    random = np.random.default_rng(5)
    phi = random.normal(size=(50, 6))
    phi[:30, 3:] = 0.0
    motion = MeshMotion.factored(phi, random.normal(size=(200, 6, 3)), random.normal(size=(50, 3)), 120.0)
    found, wanted = principal_basis(motion, 1.0, vertices=np.arange(30)), Reference(motion, np.arange(30))
    assert found.count == 9
    assert np.abs(found.axes[:, 30:]).max() > 1e-4
    assert misaligned(found.axes, wanted.axes) < 1e-9


@pytest.mark.parametrize("vertices, markers", [(6, 15), (40, 8)])
def test_more_markers_than_vertices_or_the_same_one_twice_count_once(vertices: int, markers: int) -> None:
    motion = factored(vertices, markers, fade=0.9)
    assert motion.phi is not None and motion.markers is not None
    twice = MeshMotion.factored(
        np.hstack([motion.phi, motion.phi[:, :3]]), motion.markers[:, [*range(markers), 0, 1, 2]], motion.neutral, 120.0
    )
    found, wanted = principal_basis(twice, 1.0), Reference(twice)
    assert found.count == len(wanted.eigenvalues) == 3 * min(vertices, markers)
    assert misaligned(found.axes, wanted.axes) < 1e-6


def test_an_axis_that_no_sampled_frame_shows_is_found() -> None:
    random = np.random.default_rng(2)
    frames, vertices = 2000, 120
    moved = np.tensordot(random.normal(size=(frames, 3)), random.normal(size=(3, vertices, 3)), axes=1)
    sampled = np.unique(np.linspace(0, frames - 1, 256).round().astype(int))
    burst = np.setdiff1d(np.arange(900, 1000), sampled)
    hidden = np.zeros((vertices, 3))
    hidden[70:] = random.normal(size=(50, 3))
    moved[burst] += 12.0 * hidden * random.normal(size=(len(burst), 1, 1))
    motion = MeshMotion.dense(moved, np.zeros((vertices, 3)), 120.0)
    found = principal_basis(motion, count=2)
    wanted = Reference(motion)
    np.testing.assert_allclose(found.eigenvalues[:2], wanted.eigenvalues[:2], rtol=1e-8)
    assert abs(np.vdot(found.axes[0], hidden)) / np.linalg.norm(hidden) > 0.99


def test_a_spectrum_without_a_gap_converges_too() -> None:
    random = np.random.default_rng(4)
    motion = MeshMotion.dense(random.normal(size=(500, 120, 3)), np.zeros((120, 3)), 120.0)
    found, wanted = principal_basis(motion, 0.3), Reference(motion)
    shares = np.cumsum(wanted.eigenvalues) / wanted.total
    assert found.count == int(np.argmax(shares >= 0.3)) + 1 > 20
    np.testing.assert_allclose(found.eigenvalues[: found.count], wanted.eigenvalues[: found.count], rtol=1e-8)
