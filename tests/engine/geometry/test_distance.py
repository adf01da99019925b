from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.geometry.distance import closest_on_triangles, closest_points, surface_distance


@given(st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_nearest_points_of_triangles_equal_the_reference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    triangles, points = rng.normal(size=(200, 3, 3)), 2 * rng.normal(size=(200, 3))
    ours = closest_on_triangles(points, triangles)
    reference = trimesh.triangles.closest_point(triangles, points)
    np.testing.assert_allclose(
        np.linalg.norm(ours - points, axis=1), np.linalg.norm(reference - points, axis=1), atol=1e-9
    )


def test_distance_is_exact_over_uneven_faces() -> None:
    rng = np.random.default_rng(1)
    ball = trimesh.creation.icosphere(subdivisions=3, radius=10)
    big = np.array([[-40.0, -12, -40], [40, -12, -40], [0, -12, 60]])
    vertices = np.vstack([ball.vertices, big])
    faces = np.vstack([ball.faces, [[len(ball.vertices) + k for k in range(3)]]])
    points = rng.uniform(-20, 20, (300, 3))
    brute = np.array([np.linalg.norm(closest_on_triangles(p, vertices[faces]) - p, axis=1).min() for p in points])
    np.testing.assert_allclose(surface_distance(points, vertices, faces), brute, atol=1e-12)
    found, face = closest_points(points, vertices, faces)
    assert np.abs(surface_distance(found, vertices, faces)).max() < 1e-12
    assert face.max() < len(faces)


def test_points_on_a_vertex_an_edge_or_a_sliver_have_a_nearest_point() -> None:
    sliver = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    np.testing.assert_allclose(closest_on_triangles(np.array([1.5, 3.0, 0]), sliver), [1.5, 0, 0])
    point = np.zeros((3, 3))
    np.testing.assert_allclose(closest_on_triangles(np.array([1.0, 2, 3]), point), [0, 0, 0])


def test_an_empty_surface_is_an_error() -> None:
    with pytest.raises(InputError, match="no faces"):
        surface_distance(np.zeros((1, 3)), np.zeros((3, 3)), np.zeros((0, 3), dtype=int))
