"""The other side of a face: planted permutations are found by walking, where nearest points would be wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.errors import InputError
from engine.mesh import TriangleMesh
from engine.mirror_map import mid_plane, mirror_map, mirrored
from tests.engine.mirror_samples import half_face, uneven

ICT = Path(__file__).parents[3] / "shared" / "data" / "rigs" / "ict_facekit.npz"


@pytest.mark.parametrize("seed", range(4))
def test_the_planted_mirror_is_found_over_the_mesh(seed: int) -> None:
    face = half_face(seed=seed)
    found = mirror_map(face.mesh)
    assert (found.how, found.walked, len(found.unmatched)) == ("topological", len(face.mirror), 0)
    np.testing.assert_array_equal(found.vertices, face.mirror)
    assert abs(found.middle) < 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_an_unevenly_sculpted_face_is_paired_where_nearest_points_fail(seed: int) -> None:
    face = half_face(seed=seed)
    mesh = uneven(face, seed=seed + 10)
    found = mirror_map(mesh)
    np.testing.assert_array_equal(found.vertices, face.mirror)
    reflected = mesh.vertices * [-1, 1, 1] + [2 * found.middle, 0, 0]
    nearest = np.linalg.norm(reflected[:, None] - mesh.vertices[None], axis=2).argmin(axis=1)
    assert (nearest != face.mirror).mean() > 0.05  # the control: by the plane alone it would be wrong


def test_triangles_that_are_cut_symmetrically_are_walked_as_they_are() -> None:
    face = half_face(shuffled=False, eyes=False)
    right = face.mesh.vertices[face.mesh.faces][:, :, 0].mean(axis=1) < 0
    own = face.mesh.faces[right]
    rng = np.random.default_rng(0)
    faces = np.concatenate([own, face.mirror[own][:, ::-1]])
    # Neighbours do not follow each other any more, so that no quadrilateral can be put together.
    mesh = TriangleMesh(face.mesh.vertices, faces[rng.permutation(len(faces))])
    found = mirror_map(mesh)
    assert found.how == "topological"
    np.testing.assert_array_equal(found.vertices, face.mirror)


def test_a_face_with_sides_connected_in_different_ways_is_paired_by_the_plane_and_says_so() -> None:
    face = half_face(eyes=False)
    x = face.mesh.vertices[face.mesh.faces][:, :, 0].mean(axis=1)
    hole = (x > 30) & (np.arange(len(x)) % 5 == 0)
    mesh = TriangleMesh(face.mesh.vertices, face.mesh.faces[~hole])
    found = mirror_map(mesh)
    assert found.how == "by plane" and len(found.unmatched) == 0
    used = np.unique(mesh.faces)
    there = used[np.isin(face.mirror[used], used)]
    np.testing.assert_array_equal(found.vertices[there], face.mirror[there])
    far = mesh.vertices.copy()
    lost = used[np.argsort(far[used, 0])[-5:]]
    far[lost] += [60.0, 0, 0]
    assert set(lost) <= set(mirror_map(mesh.with_vertices(far)).unmatched)


def test_the_middle_may_lie_beside_the_origin() -> None:
    face = half_face()
    moved = face.mesh.with_vertices(face.mesh.vertices + np.array([13.7, 5, 2]))
    assert mid_plane(moved) == pytest.approx(13.7, abs=1e-6)
    np.testing.assert_array_equal(mirror_map(moved).vertices, face.mirror)


def test_a_mirrored_shape_moves_the_other_side_the_other_way() -> None:
    face = half_face()
    pairs = mirror_map(face.mesh)
    shape = np.zeros_like(face.mesh.vertices)
    shape[5] = [1, 2, 3]
    seen = mirrored(shape, pairs)
    assert np.flatnonzero(seen.any(axis=1)).tolist() == [face.mirror[5]]
    np.testing.assert_array_equal(seen[face.mirror[5]], [-1, 2, 3])


def test_no_faces_no_sides() -> None:
    with pytest.raises(InputError, match="no faces"):
        mirror_map(TriangleMesh(np.eye(3), np.zeros((0, 3), dtype=int)))


@pytest.mark.skipif(not ICT.exists(), reason="needs ../shared/data/rigs/ict_facekit.npz")
def test_most_of_the_light_stage_head_is_walked() -> None:
    from engine.files.rig import read_rig

    mesh = read_rig(ICT).rig.mesh
    found = mirror_map(mesh)
    assert found.walked > 0.85 * len(mesh.vertices) and not len(found.unmatched)
    reflected = mesh.vertices * [-1, 1, 1] + [2 * found.middle, 0, 0]
    assert np.linalg.norm(reflected - mesh.vertices[found.vertices], axis=1).max() < 0.3
