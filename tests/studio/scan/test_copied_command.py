"""The copied command names the unit where the user chose it, and only there, and the fiducials that were skipped."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import resources
from engine.files.landmarks_json import read_fiducials, write_fiducials
from engine.files.npz import write_npz
from engine.files.scan import read_scan
from engine.files.source import checked_file
from engine.landmarks import Landmark, LandmarkSet, LandmarkState
from studio.cli import main
from studio.project.document import ScanItem, SourceInfo
from studio.scan.job import FitInputs, as_command, figures, run, usable_fiducials


def item_of(path: Path, unit: str | None) -> ScanItem:
    """Return a scan as it is read from ``path``."""
    file = read_scan(checked_file(path), unit)
    return ScanItem("a", "a", "", source=SourceInfo(str(path), file.unit, file.assumed))


@pytest.mark.parametrize("unit", [None, "mm", "cm", "m"])
def test_a_file_without_a_unit_gets_the_one_that_was_chosen(tmp_path: Path, unit: str | None) -> None:
    points = np.random.default_rng(0).normal(size=(20, 20, 3)) - [0, 0, 600]
    np.savez(tmp_path / "a.npz", points=points)
    item = item_of(tmp_path / "a.npz", unit)
    assert item.source.unit_open
    words = as_command(item, item.options).split()
    assert ("--unit" in words) == (unit is not None)
    assert unit is None or words[words.index("--unit") + 1] == unit


def test_a_file_that_states_its_unit_gets_none(tmp_path: Path) -> None:
    sample = read_scan(resources.sample_path("subject", "base.json")).scan
    write_npz(tmp_path / "a.npz", sample)
    for path in (tmp_path / "a.npz", resources.sample_path("subject", "base.json")):
        item = item_of(path, None)
        assert not item.source.unit_open and "--unit" not in as_command(item, item.options)
    disparity = SourceInfo("d.json", "m", "disparity in 1/m, as in the file; 30 mm assumed: the file names none")
    item = replace(item, source=disparity)
    assert not item.source.unit_open and "--unit" not in as_command(item, item.options)


def test_a_skipped_fiducial_is_skipped_by_the_command_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What the window fits without a point, the command fits without it from the file that Export fiducials writes."""
    path = resources.sample_path("subject", "base.json")
    true = read_fiducials(resources.sample_path("subject", "base_fiducials.json"))
    landmarks = LandmarkSet.placed({name: place for name, place in true.positions.items() if name != "forehead"})
    landmarks = landmarks.with_point("forehead", Landmark(state=LandmarkState.SKIPPED))
    item = replace(item_of(path, None), landmarks=landmarks)
    placed = usable_fiducials(item.landmarks, "closed")
    write_fiducials(tmp_path / "f.json", placed, true.image_size)
    words = shlex.split(as_command(item, item.options, str(tmp_path / "f.json"), str(tmp_path / "a.glb")))
    assert words[words.index("--skip") + 1] == "forehead"
    assert main([*words[1:], "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    face = run(FitInputs(read_scan(path).scan, placed), item.options)
    assert told["skipped_fiducials"] == ["forehead"] and told["median_mm"] == pytest.approx(figures(face)["median_mm"])
    assert main([*(word for word in words[1:] if word not in ("--skip", "forehead"))]) == 2
    assert "forehead is missing" in capsys.readouterr().err
    assert main([*words[1:], "--skip", "ear"]) == 2
    assert "ear is not in scheme closed" in capsys.readouterr().err
