"""Fiducials carried from the command line are those that the engine finds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import resources
from engine.files.landmarks import write_landmarks
from engine.files.landmarks_json import read_fiducials
from engine.files.obj import write_obj
from engine.files.scan import read_scan
from engine.scan.carry import carry_fiducials
from studio.cli import main
from tests.engine.scan.truth import true_scan


def sample(name: str) -> Path:
    return resources.sample_path("subject", name)


def test_carry_writes_one_file_per_scan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["fiducials", "carry", str(sample("base.json")), str(sample("car.json")), str(sample("base.json"))]
    words += ["--fiducials", str(sample("base_fiducials.json")), "--out", str(tmp_path / "new"), "--json"]
    assert main(words) == 0
    first, second = json.loads(capsys.readouterr().out)["carried"]
    assert (first["scheme"], first["fiducials"]) == ("open", 26) and (second["scheme"], second["fiducials"]) == (
        "closed",
        20,
    )
    base, car = (read_scan(sample(f"{name}.json")).scan for name in ("base", "car"))
    start = read_fiducials(sample("base_fiducials.json")).positions
    expected = carry_fiducials(base, start, car)
    written = read_fiducials(Path(first["file"])).positions
    assert set(first["certain"]) == expected.certain
    for name, place in expected.positions.items():
        np.testing.assert_allclose(written[name], place, atol=1e-9)
    itself = read_fiducials(Path(second["file"])).positions
    assert max(np.hypot(*np.subtract(itself[name], start[name])) for name in start) < 0.05


def test_carry_refuses_in_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["fiducials", "carry", str(sample("base.json")), "--fiducials", str(sample("base_fiducials.json"))]
    assert main([*words, "--out", str(tmp_path)]) == 2
    known = Path(tmp_path / "base_fiducials.json")
    known.write_bytes(sample("base_fiducials.json").read_bytes())
    again = ["fiducials", "carry", str(sample("base.json")), str(sample("base.json"))]
    assert main([*again, "--fiducials", str(known), "--out", str(tmp_path)]) == 2
    assert "would be replaced" in capsys.readouterr().err.strip().splitlines()[-1]


def test_what_was_placed_by_hand_is_not_replaced_unasked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    placed = tmp_path / "car_fiducials.json"
    placed.write_bytes(sample("car_fiducials.json").read_bytes())
    words = ["fiducials", "carry", str(sample("base.json")), str(sample("car.json"))]
    words += ["--fiducials", str(sample("base_fiducials.json")), "--out", str(tmp_path)]
    assert main(words) == 2
    assert "car_fiducials.json" in capsys.readouterr().err
    assert placed.read_bytes() == sample("car_fiducials.json").read_bytes()
    assert main([*words, "--replace"]) == 0
    assert placed.read_bytes() != sample("car_fiducials.json").read_bytes()


def test_points_in_space_are_carried_from_a_mesh(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Points on a mesh reach its picture by the view that it is seen with."""
    head = true_scan("base")
    write_obj(tmp_path / "head.obj", head.face_skin_mesh())
    names = list(head.fiducials)
    write_landmarks(tmp_path / "head.ljson", np.array([head.position(name) for name in names]), names)
    words = ["fiducials", "carry", str(tmp_path / "head.obj"), str(tmp_path / "head.obj"), "--json"]
    assert main([*words, "--fiducials", str(tmp_path / "head.ljson"), "--out", str(tmp_path / "out")]) == 0
    (told,) = json.loads(capsys.readouterr().out)["carried"]
    file = read_scan(tmp_path / "head.obj")
    true = file.view.project(np.array([head.position(name) for name in names]))
    written = read_fiducials(Path(told["file"])).positions
    off = [
        np.hypot(*np.subtract(written[name], place)) for name, place in zip(names, true, strict=True) if name in written
    ]
    assert len(off) >= 18 and np.median(off) < 0.5


def test_converting_keeps_the_mapping_it_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mapping = tmp_path / "map.json"
    mapping.write_text(json.dumps({"name": "mine", "count": 20, "fiducials": {"chin": 0}}))
    before = mapping.read_bytes()
    words = [
        "fiducials",
        "convert",
        str(sample("base_fiducials.json")),
        "--mapping",
        str(mapping),
        "--out",
        str(mapping),
    ]
    assert main(words) == 2
    assert mapping.read_bytes() == before
