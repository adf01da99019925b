"""What may be done to a motion without changing what its principal axes span."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.basis.principal import principal_basis
from engine.motion import MeshMotion
from tests.engine.basis.motions import dense, factored, streamed

rotations = st.integers(0, 1000).map(lambda seed: _rotation(np.random.default_rng(seed)))


def _rotation(random: np.random.Generator) -> np.ndarray:
    turned, triangle = np.linalg.qr(random.normal(size=(3, 3)))
    turned = turned * np.sign(np.diag(triangle))
    return turned if np.linalg.det(turned) > 0 else -turned


def _forms(motion: MeshMotion, seed: int) -> MeshMotion:
    return (motion, dense(motion), streamed(motion))[seed % 3]


def _same_span(one: np.ndarray, other: np.ndarray, tolerance: float = 1e-6) -> None:
    first, second = one.reshape(len(one), -1), other.reshape(len(other), -1)
    assert first.shape == second.shape
    np.testing.assert_allclose(np.linalg.svd(first @ second.T, compute_uv=False), 1.0, atol=tolerance)


@settings(max_examples=12, deadline=None)
@given(rotation=rotations, scale=st.floats(0.01, 100), seed=st.integers(0, 50))
def test_turning_and_scaling_the_frame_turns_and_scales_the_axes(rotation: np.ndarray, scale: float, seed: int) -> None:
    motion = factored(frames=280, vertices=100, seed=seed)
    assert motion.phi is not None and motion.markers is not None
    turned = MeshMotion.factored(
        motion.phi, scale * motion.markers @ rotation, scale * motion.neutral @ rotation, 120.0
    )
    one, other = principal_basis(motion, count=6), principal_basis(_forms(turned, seed), count=6)
    assert other.coverage == pytest.approx(one.coverage, rel=1e-9)
    np.testing.assert_allclose(other.eigenvalues[:6], scale**2 * one.eigenvalues[:6], rtol=1e-8)
    _same_span(one.axes @ rotation, other.axes)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 50))
def test_the_order_of_vertices_and_of_frames_and_their_repetition_change_no_span(seed: int) -> None:
    motion = factored(frames=280, vertices=100, seed=seed)
    random = np.random.default_rng(seed)
    order, frames = random.permutation(100), np.tile(random.permutation(280), 2)
    assert motion.phi is not None and motion.markers is not None
    mixed = MeshMotion.factored(motion.phi[order], motion.markers[frames], motion.neutral[order], 120.0)
    one, other = principal_basis(motion, count=6), principal_basis(_forms(mixed, seed), count=6)
    assert other.coverage == pytest.approx(one.coverage, rel=1e-9)
    np.testing.assert_allclose(other.eigenvalues[:6], one.eigenvalues[:6], rtol=1e-8)
    _same_span(one.axes[:, order], other.axes)
