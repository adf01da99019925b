"""Files of other tools for a scan: pixels, other sizes and points in space come out where they were planted."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import resources
from engine.errors import InputError
from engine.files.landmarks import read_landmarks, write_landmarks
from engine.files.landmarks_json import read_fiducials
from engine.files.scan import read_scan
from engine.landmark_mapping import LandmarkMapping, invert_mapping
from engine.scan.landmark_pixels import project_points, scale_pixels
from engine.scan.mesh_view import MeshView
from engine.scan.range_image import RangeImage
from studio.cli import main
from studio.scan.fiducial_files import fiducials_for_fit, fiducials_from, find_fiducials, shipped_mappings
from studio.scan.fiducial_options import FiducialOptions
from tests.engine.files.test_landmark_files import JAMES, VIDEO

IBUG = next(mapping for mapping in shipped_mappings() if mapping.name == "ibug68")
BASE = resources.sample_path("subject", "base.json")
TRUTH = read_fiducials(resources.sample_path("subject", "base_fiducials.json")).positions
SIZE = (640, 480)


@cache
def scan() -> RangeImage:
    return read_scan(BASE).scan


@pytest.fixture
def pts(tmp_path: Path) -> Callable[..., Path]:
    def write(positions: dict[str, tuple[float, float]] = TRUTH, name: str = "face.pts") -> Path:
        done = invert_mapping(IBUG, {n: p for n, p in positions.items() if n in IBUG.entries})
        points = np.where(np.isfinite(done.points), done.points, 10.0)
        write_landmarks(tmp_path / name, points, [str(k) for k in range(68)])
        return tmp_path / name

    return write


def test_points_of_another_tool_lie_where_they_were_planted(pts: Callable[..., Path]) -> None:
    positions, remarks = fiducials_from(pts(), "closed", SIZE, scan())
    assert list(positions) == [name for name in TRUTH_ORDER if name != "forehead"]
    for name, place in positions.items():
        assert place == pytest.approx(TRUTH[name], abs=1e-9)
    told = "\n".join(remarks)
    assert "19 of 20 fiducials found" in told and "not in the mapping: forehead" in told and "68 points" in told
    shifted, _ = fiducials_from(pts(), "closed", SIZE, scan(), options=FiducialOptions(origin=0))
    assert shifted["nose_tip"] == pytest.approx(np.add(TRUTH["nose_tip"], 1), abs=1e-9)


TRUTH_ORDER = (
    "forehead", "brow_left_outer", "brow_left_inner", "brow_right_inner", "brow_right_outer", "eye_left_outer",
    "eye_left_inner", "eye_right_inner", "eye_right_outer", "nose_bridge", "nose_tip", "nose_left", "nose_right",
    "mouth_left", "mouth_right", "lip_upper", "lip_lower", "chin", "jaw_left", "jaw_right",
)  # fmt: skip


def test_what_falls_outside_or_on_holes_is_told_and_never_moved(pts: Callable[..., Path]) -> None:
    rows, columns = np.nonzero(~scan().valid)
    hole = float(columns[0]), float(rows[0])
    moved = {**TRUTH, "jaw_left": (639.6, 10.0), "jaw_right": hole, "nose_left": (-0.4, 5.0)}
    path = pts(moved)
    found = find_fiducials(read_landmarks(path), "face.pts", "closed", scan())
    assert found.named("outside") == ("jaw_left",) and "jaw_right" in found.named("on a hole")
    assert "jaw_left" not in found.usable and found.usable["jaw_right"] == pytest.approx(hole, abs=1e-9)
    assert any("1 outside the picture, left unset: jaw_left" in line for line in found.remarks)
    with pytest.raises(InputError, match=r"jaw_left outside the picture of 640 x 480"):
        fiducials_for_fit(path, "closed", scan(), FiducialOptions())


def test_another_size_is_scaled_only_when_asked_and_only_in_proportion(tmp_path: Path) -> None:
    half = scale_pixels(np.array(list(TRUTH.values())), SIZE, (320, 240))
    assert np.allclose(scale_pixels(half, (320, 240), SIZE), list(TRUTH.values()), atol=1e-9)
    assert scale_pixels(np.array([[-0.5, 479.5]]), SIZE, (320, 240)).tolist() == [[-0.5, 239.5]]
    write_landmarks(tmp_path / "half.json", half, list(TRUTH), (320, 240))
    with pytest.raises(InputError, match="was made for a picture of 320 x 240"):
        fiducials_from(tmp_path / "half.json", "closed", SIZE, scan())
    positions, _ = fiducials_from(tmp_path / "half.json", "closed", SIZE, scan(), options=FiducialOptions(scale=True))
    for name, place in positions.items():
        assert place == pytest.approx(TRUTH[name], abs=1e-9)
    with pytest.raises(InputError, match="other proportions"):
        scale_pixels(half, (300, 300), SIZE)
    write_landmarks(tmp_path / "half.csv", half, list(TRUTH))
    options = FiducialOptions(image_size=(320, 240), scale=True)
    positions, _ = fiducials_from(tmp_path / "half.csv", "closed", SIZE, scan(), options=options)
    assert positions["chin"] == pytest.approx(TRUTH["chin"], abs=1e-9)


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("cm", 10.0), ("85.3 mm", 85.3)])
@pytest.mark.parametrize("placed", [False, True])
def test_points_in_space_come_to_their_pixels_and_hidden_ones_are_told(
    tmp_path: Path, unit: str, factor: float, placed: bool
) -> None:
    view = MeshView((0.3, -0.2, 0.1), (5.0, -8.0, 20.0), 640.0, 22.0) if placed else None
    rows, columns = np.nonzero(scan().valid)
    chosen = np.random.default_rng(5).choice(len(rows), 20, replace=False)
    pixels = np.column_stack([columns[chosen], rows[chosen]])
    points = scan().points[rows[chosen], columns[chosen]].copy()
    points[3] *= 1.0 + 60.0 / np.abs(points[3, 2])  # along its ray, 60 mm behind the surface
    points = points if view is None else view.into_mesh(points)
    write_landmarks(tmp_path / "space.ljson", points / factor, TRUTH_ORDER)
    file = read_landmarks(tmp_path / "space.ljson")
    found = find_fiducials(file, "space.ljson", "closed", scan(), view=view, unit=unit)
    assert np.flatnonzero(found.hidden).tolist() == [3] and found.absent == {TRUTH_ORDER[3]: TRUTH_ORDER[3]}
    for k, name in enumerate(TRUTH_ORDER):
        if k != 3:
            assert found.positions[name] == pytest.approx(pixels[k], abs=1e-6)


def test_a_scan_without_its_camera_shows_the_rays_or_says_that_it_cannot() -> None:
    rows, columns = np.nonzero(scan().valid)
    chosen = np.random.default_rng(2).choice(len(rows), 40, replace=False)
    points = scan().points[rows[chosen], columns[chosen]]
    seen = project_points(points, RangeImage(scan().points, None, None))
    assert np.abs(seen.pixels - np.column_stack([columns[chosen], rows[chosen]])).max() < 0.01
    jitter = np.random.default_rng(3).normal(0, 20, scan().points.shape)
    with pytest.raises(InputError, match="camera is not known"):
        project_points(points, RangeImage(scan().points + jitter, None, None))


def test_a_fit_skips_what_a_layout_cannot_give_and_refuses_what_names_lack(
    tmp_path: Path, pts: Callable[..., Path]
) -> None:
    positions, skipped, remarks = fiducials_for_fit(pts(), "closed", scan(), FiducialOptions())
    assert skipped == ("forehead",) and len(positions) == 19 and remarks
    few = {name: TRUTH[name] for name in TRUTH_ORDER[:12]}
    write_landmarks(tmp_path / "few.csv", np.array(list(few.values())), list(few))
    with pytest.raises(InputError, match=r"nose_right, mouth_left.* and 3 more are missing; give --mapping"):
        fiducials_for_fit(tmp_path / "few.csv", "closed", scan(), FiducialOptions())
    write_landmarks(tmp_path / "two.pts", np.array([[1.0, 2.0], [5.0, 5.0]]), ["0", "1"])
    with pytest.raises(InputError, match="no point of scheme closed"):
        fiducials_for_fit(tmp_path / "two.pts", "closed", scan(), FiducialOptions())


def test_swapped_sides_are_noticed(pts: Callable[..., Path]) -> None:
    swap = {n: n.replace("left", "RIGHT").replace("right", "left").replace("RIGHT", "right") for n in IBUG.entries}
    wrong = LandmarkMapping("wrong", {swap[n]: s for n, s in IBUG.entries.items()}, "", 68)
    _, remarks = fiducials_from(pts(), "closed", SIZE, scan(), wrong)
    assert any("look swapped" in line for line in remarks)
    assert not any("look swapped" in line for line in fiducials_from(pts(), "closed", SIZE, scan())[1])


def run(capsys: pytest.CaptureFixture[str], *words: object, code: int = 0) -> dict[str, object]:
    assert main([*map(str, words), "--json"]) == code, capsys.readouterr().err
    out = capsys.readouterr().out
    return json.loads(out) if code == 0 else {}


def test_the_command_line_goes_through_every_format_and_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    start = tmp_path / "start.json"
    write_landmarks(start, np.array(list(TRUTH.values())), list(TRUTH), SIZE)
    names = [start, *(tmp_path / f"a{ending}" for ending in (".ljson", ".csv", ".json"))]
    for source, out in itertools.pairwise(names):
        size = () if source == start else ("--image-size", *SIZE)
        result = run(capsys, "fiducials", "convert", source, "--mapping", "none", *size, "--out", out)
        assert result["points"] == 20 and result["files"] == [str(out)]
    assert read_fiducials(names[-1]) == read_fiducials(start)
    run(capsys, "fiducials", "convert", start, "--mapping", "ibug68", "--out", tmp_path / "b.ljson")
    back = run(capsys, "fiducials", "convert", tmp_path / "b.ljson", "--scan", BASE, "--out", tmp_path / "c.json")
    assert back["mapping"] == "ibug68" and back["fiducials"] == 19 and back["unmapped"] == ["forehead"]
    for name, place in read_fiducials(tmp_path / "c.json").positions.items():
        assert place == pytest.approx(TRUTH[name], abs=1e-9)
    info = run(capsys, "fiducials", "info", tmp_path / "b.ljson")
    assert (info["format"], info["points"], info["present"], info["mapping"]) == ("ljson", 68, 19, "ibug68")


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("a.json", "--mapping", "ibug68", "--out", "o.pts"), "cannot leave them out"),
        (("a.json", "--out", "o.xyz"), "no ending that tells the format"),
        (("a.json", "--out", "a.json"), "would be replaced"),
        (("a.json", "--mapping", "nobody", "--out", "o.csv"), "mapping 'nobody'"),
        (("a.json", "--group", "b", "--out", "o.csv"), "no group 'b'"),
        (("a.json", "--origin", "0.3", "--out", "o.csv"), "origin"),
        (("a.json", "--scale", "--out", "o.csv"), "give --scan"),
        (("nothing.pts", "--out", "o.csv"), "there is no such file"),
    ],
)
def test_the_command_line_refuses_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    named: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    write_landmarks("a.json", np.array(list(TRUTH.values())), list(TRUTH), SIZE)
    before = Path("a.json").read_bytes()
    assert main(["fiducials", "convert", *words]) == 2
    err = capsys.readouterr().err
    assert named in err.splitlines()[-1], err
    assert Path("a.json").read_bytes() == before and len(list(tmp_path.iterdir())) == 1


@pytest.mark.skipif(not JAMES.exists(), reason="the trial mesh is not beside the project")
def test_the_trial_mesh_finds_its_own_points_on_its_surface() -> None:
    mesh = read_scan(JAMES.with_suffix(".obj"))
    assert mesh.view is not None
    file = read_landmarks(JAMES)
    found = find_fiducials(file, str(JAMES), "open", mesh.scan, view=mesh.view, unit=mesh.unit)
    assert found.mapping.name == "menpo_face" and len(found.usable) == 25 and not found.mirrored
    apart = {}
    for name in found.usable:
        if found.places[name] == "ok" and len(found.mapping.entries[name]) == 1:
            x, y = (round(v) for v in found.usable[name])
            seen = mesh.view.into_mesh(mesh.scan.points[y, x])[0]
            point = file.points[file.labels.index(found.mapping.entries[name][0])]
            apart[name] = float(np.linalg.norm(seen - point))
    assert len(apart) >= 20
    assert max(apart.values()) < 3.0, "a millimetre of noise, not another place of the face"


@pytest.mark.skipif(not VIDEO.exists(), reason="the trial video's points are not beside the project")
def test_the_trial_video_gives_one_face_a_frame(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("fiducials", "convert", VIDEO, "--image-size", 640, 360, "--group", "8", "--out", tmp_path / "f.json")
    assert run(capsys, *words)["fiducials"] == 19
    positions = read_fiducials(tmp_path / "f.json").positions
    table = np.loadtxt(VIDEO, delimiter=",")[2, 1:].reshape(-1, 2)
    assert positions["nose_tip"] == tuple(table[30]) and positions["eye_left_outer"] == tuple(table[45])
