"""The drawn views of the basis stage: what each shows, what it leaves alone, and pictures without a window."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

from tests.widgets.scene import made_head
from widgets.scene import camera
from widgets.scene.background import DARK, LIGHT, PAPER
from widgets.scene.basis_content import BasisContent
from widgets.scene.basis_rig import RigLook
from widgets.scene.basis_scene import BasisScene
from widgets.scene.basis_state import BY_HAND, BY_QUASI, CHANGE, HAND, ORIGINAL, QUASI, VIEWS, ViewState
from widgets.scene.basis_stills import RigStills, frame_triplet_image, marker_error_image, shape_pair_image
from widgets.scene.heatmap import HeatRange, cividis

SIZE = (240, 220)
HAND_SHAPE, QUASI_SHAPE = made_head.bump(made_head.HAND, 14.0), made_head.bump(made_head.QUASI, 14.0)
NEUTRAL = made_head.head().vertices


class Stage:
    """Seven views on top of each other in an off-screen window; one of them is drawn at a time."""

    def __init__(self) -> None:
        self.plotter: Any = pv.Plotter(
            off_screen=True, shape=(VIEWS, 1), border=False, window_size=list(SIZE), lighting="none"
        )
        self.plotter.render_window.SetMultiSamples(0)
        self.content = BasisContent()
        self.content.set_rig(made_head.head(), made_head.skin_vertices(), None)
        self.scene = BasisScene(self.plotter, self.content, DARK)
        for renderer in self.plotter.renderers:
            renderer.camera_set = True
            renderer.SetViewport(0, 0, 1, 1)
        self.plotter.link_views()
        self.look("front")
        self.scene.layout([SIZE] * VIEWS, 1.0)

    def look(self, view: str) -> None:
        camera.look(self.scene.camera, self.scene.framed(), view, SIZE[0] / SIZE[1], 1.2)
        camera.clip(self.scene.camera, self.scene.bounds() or ())
        self.scene.turn()

    def show(self, **state: Any) -> set[int]:
        self.scene.set_state(ViewState(**state))
        return self.scene.refresh()

    def shoot(self, view: int) -> np.ndarray:
        for k, renderer in enumerate(self.plotter.renderers):
            renderer.SetDraw(k == view)
        window = self.plotter.render_window
        window.Render()
        grab = vtkWindowToImageFilter()
        grab.SetInput(window)
        grab.ReadFrontBufferOff()
        grab.Update()
        image = grab.GetOutput()
        columns, rows, _ = image.GetDimensions()
        pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(rows, columns, -1)[::-1, :, :3].astype(int)
        grab.SetInput(None)
        return pixels


@pytest.fixture(scope="module")
def one_stage() -> Iterator[Stage]:
    stage = Stage()
    yield stage
    stage.scene.close()
    stage.plotter.close()


@pytest.fixture
def stage(one_stage: Stage) -> Stage:
    one_stage.content.set_rig(made_head.head(), made_head.skin_vertices(), None)
    one_stage.content.heat = HeatRange(0.0, 3.0)
    one_stage.show()
    one_stage.look("front")
    return one_stage


def bare(stage: Stage, view: int) -> np.ndarray:
    """Return a view without the strips where words stand."""
    return stage.shoot(view)[30:-30]


def reddish(pixels: np.ndarray) -> np.ndarray:
    return (pixels[..., 0] > 150) & (pixels[..., 1] < 100) & (pixels[..., 2] < 110)


def bluish(pixels: np.ndarray) -> np.ndarray:
    return (pixels[..., 2] > 200) & (pixels[..., 0] < 100) & (pixels[..., 1] < 160)


def test_hand_and_quasi_eigen_stand_beside_each_other_under_one_camera(stage: Stage) -> None:
    stage.content.set_shape("smile", HAND_SHAPE, HAND_SHAPE)
    stage.show()
    same = bare(stage, HAND), bare(stage, QUASI)
    assert (same[0] == same[1]).all(), "one shape, one picture"
    stage.content.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    stage.show()
    assert (np.abs(bare(stage, HAND) - bare(stage, QUASI)).sum(axis=2) > 30).mean() > 0.03


def test_flipping_shows_the_quasi_eigen_shape_where_the_hand_shape_was_and_moves_nothing(stage: Stage) -> None:
    stage.content.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    stage.show()
    before, where = stage.shoot(HAND), np.array(stage.scene.camera.GetModelViewTransformMatrix().GetData())
    wanted = bare(stage, QUASI)
    assert stage.show(flipped=True) == {HAND}
    assert (bare(stage, HAND) == wanted).all()
    assert (np.array(stage.scene.camera.GetModelViewTransformMatrix().GetData()) == where).all()
    assert stage.show() == {HAND}
    assert (stage.shoot(HAND) == before).all()


@pytest.mark.parametrize("orthographic", [False, True])
def test_the_wipe_parts_both_shapes_at_its_line(stage: Stage, orthographic: bool) -> None:
    stage.content.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    camera.set_orthographic(stage.scene.camera, orthographic)
    stage.look("three_quarter")
    stage.show()
    hand, quasi = bare(stage, HAND), bare(stage, QUASI)
    for share in (0.35, 0.6):
        stage.show(mode="wipe", wipe=share)
        wiped, line = bare(stage, HAND), round(share * SIZE[0])
        assert (wiped[:, : line - 5] == hand[:, : line - 5]).all()
        assert (wiped[:, line + 5 :] == quasi[:, line + 5 :]).all()
        assert stage.scene.wipe.contains(line + 3) and not stage.scene.wipe.contains(line + 20)
    stage.show()
    assert (bare(stage, HAND) == hand).all(), "nothing stays cut"
    camera.set_orthographic(stage.scene.camera, False)


def test_two_equal_shapes_over_each_other_do_not_flicker(stage: Stage) -> None:
    stage.content.set_shape("smile", HAND_SHAPE, HAND_SHAPE)
    stage.show()
    alone = bare(stage, HAND)
    stage.show(mode="overlay")
    both = bare(stage, HAND)
    assert (np.abs(both - alone).sum(axis=2) > 24).mean() < 0.01
    stage.content.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    stage.show(mode="overlay")
    mixed = bare(stage, HAND)
    bluer = (mixed[..., 2] - mixed[..., 0]) > (alone[..., 2] - alone[..., 0]) + 40
    assert bluer[:, : SIZE[0] // 2].sum() > 8 * bluer[:, SIZE[0] // 2 :].sum(), "blue where quasi-eigen lies outside"


def test_the_heatmap_has_the_colours_of_the_change_and_a_range_that_stays(stage: Stage) -> None:
    offset = np.array([0.0, 0.0, 1.5])
    stage.content.set_shape("a", HAND_SHAPE, HAND_SHAPE + offset)
    stage.show()
    half = cividis()[128].astype(float)
    face = stage.scene.faces[CHANGE]
    colours = np.asarray(face.surfaces[0].point_data["colour"]).astype(float)
    assert np.percentile(np.abs(colours - half), 40) < 2.0, "open ground wears 1.5 of 3 mm"
    stage.content.set_shape("b", HAND_SHAPE, HAND_SHAPE + 10 * offset)
    stage.show()
    assert stage.content.heat == HeatRange(0.0, 3.0)
    colours = np.asarray(face.surfaces[0].point_data["colour"]).astype(float)
    assert np.percentile(np.abs(colours - cividis()[255]), 40) < 2.0
    eyes = np.asarray(face.surfaces[1].point_data["colour"]).astype(float)
    assert np.ptp(eyes, axis=1).max() < 30, "what is not measured is grey"


def test_views_whose_data_are_the_same_are_not_touched(stage: Stage) -> None:
    stage.content.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    placed = [NEUTRAL + k * HAND_SHAPE for k in (1.0, 0.9, 0.8)]
    stage.content.set_frame(0, (*placed, None), (1.0, 0.5))
    assert stage.show() == {HAND, QUASI, CHANGE, ORIGINAL, BY_HAND, BY_QUASI}
    assert stage.show() == set()
    times = {view: [s.GetMTime() for s in stage.scene.faces[view].surfaces] for view in (HAND, QUASI, CHANGE)}
    stage.content.set_frame(1, (placed[1], placed[2], placed[0], None), (1.0, 0.5))
    assert stage.show() == {ORIGINAL, BY_HAND, BY_QUASI}
    assert {v: [s.GetMTime() for s in stage.scene.faces[v].surfaces] for v in times} == times
    stage.content.set_shape("smile", HAND_SHAPE, 0.5 * QUASI_SHAPE)
    assert stage.show() == {QUASI, CHANGE}, "a slider between hand and quasi-eigen leaves the hand shape alone"


def test_vtk_never_holds_an_array_of_the_engine(stage: Stage) -> None:
    hand, quasi, placed = HAND_SHAPE.copy(), QUASI_SHAPE.copy(), NEUTRAL + HAND_SHAPE
    mesh = made_head.head()
    kept = [a.copy() for a in (hand, quasi, placed, mesh.vertices, mesh.faces)]
    stage.content.set_shape("smile", hand, quasi)
    stage.content.set_frame(0, (placed, placed, placed, None), (1.0, 1.0))
    stage.show()
    for face in [*stage.scene.faces, stage.scene.twin]:
        for surface in face.surfaces:
            np.asarray(surface.points)[:] = 7.0
            surface.point_data["Normals"][:] = 7.0
            vtk_to_numpy(surface.GetPolys().GetConnectivityArray())[:] = 0
    for now, before in zip((hand, quasi, placed, mesh.vertices, mesh.faces), kept, strict=True):
        assert (now == before).all()
    rig = stage.content.rig
    assert rig is not None and np.allclose(rig.neutral.points, mesh.vertices, atol=1e-4), "nor one of the rig's"
    stage.content.set_rig(None, None, None)
    stage.show()


def test_markers_are_red_and_blue_where_they_are_and_hidden_behind_the_head(stage: Stage) -> None:
    front, back = np.array([0.0, -12.0, made_head.RADIUS + 14.0]), np.array([0.0, 40.0, -made_head.RADIUS])
    stage.content.set_frame(0, (NEUTRAL, NEUTRAL, NEUTRAL, None), (1.0, 1.0))
    captured = np.array([front, back, [np.nan] * 3])
    moved = captured + np.array([26.0, 0.0, -8.0])
    stage.content.set_markers(captured, moved, None)
    stage.show()
    picture = stage.shoot(BY_HAND)[:-30]
    for mark, colour in ((captured[0], reddish), (moved[0], bluish)):
        x, y = camera.project(stage.scene.camera, mark[None], *SIZE)[0]
        rows, columns = np.nonzero(colour(picture))
        assert 12 <= len(rows) <= 60, "one disc"
        assert np.hypot(columns.mean() - x, SIZE[1] - 1 - rows.mean() - y) < 2.0
    assert not bluish(stage.shoot(ORIGINAL)[:-60]).any() and reddish(stage.shoot(ORIGINAL)[:-60]).sum() >= 12
    stage.look("back")
    rows, columns = np.nonzero(reddish(stage.shoot(BY_HAND)[:-30]))
    x, y = camera.project(stage.scene.camera, back[None], *SIZE)[0]
    assert np.hypot(columns.mean() - x, SIZE[1] - 1 - rows.mean() - y) < 2.0
    stage.show(markers=False)
    assert not reddish(stage.shoot(BY_HAND)[:-30]).any()


def test_the_value_under_the_pointer_is_the_vertexs(stage: Stage) -> None:
    stage.content.set_shape("smile", HAND_SHAPE, HAND_SHAPE + np.array([0.0, 1.25, 0.0]))
    stage.show()
    middle = (SIZE[0] / 2, SIZE[1] / 2)
    sight = camera.ray(stage.scene.camera, *middle, *SIZE)
    assert stage.scene.read_at(CHANGE, sight, middle) == {CHANGE}
    assert stage.scene._readings[CHANGE]._words.text == "1.25 mm"
    assert stage.scene.read_at(HAND, sight, middle) == {CHANGE}, "shapes have no values"
    assert stage.scene.read_at(CHANGE, None, middle) == set()


def test_everything_written_lies_inside_its_view(stage: Stage) -> None:
    stage.content.set_shape("a_very_long_name_of_a_shape_indeed", HAND_SHAPE, QUASI_SHAPE, "0.40")
    stage.content.set_frame(12344, (NEUTRAL, NEUTRAL, NEUTRAL, None), (2.234, 0.171))
    stage.content.set_markers(np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)))
    stage.content.set_clip(np.full(len(NEUTRAL), 9.0), "quasi_eigen")
    stage.show(clip_heat=True)
    for renderer in list(stage.plotter.renderers)[:6]:
        props = renderer.GetViewProps()
        for k in range(props.GetNumberOfItems()):
            prop = props.GetItemAsObject(k)
            if prop.IsA("vtkTextActor") and prop.GetVisibility():
                box = [0.0] * 4
                prop.GetBoundingBox(renderer, box)
                x, y = prop.GetPosition()
                assert x + box[1] <= SIZE[0] - 4 and x + box[0] >= 4, prop.GetInput()
                assert y + box[3] <= SIZE[1] - 4 and y + box[2] >= 0, prop.GetInput()


def test_a_closed_scene_leaves_nothing() -> None:
    stage = Stage()
    stage.content.set_shape("smile", HAND_SHAPE, QUASI_SHAPE)
    stage.show(mode="overlay")
    stage.shoot(HAND)
    held = [weakref.ref(stage.scene.faces[HAND].surfaces[0]), weakref.ref(stage.scene)]
    stage.scene.close()
    assert all(renderer.GetViewProps().GetNumberOfItems() == 0 for renderer in stage.plotter.renderers)
    stage.plotter.close()
    del stage
    gc.collect()
    assert [ref() for ref in held] == [None, None]


def test_a_still_of_equal_shapes_shows_one_picture_twice_and_no_change() -> None:
    row = shape_pair_image(made_head.head(), HAND_SHAPE, HAND_SHAPE, names=False, size=(160, 150))
    assert row.shape == (150, 3 * 160 + 4, 3) and row.dtype == np.uint8
    assert (row[:, :160] == row[:, 162:322]).all()
    change = row[10:-40, 324:].astype(int)
    face = np.abs(change - 255).sum(axis=2) > 60
    assert (change[face][:, 2] >= change[face][:, 0]).mean() > 0.9, "all of it at the blue end"
    other = shape_pair_image(made_head.head(), HAND_SHAPE, QUASI_SHAPE, names=False, size=(160, 150), change=False)
    assert other.shape == (150, 322, 3) and (other[:, :160] == row[:, :160]).all()


def test_stills_of_frames_have_a_picture_for_each_reconstruction() -> None:
    rig = RigLook(made_head.head(), made_head.skin_vertices())
    placed = [NEUTRAL + k * HAND_SHAPE for k in (1.0, 0.5, 0.9)]
    row = frame_triplet_image(rig, *placed, rms_mm=(1.2, 0.3), size=(140, 130), frame=7)
    more = frame_triplet_image(rig, *placed, by_pca=placed[0], size=(140, 130), names=False)
    assert row.shape == (130, 3 * 140 + 4, 3) and more.shape == (130, 4 * 140 + 6, 3)
    assert (more[:, :140] == more[:, -140:]).all()


def test_stills_of_markers_show_captured_ones_everywhere_and_reconstructed_ones_where_they_belong() -> None:
    mark = np.array([[0.0, -12.0, made_head.RADIUS + 14.0]])
    row = marker_error_image(
        made_head.head(), (NEUTRAL,) * 3, mark, mark + np.array([26.0, 0.0, -8.0]), mark, names=False, size=(160, 150),
        view="front", colours=LIGHT,
    ).astype(int)  # fmt: skip
    red = (row[..., 0] > 150) & (row[..., 1] < 110) & (row[..., 2] < 110)
    blue = (row[..., 2] > 150) & (row[..., 0] < 110)
    panels = [slice(k * 162, k * 162 + 160) for k in range(3)]
    assert [bool(red[:, p].any()) for p in panels] == [True, True, False], "where both lie in one place blue is seen"
    assert [bool(blue[:, p].any()) for p in panels] == [False, True, True]


def test_a_stage_takes_one_picture_after_the_other() -> None:
    rig = RigLook(made_head.head())
    with RigStills(96, 90, PAPER) as stage:
        stage.look(rig, "front")
        picture = stage.picture(rig, rig.neutral)
        turned = stage.picture(rig, rig.moved(HAND_SHAPE), values=np.full(rig.count, np.nan), name=("A", "b"))
    assert picture.shape == turned.shape == (90, 96, 3)
    assert (picture != 255).any(axis=2).mean() > 0.3
