from __future__ import annotations

import numpy as np
import pytest
import trimesh

import resources
from engine.errors import InputError
from engine.files.template import read_template
from engine.geometry.harmonic import harmonic_fill
from engine.geometry.normals import face_normals, signed_areas, smallest_angles, vertex_normals
from engine.geometry.sampling import sample_bilinear, valid_share
from engine.geometry.subdivide import one_to_four, subdivision, unique_edges
from engine.mesh import TriangleMesh

TEMPLATE = read_template(resources.template_path())


def bowl(seed: int = 0) -> TriangleMesh:
    flat = TEMPLATE.layout("open").vertices
    height = 0.002 * (flat**2).sum(axis=1, keepdims=True) + np.random.default_rng(seed).normal(0, 0.3, (len(flat), 1))
    return TriangleMesh(np.hstack([flat, height]), TEMPLATE.faces, uv=flat / 400, parts={"some": np.arange(40)})


def test_subdivision_counts_are_those_of_the_paper() -> None:
    assert [TEMPLATE.refine(level).weights.shape[0] for level in range(4)] == [441, 1686, 6588, 26040]
    assert [len(TEMPLATE.refine(level).faces) for level in range(4)] == [804, 3216, 12864, 51456]


def test_subdivision_keeps_old_vertices_area_and_parents() -> None:
    mesh = bowl()
    fine = subdivision(mesh.faces, len(mesh.vertices), 2)
    vertices = fine.apply(mesh.vertices)
    np.testing.assert_array_equal(vertices[: len(mesh.vertices)], mesh.vertices)
    coarse_normals = face_normals(mesh.vertices, mesh.faces)
    summed = np.zeros_like(coarse_normals)
    np.add.at(summed, fine.parent_faces, face_normals(vertices, fine.faces))
    np.testing.assert_allclose(summed, coarse_normals, atol=1e-9)
    assert np.asarray(fine.weights.sum(axis=1)) == pytest.approx(1.0)


def test_subdivided_mesh_equals_the_reference_and_stays_closed_where_it_was() -> None:
    mesh = bowl()
    fine = one_to_four(mesh, 1)
    reference_vertices, reference_faces = trimesh.remesh.subdivide(mesh.vertices, mesh.faces)

    def triangles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
        middles = vertices[faces].mean(axis=1)
        return middles[np.lexsort(middles.round(9).T)]

    np.testing.assert_allclose(
        triangles(fine.vertices, fine.faces), triangles(reference_vertices, reference_faces), atol=1e-9
    )
    _, sides = unique_edges(fine.faces)
    assert (np.bincount(sides.ravel()) == 1).sum() == 2 * 78
    assert len(fine.parts["some"]) == 160
    np.testing.assert_allclose(fine.uv, fine.vertices[:, :2] / 400)


def test_absurd_levels_are_refused() -> None:
    with pytest.raises(InputError, match="levels"):
        subdivision(TEMPLATE.faces, 441, 12)


def test_normals_are_those_of_a_reference_library() -> None:
    mesh = bowl()
    reference = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    ours = face_normals(mesh.vertices, mesh.faces)
    np.testing.assert_allclose(np.linalg.norm(ours, axis=1) / 2, reference.area_faces)
    by_area = trimesh.geometry.weighted_vertex_normals(
        441, mesh.faces, reference.face_normals, np.repeat(reference.area_faces[:, None], 3, axis=1)
    )
    np.testing.assert_allclose(vertex_normals(mesh.vertices, mesh.faces), by_area, atol=1e-9)
    np.testing.assert_allclose(smallest_angles(mesh.vertices, mesh.faces), reference.face_angles.min(axis=1), atol=1e-9)


def test_signed_area_tells_a_fold() -> None:
    flat = TEMPLATE.layout("open").vertices
    assert (signed_areas(flat, TEMPLATE.faces) > 0).all()
    folded = flat.copy()
    folded[TEMPLATE.layout("open").fiducials["nose_tip"]] += [40, 0]
    assert (signed_areas(folded, TEMPLATE.faces) <= 0).any()


def test_bilinear_sampling_is_exact_on_planes_and_ignores_holes() -> None:
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(np.arange(40.0), np.arange(30.0))
    image = np.stack([2 * x - 3 * y + 1, x * y], axis=2)
    place = rng.uniform(0, 1, (500, 2)) * [39, 29]
    values, weight = sample_bilinear(image, place)
    np.testing.assert_allclose(values[:, 0], 2 * place[:, 0] - 3 * place[:, 1] + 1)
    np.testing.assert_allclose(values[:, 1], place[:, 0] * place[:, 1])
    assert weight == pytest.approx(1.0)
    holed = np.full((4, 4, 1), 900.0)
    holed[1, 1] = np.nan
    values, weight = sample_bilinear(holed, np.array([[1.25, 1.25], [1.5, 1.0], [9.0, 1.0], [1.02, 1.02]]))
    np.testing.assert_allclose(values[:2, 0], 900.0)
    assert weight[0] == pytest.approx(1 - 0.75**2)
    assert np.isnan(values[2:, 0]).all()


def test_nothing_is_read_halfway_across_a_step() -> None:
    depth = np.where(np.arange(8) < 4, 600.0, 615.0)[None, :, None].repeat(6, axis=0)
    place = np.array([[3.2, 2.5], [3.8, 2.5], [1.5, 2.5]])
    bridged, _ = sample_bilinear(depth, place)
    np.testing.assert_allclose(bridged[:, 0], [603.0, 612.0, 600.0])
    kept, weight = sample_bilinear(depth, place, step=3.0)
    np.testing.assert_allclose(kept[:, 0], [600.0, 615.0, 600.0])
    np.testing.assert_allclose(weight, [0.8, 0.8, 1.0])
    np.testing.assert_allclose(valid_share(depth[..., 0] < 610, place), [0.8, 0.2, 1.0])


def test_harmonic_fill_continues_a_plane_and_reports_islands() -> None:
    flat = TEMPLATE.layout("open").vertices
    plane = flat @ np.array([[0.3], [-0.2]]) + 5
    inside = np.linalg.norm(flat - flat[TEMPLATE.layout("open").fiducials["nose_tip"]], axis=1) < 60
    filled, reached = harmonic_fill(np.where(inside[:, None], np.nan, plane), ~inside, TEMPLATE.faces, flat)
    # The lip slit is a border inside the hole: only away from it is the fill the plane.
    away = np.linalg.norm(flat - [0, 317], axis=1) > 45
    assert reached.all()
    np.testing.assert_allclose(filled[away & ~inside], plane[away & ~inside])
    eye = np.linalg.norm(flat - [50, 210], axis=1) < 25
    filled, _ = harmonic_fill(np.where(eye[:, None], np.nan, plane), ~eye, TEMPLATE.faces, flat)
    np.testing.assert_allclose(filled, plane, atol=1e-9)

    twice = np.vstack([flat, flat])
    faces = np.vstack([TEMPLATE.faces, TEMPLATE.faces + 441])
    known = np.arange(882) < 441
    filled, reached = harmonic_fill(np.vstack([plane, plane * np.nan]), known, faces, twice)
    np.testing.assert_array_equal(reached, known)
    assert np.isnan(filled[441:]).all()


def test_the_template_is_what_it_says() -> None:
    edges, sides = unique_edges(TEMPLATE.faces)
    assert (len(TEMPLATE.mirror), len(TEMPLATE.faces), len(edges)) == (441, 804, 1245)
    assert (np.bincount(sides.ravel()) == 1).sum() == 78
    np.testing.assert_array_equal(TEMPLATE.mirror[TEMPLATE.mirror], np.arange(441))
    mirrored = TEMPLATE.mirror[TEMPLATE.faces][:, ::-1]
    assert {frozenset(face) for face in mirrored.tolist()} == {frozenset(face) for face in TEMPLATE.faces.tolist()}
    for name, count in (("closed", 20), ("open", 26)):
        layout = TEMPLATE.layout(name)
        assert len(layout.fiducials) == count
        np.testing.assert_allclose(layout.vertices[TEMPLATE.mirror], layout.vertices * [-1, 1], atol=1e-9)
        assert (signed_areas(layout.vertices, TEMPLATE.faces) > 0).all()
        angles = smallest_angles(np.pad(layout.vertices, ((0, 0), (0, 1))), TEMPLATE.faces)
        assert np.degrees(angles.min()) > 12
        assert np.degrees(np.median(angles)) > 44
    slit = TEMPLATE.layout("open").vertices - TEMPLATE.layout("closed").vertices
    width = np.ptp(
        TEMPLATE.layout("open").vertices[
            [TEMPLATE.layout("open").fiducials[n] for n in ("mouth_left", "mouth_right")], 0
        ]
    )
    assert 0.1 * width < np.ptp(slit[:, 1]) < 0.4 * width
