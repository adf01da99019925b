"""Motion in its four forms is one motion; what is wrong with it is said in one line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.motion import MarkerClip, MeshMotion, WeightCurves, driven_by
from engine.shapes import ExpressionBasis
from tests.engine.basis.motions import dense, driven, factored, streamed

PAIRS = {
    "dense of factored": (factored, lambda: dense(factored())),
    "streamed of factored": (factored, lambda: streamed(factored())),
    "dense of driven": (lambda: driven(mean=True), lambda: dense(driven(mean=True))),
    "streamed of driven": (driven, lambda: streamed(driven())),
}


@pytest.mark.parametrize("pair", PAIRS)
def test_all_forms_give_the_same_displacements(pair: str) -> None:
    one, other = (make() for make in PAIRS[pair])
    some = np.array([3, 4, 77, 11])
    np.testing.assert_allclose(one.displacements(5, 40), other.displacements(5, 40), atol=1e-11)
    np.testing.assert_allclose(one.displacements(5, 40, some), other.displacements(5, 40)[:, some], atol=1e-11)
    np.testing.assert_allclose(one.frame(319), other.frame(319), atol=1e-11)
    np.testing.assert_allclose(one.frame(7), one.neutral + one.displacements(7, 8)[0], atol=0)
    np.testing.assert_allclose(one.positions(9, 12), other.positions(9, 12), atol=1e-11)
    assert one.displacements(4, 4).shape == (0, 120, 3) and other.displacements(4, 4).shape == (0, 120, 3)


def test_factored_motion_is_phi_times_every_coordinate_of_the_markers() -> None:
    motion = factored()
    assert motion.phi is not None and motion.markers is not None
    # Kim & Ko 2007, section 5.2: B = Phi (x) I3.
    whole = np.kron(motion.phi, np.eye(3)) @ motion.markers[11].ravel()
    np.testing.assert_allclose(motion.displacements(11, 12)[0].ravel(), whole, atol=1e-12)


def test_driven_motion_is_what_the_basis_evaluates_to() -> None:
    motion = driven(mean=True)
    assert motion.basis is not None and motion.weights is not None
    np.testing.assert_allclose(motion.frame(21), motion.basis.evaluate(motion.weights[21]), atol=1e-12)


@settings(deadline=None)
@given(largest=st.integers(1, 400_000), form=st.sampled_from([factored, driven]), part=st.booleans())
def test_chunks_are_all_frames_in_order_whatever_their_size(
    largest: int, form: Callable[..., MeshMotion], part: bool
) -> None:
    motion = form(vertices=30, frames=70)
    some = np.array([2, 9]) if part else None
    for kind in (motion, dense(motion), streamed(motion)):
        starts, pieces = zip(*kind.chunks(some, largest), strict=True)
        assert [0, *np.cumsum([len(piece) for piece in pieces])[:-1]] == list(starts)
        assert all(piece.nbytes <= largest or len(piece) == 1 for piece in pieces)
        np.testing.assert_allclose(np.concatenate(pieces), motion.displacements(0, 70, some), atol=1e-11)


def test_a_slice_of_a_slice_is_the_frames_counted_through_and_copies_none() -> None:
    for motion in (factored(), driven(), dense(driven()), streamed(driven())):
        inner = motion.slice(100, 300).slice(20, 30)
        assert len(inner) == 10 and inner.fps == motion.fps and inner.kind == motion.kind
        np.testing.assert_allclose(inner.displacements(0, 10), motion.displacements(120, 130), atol=1e-11)
        for name in ("markers", "weights", "vertices"):
            if getattr(motion, name) is not None:
                assert np.shares_memory(getattr(inner, name), getattr(motion, name))
        with pytest.raises(InputError, match="frame range: 5:11 does not lie in 0:10"):
            inner.slice(5, 11)
        with pytest.raises(InputError, match="frame range: 5:5"):
            inner.slice(5, 5)


def test_frames_that_are_not_there_are_not_wrapped_around() -> None:
    for motion in (factored(), driven(), dense(driven()), streamed(driven())):
        for start, stop in ((-1, 3), (0, 321), (5, 4)):
            with pytest.raises(InputError, match=f"frames: {start} to {stop} of 320"):
                motion.displacements(start, stop)
        with pytest.raises(InputError):
            motion.frame(320)
        with pytest.raises(InputError):
            motion.frame(-1)


def test_mapped_and_single_positions_stay_as_they_are(tmp_path: Path) -> None:
    np.save(tmp_path / "take.npy", dense(driven(), np.float32).vertices)
    mapped = np.load(tmp_path / "take.npy", mmap_mode="r")
    motion = MeshMotion.dense(mapped, driven().neutral, 60.0)
    assert motion.vertices is mapped and np.shares_memory(motion.positions(3, 9), mapped)
    assert motion.positions(3, 9).dtype == np.float32 and motion.displacements(3, 9).dtype == np.float64
    # Positions near 80 mm carry 4e-6 mm each in single precision.
    np.testing.assert_allclose(motion.displacements(0, 320), driven().displacements(0, 320), atol=2e-5)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_frame_that_is_not_finite_is_counted_from_the_start_of_the_clip(bad: float) -> None:
    positions = np.zeros((50, 4, 3), np.float32)
    positions[33, 2, 1] = bad
    neutral = np.zeros((4, 3))
    for motion in (
        MeshMotion.dense(positions, neutral, 25.0),
        MeshMotion.streamed(lambda a, b: positions[a:b], 50, neutral, 25.0),
    ):
        assert motion.displacements(0, 33).shape == (33, 4, 3)
        for start in (0, 10):
            with pytest.raises(InputError, match="motion, frame 34: holds positions that are not finite"):
                motion.slice(start, 50).displacements(5, 40)


def test_a_reader_that_gives_other_frames_than_it_was_asked_for_is_refused() -> None:
    motion = MeshMotion.streamed(lambda a, b: np.zeros((b - a + 1, 4, 3)), 50, np.zeros((4, 3)), 25.0)
    with pytest.raises(InputError, match=r"motion: gives frames of shape \(4, 4, 3\), not \(3, 4, 3\)"):
        motion.displacements(0, 3)


NEUTRAL = np.zeros((4, 3))
BASIS = ExpressionBasis(NEUTRAL, ("a", "b"), np.ones((2, 4, 3)))
WRONG: list[tuple[Callable[[], Any], str]] = [
    (lambda: MeshMotion.dense(np.zeros((5, 3, 3)), NEUTRAL, 60), r"motion: has shape \(5, 3, 3\) for 4 vertices"),
    (lambda: MeshMotion.dense(np.zeros((0, 4, 3)), NEUTRAL, 60), "motion: has no frames"),
    (lambda: MeshMotion.dense(np.zeros((5, 4, 3)), NEUTRAL, 0), "frame rate: is 0"),
    (lambda: MeshMotion.dense(np.zeros((5, 4, 3)), NEUTRAL, float("nan")), "frame rate: is nan"),
    (lambda: MeshMotion.dense(np.zeros((5, 4, 3)), np.full((4, 3), np.nan), 60), "neutral: has shape"),
    (lambda: MeshMotion.factored(np.zeros((3, 2)), np.zeros((5, 2, 3)), NEUTRAL, 60), "phi: has shape"),
    (lambda: MeshMotion.factored(np.zeros((4, 2)), np.zeros((5, 3, 3)), NEUTRAL, 60), "for 2 markers"),
    (lambda: MeshMotion.factored(np.zeros((4, 2)), np.zeros((0, 2, 3)), NEUTRAL, 60), "motion: has no frames"),
    (
        lambda: MeshMotion.factored(np.zeros((4, 2)), np.full((5, 2, 3), np.nan), NEUTRAL, 60),
        "markers: hold numbers that are not finite; fill the gaps first",
    ),
    (lambda: MeshMotion.driven(BASIS, np.zeros((5, 3)), 60), r"weights: have shape \(5, 3\) for 2 shapes"),
    (lambda: MeshMotion.driven(BASIS, np.full((5, 2), np.inf), 60), "weights: hold numbers that are not finite"),
    (lambda: MeshMotion.driven(BASIS, np.zeros((0, 2)), 60), "motion: has no frames"),
    (lambda: MeshMotion.streamed(lambda a, b: NEUTRAL[None], 0, NEUTRAL, 60), "motion: has no frames"),
    (lambda: MarkerClip(("a", "a"), np.zeros((5, 2, 3)), 60), "names: a stands for several"),
    (lambda: MarkerClip(("a",), np.zeros((5, 2, 3)), 60), "names: are 1 for 2"),
    (lambda: MarkerClip(("a", "b"), np.zeros((5, 2)), 60), r"markers: have shape \(5, 2\)"),
    (lambda: MarkerClip(("a", "b"), np.full((5, 2, 3), np.inf), 60), "infinite positions"),
    (lambda: WeightCurves(("a", " "), np.zeros((5, 2)), 60), "names: shape 2 has none"),
    (lambda: WeightCurves(("a", "b"), np.full((5, 2), np.nan), 60), "weights: hold numbers that are not finite"),
    (lambda: driven_by(BASIS, WeightCurves(("x",), np.zeros((5, 1)), 60)), "none of its curves .x. has the name of"),
]


@pytest.mark.parametrize("make, message", WRONG)
def test_what_is_wrong_is_said_in_one_line(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        make()
    assert "\n" not in str(refused.value)


def test_a_gap_is_where_any_coordinate_of_a_marker_is_missing() -> None:
    positions = np.zeros((3, 2, 3))
    positions[1, 0, 2] = np.nan
    clip = MarkerClip(("a", "b"), positions, 120.0)
    assert clip.seen.tolist() == [[True, True], [False, True], [True, True]] and len(clip) == 3
    positions[0] = 7.0
    assert not clip.positions[0].any() and not clip.positions.flags.writeable


def test_curves_drive_the_shapes_of_their_names_and_the_rest_is_told() -> None:
    curves = WeightCurves(("headYaw", "B"), np.arange(10.0).reshape(5, 2), 30.0)
    motion, unused, resting = driven_by(BASIS, curves)
    assert unused == ("headYaw",) and resting == ("a",) and motion.fps == 30.0
    np.testing.assert_array_equal(motion.displacements(0, 5)[:, 2, 1], curves.weights[:, 1])
