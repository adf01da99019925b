"""Parts of a 3-D picture whose answers are known."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vtkmodules.vtkRenderingCore import vtkCamera

from engine.geometry.normals import vertex_normals
from engine.geometry.subdivide import subdivision, unique_edges
from tests.widgets.scene import synthetic
from widgets.scene import camera as hand
from widgets.scene.heatmap import HeatRange, cividis, heat_colours, share_above, share_text
from widgets.scene.occlusion import openness
from widgets.scene.scan_points import on_surface, sample
from widgets.scene.wire import coarse_edges


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_the_wire_is_the_template_subdivided_edge_by_edge(levels: int) -> None:
    template = synthetic.template()
    fine = subdivision(template.faces, len(template.mirror), levels)
    found = {tuple(edge) for edge in coarse_edges(fine.faces, levels).tolist()}
    weights = fine.weights.tocsr()
    coarse = {tuple(edge) for edge in unique_edges(template.faces)[0].tolist()}
    assert len(found) == len(coarse) * 2**levels
    pieces: Counter[tuple[int, ...]] = Counter()
    for a, b in found:
        ends = tuple(sorted(set(weights[a].indices) | set(weights[b].indices)))
        assert ends in coarse, "both ends of a piece lie on one template edge"
        pieces[ends] += 1
    assert set(pieces.values()) == {2**levels}


def test_the_wire_follows_both_lips_where_they_touch() -> None:
    faces = np.array([[0, 1, 2], [3, 5, 4]])
    edges = {tuple(edge) for edge in coarse_edges(faces, 0).tolist()}
    assert edges == {(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5)}


def test_heat_is_cividis_at_the_ends_and_grey_where_nothing_was_measured() -> None:
    import matplotlib

    colours = heat_colours(np.array([0.0, 0.2, 5.0, -1.0, np.nan, np.inf]), HeatRange(0.0, 0.2), "#6b717a")
    reference = np.round(np.array([matplotlib.colormaps["cividis"](x)[:3] for x in (0.0, 1.0)]) * 255).astype(int)
    assert (colours[0] == reference[0]).all() and (colours[3] == reference[0]).all()
    assert (
        (colours[1] == reference[1]).all() and (colours[2] == reference[1]).all() and (colours[5] == reference[1]).all()
    )
    assert tuple(colours[4]) == (0x6B, 0x71, 0x7A)
    assert (cividis()[:, 2].astype(int) - cividis()[:, 0])[0] > 60, "it starts blue"


def test_the_share_out_of_range_counts_known_values_only() -> None:
    values = np.array([0.1, 0.1, 0.3, np.nan, np.nan])
    assert share_above(values, HeatRange(0.0, 0.2)) == pytest.approx(1 / 3)
    assert share_text(values, HeatRange(0.0, 0.2)) == "33.3 % above 0.2"
    assert share_text(values, HeatRange(0.15, 0.2)) == "66.7 % below 0.15, 33.3 % above 0.2"
    assert share_text(np.full(3, np.nan), HeatRange()) == ""
    assert share_text(np.r_[np.zeros(9999), 1.0], HeatRange()).startswith("< 0.1 %"), "one in ten thousand is not none"


def test_a_range_without_width_is_refused() -> None:
    for low, high in ((0.2, 0.2), (0.3, 0.1), (0.0, float("nan"))):
        with pytest.raises(ValueError, match="low < high"):
            HeatRange(low, high)


def test_a_dent_is_dark_and_a_bump_is_not() -> None:
    x, y = np.meshgrid(np.linspace(-40, 40, 41), np.linspace(-40, 40, 41))
    index = np.arange(41 * 41).reshape(41, 41)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    dark = {}
    for name, sign in (("flat", 0.0), ("dent", -1.0), ("bump", 1.0)):
        vertices = np.stack([x, y, sign * 6 * np.exp(-(x**2 + y**2) / 30)], -1).reshape(-1, 3)
        dark[name] = 1 - openness(vertices, faces, vertex_normals(vertices, faces))[index[20, 20]]
    assert dark["flat"] == pytest.approx(0, abs=1e-12)
    assert dark["bump"] == pytest.approx(0, abs=1e-12)
    assert dark["dent"] > 0.3


def test_dots_on_the_face_are_left_out_and_spikes_stay() -> None:
    fit, scan = synthetic.fit(), synthetic.scan()
    points, pixels = sample(scan.points, 100_000)
    assert np.array_equal(points, scan.points[tuple(pixels[:, ::-1].astype(int).T)].astype(np.float32))
    spikes = points.copy()
    middle = np.flatnonzero((np.abs(pixels - [120, 120]) < 40).all(axis=1))
    spikes[middle[::7], 2] += 9.0
    gone = on_surface(spikes, pixels, fit.mesh.vertices, fit.normals, fit.pixels)
    assert not gone[middle[::7]].any(), "spikes are shown"
    kept = np.setdiff1d(middle, middle[::7])
    assert gone[kept].mean() > 0.97, "what lies on the face is not"
    outside = (pixels[:, 1] < fit.pixels[:, 1].min() - 8) | (pixels[:, 1] > fit.pixels[:, 1].max() + 8)
    assert outside.any() and not gone[outside].any()


def test_the_same_scan_gives_the_same_dots() -> None:
    first, second = sample(synthetic.scan().points, 500), sample(synthetic.scan().points, 500)
    assert len(first[0]) == 500
    assert np.array_equal(first[0], second[0])


def a_camera(direction: tuple[float, float, float] = (0.3, 0.2, 1.0)) -> vtkCamera:
    camera = vtkCamera()
    hand.frame(camera, synthetic.fit().mesh.vertices, np.array(direction), 1.2)
    hand.clip(camera, (-200, 200, -200, 200, -900, -400))
    return camera


@pytest.mark.parametrize("view", sorted(hand.VIEWS))
@pytest.mark.parametrize("aspect", [0.6, 1.0, 1.9])
def test_a_standard_view_fills_the_picture_and_cuts_nothing(view: str, aspect: float) -> None:
    camera = vtkCamera()
    points = synthetic.fit().mesh.vertices
    hand.look(camera, points, view, aspect, margin=1.1)
    height = 1000.0
    seen = hand.project(camera, points, aspect * height, height)
    span = (seen.max(axis=0) - seen.min(axis=0)) / [aspect * height, height]
    assert seen.min() >= 0 and (seen.max(axis=0) <= [aspect * height, height]).all()
    assert span.max() == pytest.approx(1 / 1.1, abs=0.03), "one direction is filled but for the margin"
    middle = (seen.max(axis=0) + seen.min(axis=0)) / 2 / [aspect * height, height]
    assert np.allclose(middle, 0.5, atol=0.02)


@given(st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)), min_size=1, max_size=12))
def test_orbiting_keeps_horizon_pivot_and_distance(steps: list[tuple[float, float]]) -> None:
    camera = a_camera()
    pivot = np.array([10.0, -20.0, -640.0])
    before = float(np.linalg.norm(np.array(camera.GetPosition()) - pivot))
    place = hand.project(camera, pivot[None], 800, 600)
    for yaw, pitch in steps:
        hand.orbit(camera, pivot, yaw, pitch)
    _, right, up = hand.axes(camera)
    assert abs(right[1]) < 1e-9, "no roll"
    assert up[1] > 0, "never upside down"
    assert np.linalg.norm(np.array(camera.GetPosition()) - pivot) == pytest.approx(before, rel=1e-9)
    assert np.allclose(hand.project(camera, pivot[None], 800, 600), place, atol=1e-6), "the pivot holds still"


@given(st.floats(-200, 200), st.floats(-200, 200))
def test_panning_carries_the_gripped_point_with_the_hand(dx: float, dy: float) -> None:
    camera = a_camera()
    grip = np.array([15.0, 30.0, -640.0])
    before = hand.project(camera, grip[None], 800, 600)[0]
    hand.pan(camera, dx, dy, grip, 600)
    assert np.allclose(hand.project(camera, grip[None], 800, 600)[0] - before, [dx, dy], atol=1e-6)


@given(st.floats(0.5, 3.0), st.floats(100, 700), st.floats(100, 500))
def test_the_wheel_nears_what_is_under_the_pointer(factor: float, x: float, y: float) -> None:
    camera = a_camera()
    target = hand.on_plane(camera, hand.ray(camera, x, y, 800, 600), np.array(camera.GetFocalPoint()))
    assert np.allclose(hand.project(camera, target[None], 800, 600)[0], (x, y), atol=1e-6), "the ray is the projection"
    before = float(np.linalg.norm(np.array(camera.GetPosition()) - target))
    hand.zoom(camera, factor, target)
    assert np.allclose(hand.project(camera, target[None], 800, 600)[0], (x, y), atol=1e-5)
    assert np.linalg.norm(np.array(camera.GetPosition()) - target) == pytest.approx(before / factor, rel=1e-9)


def test_no_wheel_goes_through_the_face() -> None:
    camera = a_camera()
    target = np.array([0.0, 0.0, -640.0])
    for _ in range(200):
        hand.zoom(camera, 1.5, target)
    assert np.linalg.norm(np.array(camera.GetPosition()) - target) >= 7.9


def test_scene_and_report_load_without_qt() -> None:
    code = (
        "import sys\n"
        "class Blocked:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name.split('.')[0] in ('PySide6', 'pyvistaqt', 'qtpy'): raise ImportError(name)\n"
        "sys.meta_path.insert(0, Blocked())\n"
        "import widgets.scene.stills, widgets.scene.fit_scene, studio.report.pages, studio.report.plates\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
