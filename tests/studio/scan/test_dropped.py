"""What dropped files and folders are taken for."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

import resources
from engine.progress import silent
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
    assert not spoilt.item.landmarks.points and any("chin" in remark for remark in spoilt.remarks)
