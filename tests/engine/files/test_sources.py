"""Files that others name: no device is read for ever, no absurd size believed, one border for every check."""

from __future__ import annotations

import json
import os

import cv2
import numpy as np
import pytest

from engine.errors import InputError
from engine.files.atomic import atomic_write, check_writable
from engine.files.depth_json import write_depth_scan
from engine.files.landmarks_json import Fiducials, check_fiducials
from engine.files.npz import write_npz
from engine.files.ply import write_ply
from engine.files.scan import read_scan
from engine.files.scheme import read_scheme
from engine.files.source import kind_of
from engine.files.template import read_template
from engine.landmarks import inside
from engine.scan.range_image import RangeImage
from engine.scan.warp import check_inside
from tests.engine.files.planted import planted_scan


@pytest.mark.parametrize("reader", [read_template, read_scheme])
def test_a_template_or_scheme_is_a_regular_file(tmp_path, reader):
    os.mkfifo(tmp_path / "pipe")
    for path in ("/dev/zero", tmp_path / "pipe"):
        with pytest.raises(InputError, match="is not a regular file"):
            reader(path)
    with pytest.raises(InputError, match="is a folder"):
        reader(tmp_path)
    with (tmp_path / "large").open("wb") as handle:
        handle.truncate(65 << 20)
    with pytest.raises(InputError, match="MB, more than"):
        reader(tmp_path / "large")


def test_a_field_that_is_wrong_is_named_after_its_file(tmp_path):
    (tmp_path / "t.json").write_text('{"name": "t", "faces": [], "mirror": [], "layouts": 3}')
    with pytest.raises(InputError, match=r"t\.json, layouts: .*; choose a face template"):
        read_template(tmp_path / "t.json")
    (tmp_path / "t.json").write_text('{"name": "t", "faces": [[0, 1, 9]], "mirror": [0, 1], "layouts": {}}')
    with pytest.raises(InputError, match=r"t\.json, template t: a face index is outside"):
        read_template(tmp_path / "t.json")
    (tmp_path / "t.json").write_text(json.dumps({"name": "t", "faces": [[0, 1, 10**30]], "mirror": [], "layouts": {}}))
    with pytest.raises(InputError, match=r"t\.json, faces"):
        read_template(tmp_path / "t.json")
    (tmp_path / "s.toml").write_text('name = "s"\n')
    with pytest.raises(InputError, match=r"s\.toml, (title|landmark): .*; compare with a bundled scheme"):
        read_scheme(tmp_path / "s.toml")


@pytest.mark.parametrize("writer", [(write_npz, "s.npz"), (write_ply, "s.ply")])
def test_a_coordinate_beyond_a_kilometre_is_refused(tmp_path, writer):
    write, name = writer
    scan = planted_scan()
    for value, fits in ((9.9e5, True), (-9.9e5, True), (1.01e6, False), (-1.01e6, False), (3e38, False)):
        points = scan.points.copy()
        points[10, 10, 0] = value
        write(tmp_path / name, RangeImage(points, scan.colour))
        if fits:
            assert read_scan(tmp_path / name, "mm").scan.points[10, 10, 0] == value
        else:
            with pytest.raises(InputError, match=rf"{name}, points: a coordinate of .* check whether it is in mm"):
                read_scan(tmp_path / name, "mm")
    points = scan.points.copy()
    points[10, 10, 0] = 2e3
    write(tmp_path / name, RangeImage(points, scan.colour))
    with pytest.raises(InputError, match=r"2e\+06 mm.* in m$" if name == "s.npz" else "mm"):
        read_scan(tmp_path / name, "m")


def test_absurd_depth_and_focal_lengths_are_refused(tmp_path):
    path = tmp_path / "s.json"
    write_depth_scan(path, planted_scan(colour=False))
    fields = json.loads(path.read_text())

    def refused(**changes: object) -> str:
        path.write_text(json.dumps(fields | changes))
        with pytest.raises(InputError) as caught:
            read_scan(path)
        return str(caught.value)

    assert f"{path}, points: " in refused(unit_mm=1e4) and "check unit_mm" in refused(unit_mm=1e4)
    assert f"{path}, fx: " in refused(fx=1e-300)
    depth = np.full((24, 32), 650.0, np.float32)
    depth[3, 4] = 3e38
    cv2.imwrite(str(tmp_path / "d.tif"), depth)
    assert "3e+38 mm" in refused(depth="d.tif", unit_mm=1.0)


def test_names_too_long_for_the_system_are_refused(tmp_path):
    for path in (tmp_path / ("x" * 300), tmp_path / ("x" * 300) / "face.glb"):
        with pytest.raises(InputError, match="cannot be used"):
            kind_of(path)
        with pytest.raises(InputError, match="cannot be used"):
            check_writable(path)
    assert kind_of(tmp_path / "none" / "x") is None
    assert kind_of(tmp_path) == "folder"
    assert kind_of(__file__) == "file"
    assert kind_of("/dev/null") == "other"


def test_every_name_that_the_system_takes_can_be_written(tmp_path):
    for name in ("x" * 255, "é" * 127, "面" * 85, "🙂" * 63):
        check_writable(tmp_path / name)
        with atomic_write(tmp_path / name) as handle:
            handle.write(b"a")
        assert (tmp_path / name).read_bytes() == b"a"


@pytest.mark.parametrize(
    ("place", "is_inside"),
    [
        ((-0.5, -0.5), True),
        ((7.5, 5.5), True),
        ((-0.51, 2.0), False),
        ((7.51, 2.0), False),
        ((2.0, -0.51), False),
        ((2.0, 5.51), False),
        ((float("nan"), 2.0), False),
        ((2.0, float("inf")), False),
    ],
)
def test_the_border_pixels_belong_to_the_picture_whole(place, is_inside):
    assert inside(*place, 8, 6) is is_inside
    checks = (
        lambda: check_fiducials(Fiducials({"chin": place}, (8, 6)), ["chin"], (8, 6)),
        lambda: check_inside({"chin": place}, 8, 6),
    )
    for check in checks:
        if is_inside:
            check()
        else:
            with pytest.raises(InputError):
                check()
