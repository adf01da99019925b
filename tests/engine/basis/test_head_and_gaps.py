"""The head's motion is found and removed as planted; gaps are filled, counted, and never in silence."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from engine.basis.gaps import fill_gaps
from engine.basis.head import head_motion, propose_head
from engine.errors import InputError
from engine.motion import MarkerClip
from tests.engine.basis.planted_clip import HEAD, planted_clip, with_gaps


def angle_deg(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.rad2deg(Rotation.from_matrix(np.swapaxes(first, 1, 2) @ second).magnitude())


def test_planted_head_motion_comes_back_exactly():
    planted = planted_clip()
    found = head_motion(planted.clip, HEAD, 0)
    np.testing.assert_allclose(found.rotations, [pose.rotation for pose in planted.poses], atol=1e-9)
    np.testing.assert_allclose(found.translations, [pose.translation for pose in planted.poses], atol=1e-7)
    assert (found.filled.sum(), found.strays) == (0, 0)
    still = planted_clip(still=True).clip.positions
    np.testing.assert_allclose(found.remove(planted.clip.positions), still, atol=1e-7)


def test_a_missing_and_a_straying_marker_do_not_matter():
    planted = planted_clip(noise=0.05)
    clean = head_motion(planted.clip, HEAD, 0)
    positions = with_gaps(planted.clip, {HEAD[0]: slice(10, 40), HEAD[3]: slice(30, 60)}).positions.copy()
    positions[50:53, planted.clip.labels.index(HEAD[5])] += [15, -4, 9]
    found = head_motion(MarkerClip(planted.clip.labels, positions, 120), HEAD, 0)
    assert found.strays == 3
    assert not found.filled.any()
    assert angle_deg(found.rotations, clean.rotations).max() < 0.1
    # The control: with the stray in, the pose is off.
    assert np.abs(found.translations - clean.translations).max() < 0.5


def test_frames_with_two_head_markers_are_interpolated_and_counted():
    planted = planted_clip(frames=240)
    gaps = {label: slice(100, 106) for label in HEAD[2:]}
    found = head_motion(with_gaps(planted.clip, gaps), HEAD, 0)
    assert np.flatnonzero(found.filled).tolist() == list(range(100, 106))
    truth = np.array([pose.rotation for pose in planted.poses])
    across = angle_deg(truth[99:100], truth[106:107]).max()
    assert angle_deg(found.rotations[100:106], truth[100:106]).max() < 0.15 * across


def test_poses_are_seen_from_another_frame():
    from engine.geometry.rigid import RigidTransform

    placement = RigidTransform(Rotation.from_rotvec([0.3, -1, 0.2]).as_matrix(), np.array([5.0, 6, 7]), 1.3)
    planted = planted_clip(placement=placement)
    found = head_motion(planted.clip, HEAD, 0).seen_from(placement)
    for pose, truth in zip(found.transforms(), planted.poses, strict=True):
        np.testing.assert_allclose(pose.rotation, truth.rotation, atol=1e-9)
        np.testing.assert_allclose(pose.translation, truth.translation, atol=1e-6)


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_head_markers_are_proposed_by_how_rigidly_they_move(noise):
    planted = planted_clip(noise=noise)
    assert set(propose_head(planted.clip)) == set(HEAD)


def test_head_markers_are_proposed_by_name():
    clip = planted_clip(frames=10).clip
    labels = [*clip.labels[:-7], *("LFHD", "RFHD", "LBHD", "RBHD", "head_5", "Head 6", "headband")]
    assert propose_head(MarkerClip(labels, clip.positions, 120)) == ("LFHD", "RFHD", "LBHD", "RBHD", "head_5", "Head 6")


def test_nothing_is_proposed_where_nothing_is_rigid():
    rng = np.random.default_rng(0)
    assert propose_head(MarkerClip([f"m{k}" for k in range(20)], rng.normal(0, 50, (50, 20, 3)), 30)) == ()


@pytest.mark.parametrize(
    ("labels", "words"),
    [(("nobody", *HEAD[:3]), "nobody"), (HEAD[:2], "are 2"), ((HEAD[0],) * 4, "are 1")],
)
def test_head_markers_that_cannot_be_are_refused(labels, words):
    with pytest.raises(InputError, match=words):
        head_motion(planted_clip(frames=5).clip, labels)


def test_head_markers_on_a_line_are_refused():
    clip = MarkerClip(["a", "b", "c"], np.tile(np.outer([1, 2, 4.0], [1, 2, 3]), (5, 1, 1)), 30)
    with pytest.raises(InputError, match="line"):
        head_motion(clip, ["a", "b", "c"])


# Gaps -----------------------------------------------------------------------------------------------------------------


def test_short_gaps_follow_a_cubic():
    """A parabola is closed exactly but for the slopes, which are taken over a few frames."""
    time = np.arange(200.0)
    track = np.stack([0.5 * time, 3 + 0 * time, 0.001 * time**2], axis=1)
    positions = np.stack([track, track + np.array([10, 0, 0])], axis=1)
    broken = positions.copy()
    broken[50:70, 1] = np.nan
    found = fill_gaps(broken, longest=24)
    assert (found.short, found.long, found.longest) == (20, 0, 20)
    np.testing.assert_allclose(found.positions, positions, atol=0.03)
    # The control: a straight line would be 0.1 mm off in the middle.
    assert abs((positions[49, 1, 2] + positions[70, 1, 2]) / 2 - positions[59:61, 1, 2].mean()) > 0.09


def test_long_gaps_of_low_rank_motion_come_back_from_the_other_markers():
    rng = np.random.default_rng(1)
    curves = np.column_stack([np.sin(np.arange(400) / (7 + k)) for k in range(4)])
    positions = 50 * rng.normal(size=(1, 20, 3)) + np.einsum("lk,kmc->lmc", curves, rng.normal(0, 4, (4, 20, 3)))
    broken = positions.copy()
    broken[100:180, 3] = np.nan
    broken[150:260, 8] = np.nan
    found = fill_gaps(broken, longest=24)
    assert (found.short, found.long, found.longest) == (0, 190, 110)
    error = np.abs(found.positions - positions).max()
    moved = np.abs(positions[100:180, 3] - positions[99, 3]).max()
    assert error < 0.02 * moved
    np.testing.assert_array_equal(found.positions[~np.isnan(broken)], broken[~np.isnan(broken)])


def test_filled_runs_go_on_from_what_is_seen_beside_them():
    planted = planted_clip(frames=300, noise=0.1)
    broken = planted.clip.positions.copy()
    broken[80:140, 10] = np.nan
    found = fill_gaps(broken, longest=10).positions[:, 10]
    steps = np.linalg.norm(np.diff(planted.clip.positions[:, 10], axis=0), axis=1)
    assert np.linalg.norm(found[80] - found[79]) < steps.max() + 0.5
    assert np.linalg.norm(found[140] - found[139]) < steps.max() + 0.5


def test_markers_and_frames_that_show_too_little_are_left_out():
    positions = np.random.default_rng(0).normal(0, 40, (100, 8, 3))
    positions[5:, 2] = np.nan
    positions[40:60] = np.nan
    found = fill_gaps(positions, longest=5)
    assert found.markers.tolist() == [0, 1, 3, 4, 5, 6, 7]
    assert found.frames.tolist() == [*range(40), *range(60, 100)]
    assert np.isfinite(found.positions).all()


def test_without_gaps_nothing_changes():
    positions = planted_clip(frames=10).clip.positions
    found = fill_gaps(positions, longest=5)
    np.testing.assert_array_equal(found.positions, positions)
    assert (found.short, found.long, found.longest) == (0, 0, 0)


def test_gaps_alone_are_refused():
    with pytest.raises(InputError):
        fill_gaps(np.full((4, 3, 3), np.nan), 5)
