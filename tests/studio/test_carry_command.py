"""Fiducials carried from the command line are those that the engine finds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import resources
from engine.files.landmarks_json import read_fiducials
from engine.files.scan import read_scan
from engine.scan.carry import carry_fiducials
from studio.cli import main


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
