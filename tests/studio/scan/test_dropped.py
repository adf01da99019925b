"""What dropped files and folders are taken for."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import resources
from engine.files.landmarks import write_landmarks
from engine.files.landmarks_json import read_fiducials
from engine.landmarks import LandmarkState
from engine.progress import silent
from engine.scan.mouth import INNER_FRACTIONS
from studio.scan.dropped import ScanToRead, fiducials_beside, scans_in, sort_files
from studio.scan.loading import load_scan


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("base", "car"):
        for file in resources.sample_path("subject").glob(f"{name}*"):
            shutil.copy(file, tmp_path)
    return tmp_path


def test_a_folder_gives_its_scans_in_natural_order_with_their_fiducials(folder: Path) -> None:
    for number in (10, 9, 2):
        (folder / f"take{number}.npz").write_bytes(b"x")
    (folder / ".hidden.npz").write_bytes(b"x")
    (folder / "take9.pts").write_text("version: 1\n")
    (folder / "deeper").mkdir()
    shutil.copy(folder / "take2.npz", folder / "deeper" / "not_asked_for.npz")
    dropped = sort_files([folder])
    assert [scan.path.name for scan in dropped.scans] == [
        "base.json",
        "car.json",
        "take2.npz",
        "take9.npz",
        "take10.npz",
    ]
    assert [scan.fiducials and scan.fiducials.name for scan in dropped.scans] == [
        "base_fiducials.json", "car_fiducials.json", None, "take9.pts", None,
    ]  # fmt: skip
    assert dropped.fiducials == () and dropped.left_out == ()


def test_fiducials_go_with_their_scan_or_stand_alone(folder: Path) -> None:
    scan, points = folder / "base.json", folder / "base_fiducials.json"
    assert sort_files([scan, points]).fiducials == ()
    assert sort_files([points]).fiducials == (points,) and sort_files([points]).scans == ()
    assert fiducials_beside(scan) == points
    (folder / "notes.txt").write_text("read me")
    (folder / "odd.pdf").write_bytes(b"x")
    left = sort_files([folder / "odd.pdf"]).left_out
    assert len(left) == 1 and "odd.pdf" in left[0]


def test_json_is_told_by_what_it_holds(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(json.dumps({"image_size": [4, 4], "points": {}}))
    (tmp_path / "b.json").write_text(json.dumps({"depth": "b.png", "points": {}}))
    (tmp_path / "c.json").write_text("{broken")
    assert [path.name for path in scans_in(tmp_path)] == ["b.json", "c.json"]


def test_the_scheme_follows_the_fiducials_and_bad_ones_are_left_out_with_a_remark(folder: Path) -> None:
    car = load_scan(ScanToRead(folder / "car.json", folder / "car_fiducials.json"), silent)
    base = load_scan(ScanToRead(folder / "base.json", folder / "base_fiducials.json"), silent)
    assert (car.item.scheme, base.item.scheme) == ("open", "closed")
    assert (len(car.item.landmarks.points), len(base.item.landmarks.points)) == (26, 20)
    document = json.loads((folder / "base_fiducials.json").read_text())
    document["points"]["chin"] = [9000, 3]
    (folder / "base_fiducials.json").write_text(json.dumps(document))
    spoilt = load_scan(ScanToRead(folder / "base.json", folder / "base_fiducials.json"), silent)
    states = {name: point.state for name, point in spoilt.item.landmarks.points.items()}
    assert states.pop("chin") == LandmarkState.PROPOSED  # by the others
    assert set(states.values()) == {LandmarkState.PLACED} and len(states) == 19
    assert any("chin" in remark and "outside" in remark for remark in spoilt.remarks)
    (folder / "base_fiducials.json").write_text('{"points": 3}')
    lost = load_scan(ScanToRead(folder / "base.json", folder / "base_fiducials.json"), silent)
    assert not lost.item.landmarks.points and any("left out" in remark for remark in lost.remarks)


@pytest.mark.parametrize(("name", "scheme"), [("base", "closed"), ("car", "open")])
def test_points_of_another_tool_come_along_and_the_mouth_tells_the_scheme(folder: Path, name: str, scheme: str) -> None:
    """A layout of 68 points has inner lips whether the mouth is open or not."""
    true = read_fiducials(resources.sample_path("subject", f"{name}_fiducials.json")).positions
    if name == "base":  # a closed mouth's inner lips lie on its line
        middle = np.mean([true["mouth_left"], true["mouth_right"]], axis=0)
        true |= {inner: (middle[0] + k, middle[1] + 0.1 * k) for k, inner in enumerate(sorted(INNER_FRACTIONS))}
    write_landmarks(folder / f"{name}.csv", np.array(list(true.values())), tuple(true))
    (folder / f"{name}_fiducials.json").unlink()
    loaded = load_scan(ScanToRead(folder / f"{name}.json", fiducials_beside(folder / f"{name}.json")), silent)
    assert loaded.item.scheme == scheme
    for landmark, point in loaded.item.landmarks.points.items():
        np.testing.assert_allclose((point.x, point.y), true[landmark], atol=1e-6)
    assert len(loaded.item.landmarks.points) == (26 if scheme == "open" else 20)
