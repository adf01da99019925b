"""The proof of the basis stage: on the sample's performance, through the whole pipeline, with a control that fails."""

import numpy as np
import pytest

from engine.basis.error import reproduction_error
from engine.basis.quasi_eigen import project
from engine.basis.weights import solve_weights
from tests.engine.basis import proof

GAIN, LOSS, WEIGHT, COSINE = 3.5, 1.3, 3.0, 0.85
MISSED = 3.0


@pytest.mark.timeout(300)
class TestTheAnimatorsBasis:
    def test_it_gains_most_of_what_pca_has_and_still_looks_like_itself(self):
        found = proof.figures(proof.HAND_A)
        assert len(found.hand) >= proof.axes().count + 1
        assert found.gain >= GAIN
        assert found.loss <= LOSS
        assert found.p99 <= WEIGHT
        assert found.p99_free <= WEIGHT
        assert found.cosine >= COSINE

    def test_the_affine_form_is_pca_at_full_rank(self):
        skin = proof.rig(proof.HAND_A).skin
        affine = project(proof.figures(proof.HAND_A).hand, proof.axes(), affine=True)
        assert affine.rank == proof.axes().count
        weights = solve_weights(affine.basis, proof.motion(), vertices=skin)
        alpha = reproduction_error(affine.basis, proof.motion(), weights, vertices=skin).alpha_mean
        assert alpha == pytest.approx(proof.alpha_pca(), rel=1e-6)

    def test_pooled_pca_error_is_what_the_coverage_says(self):
        skin = proof.rig(proof.HAND_A).skin
        principal, motion = proof.axes(), proof.motion()
        basis = principal.basis()
        weights = solve_weights(basis, motion, vertices=skin)
        pooled = reproduction_error(basis, motion, weights, vertices=skin).alpha_pooled
        centred = motion.neutral[skin] - motion.neutral[skin].mean(axis=0)
        phi, markers = motion.phi[skin], motion.markers
        squares = (markers * np.einsum("jk,lkc->ljc", phi.T @ phi, markers)).sum() / len(motion)
        squares += (centred**2).sum() + 2 * (centred * (phi @ markers.mean(axis=0))).sum()
        lost = (1 - principal.coverage) * principal.total_variance
        assert pooled == pytest.approx(100 * np.sqrt(lost / squares), rel=1e-6)


@pytest.mark.timeout(300)
def test_random_smooth_shapes_miss_the_bar_by_far():
    found = proof.control(1)
    assert found.loss >= MISSED * LOSS
    assert 1 - found.cosine >= MISSED * (1 - COSINE)
    assert found.gain < GAIN
    assert found.by_quasi[0].alpha_mean >= MISSED * proof.figures(proof.HAND_A).by_quasi[0].alpha_mean


def test_another_artists_shapes_no_longer_look_like_themselves_and_the_user_is_told():
    found = proof.figures(proof.HAND_B)
    assert found.cosine < COSINE
    assert any("no longer look like themselves" in text for text in found.quasi.warnings)


def test_the_recording_has_what_the_page_says():
    clip = proof.clip()
    assert (len(clip), len(clip.labels), clip.fps) == (6000, 73, 120.0)
    assert len(proof.bound().binding) == 66
    assert 0 < (~clip.seen).sum() < 1000
