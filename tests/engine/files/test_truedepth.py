"""A real scan of a phone's depth camera, in the disparity form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.files.scan import read_scan

FOLDER = Path(__file__).parents[4] / "shared" / "data" / "scans" / "truedepth_frontal"

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="../shared/data is not here: real scans are not shipped")


def test_a_head_of_plausible_size_comes_out():
    found = read_scan(FOLDER / "scan.json")
    scan = found.scan
    assert (scan.width, scan.height) == (480, 640)
    assert scan.missing_fraction == 0.0
    assert scan.colour.shape == scan.points.shape
    assert "30 mm" in found.assumed
    assert any("coarse" in warning for warning in found.warnings)
    assert any("1158 x 1544" in warning for warning in found.warnings)
    # Pupils, read off the picture: adults' are 54 to 74 mm apart. The head stands free before the wall.
    right, left = scan.points[273, 177], scan.points[273, 286]
    assert 54 < left[0] - right[0] < 74
    assert 300 < -scan.points[273, 230, 2] < 400
    temple = scan.points[240]
    head = temple[-temple[:, 2] < 450]
    assert 130 < np.ptp(head[:, 0]) < 190
