"""A virtual camera before a mesh: what is planted is seen, points go there and back, fiducials move along."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import resources
from engine.errors import Cancelled, InputError
from engine.files.glb import write_glb
from engine.files.images import read_image
from engine.files.mesh_file import read_mesh
from engine.files.obj import write_obj
from engine.files.scan import read_scan
from engine.files.template import read_template
from engine.geometry.distance import surface_distance
from engine.mesh import TriangleMesh
from engine.scan.fit import fit_template
from engine.scan.mesh_preview import light_copy, vertex_colours
from engine.scan.mesh_view import MeshView, view_mesh, whole_view
from engine.scan.reproject import reproject
from engine.scan.virtual import visible_points
from resources.sample.head import Heads
from tests.engine.files.mesh_samples import bumpy, checks

DATA = Path(__file__).resolve().parents[4] / "shared" / "data"
ANGLES = st.floats(-179, 179)


class Thing:
    def __init__(self, mesh: TriangleMesh, texture: object = None, colours: object = None) -> None:
        self.mesh, self.texture, self.colours = mesh, texture, colours


@given(ANGLES, st.floats(-90, 90), ANGLES, st.floats(1, 1000))
def test_angles_and_points_there_and_back(turn: float, tilt: float, roll: float, scale: float) -> None:
    view = MeshView(look_at_mm=(3.0, -4.0, 5.0)).turned(turn, tilt, roll)
    again = view.turned(*view.angles_deg)
    np.testing.assert_allclose(again.matrix, view.matrix, atol=1e-6)
    points = np.array([[0.0, 0, 0], [30, 10, -20], [3, -4, 5]])
    np.testing.assert_allclose(view.into_mesh(view.into_camera(points)), points, atol=1e-9)
    np.testing.assert_allclose(view.project(points)[2], [299.5, 399.5])
    np.testing.assert_allclose(view.scaled(0.5).project(points * 0.5), view.project(points), atol=1e-6)
    np.testing.assert_allclose(view.project(points / scale, scale), view.project(points), atol=1e-6)


def test_every_pixel_lies_on_the_mesh_and_has_its_colour() -> None:
    mesh = bumpy(60, 80)
    view = whole_view(mesh, 150, 200).turned(20, -10, 5)
    uv, texture = mesh.uv, checks(640, 480)
    scan = view_mesh(Thing(mesh, texture), view)
    points = view.into_mesh(scan.points[scan.valid])
    assert surface_distance(points[::50], mesh.vertices, mesh.faces).max() < 1e-6
    rows, columns = np.nonzero(scan.valid)
    np.testing.assert_allclose(view.project(points), np.column_stack([columns, rows]), atol=1e-6)
    assert scan.colour is not None and uv is not None
    # Red says how far to the right in the chart a pixel lies; so it grows with the angle about the axis.
    angle = np.mod(np.arctan2(points[:, 2], points[:, 0]) / (2 * np.pi), 1.0)
    red = scan.colour[rows, columns, 0] / 255
    inner = (angle > 0.05) & (angle < 0.95)
    assert np.corrcoef(angle[inner], red[inner])[0, 1] > 0.999
    assert np.median(np.abs(angle - red)[inner]) < 0.01


def test_nothing_grazing_nothing_behind_and_a_word_where_nothing_is_seen() -> None:
    mesh = bumpy(60, 80)
    view = whole_view(mesh, 150, 200)
    scan = view_mesh(Thing(mesh), view)
    assert scan.colour is None
    steep = np.abs(np.diff(scan.points[..., 2], axis=0))
    assert np.nanmax(steep) < 60
    inside = MeshView(distance_mm=30.0, field_of_view_deg=60, width=60, height=80)
    assert np.nanmax(view_mesh(Thing(mesh), inside).points[..., 2]) < 0
    with pytest.raises(InputError, match="no pixel sees"):
        view_mesh(Thing(mesh), MeshView(look_at_mm=(5000.0, 0, 0)))
    for wrong in ({"distance_mm": 1.0}, {"width": 100_000}, {"field_of_view_deg": 179.0}, {"rotation": (np.nan, 0, 0)}):
        with pytest.raises(InputError):
            MeshView(**wrong)


def sheets(count: int) -> TriangleMesh:
    """Return large triangles one behind the other, every one over the whole picture; the first is the nearest."""
    z = -0.1 * np.arange(count)[:, None]
    corners = np.stack(
        [np.hstack([np.broadcast_to(xy, (count, 2)), z]) for xy in ((-900, -900), (2700, -900), (-900, 2700))]
    )
    return TriangleMesh(corners.transpose(1, 0, 2).reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def test_more_faces_one_behind_the_other_than_can_be_looked_through_are_refused_before_the_work() -> None:
    view, told = MeshView(), []
    for count in (500, 20_000):
        with pytest.raises(InputError, match=f"overlap {count} times"):
            view_mesh(Thing(sheets(count)), view, lambda share, text: told.append(share))
    assert told == [0.0, 0.0]
    few = view_mesh(Thing(sheets(10)), view, lambda share, text: told.append(share))
    np.testing.assert_allclose(few.points[..., 2], -view.distance_mm, atol=1e-9)
    assert len([share for share in told if 0.1 <= share < 0.7]) >= 3 and told == sorted(told)


def test_a_face_larger_than_a_block_is_looked_at_in_pieces() -> None:
    view = MeshView(width=2000, height=1500)
    seen = view_mesh(Thing(sheets(2)), view)
    assert seen.valid.all()
    np.testing.assert_allclose(seen.points[..., 2], -view.distance_mm, atol=1e-9)


def test_looking_stops_when_it_is_cancelled() -> None:
    def stop(share: float, text: str) -> None:
        if share > 0.2:
            raise Cancelled

    with pytest.raises(Cancelled):
        view_mesh(Thing(sheets(10)), MeshView(), stop)


def test_a_light_copy_keeps_form_and_colour() -> None:
    mesh = bumpy(200, 240)
    light = light_copy(Thing(mesh, checks()), 8000)
    assert 2000 < len(light.mesh.faces) <= 8000 and light.texture is None and light.colours is not None
    away = surface_distance(light.mesh.vertices[::10], mesh.vertices, mesh.faces)
    assert np.percentile(away, 90) < 1.0
    whole = vertex_colours(Thing(mesh, checks()))
    assert np.abs(whole.mean(axis=0) - light.colours.mean(axis=0)).max() < 12
    assert light_copy(Thing(mesh), 10**6).mesh is mesh


def test_fiducials_go_along_through_space() -> None:
    mesh = bumpy(60, 80)
    before = whole_view(mesh, 300, 400)
    after = before.turned(35, 5, 10)
    scans = [view_mesh(Thing(mesh), view) for view in (before, after)]
    rows, columns = np.nonzero(scans[0].valid)
    pick = np.random.default_rng(0).choice(len(rows), 80, replace=False)
    pixels = np.column_stack([columns, rows])[pick].astype(float)
    found = reproject(pixels, (scans[0], before), (scans[1], after))
    truth = before.into_mesh(scans[0].points[rows[pick], columns[pick]])
    exact = after.project(truth)
    kept = np.isfinite(found.pixels).all(axis=1)
    assert 40 < kept.sum() < 80 and found.hidden.any()
    np.testing.assert_allclose(found.pixels[kept], exact[kept], atol=1e-6)
    placed = mesh.with_vertices(after.into_camera(mesh.vertices))
    seen = visible_points(placed, after.camera, after.into_camera(truth), 0.5)[1]
    assert (seen == kept).mean() > 0.9
    nowhere = reproject(np.array([[1.0, 1.0]]), (scans[0], before), (scans[1], after))
    assert nowhere.unmeasured[0] and not nowhere.outside[0]


@pytest.mark.parametrize("suffix", ["obj", "glb"])
def test_a_bundled_head_as_a_mesh_file_becomes_a_face(tmp_path: Path, suffix: str) -> None:
    heads = Heads.load(resources.sample_path("truth.npz"))
    mesh = TriangleMesh(heads.vertices("base"), heads.faces, heads.uv)
    skin = read_image(resources.sample_path("subject", "skin.jpg"))
    path = tmp_path / f"head.{suffix}"
    (write_obj if suffix == "obj" else write_glb)(path, mesh, texture=skin)
    file = read_scan(path)
    assert file.view is not None and file.scan.colour is not None
    fiducials = heads.fiducials_of("base")
    names = read_template(resources.template_path()).layout("closed").fiducials
    truth = {name: mesh.vertices[fiducials[name]] for name in names}
    pixels = dict(zip(truth, file.view.project(np.array(list(truth.values()))).tolist(), strict=True))
    face = fit_template(file.scan, pixels, read_template(resources.template_path()), "closed", levels=1)
    fitted = file.view.into_mesh(face.mesh.vertices)
    at = np.linalg.norm([fitted[names[name]] - truth[name] for name in truth], axis=1)
    away = surface_distance(fitted[~face.filled], mesh.vertices, mesh.faces)
    assert np.median(at) < 0.5 and np.percentile(away, 95) < 0.5, (at, np.percentile(away, [50, 95]))


def test_a_photographed_head_becomes_a_face_where_its_landmarks_are() -> None:
    folder = DATA / "meshes"
    if not (folder / "james.obj").is_file():
        pytest.skip("the scanned head is not here")
    mesh, file = read_mesh(folder / "james.obj"), read_scan(folder / "james.obj")
    marks = json.loads((folder / "james.ljson").read_text())["groups"]["LJSON"]
    points = np.array(marks["landmarks"]["points"])
    part = {entry["label"]: entry["mask"] for entry in marks["labels"]}
    mouth, nose, left, right = (points[part[name]] for name in ("mouth", "nose", "reye", "leye"))
    brow_left, brow_right = points[part["reyebrow"]], points[part["leyebrow"]]
    truth = {
        "brow_left_inner": brow_left[0], "brow_left_outer": brow_left[-1], "brow_right_inner": brow_right[-1],
        "brow_right_outer": brow_right[0], "eye_left_inner": left[0], "eye_left_outer": left[3],
        "eye_right_outer": right[0], "eye_right_inner": right[3], "nose_bridge": nose[0], "nose_tip": nose[3],
        "nose_left": nose[-1], "nose_right": nose[4], "mouth_right": mouth[0], "mouth_left": mouth[6],
        "lip_upper": mouth[3], "lip_lower": mouth[9], "chin": points[part["chin"]][8],
    }  # fmt: skip
    assert file.view is not None
    pixels = dict(zip(truth, file.view.project(np.array(list(truth.values()))).tolist(), strict=True))
    assert pixels["eye_left_outer"][0] > pixels["eye_right_outer"][0] + 200, "the subject's left is to the right"
    template = read_template(resources.template_path())
    names = template.layout("closed").fiducials
    face = fit_template(file.scan, pixels, template, "closed", levels=2)
    fitted = file.view.into_mesh(face.mesh.vertices)
    at = np.linalg.norm([fitted[names[name]] - truth[name] for name in truth], axis=1)
    away = surface_distance(fitted[~face.filled], mesh.mesh.vertices, mesh.mesh.faces)
    assert np.median(at) < 1.0 and at.max() < 6.0, dict(zip(truth, at.round(2), strict=True))
    assert np.median(away) < 0.1 and np.percentile(away, 99) < 1.0, np.percentile(away, [50, 95, 99])
