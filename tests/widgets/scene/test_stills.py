"""Pictures made without a window: they show what they are given and change none of it."""

from __future__ import annotations

import gc
import hashlib
import weakref
from collections.abc import Iterator

import numpy as np
import pytest
import pyvista as pv

from tests.widgets.scene import synthetic
from widgets.scene.background import DARK, PAPER
from widgets.scene.camera import VIEWS, look, project, ray
from widgets.scene.face import FaceActor
from widgets.scene.fit_scene import DISTANCE, FitScene
from widgets.scene.heatmap import HeatRange
from widgets.scene.scan_points import sample
from widgets.scene.stills import Stills

SIZE = (160, 200)


@pytest.fixture(scope="module")
def stills() -> Iterator[Stills]:
    with Stills(*SIZE) as stage:
        yield stage


@pytest.fixture
def plotter() -> Iterator[pv.Plotter]:
    plotter = pv.Plotter(off_screen=True, window_size=[200, 300], shape=(2, 1), border=False)
    yield plotter
    plotter.close()


def fingerprint(*arrays: np.ndarray) -> str:
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()


def seen(picture: np.ndarray) -> np.ndarray:
    """Return where something stands before the white paper."""
    return (picture < 250).any(axis=2)


def test_every_look_shows_the_face_and_each_another(stills: Stills) -> None:
    fit, colour = synthetic.fit(), synthetic.scan().colour
    pictures = {look: stills.face(fit, look, picture=colour, view="front") for look in ("shaded", "textured", "heat")}
    for name, picture in pictures.items():
        assert picture.shape == (200, 160, 3)
        assert 0.3 < seen(picture).mean() < 0.95, name
    assert np.abs(pictures["shaded"].astype(int) - pictures["textured"]).mean() > 8
    assert np.abs(pictures["shaded"].astype(int) - pictures["heat"]).mean() > 8


def test_the_texture_is_upright_and_not_mirrored(stills: Stills) -> None:
    """The picture's left half is green; the camera looks at the face as the scanner did."""
    picture = stills.face(synthetic.fit(), "textured", picture=synthetic.scan().colour, view="front").astype(int)
    green = (picture[..., 1] > picture[..., 0] + 30) & seen(picture)
    assert green[:, :70].sum() > 20 * max(green[:, 90:].sum(), 1)


def test_blank_hides_and_wire_shows(stills: Stills) -> None:
    blank = stills.face(synthetic.fit(), "blank", view="front")
    wired = stills.face(synthetic.fit(), "blank", view="front", wire=1.0)
    dense = stills.face(synthetic.fit(), "blank", view="front", wire=1.0, levels=0)
    assert not seen(blank).any()
    assert 0 < seen(wired).mean() < seen(dense).mean()


def test_missing_values_are_grey_in_the_heatmap(stills: Stills) -> None:
    fit = synthetic.fit()
    assert fit.filled.any() and np.isnan(fit.deviation_mm[fit.filled]).all()
    picture = stills.face(fit, "heat", heat=HeatRange(0.0, 1e-6), view="front").astype(int)
    spread = picture.max(axis=2) - picture.min(axis=2)
    assert ((spread < 40) & seen(picture)).sum() > 30, "the hole is grey"
    assert ((spread > 90) & seen(picture)).sum() > 3000, "all that was measured is above this range: yellow"


def test_fiducials_are_drawn_in_the_colours_of_their_sides_unless_hidden(stills: Stills) -> None:
    fit, layout = synthetic.fit(), synthetic.template().layout("closed")
    places = {name: fit.mesh.vertices[k] for name, k in layout.fiducials.items()}

    def teal(view: str) -> int:
        picture = stills.face(fit, "shaded", view=view, fiducials=places).astype(int)
        return int((np.abs(picture - [47, 184, 166]).sum(axis=2) < 30).sum())

    assert teal("front") > 100, "eight discs on the subject's left"
    assert teal("left") > teal("right"), "from the right the nose hides some"


def test_updating_a_view_leaves_the_engines_arrays_alone(plotter: pv.Plotter) -> None:
    fit, scan = synthetic.fit(), synthetic.scan()
    arrays = (fit.mesh.vertices, fit.mesh.faces, fit.mesh.uv, fit.normals, fit.deviation_mm, scan.points, scan.colour)
    before = fingerprint(*arrays)
    face = FaceActor(plotter.renderers[0], DARK)
    face.set_mesh(fit.mesh.vertices, fit.mesh.faces, fit.normals, levels=1, uv=fit.mesh.uv, picture=scan.colour)
    buffer = np.asarray(face.surface.points)
    assert not np.shares_memory(buffer, fit.mesh.vertices)
    face.update_points(fit.mesh.vertices + 5.0, -fit.normals)
    assert np.asarray(face.surface.points) is not fit.mesh.vertices
    assert np.allclose(face.vertices(), fit.mesh.vertices + 5.0, atol=1e-3), "written in place"
    assert np.shares_memory(np.asarray(face.surface.points), buffer)
    scene = FitScene(plotter, DARK)
    scene.set_scan(scan)
    scene.set_fit(fit, scan.colour)
    scene.set_heat(HeatRange(0.0, 0.5))
    plotter.render()
    scene.close()
    face.remove()
    assert fingerprint(*arrays) == before
    assert all(not a.flags.writeable for a in arrays)


def test_an_aliased_buffer_would_have_been_caught() -> None:
    """The control: what pyvista does with a float32 array that is not copied."""
    ours = np.zeros((3, 3), dtype=np.float32)
    theirs = pv.PolyData.from_regular_faces(ours, np.array([[0, 1, 2]]))
    theirs.points[:] = 1.0
    assert ours.sum() == 9


def test_the_range_of_the_bar_stays_when_new_data_comes(plotter: pv.Plotter) -> None:
    scene = FitScene(plotter, DARK)
    scene.layout([(200.0, 149.0), (200.0, 149.0)], 1.0)
    scene.set_fit(synthetic.fit())
    scene.set_heat(HeatRange(0.05, 0.4))
    scene.set_fit(synthetic.fit(seed=0, levels=2))
    assert (scene.heat.low, scene.heat.high) == (0.05, 0.4)
    assert scene.bar.axis == 0.4
    scene.close()


def test_picking_finds_the_vertex_under_the_pointer(plotter: pv.Plotter) -> None:
    scene, fit = FitScene(plotter, DARK), synthetic.fit()
    scene.set_fit(fit)
    points = fit.mesh.vertices
    look(scene.camera, points, "front", 1.0)
    from widgets.scene.camera import clip

    clip(scene.camera, scene.bounds() or ())
    rng = np.random.default_rng(3)
    inner = np.flatnonzero(np.abs(fit.pixels - [120, 120]).max(axis=1) < 50)
    for vertex in rng.choice(inner, 12, replace=False):
        x, y = project(scene.camera, points[vertex][None], 300, 300)[0]
        hit = scene.pick(ray(scene.camera, x, y, 300, 300))
        assert hit is not None
        assert np.linalg.norm(points[hit[0]] - points[vertex]) < 0.5
    assert scene.pick(ray(scene.camera, 1, 1, 300, 300)) is None, "beside the face there is nothing"
    assert scene.describe(int(np.flatnonzero(fit.filled)[0])) == "filled, not measured"
    scene.close()


def test_the_bars_handles_are_where_their_values_are(plotter: pv.Plotter) -> None:
    scene = FitScene(plotter, DARK)
    scene.set_fit(synthetic.fit())
    scene.layout([(400.0, 300.0), (400.0, 300.0)], 1.0)
    bar = scene.bar
    bar.set(HeatRange(0.05, 0.15), "", DARK, (400.0, 300.0), 1.0, axis=0.2)
    for name, value in (("low", 0.05), ("high", 0.15)):
        xs = [x for x in range(400) if bar.handle_at(x, 29) == name]
        assert bar.value_at(float(np.mean(xs))) == pytest.approx(value, abs=0.004)
    assert bar.handle_at(20, 29) is None and not bar.contains(20, 29)
    scene.close()


def test_standard_views_are_named_for_the_subjects_sides() -> None:
    assert VIEWS["left"][0] > 0 > VIEWS["right"][0]


def test_a_closed_stage_leaves_nothing(plotter: pv.Plotter) -> None:
    scene = FitScene(plotter, PAPER)
    scene.set_scan(synthetic.scan())
    scene.set_fit(synthetic.fit(), synthetic.scan().colour)
    plotter.render()
    held = [weakref.ref(scene.faces[DISTANCE].surface), weakref.ref(scene)]
    scene.close()
    assert all(renderer.GetViewProps().GetNumberOfItems() == 0 for renderer in plotter.renderers)
    del scene
    gc.collect()
    assert [ref() for ref in held] == [None, None]


def test_dots_frame_and_sampling_agree(stills: Stills) -> None:
    dots, _ = sample(synthetic.scan().points, 4000)
    with_dots = stills.face(synthetic.fit(), "shaded", view="front", dots=dots)
    without = stills.face(synthetic.fit(), "shaded", view="front")
    assert seen(with_dots).sum() > seen(without).sum() + 200
