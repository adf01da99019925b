"""Rigid alignment finds planted motions exactly, and says when they cannot be found."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from engine.errors import InputError
from engine.geometry.rigid import RigidTransform, align


def planted(seed: int, scale: float = 1.0) -> tuple[RigidTransform, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    known = RigidTransform(Rotation.random(random_state=rng).as_matrix(), rng.normal(0, 50, 3), scale)
    points = rng.normal(0, 60, (8, 3))
    return known, points, known.apply(points)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), scale=st.floats(0.01, 100))
def test_planted_similarity_comes_back_exactly(seed, scale):
    known, points, moved = planted(seed, scale)
    found = align(points, moved, scale=True)
    np.testing.assert_allclose(found.rotation, known.rotation, atol=1e-10)
    np.testing.assert_allclose(found.scale, scale, rtol=1e-10)
    np.testing.assert_allclose(found.apply(points), moved, atol=1e-8 * max(1, scale))
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_agrees_with_scipy_on_noisy_points():
    rng = np.random.default_rng(5)
    _, points, moved = planted(5)
    moved = moved + rng.normal(0, 2, moved.shape)
    weights = rng.uniform(0.1, 2, len(points))
    found = align(points, moved, weights)
    centre = weights / weights.sum()
    rotation, _ = Rotation.align_vectors(moved - centre @ moved, points - centre @ points, weights=weights)
    np.testing.assert_allclose(found.rotation, rotation.as_matrix(), atol=1e-7)


def test_a_mirrored_cloud_gives_a_rotation_and_no_mirror():
    _, points, _ = planted(2)
    found = align(points, points * [-1, 1, 1])
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    # And it is the best one: no small turn about any axis is better.
    cost = np.sum((found.apply(points) - points * [-1, 1, 1]) ** 2)
    middle = points.mean(axis=0)
    for axis in np.vstack([np.eye(3), -np.eye(3)]):
        turn = Rotation.from_rotvec(0.01 * axis).as_matrix() @ found.rotation
        goal = (points * [-1, 1, 1]).mean(axis=0)
        assert np.sum(((points - middle) @ turn.T + goal - points * [-1, 1, 1]) ** 2) > cost


def test_points_without_weight_have_no_say():
    known, points, moved = planted(3)
    moved = moved.copy()
    moved[2] += 500
    weights = np.ones(len(points))
    weights[2] = 0
    np.testing.assert_allclose(align(points, moved, weights).rotation, known.rotation, atol=1e-10)
    assert not np.allclose(align(points, moved).rotation, known.rotation, atol=1e-2)


def test_inverse_and_composition():
    known, points, moved = planted(4, 1.7)
    np.testing.assert_allclose(known.inverse().apply(moved), points, atol=1e-10)
    other = planted(9, 0.5)[0]
    np.testing.assert_allclose(other.after(known).apply(points), other.apply(moved), atol=1e-9)
    np.testing.assert_allclose(known.turn(points[:1] - points[1:2]), moved[:1] - moved[1:2], atol=1e-9)


@pytest.mark.parametrize(
    "points",
    [
        np.eye(3)[:2],
        np.outer(np.arange(5.0), [1, 2, 3]),
        np.outer(np.arange(5.0), [1, 2, 3]) + 1e6,
        np.ones((5, 3)),
        np.full((4, 3), np.nan),
        np.zeros((4, 2)),
    ],
)
def test_what_has_no_answer_is_refused(points):
    with pytest.raises(InputError) as caught:
        align(points, points)
    assert caught.value.remedy


def test_three_points_are_enough():
    known, points, moved = planted(6)
    np.testing.assert_allclose(align(points[:3], moved[:3]).rotation, known.rotation, atol=1e-9)
