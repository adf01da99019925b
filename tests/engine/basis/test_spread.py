"""Spreading: exact at the markers, linear, zero far away, and no bleeding across the lips; the surface beats space."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from engine.basis.bind import barycentric
from engine.basis.markers import MarkerBinding
from engine.basis.spread import REACH_MM, spread
from engine.errors import InputError
from engine.geometry.distance import closest_points
from engine.mesh import TriangleMesh
from tests.engine.basis.planted_clip import lips, sample_pairs, sample_rig


def bound_at(mesh: TriangleMesh, points: np.ndarray) -> MarkerBinding:
    near, faces = closest_points(points, mesh.vertices, mesh.faces)
    weights = barycentric(near, mesh.vertices[mesh.faces[faces]])
    labels = tuple(f"m{k}" for k in range(len(points)))
    return MarkerBinding(labels, faces, weights, near, np.zeros(len(points)))


@pytest.fixture(scope="module")
def sample():
    mesh = sample_rig().mesh
    rng = np.random.default_rng(0)
    rest = np.array([mesh.vertices[pair.target] for pair in sample_pairs()]) + rng.normal(0, 0.7, (66, 3))
    skin = mesh.faces[mesh.parts["skin"]]
    near, faces = closest_points(rest, mesh.vertices, skin)
    weights = barycentric(near, mesh.vertices[skin[faces]])
    labels = tuple(pair.label for pair in sample_pairs())
    return mesh, MarkerBinding(labels, mesh.parts["skin"][faces], weights, near, np.zeros(66))


@pytest.fixture(scope="module")
def surface(sample):
    return spread(*sample)


@pytest.fixture(scope="module")
def space(sample):
    return spread(*sample, method="rbf")


@pytest.mark.parametrize("method", ["surface", "space"])
def test_exact_at_the_markers_and_zero_far_away(sample, method, request):
    mesh, binding = sample
    phi = request.getfixturevalue(method)
    np.testing.assert_allclose(binding.on(phi, mesh.faces), np.eye(66), atol=1e-9)
    away = cKDTree(binding.points(mesh)).query(mesh.vertices)[0]
    assert np.abs(phi[away > 1.5 * REACH_MM]).max() == 0
    assert (away > 1.5 * REACH_MM).sum() > 100
    assert np.isfinite(phi).all()
    assert not phi.flags.writeable


def test_surface_moves_all_alike_when_all_markers_do(sample, surface):
    """In the midst of the markers, a common shift of all of them shifts the skin by as much."""
    mesh, binding = sample
    total = surface.sum(axis=1)
    near = np.zeros(len(mesh.vertices), dtype=bool)
    near[np.unique(mesh.faces[binding.faces])] = True
    assert np.median(np.abs(total[near] - 1)) < 0.02


def test_surface_reproduces_the_rigs_shapes_better_than_space(sample, surface, space):
    mesh, binding = sample
    skin = sample_rig().skin
    errors = {"surface": [], "space": [], "nothing": []}
    for shape in sample_rig().basis.displacements:
        marked, size = binding.on(shape, mesh.faces), np.linalg.norm(shape[skin])
        for name, phi in (("surface", surface), ("space", space), ("nothing", 0 * surface)):
            errors[name].append(np.linalg.norm(phi[skin] @ marked - shape[skin]) / size)
    median = {name: float(np.median(values)) for name, values in errors.items()}
    assert median["surface"] < 0.85 * median["space"]
    assert median["surface"] < 0.5
    assert median["nothing"] == pytest.approx(1)


def test_parts_of_the_jaw_follow_the_chin_and_the_others_stay(sample, surface):
    mesh, binding = sample
    tongue = np.unique(mesh.faces[mesh.parts["tongue"]])
    assert np.ptp(surface[tongue], axis=0).max() < 1e-12
    chin = [binding.labels.index(label) for label in binding.labels if "chin" in label]
    assert surface[tongue[0], chin].sum() > 0.5
    eyes = np.unique(mesh.faces[mesh.parts["eyes"]])
    assert np.abs(surface[eyes]).max() == 0
    lower, upper = (np.unique(mesh.faces[mesh.parts[name]]) for name in ("teeth_lower", "teeth_upper"))
    assert surface[lower, :].sum(axis=1).min() > 0.5
    assert np.abs(surface[upper]).max() == 0


def test_of_both_rows_in_one_part_the_lower_one_follows(sample, surface):
    mesh, binding = sample
    kept = {name: faces for name, faces in mesh.parts.items() if not name.startswith("teeth")}
    both = np.concatenate([mesh.parts["teeth_upper"], mesh.parts["teeth_lower"]])
    joined = TriangleMesh(mesh.vertices, mesh.faces, parts={**kept, "teeth": both})
    np.testing.assert_array_equal(spread(joined, binding), surface)


def test_a_marker_on_the_lower_lip_does_not_move_the_upper_one():
    mesh, lower = lips()
    points = np.array([[0, -3, 0], [0, 3, 0], [-20, -12, 0], [20, -12, 0], [-20, 12, 0], [20, 12, 0.0]])
    binding = bound_at(mesh, points)
    phi = spread(mesh, binding)
    middle = np.abs(mesh.vertices[:, 0]) < 10
    rim = middle & (np.abs(mesh.vertices[:, 1]) < 1)
    upper = np.arange(len(mesh.vertices)) < lower
    assert phi[rim & ~upper, 0].min() > 0.6
    assert np.abs(phi[rim & upper, 0]).max() < 0.1
    # In space the rims, 0.1 mm apart, cannot but move together.
    through = spread(mesh, binding, method="rbf")
    assert np.abs(through[rim & upper, 0]).min() > 0.3


def test_a_rigid_shift_of_a_floating_sheet_is_exact():
    """No vertex is out of reach: nothing is held, and all go along."""
    mesh, lower = lips()
    sheet = TriangleMesh(mesh.vertices[:lower], mesh.faces[(mesh.faces < lower).all(axis=1)])
    phi = spread(sheet, bound_at(sheet, np.array([[0, 15, 0], [-20, 10, 0], [20, 20, 0.0]])), reach_mm=1e4)
    np.testing.assert_allclose(phi.sum(axis=1), 1, atol=1e-3)


def test_pieces_without_a_marker_stay_still():
    mesh, lower = lips()
    apart = TriangleMesh(
        np.vstack([mesh.vertices, mesh.vertices + np.array([0, 0, 2])]),
        np.vstack([mesh.faces, mesh.faces + len(mesh.vertices)]),
    )
    for method in ("surface", "rbf"):
        phi = spread(apart, bound_at(apart, np.array([[0, 5, 0], [10, 9, 0], [3, -8, 0.0]])), method)
        assert np.abs(phi[len(mesh.vertices) :]).max() == 0
        assert np.abs(phi[:lower]).max() > 0.9


@pytest.mark.parametrize("method", ["surface", "rbf"])
def test_markers_in_one_place_are_refused(method):
    mesh, _ = lips()
    with pytest.raises(InputError, match="m0, m1"):
        spread(mesh, bound_at(mesh, np.array([[0, 5, 0], [0, 5.01, 0], [9, 9, 0.0]])), method)


def test_more_markers_than_a_triangle_can_tell_apart_are_refused():
    mesh = TriangleMesh([[0, 0, 0], [50, 0, 0], [0, 50, 0], [50, 50, 0]], [[0, 1, 2], [1, 3, 2]])
    points = np.array([[5, 5, 0], [20, 5, 0], [5, 20, 0], [12, 12, 0.0]])
    with pytest.raises(InputError, match="three sit in one triangle"):
        spread(mesh, bound_at(mesh, points))


def test_an_unknown_method_is_refused():
    mesh, _ = lips()
    with pytest.raises(InputError, match="surface or rbf"):
        spread(mesh, bound_at(mesh, np.array([[0, 5, 0.0]])), "best")
