"""What must not change the figures: turning everything, other units, other orders."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from engine.basis.compare import Comparison, compare
from engine.basis.principal import principal_basis
from engine.basis.quasi_eigen import QuasiEigen, project
from engine.motion import MeshMotion
from engine.shapes import ExpressionBasis
from tests.engine.basis.answers import SKIN, likely_hand
from tests.engine.basis.motions import factored

MOTION = factored(frames=90, markers=5)
HAND = likely_hand(MOTION, 5)


def run(motion: MeshMotion, hand: ExpressionBasis, affine: bool, vertices: np.ndarray) -> tuple[QuasiEigen, Comparison]:
    principal = principal_basis(motion, count=4, vertices=vertices)
    quasi = project(hand, principal, affine)
    return quasi, compare(hand, quasi, principal, motion, vertices=vertices)


PLAIN = {affine: run(MOTION, HAND, affine, SKIN) for affine in (False, True)}


def same(found: tuple[QuasiEigen, Comparison], affine: bool, order=slice(None), frames=slice(None), unit=1.0):
    """Assert that all figures are those of the plain case, shapes and frames in another order, lengths in a unit."""
    (quasi, compared), (plain, before) = found, PLAIN[affine]
    np.testing.assert_allclose(quasi.cosine, plain.cosine[order], atol=1e-9)
    np.testing.assert_allclose(quasi.residual_fraction, plain.residual_fraction[order], atol=1e-9)
    np.testing.assert_allclose(quasi.residual_mm, unit * plain.residual_mm[order], rtol=1e-8)
    np.testing.assert_allclose(quasi.singular_values, plain.singular_values, rtol=1e-7)
    assert quasi.rank == plain.rank and abs(quasi.span_coverage - plain.span_coverage) < 1e-9
    assert quasi.missing == plain.missing
    for key in ("hand", "quasi_eigen"):
        for name in before.weights[key]:
            ours, theirs = compared.errors[key][name], before.errors[key][name]
            weights = before.weights[key][name][frames][:, order]
            np.testing.assert_allclose(compared.weights[key][name], weights, atol=1e-6)
            np.testing.assert_allclose(ours.alpha_frames, theirs.alpha_frames[frames], rtol=1e-6)
            np.testing.assert_allclose(ours.rms_mm, unit * theirs.rms_mm, rtol=1e-6)
    pca = [found.errors["pca"]["free"].alpha_pooled for found in (compared, before)]
    np.testing.assert_allclose(*pca, rtol=1e-8)


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000), affine=st.booleans())
def test_turning_and_moving_everything(seed, affine):
    turn, shift = Rotation.random(random_state=seed).as_matrix(), np.random.default_rng(seed).normal(size=3) * 100
    neutral = MOTION.neutral @ turn.T + shift
    motion = MeshMotion.factored(MOTION.phi, MOTION.markers @ turn.T, neutral, MOTION.fps)
    same(run(motion, ExpressionBasis(neutral, HAND.names, HAND.displacements @ turn.T), affine, SKIN), affine)


@settings(max_examples=8, deadline=None)
@given(exponent=st.floats(-3, 3), affine=st.booleans())
def test_other_units(exponent, affine):
    unit = 10.0**exponent
    motion = MeshMotion.factored(MOTION.phi, unit * MOTION.markers, unit * MOTION.neutral, MOTION.fps)
    hand = ExpressionBasis(unit * HAND.neutral, HAND.names, unit * HAND.displacements)
    same(run(motion, hand, affine, SKIN), affine, unit=unit)


@settings(max_examples=8, deadline=None)
@given(order=st.permutations(range(5)), affine=st.booleans())
def test_shapes_in_another_order(order, affine):
    hand = ExpressionBasis(HAND.neutral, [HAND.names[i] for i in order], HAND.displacements[order])
    same(run(MOTION, hand, affine, SKIN), affine, order=list(order))


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000), affine=st.booleans())
def test_frames_in_another_order(seed, affine):
    frames = np.random.default_rng(seed).permutation(len(MOTION))
    motion = MeshMotion.factored(MOTION.phi, MOTION.markers[frames], MOTION.neutral, MOTION.fps)
    same(run(motion, HAND, affine, SKIN), affine, frames=frames)


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000), affine=st.booleans())
def test_vertices_in_another_order(seed, affine):
    order = np.random.default_rng(seed).permutation(len(MOTION.neutral))
    motion = MeshMotion.factored(MOTION.phi[order], MOTION.markers, MOTION.neutral[order], MOTION.fps)
    hand = ExpressionBasis(HAND.neutral[order], HAND.names, HAND.displacements[:, order])
    same(run(motion, hand, affine, np.sort(np.argsort(order)[SKIN])), affine)
