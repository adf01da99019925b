"""What the basis views show, before anything is drawn: normals, poses, change, arrangement, materials, framing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.errors import InputError
from engine.geometry.normals import vertex_normals
from engine.mesh import TriangleMesh
from tests.widgets.scene import made_head
from widgets.scene.basis_content import BasisContent, beyond, counted
from widgets.scene.basis_normals import VertexNormals
from widgets.scene.basis_rig import RigLook, head_of, material_of
from widgets.scene.basis_state import (
    BY_HAND,
    BY_PCA,
    BY_QUASI,
    CHANGE,
    HAND,
    MODES,
    ORIGINAL,
    QUASI,
    ViewState,
    places,
)
from widgets.scene.occlusion import openness
from widgets.viewers.arrangement import Cell, in_a_grid, in_a_run


@pytest.fixture
def content() -> BasisContent:
    found = BasisContent()
    found.set_rig(made_head.head(), made_head.skin_vertices(), None)
    return found


@given(st.integers(0, 2**31), st.integers(4, 40), st.integers(1, 80))
def test_normals_are_those_of_the_engine(seed: int, count: int, number: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(scale=50.0, size=(count, 3))
    faces = rng.integers(0, count, (number, 3))
    faces[0] = (0, 0, 1)  # a face without area
    wanted = vertex_normals(points.astype(np.float32).astype(np.float64), faces)
    out = np.empty((count, 3), dtype=np.float32)
    maker = VertexNormals(faces, count)
    for _ in range(2):  # its buffers remember nothing
        maker.into(points.astype(np.float32), out)
    unsure = np.abs(np.linalg.norm(out, axis=1) - 1.0) > 1e-5
    assert not unsure.any()
    total = np.zeros((count, 3))
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.add.at(total, faces.ravel(), np.repeat(cross, 3, axis=0))
    size = np.zeros(count)
    np.add.at(size, faces.ravel(), np.repeat(np.linalg.norm(cross, axis=1), 3))
    clear = (np.linalg.norm(total, axis=1) > 1e-2 * size) & (size > 1.0)
    assert np.abs(out[clear] - wanted[clear]).max(initial=0.0) < 2e-4
    alone = size == 0.0
    assert (out[alone] == [0.0, 0.0, 1.0]).all()


def test_what_is_given_is_copied_and_never_written_to(content: BasisContent) -> None:
    hand, quasi = made_head.bump(made_head.HAND), made_head.bump(made_head.QUASI)
    placed = made_head.head().vertices + hand
    before = [array.copy() for array in (hand, quasi, placed)]
    content.set_shape("smile", hand, quasi)
    content.set_frame(3, (placed, None, None, None), ())
    poses = {view: content.pose(view) for view in (HAND, QUASI, ORIGINAL)}
    for array, pose in zip((hand, quasi, placed), poses.values(), strict=True):
        assert pose is not None and not np.shares_memory(pose.points, array)
    kept = [pose.points.copy() for pose in poses.values() if pose is not None]
    placed += 100.0
    for pose, points in zip(poses.values(), kept, strict=True):
        assert pose is not None and (pose.points == points).all(), "the caller's buffer is the caller's"
    placed -= 100.0
    assert all(np.allclose(a, b, atol=1e-12) for a, b in zip((hand, quasi, placed), before, strict=True))


def test_a_pose_is_the_same_value_until_other_data_come(content: BasisContent) -> None:
    content.set_shape("smile", made_head.bump(made_head.HAND), made_head.bump(made_head.QUASI))
    first, quasi = content.pose(HAND), content.pose(QUASI)
    assert content.pose(CHANGE) is quasi, "the change is seen on the quasi-eigen shape"
    content.set_frame(0, (made_head.head().vertices, None, None, None), ())
    assert content.pose(HAND) is first and content.pose(QUASI) is quasi
    content.set_shape("smile", made_head.bump(made_head.HAND), None)
    assert content.pose(HAND) is first, "another array with the same numbers is no other data"
    content.set_shape("smile", made_head.bump(made_head.QUASI), None)
    assert content.pose(HAND) is not first and content.pose(QUASI) is None and content.pose(CHANGE) is None


def test_the_change_is_the_length_of_the_difference_on_the_skin_and_unknown_elsewhere(content: BasisContent) -> None:
    hand = made_head.bump(made_head.HAND)
    offset = np.array([1.0, -2.0, 2.0])
    content.set_shape("smile", hand, hand + offset)
    assert content.change is not None
    skin = made_head.skin_vertices()
    assert content.change[skin] == pytest.approx(3.0, abs=1e-12)
    assert np.isnan(np.delete(content.change, skin)).all()


@pytest.mark.parametrize("which, view", [("hand", BY_HAND), ("quasi_eigen", BY_QUASI), ("pca", BY_PCA)])
def test_the_error_over_the_clip_goes_to_the_view_of_its_basis(content: BasisContent, which: str, view: int) -> None:
    values = np.arange(len(made_head.head().vertices), dtype=float)
    content.set_clip(values, which)
    assert set(content.clip) == {view}
    skin = made_head.skin_vertices()
    assert (content.clip[view][skin] == values[skin]).all()
    content.set_clip(None, which)
    assert not content.clip


def test_another_rig_takes_everything_along_but_the_range(content: BasisContent) -> None:
    heat = content.heat
    content.set_shape("smile", made_head.bump(made_head.HAND), None)
    content.set_markers(np.zeros((2, 3)), np.ones((2, 3)))
    content.set_rig(made_head.head(), None, None)
    assert not content.has(HAND) and content.captured is None and not content.rebuilt and content.name == ""
    assert content.heat is heat


def test_what_does_not_fit_the_rig_is_refused_with_both_counts(content: BasisContent) -> None:
    count = len(made_head.head().vertices)
    with pytest.raises(InputError, match=rf"\(7, 3\).*{count} vertices"):
        content.set_shape("smile", np.zeros((7, 3)), None)
    with pytest.raises(InputError, match=str(count)):
        content.set_clip(np.zeros(5), "hand")
    with pytest.raises(InputError, match="reconstructed markers"):
        content.set_markers(np.zeros((4, 3)), np.zeros((5, 3)))


def test_every_piece_shows_the_vertices_it_stands_for() -> None:
    rig = RigLook(made_head.head())
    assert {piece.material for piece in rig.pieces} == {"skin", "eye", "teeth"}
    faces = 0
    for piece in rig.pieces:
        corners = made_head.head().vertices[piece.source][piece.faces]
        assert len(corners) and piece.colours.shape == (len(piece.source), 3)
        faces += len(corners)
    assert faces == len(made_head.head().faces)


def test_a_texture_seam_splits_a_vertex_and_keeps_its_place() -> None:
    mesh = made_head.head()
    count = len(mesh.faces)
    uv = np.random.default_rng(1).uniform(size=(3 * count, 2))  # every corner its own: seams everywhere
    charted = TriangleMesh(mesh.vertices, mesh.faces, uv, np.arange(3 * count).reshape(-1, 3), mesh.parts)
    rig = RigLook(charted, None, np.zeros((4, 4, 3), dtype=np.uint8))
    for piece in rig.pieces:
        assert piece.uv is not None and len(piece.source) == 3 * len(piece.faces)
        placed = rig.neutral.points[piece.source]
        assert len(np.unique(placed, axis=0)) < len(placed)


@pytest.mark.parametrize(
    "part, material",
    [("skin", "skin"), ("eye_left", "eye"), ("Eyelashes", "hair"), ("brow_hair", "hair"), ("teeth_upper", "teeth"),
     ("tongue", "tongue"), ("jaw", "skin"), ("eye_sockets", "skin"), ("mouth", "mouth")],
)  # fmt: skip
def test_parts_are_known_by_their_names(part: str, material: str) -> None:
    assert material_of(part) == material


def test_eyes_look_forward() -> None:
    rig = RigLook(made_head.head())
    eyes = next(piece for piece in rig.pieces if piece.material == "eye")
    points = rig.neutral.points[eyes.source]
    for x in (28.0, -28.0):
        away = np.linalg.norm(points - [x, 24.0, 80.0], axis=1)
        assert eyes.colours[away.argmin()].max() < 40, "a black pupil in front"
        side = np.linalg.norm(points - [x, 38.0, 66.0], axis=1)
        assert eyes.colours[side.argmin()].min() > 200, "white above"


def test_shoulders_are_not_framed_and_a_face_without_any_is_framed_whole() -> None:
    mesh = made_head.head()
    assert head_of(mesh.vertices) is mesh.vertices
    rng = np.random.default_rng(0)
    neck = np.column_stack([rng.uniform(-35, 35, 800), rng.uniform(-130, -75, 800), rng.uniform(-40, 30, 800)])
    low = np.column_stack([rng.uniform(-190, 190, 2000), rng.uniform(-200, -130, 2000), rng.uniform(-60, 60, 2000)])
    framed = head_of(np.concatenate([mesh.vertices, neck, low]))
    assert np.abs(framed[:, 0]).max() < 1.05 * made_head.RADIUS
    assert framed[:, 1].min() > -150.0 and len(framed) > len(mesh.vertices)


def test_a_coarse_plain_curve_is_not_taken_for_a_hollow() -> None:
    points, faces = made_head.ball(9, 14, 90.0, (0.0, 0.0, 0.0))
    inside = faces[:, ::-1]  # seen from within, where every place lies below its surroundings
    normals = vertex_normals(points, inside)
    assert openness(points, inside, normals).mean() < 0.2
    assert openness(points, inside, normals, 2.6).mean() > 0.7
    fine, faces = made_head.ball(60, 90, 14.0, (0.0, 0.0, 0.0))
    inside = faces[:, ::-1]
    normals = vertex_normals(fine, inside)
    assert openness(fine, inside, normals, 2.6) == pytest.approx(openness(fine, inside, normals)), "fine ground as ever"


@pytest.mark.parametrize("mode", [m for m in MODES if m != "grid"])
@pytest.mark.parametrize("heat", [True, False])
@pytest.mark.parametrize("pca", [True, False])
def test_views_share_the_room_without_overlap(mode: str, heat: bool, pca: bool) -> None:
    state = ViewState(mode=mode, heat=heat, pca=pca)  # type: ignore[arg-type]
    cells = {view: Cell(*place) for view, place in places(state).items()}
    for width, height, gap in ((896, 578, 2), (732, 478, 2), (1793, 1157, 4)):
        rects = in_a_grid(cells, width, height, gap)
        room = np.zeros((height, width), dtype=int)
        for left, bottom, w, h in (map(int, rect) for rect in rects.values()):
            room[bottom : bottom + h, left : left + w] += 1
            grown = room[max(bottom - gap, 0) : bottom + h + gap, max(left - gap, 0) : left + w + gap]
            assert grown.max() == 1, "nothing lies closer than the gap"
            room[bottom : bottom + h, left : left + w] = 1
        assert (room == 0).mean() < 0.03
    assert {HAND, ORIGINAL, BY_HAND, BY_QUASI} <= set(cells)
    assert (CHANGE in cells) == heat and (BY_PCA in cells) == pca and (QUASI in cells) == (mode == "side")


@given(st.integers(40, 2000), st.integers(40, 2000), st.integers(1, 4), st.integers(0, 6))
def test_a_run_lies_along_the_longer_side(width: int, height: int, count: int, gap: int) -> None:
    rects = in_a_run(range(count), width, height, gap)
    along, across = (1, 0) if height >= width else (0, 1)
    spans = sorted((rect[along], rect[along] + rect[2 + along]) for rect in rects.values())
    assert spans[0][0] == 0 and spans[-1][1] == (width, height)[along]
    assert all(b[0] - a[1] in (gap - 1, gap, gap + 1) for a, b in pairwise(spans))
    assert all(rect[across] == 0 and rect[2 + across] == (width, height)[across] for rect in rects.values())
    sizes = [rect[2 + along] for rect in rects.values()]
    assert max(sizes) - min(sizes) <= 1


def test_the_error_over_the_clip_has_a_range_of_its_own_and_words_fall_silent_at_nothing() -> None:
    content = BasisContent()
    mesh = TriangleMesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    content.set_rig(mesh, None, None)
    content.set_clip(np.array([0.2, 0.21, 0.22]), "hand", 6000)
    content.set_clip(np.array([0.01, 0.02, np.nan]), "quasi_eigen", 6000)
    assert (content.heat.high, content.clip_heat.high) == (3.0, 0.25), "by hand, whatever the change's range is"
    assert beyond(content.clip[BY_HAND], content.clip_heat) == ""
    assert beyond(np.array([1.0, 4.0]), content.heat) == "50.0 % above 3 mm"
    assert counted(6000) == "6\u2009000"
