"""Binding: planted displacements come back on the rig, with pairs and without; what is wrong is named."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from engine.basis.markers import MarkerPair, bind_markers, marker_motion
from engine.errors import InputError
from engine.geometry.rigid import RigidTransform
from engine.motion import MarkerClip
from tests.engine.basis.planted_clip import HEAD, planted_clip, sample_pairs, sample_rig, with_gaps

ELSEWHERE = RigidTransform(Rotation.from_rotvec([0.15, -0.1, 0.05]).as_matrix(), np.array([40.0, 25, -30]))


@pytest.fixture(scope="module")
def mesh():
    return sample_rig().mesh


def test_planted_displacements_come_back_through_head_motion_and_another_frame(mesh):
    planted = planted_clip(placement=ELSEWHERE)
    bound = bind_markers(mesh, planted.clip, pairs=sample_pairs(), head=HEAD, rest_frame=0)
    np.testing.assert_allclose(bound.displacements, planted.displacements, atol=1e-6)
    np.testing.assert_allclose(bound.placement.rotation, ELSEWHERE.rotation, atol=1e-9)
    np.testing.assert_allclose(bound.binding.distance_mm, 0, atol=1e-6)
    np.testing.assert_allclose(bound.binding.points(mesh), bound.binding.rest, atol=1e-6)
    assert bound.head is not None
    np.testing.assert_allclose(bound.head.rotations, [pose.rotation for pose in planted.poses], atol=1e-9)
    np.testing.assert_allclose(bound.captured, bound.binding.rest + planted.displacements, atol=1e-6)
    assert (bound.filled, bound.left_out, bound.warnings) == (0, (), ())


def test_a_performer_of_another_size_is_fitted_when_asked(mesh):
    placement = RigidTransform(ELSEWHERE.rotation, ELSEWHERE.translation, 0.85)
    planted = planted_clip(frames=20, placement=placement)
    bound = bind_markers(mesh, planted.clip, pairs=sample_pairs(), head=HEAD, rest_frame=0, scale=True)
    np.testing.assert_allclose(bound.displacements, planted.displacements, atol=1e-6)
    assert bound.placement.scale == pytest.approx(0.85)
    rigid = bind_markers(mesh, planted.clip, pairs=sample_pairs(), head=HEAD, rest_frame=0)
    assert np.median(rigid.binding.distance_mm) > 3


def test_without_pairs_markers_find_their_places(mesh):
    """From somewhere else, turned by 11 degrees: every marker ends within 3 mm of where it was planted."""
    planted = planted_clip(frames=20, placement=ELSEWHERE)
    bound = bind_markers(mesh, planted.clip, head=HEAD, rest_frame=0)
    truth = np.array([mesh.vertices[pair.target] for pair in sample_pairs()])
    away = np.linalg.norm(bound.binding.points(mesh) - truth, axis=1)
    assert np.median(away) < 1.0
    assert away.max() < 3.0
    # Before the alignment they were 50 mm away.
    start = np.linalg.norm(planted.clip.positions[0, : len(truth)] - truth, axis=1)
    assert np.median(start) > 40
    moved = np.linalg.norm(planted.displacements, axis=2)
    off = np.linalg.norm(bound.displacements - planted.displacements, axis=2)
    assert off.max() < 0.05 * moved.max()


def test_gaps_are_filled_and_counted(mesh):
    planted = planted_clip(frames=400)
    clip = with_gaps(planted.clip, {"chin": slice(50, 60), "nose_tip": slice(200, 290)})
    bound = bind_markers(mesh, clip, pairs=sample_pairs(), head=HEAD, rest_frame=0)
    assert (bound.filled, bound.filled_short, bound.filled_long) == (100, 10, 90)
    assert any("10 positions filled between" in line and "90 from the other" in line for line in bound.warnings)
    assert np.isnan(bound.captured[200:290, bound.binding.labels.index("nose_tip")]).all()
    off = np.linalg.norm(bound.displacements - planted.displacements, axis=2)
    assert off.max() < 0.1 * np.linalg.norm(planted.displacements, axis=2).max()


def test_the_motion_of_the_mesh_follows_the_markers(mesh):
    planted = planted_clip(frames=12)
    bound = bind_markers(mesh, planted.clip, pairs=sample_pairs(), head=HEAD, rest_frame=0)
    motion = marker_motion(mesh, bound, method="rbf")
    assert motion.kind == "factored"
    moved = motion.displacements(7, 8)[0]
    np.testing.assert_allclose(bound.binding.on(moved, mesh.faces), planted.displacements[7], atol=1e-6)


def test_a_marker_far_from_the_face_is_warned_about(mesh):
    planted = planted_clip(frames=6)
    positions = planted.clip.positions.copy()
    positions[:, 5] += [0, 0, 40]
    clip = MarkerClip(planted.clip.labels, positions, 120)
    bound = bind_markers(mesh, clip, pairs=sample_pairs(), head=HEAD, rest_frame=0)
    label = clip.labels[5]
    assert any("further than 15 mm" in line and label in line for line in bound.warnings)


def test_a_head_that_moves_without_head_markers_is_warned_about(mesh):
    planted = planted_clip(frames=60)
    own = [pair.label for pair in sample_pairs()]
    clip = MarkerClip(own, planted.clip.positions[:, : len(own)], 120)
    assert any("choose some" in line for line in bind_markers(mesh, clip, pairs=sample_pairs()).warnings)


def test_a_paired_place_and_a_marker_without_pair(mesh):
    planted = planted_clip(frames=6)
    place = tuple(mesh.vertices[sample_pairs()[0].target].tolist())
    pairs = [MarkerPair(sample_pairs()[0].label, place), *sample_pairs()[1:-1]]
    bound = bind_markers(mesh, planted.clip, pairs=pairs, head=HEAD, rest_frame=0)
    np.testing.assert_allclose(bound.binding.points(mesh)[0], place, atol=1e-9)
    last = sample_pairs()[-1]
    assert any(last.label in line and "not paired" in line for line in bound.warnings)
    np.testing.assert_allclose(bound.binding.points(mesh)[-1], mesh.vertices[last.target], atol=0.5)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"pairs": [MarkerPair("nobody", 3)]}, "nobody"),
        ({"pairs": [*sample_pairs()[:2]]}, "at least 3"),
        ({"pairs": [*sample_pairs()[:5], sample_pairs()[0]]}, "twice"),
        ({"pairs": [*sample_pairs()[:5], MarkerPair(HEAD[0], 3)], "head": HEAD}, "head marker too"),
        ({"pairs": [*sample_pairs()[:5], MarkerPair(sample_pairs()[9].label, 10**6)]}, "outside"),
        ({"head": ("nobody", *HEAD)}, "nobody"),
        ({"rest_frame": 99}, "rest frame"),
    ],
)
def test_what_cannot_be_bound_is_named(mesh, options, words):
    with pytest.raises(InputError, match=words) as caught:
        bind_markers(mesh, planted_clip(frames=4).clip, **options)
    assert caught.value.remedy


def test_too_few_markers_to_find_the_face_ask_for_pairs(mesh):
    clip = planted_clip(frames=4).clip
    few = MarkerClip(clip.labels[:5], clip.positions[:, :5], 120)
    with pytest.raises(InputError, match="pairs"):
        bind_markers(mesh, few)
