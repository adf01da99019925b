"""The copied command names the unit where the user chose it, and only there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import resources
from engine.files.npz import write_npz
from engine.files.scan import read_scan
from engine.files.source import checked_file
from studio.project.document import ScanItem, SourceInfo
from studio.scan.job import as_command


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
