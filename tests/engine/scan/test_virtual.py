"""The virtual scanner against analytic surfaces, and the bundled sample against its truth."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

import resources
from engine.errors import InputError
from engine.files.scheme import read_scheme
from engine.mesh import TriangleMesh
from engine.scan.range_image import Camera
from engine.scan.raster import cast_rays, rasterise
from engine.scan.virtual import VirtualScanner, frontal_camera, visible_points

from . import truth

CAMERA = Camera(130.0, 126.0, 63.2, 47.9)
SIZE = (128, 96)


def wall(depth: float = 600.0, slope: tuple[float, float] = (0.0, 0.0), half: float = 600.0) -> TriangleMesh:
    """Two triangles of the plane z = -depth + slope . (x, y)."""
    xy = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    corners = np.column_stack([xy, -depth + xy @ slope])
    return TriangleMesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), uv=np.array([[0.0, 1], [1, 1], [1, 0], [0, 0]]))


def ball(radius: float = 100.0, distance: float = 650.0, subdivisions: int = 5) -> TriangleMesh:
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return TriangleMesh(sphere.vertices + np.array([3.0, -2.0, -distance]), sphere.faces)


def rays(camera: Camera, width: int, height: int) -> np.ndarray:
    return camera.points(np.ones((height, width)))


@settings(max_examples=20, deadline=None)
@given(st.floats(300, 1200), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_a_plane_is_met_where_the_ray_meets_it(depth: float, along_x: float, along_y: float) -> None:
    raster = rasterise(wall(depth, (along_x, along_y), half=depth), CAMERA, *SIZE)
    ray = rays(CAMERA, *SIZE)
    analytic = depth / (1 + ray[..., 0] * along_x + ray[..., 1] * along_y)
    assert (raster.face_index >= 0).all()
    np.testing.assert_allclose(-raster.points[..., 2], analytic, rtol=0, atol=1e-9)
    np.testing.assert_allclose(raster.points, ray * analytic[..., None], rtol=0, atol=1e-9)


def test_barycentric_weights_rebuild_the_points_in_perspective() -> None:
    mesh = ball()
    raster = rasterise(mesh, CAMERA, *SIZE)
    hit = raster.face_index >= 0
    rebuilt = raster.interpolate(mesh.faces, mesh.vertices)
    np.testing.assert_allclose(rebuilt[hit], raster.points[hit], rtol=0, atol=1e-8)
    np.testing.assert_allclose(raster.barycentric[hit].sum(axis=1), 1, atol=1e-12)
    assert raster.barycentric[hit].min() > -1e-7


def test_a_sphere_is_seen_within_its_facets_and_only_its_front() -> None:
    radius, distance = 100.0, 650.0
    mesh = ball(radius, distance)
    raster = rasterise(mesh, CAMERA, *SIZE)
    ray = rays(CAMERA, *SIZE)
    centre = np.array([3.0, -2.0, -distance])
    square, along = (ray**2).sum(axis=2), ray @ centre
    root = along**2 - square * (centre @ centre - radius**2)
    expected = np.where(root > 0, (along - np.sqrt(np.maximum(root, 0))) / square, np.nan)
    middle = root > 0.1 * root.max()
    sagitta = radius - np.linalg.norm(mesh.vertices[mesh.faces].mean(axis=1) - centre, axis=1).min()
    depth = -raster.points[..., 2]
    assert (raster.face_index[middle] >= 0).all()
    assert not (raster.face_index[root < 0] >= 0).any()
    cosine = np.sqrt(root[middle] / (square[middle] * radius**2))
    assert ((depth - expected)[middle] > -1e-9).all()
    assert ((depth - expected)[middle] * np.sqrt(square[middle]) < 1.05 * sagitta / cosine).all()


def test_the_z_buffer_agrees_with_solving_every_ray_and_triangle() -> None:
    rng = np.random.default_rng(3)
    corners = rng.normal(0, 90, (60, 3, 3)) + np.array([0, 0, -700])
    mesh = TriangleMesh(corners.reshape(-1, 3), np.arange(180).reshape(-1, 3))
    raster = rasterise(mesh, CAMERA, *SIZE)
    ray = rays(CAMERA, *SIZE).reshape(-1, 3)
    nearest, which = np.full(len(ray), np.inf), np.full(len(ray), -1)
    for k, (a, b, c) in enumerate(corners):
        system = np.stack([ray, np.broadcast_to(a - b, ray.shape), np.broadcast_to(a - c, ray.shape)], axis=2)
        depth, u, v = np.linalg.solve(system, np.broadcast_to(a, ray.shape)[..., None])[..., 0].T
        closer = (u >= 0) & (v >= 0) & (u + v <= 1) & (depth < nearest)
        nearest[closer], which[closer] = depth[closer], k
    assert len(np.unique(which)) > 40
    assert (which != raster.face_index.ravel()).mean() < 1e-3  # a ray along an edge may go either way
    same = (which >= 0) & (which == raster.face_index.ravel())
    np.testing.assert_allclose(-raster.points[..., 2].ravel()[same], nearest[same], rtol=0, atol=1e-8)


def test_no_ray_slips_between_two_triangles() -> None:
    rng = np.random.default_rng(5)
    x, y = np.meshgrid(np.linspace(-400, 400, 41), np.linspace(-330, 330, 31))
    points = np.column_stack([x.ravel(), y.ravel(), -600 + rng.normal(0, 4, x.size)])
    points[:, :2] += rng.normal(0, 3, (x.size, 2))
    a = (np.arange(30)[:, None] * 41 + np.arange(40)).ravel()
    mesh = TriangleMesh(points, np.vstack([np.column_stack([a, a + 1, a + 42]), np.column_stack([a, a + 42, a + 41])]))
    assert (rasterise(mesh, CAMERA, *SIZE, supersampling=3).face_index >= 0).all()
    vertices = points[np.abs(points[:, :2] / [400, 330]).max(axis=1) < 0.9]
    pixels, seen = visible_points(mesh, CAMERA, vertices)
    assert (cast_rays(mesh, CAMERA, pixels).face_index >= 0).all()
    assert seen.mean() > 0.95


def test_noise_lies_along_the_ray_with_the_stated_deviation() -> None:
    scanner = VirtualScanner(CAMERA, *SIZE, noise_mm=0.15, spike_fraction=0.0, grazing_limit_deg=90.0)
    result = scanner.scan(wall(600, (0.1, -0.2)), seed=4)
    error = result.scan.points - result.truth_points
    direction = result.truth_points / np.linalg.norm(result.truth_points, axis=2, keepdims=True)
    along = (error * direction).sum(axis=2)
    np.testing.assert_allclose(error, along[..., None] * direction, atol=1e-9)
    count = along.size
    assert abs(along.mean()) < 5 * 0.15 / np.sqrt(count)
    assert abs(along.std() - 0.15) < 5 * 0.15 / np.sqrt(2 * count)
    assert abs(np.corrcoef(along[:, 1:].ravel(), along[:, :-1].ravel())[0, 1]) < 5 / np.sqrt(count)


def test_spikes_have_the_stated_share_size_and_both_signs() -> None:
    scanner = VirtualScanner(CAMERA, *SIZE, noise_mm=0.0, spike_fraction=0.02, spike_range_mm=(4.0, 30.0))
    result = scanner.scan(wall(), seed=9)
    away = np.linalg.norm(result.scan.points, axis=2) - np.linalg.norm(result.truth_points, axis=2)
    size = away[result.spikes]
    np.testing.assert_array_equal(np.abs(away) > 1e-6, result.spikes)
    share = result.spikes.mean()
    assert abs(share - 0.02) < 5 * np.sqrt(0.02 * 0.98 / result.spikes.size)
    assert np.abs(size).min() >= 4.0 - 1e-9 and np.abs(size).max() <= 30.0 + 1e-9
    assert 0.3 < (size > 0).mean() < 0.7


def test_the_seed_decides_everything() -> None:
    scanner = VirtualScanner(CAMERA, *SIZE)
    first, again, other = (scanner.scan(ball(), seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.scan.points, again.scan.points)
    np.testing.assert_array_equal(first.spikes, again.spikes)
    assert not np.array_equal(first.scan.points, other.scan.points, equal_nan=True)
    np.testing.assert_array_equal(first.truth_points, other.truth_points)


def test_lost_pixels_follow_vertices_faces_texels_and_grazing_angles() -> None:
    mesh = wall(half=320)
    scanner = VirtualScanner(CAMERA, *SIZE, spike_fraction=0.0)
    by_face = scanner.scan(mesh, lost=np.array([1.0, 0.0]))
    np.testing.assert_array_equal(by_face.lost, by_face.face_index == 0)
    by_vertex = scanner.scan(mesh, lost=np.array([1.0, 0.0, 1.0, 0.0]))  # 1 along a diagonal, less beside it
    off_diagonal = np.abs(by_vertex.truth_points[..., 0] - by_vertex.truth_points[..., 1])
    np.testing.assert_array_equal(by_vertex.lost, off_diagonal < 320)
    picture = np.zeros((2, 2))
    picture[0, 1] = 1  # top right
    by_texel = scanner.scan(mesh, lost_texture=picture)
    np.testing.assert_array_equal(by_texel.lost, (by_texel.truth_points[..., :2] > 0).all(axis=2))
    np.testing.assert_array_equal(~by_texel.scan.valid, by_texel.lost)
    steep = VirtualScanner(CAMERA, *SIZE, grazing_limit_deg=60.0).scan(ball())
    normal = steep.truth_points - [3.0, -2.0, -650.0]
    cosine = -(normal * steep.truth_points).sum(axis=2)
    cosine /= np.linalg.norm(normal, axis=2) * np.linalg.norm(steep.truth_points, axis=2)
    clear = (steep.face_index >= 0) & (np.abs(cosine - 0.5) > 0.05)
    np.testing.assert_array_equal(steep.lost[clear], (cosine < 0.5)[clear])


def test_the_picture_is_the_texture_seen_through_the_pinhole() -> None:
    mesh = wall(600, half=600 * 0.6)
    ramp = np.zeros((64, 64, 3), np.uint8)
    ramp[..., 0] = np.linspace(0, 252, 64)[None, :]
    ramp[..., 1] = np.linspace(0, 252, 64)[:, None]
    result = VirtualScanner(Camera(100, 100, 49.5, 49.5), 100, 100).scan(mesh, texture=ramp)
    half = VirtualScanner(Camera(100, 100, 49.5, 49.5), 100, 100).scan(
        mesh, texture=ramp, colours=np.full((4, 3), 127.5)
    )
    seen = result.face_index >= 0
    u = (result.truth_points[..., 0] / 360 + 1) / 2 * 64 - 0.5
    v = (1 - result.truth_points[..., 1] / 360) / 2 * 64 - 0.5
    assert result.scan.colour is not None and half.scan.colour is not None
    assert np.abs(result.scan.colour[..., 0] - np.clip(u, 0, 63) * 4)[seen].max() < 2
    assert np.abs(result.scan.colour[..., 1] - np.clip(v, 0, 63) * 4)[seen].max() < 2
    assert np.abs(half.scan.colour.astype(float) * 2 - result.scan.colour)[seen].max() <= 3


@given(st.floats(20, 300), st.floats(20, 300), st.floats(0, 200))
def test_a_framed_mesh_fills_the_picture_and_no_more(width: float, height: float, depth: float) -> None:
    corners = np.array([[-width, -height, -depth], [width, height, depth]]) / 2 + [40.0, -7.0, 900.0]
    camera, shift = frontal_camera(corners, 640, 480, 650.0, fill=0.9)
    middle = corners.mean(axis=0) + shift
    np.testing.assert_allclose(middle, [0, 0, -650], atol=1e-9)
    flat = (corners - corners.mean(axis=0)) * [1, 1, 0] + middle
    low, high = camera.project(flat)
    share = np.abs(high - low) / [640, 480]
    assert share.max() == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"texture": np.zeros((4, 4, 3), np.uint8)}, "texture"),
        ({"colours": np.zeros((5, 3))}, "colours"),
        ({"lost": np.zeros(5)}, "lost"),
    ],
)
def test_what_does_not_fit_the_mesh_is_named(arguments: dict[str, np.ndarray], word: str) -> None:
    with pytest.raises(InputError, match=word):
        VirtualScanner(CAMERA, *SIZE).scan(ball(), **arguments)  # type: ignore[arg-type]


def test_meshes_that_cannot_be_scanned_are_refused() -> None:
    behind = ball(distance=50.0)
    with pytest.raises(InputError, match="behind the camera"):
        VirtualScanner(CAMERA, *SIZE).scan(behind)
    aside = ball()
    with pytest.raises(InputError, match="not seen"):
        VirtualScanner(CAMERA, *SIZE).scan(aside.with_vertices(aside.vertices + np.array([5000.0, 0, 0])))
    with pytest.raises(InputError, match="odd"):
        VirtualScanner(CAMERA, *SIZE, supersampling=2)


# The bundled sample


def test_the_sample_is_complete_and_small() -> None:
    folder = resources.sample_path()
    shipped = [p for p in folder.rglob("*") if p.is_file() and "build" not in p.parts and "__pycache__" not in p.parts]
    assert sum(p.stat().st_size for p in shipped) <= 15e6
    entries = tomllib.loads(resources.sample_path("sample.toml").read_text())["scan"]
    assert [e["id"] for e in entries] == list(truth.SCANS)
    for entry in entries:
        assert all(resources.sample_path(*entry[key].split("/")).is_file() for key in ("scan", "fiducials", "skin"))
        assert entry["scheme"] == truth.scheme_of(entry["id"])
        assert entry["held"] in entry["word"]


@pytest.mark.parametrize("name", truth.SCANS)
def test_fiducials_are_exact_visible_and_complete(name: str) -> None:
    scan, fiducials = truth.bundled_scan(name)
    scheme = read_scheme(resources.scheme_path(truth.scheme_of(name)))
    assert set(fiducials) == set(scheme.names)
    true = truth.true_scan(name)
    positions = np.array([true.position(n) for n in fiducials])
    pixels, seen = visible_points(true.mesh, truth.camera(name), positions)
    assert seen.all(), [n for n, s in zip(fiducials, seen, strict=True) if not s]
    stored = np.array(list(fiducials.values()))
    assert np.abs(stored - pixels).max() < 1e-3
    hits = cast_rays(true.mesh, truth.camera(name), stored)
    assert np.linalg.norm(hits.points - positions, axis=1).max() < 0.05
    assert np.isin(hits.face_index, true.skin).all()
    assert (stored > 0).all() and (stored < [scan.width - 1, scan.height - 1]).all()


@pytest.mark.parametrize("name", truth.SUBJECT_SCANS)
def test_the_lower_lip_point_is_where_the_red_ends_in_the_picture(name: str) -> None:
    scan, fiducials = truth.bundled_scan(name)
    assert scan.colour is not None
    x, y = fiducials["lip_lower"]
    red, green, _ = np.asarray(scan.colour, dtype=float)[:, round(x) - 3 : round(x) + 4].mean(axis=1).T
    rows = np.arange(round(y) - 6, round(y) + 13)
    ratio = (green / red)[rows]
    paler = ratio > (np.median(ratio[:5]) + np.median(ratio[-5:])) / 2
    assert not paler[:5].any() and paler[-5:].all()
    border = rows[np.argmax(paler)] - 0.5
    assert -1 < border - y < 3, border - y


def test_a_lip_that_hides_its_border_alone_has_a_point_of_its_own() -> None:
    heads = truth.heads()
    own = {
        (name, scan)
        for scan in heads.scans
        for name, vertex in heads.fiducials_of(scan).items()
        if vertex != heads.fiducials[name]
    }
    assert own == {("lip_lower", "car"), ("lip_lower", "she"), ("lip_lower", "too")}


@pytest.mark.parametrize("name", truth.SCANS)
def test_a_stored_scan_is_the_truth_plus_the_stated_noise(name: str) -> None:
    scan, _ = truth.bundled_scan(name)
    true = truth.true_scan(name)
    seen = rasterise(true.mesh, truth.camera(name), scan.width, scan.height)
    assert not (scan.valid & (seen.face_index < 0)).any()
    error = (np.linalg.norm(scan.points, axis=2) - np.linalg.norm(seen.points, axis=2))[scan.valid]
    spikes = np.abs(error) > 2.0
    assert abs(spikes.mean() - 0.003) < 0.0006
    assert np.abs(error[spikes]).min() > 3.0 and np.abs(error[spikes]).max() < 31.0
    calm = error[~spikes]
    assert abs(calm.mean()) < 0.003
    assert abs(calm.std() - 0.15) < 0.003
    lost = ((seen.face_index >= 0) & ~scan.valid).sum() / (seen.face_index >= 0).sum()
    assert 0.01 < lost < 0.10


def test_ten_anatomical_points_are_on_the_skin_of_both_people_and_in_no_scheme() -> None:
    assert len(truth.heads().anatomy) == 10
    assert not set(truth.heads().anatomy) & set(read_scheme(resources.scheme_path("open")).names)
    for name in ("base", truth.STRANGER):
        true = truth.true_scan(name)
        positions = np.array([true.position(n) for n in truth.heads().anatomy])
        assert visible_points(true.mesh, truth.camera(name), positions)[1].all()


def test_the_stranger_is_no_copy_of_the_subject() -> None:
    """Other proportions, not only another size: what a similarity transform leaves over is millimetres."""
    names = [n for n in truth.heads().fiducials if "inner" not in n or "lip" not in n]
    subject, stranger = (np.array([truth.true_scan(s).position(n) for n in names]) for s in ("base", "stranger"))
    a, b = subject - subject.mean(axis=0), stranger - stranger.mean(axis=0)
    left, size, right = np.linalg.svd(b.T @ a)
    rotation = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    rest = b - (size.sum() / (a**2).sum()) * a @ rotation.T
    assert np.sqrt((rest**2).sum(axis=1).mean()) > 3.0
