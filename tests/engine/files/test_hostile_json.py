"""JSON files that lie, and the images they name."""

from __future__ import annotations

import json
import re

import cv2
import numpy as np
import pytest

from engine.files.depth_json import write_depth_scan
from engine.files.scan import read_scan
from tests.engine.files.planted import planted_scan, write
from tests.engine.files.refusals import SMALL, refused


@pytest.fixture
def depth_scan(tmp_path):
    """A depth scan in a folder of its own, and a function that changes fields of it."""
    folder = tmp_path / "scan"
    folder.mkdir()
    write_depth_scan(folder / "s.json", planted_scan(**SMALL))
    original = json.loads((folder / "s.json").read_text())

    def change(**fields):
        merged = {key: value for key, value in {**original, **fields}.items() if value is not ...}
        (folder / "s.json").write_text(json.dumps(merged))
        return folder / "s.json"

    return change


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *(("unit_mm", value) for value in (0, -1, float("nan"), float("inf"), "1", None, True, [1], ..., 1e30)),
        *(("fx", value) for value in (0, 0.0, -5, float("nan"), float("-inf"), "500", None, ..., 10**400)),
        *(("cy", value) for value in (float("nan"), float("inf"), "x", None, ..., 1e300)),
        *(("depth", value) for value in (None, 1, [], "", ".", "  ", "no.png", "a\0b", "x" * 5000)),
        *(("colour", value) for value in (1, "", "no.png", "s.json")),
    ],
)
def test_the_bad_field_is_named(depth_scan, field, value):
    change = {"depth": ...} if (field, value) == ("depth", None) else {field: value}
    assert re.search(rf"\b{field}\b|no.png|s.json: is not a PNG", refused(read_scan, depth_scan(**change)))


def test_paths_stay_in_the_folder(depth_scan, tmp_path):
    path = depth_scan()
    outside = write(tmp_path / "outside.png", (path.parent / "s_depth.png").read_bytes())
    (path.parent / "link.png").symlink_to(outside)
    (path.parent / "up").symlink_to(tmp_path)
    (path.parent / "inner").symlink_to(path.parent / "s_depth.png")
    absolute = [str(outside), "/etc/passwd", "C:\\outside.png", "C:outside.png", "\\\\server\\share\\outside.png"]
    upwards = ["../outside.png", "a/../../outside.png", "..\\outside.png", "link.png", "up/outside.png"]
    for name in absolute + upwards:
        assert "depth" in refused(read_scan, depth_scan(depth=name)), name
    assert read_scan(depth_scan(depth="inner")).scan.width == SMALL["width"]


def test_images_that_do_not_belong_together(depth_scan):
    path = depth_scan()
    cv2.imwrite(str(path.parent / "big.png"), np.zeros((12, 16, 3), np.uint8))
    assert "16 x 12 pixels, the depth image 8 x 6" in refused(read_scan, depth_scan(colour="big.png"))
    assert "3 channels" in refused(read_scan, depth_scan(depth="s_colour.png"))
    cv2.imwrite(str(path.parent / "empty.png"), np.zeros((6, 8), np.uint16))
    assert "no valid pixel" in refused(read_scan, depth_scan(depth="empty.png"))
    (path.parent / "s_colour.png").unlink()
    assert "s_colour.png" in refused(read_scan, depth_scan())
    nothing = {"disparity": "empty.png", "disparity_min": 0, "disparity_max": 3}
    assert "no valid pixel" in refused(read_scan, depth_scan(depth=..., colour=..., **nothing))
    for bad in ({"disparity_max": 0}, {"disparity_min": 4}, {"fx": 5, "fy": ...}, {"focal_35mm": 0}):
        refused(read_scan, depth_scan(**{"depth": ..., "colour": ..., "fx": ..., "fy": ..., **nothing, **bad}))


@pytest.mark.parametrize(
    "data",
    [
        b"\xff\xfe{\0}\0",
        b'{"depth": "\xe4.png"}',
        b"[" * 10**6,
        b'{"a":' * 10**5,
        b"null",
        b"3",
        b"{}",
        b"\0" * 100,
        b'{"depth": "a", "depth": "b"}',
        b'{"depth": 1' + b"0" * 10**5 + b"}",
    ],
)
def test_text_that_is_not_the_json_it_should_be(tmp_path, data):
    refused(read_scan, write(tmp_path / "s.json", data))
