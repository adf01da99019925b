"""Small coordinates keep every inner product, and never lose what is small beside what is large."""

from __future__ import annotations

import numpy as np
import pytest

from engine.basis.reduce import metric_vertices, orthonormal_span, reduce_motion
from engine.errors import Cancelled, InputError
from engine.motion import MeshMotion
from tests.engine.basis.answers import SKIN, flat, random_hand
from tests.engine.basis.motions import FORMS, factored, streamed


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("vertices", [None, SKIN], ids=["all", "skin"])
def test_inner_products_are_those_of_the_displacements(form, vertices):
    motion = FORMS[form]()
    hand = random_hand(motion, 6)
    shapes = np.concatenate([hand.displacements, motion.displacements(0, 2), hand.displacements[:1]])
    reduced = reduce_motion(motion, shapes, vertices=vertices)
    moved, fixed = flat(motion.displacements(0, len(motion)), vertices), flat(shapes, vertices)
    np.testing.assert_allclose(reduced.shapes @ reduced.shapes.T, fixed @ fixed.T, rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(reduced.frames @ reduced.shapes.T, moved @ fixed.T, rtol=1e-11, atol=1e-7)
    np.testing.assert_allclose(reduced.moved_squared, (moved**2).sum(axis=1), rtol=1e-12)
    neutral = motion.neutral if vertices is None else motion.neutral[vertices]
    placed = moved + (neutral - neutral.mean(axis=0)).ravel()
    np.testing.assert_allclose(reduced.placed_squared, (placed**2).sum(axis=1), rtol=1e-12)
    columns = np.linalg.svd(fixed.T, full_matrices=False)[0][:, :8]
    beside = moved - moved @ columns @ columns.T
    np.testing.assert_allclose(reduced.outside, (beside**2).sum(axis=1), rtol=1e-9, atol=1e-12)
    assert reduced.frames.shape[1] == 8, "the shape given twice adds no direction"


@pytest.mark.parametrize("vertices", [None, SKIN], ids=["all", "skin"])
def test_vertices_come_from_the_second_moment(vertices):
    motion = factored()
    hand = random_hand(motion, 5)
    reduced = reduce_motion(motion, hand.displacements, vertices=vertices)
    weights = np.random.default_rng(2).normal(size=(len(motion), 5))
    errors = motion.displacements(0, len(motion)) - np.tensordot(weights, hand.displacements, axes=1)
    wanted = (errors**2).sum(axis=2).mean(axis=0)
    found = reduced.vertex_mean_square(reduced.frames - weights @ reduced.shapes)
    np.testing.assert_allclose(found, wanted if vertices is None else wanted[vertices], rtol=1e-11)


def test_what_is_outside_is_not_a_difference_of_large_numbers():
    """A motion 1e-9 outside its shapes: by subtraction of squared lengths that would be rounding."""
    random = np.random.default_rng(3)
    hand = random_hand(factored(), 4)
    beside = random.normal(size=hand.neutral.shape)
    span = orthonormal_span(flat(hand.displacements))
    beside = beside.ravel() - span @ (span.T @ beside.ravel())
    beside *= 1e-7 / np.linalg.norm(beside)
    moved = np.tensordot(random.normal(size=(30, 4)), hand.displacements, axes=1) + beside.reshape(-1, 3)
    zero = np.zeros_like(hand.neutral)
    for motion in (
        MeshMotion.dense(moved, zero, 30.0),
        MeshMotion.driven(random_hand(factored(), 4), np.zeros((30, 4)), 30.0),
    ):
        reduced = reduce_motion(motion, hand.displacements)
        wanted = 1e-7 if motion.kind == "dense" else 0.0
        np.testing.assert_allclose(np.sqrt(reduced.outside), wanted, rtol=1e-5)


def test_small_shapes_beside_large_ones_keep_their_direction():
    motion = factored()
    hand = random_hand(motion, 3)
    shapes = hand.displacements * np.array([1.0, 1e-5, 1e4])[:, None, None]
    reduced = reduce_motion(motion, shapes)
    moved, fixed = flat(motion.displacements(0, len(motion))), flat(shapes)
    np.testing.assert_allclose(reduced.frames @ reduced.shapes[1], moved @ fixed[1], rtol=1e-8, atol=1e-14)


def test_shapes_within_the_markers_reach_add_nothing():
    motion = factored(markers=9)
    reduced = reduce_motion(motion, motion.displacements(0, 30))
    assert reduced.columns.span.shape[1] == 0 and reduced.frames.shape[1] == 27
    np.testing.assert_allclose(reduced.outside, 0, atol=1e-18 * reduced.moved_squared.max())


@pytest.mark.parametrize("form", FORMS)
def test_some_frames_are_those_of_all(form):
    motion = FORMS[form]()
    hand, chosen = random_hand(motion, 4), np.array([0, 17, 55])
    some, all_ = (reduce_motion(motion, hand.displacements, frames=frames) for frames in (chosen, None))
    np.testing.assert_allclose(some.frames, all_.frames[chosen], rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(some.outside, all_.outside[chosen], rtol=1e-10, atol=1e-9)


def test_a_frame_that_is_not_finite_is_named():
    motion = factored()
    positions = motion.neutral + motion.displacements(0, 20)
    positions[12, 3, 1] = np.nan
    with pytest.raises(InputError, match=r"frame 13"):
        reduce_motion(MeshMotion.dense(positions, motion.neutral, 30.0), random_hand(motion, 2).displacements)


def test_streams_stop_when_told_to():
    def progress(fraction: float, text: str) -> None:
        if fraction > 0:
            raise Cancelled

    motion = streamed(factored())
    with pytest.raises(Cancelled):
        reduce_motion(motion, random_hand(motion, 2).displacements, progress=progress)


@pytest.mark.parametrize(
    ("vertices", "problem"),
    [([], "shape"), ([0.5], "type"), ([[1]], "shape"), ([-1], "outside"), ([5], "outside"), ([1, 1], "twice")],
)
def test_vertices_of_the_metric_must_be_there_once(vertices, problem):
    with pytest.raises(InputError, match=problem):
        metric_vertices(vertices, 5)


def test_another_topology_is_told_with_both_counts():
    with pytest.raises(InputError, match=r"119 vertices.*120"):
        reduce_motion(factored(), np.zeros((2, 119, 3)))
