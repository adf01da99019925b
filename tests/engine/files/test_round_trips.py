"""What is written comes back, and every form of the same scan reads the same."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from engine.errors import InputError
from engine.files.depth_json import write_depth_scan
from engine.files.npz import write_npz
from engine.files.ply import write_ply
from engine.files.scan import read_scan
from engine.scan.range_image import RangeImage
from tests.engine.files.planted import CAMERA, planted_scan, ply_bytes, write

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}


@pytest.mark.parametrize("colour", [True, False])
@pytest.mark.parametrize(("suffix", "writer"), [(".npz", write_npz), (".ply", write_ply)])
def test_npz_and_ply_are_lossless(tmp_path, suffix, writer, colour):
    scan = planted_scan(colour=colour)
    path = tmp_path / f"a scan{suffix}"
    writer(path, scan)
    found = read_scan(path)
    np.testing.assert_array_equal(found.scan.points, scan.points)
    if colour:
        np.testing.assert_array_equal(found.scan.colour, scan.colour)
    else:
        assert found.scan.colour is None
    assert found.scan.camera == CAMERA
    assert (found.unit, found.assumed, found.warnings) == ("mm", "mm, as in the file", ())
    assert found.source_files == (path,)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("unit_mm", [0.02, 0.1])
def test_a_depth_scan_comes_back_within_half_a_step_along_the_ray(tmp_path, unit_mm):
    scan = planted_scan()
    write_depth_scan(tmp_path / "head.json", scan, unit_mm=unit_mm)
    found = read_scan(tmp_path / "head.json")
    valid = scan.valid
    np.testing.assert_array_equal(found.scan.valid, valid)
    error = found.scan.points[..., 2][valid] - scan.points[..., 2][valid]
    assert np.abs(error).max() <= unit_mm / 2 + 1e-9
    assert np.abs(error).max() > unit_mm / 4  # it was rounded, and not to something finer
    np.testing.assert_allclose(
        found.scan.camera.project(found.scan.points[valid]), np.argwhere(valid)[:, ::-1], atol=1e-9
    )
    np.testing.assert_array_equal(found.scan.colour, scan.colour)
    assert [p.name for p in found.source_files] == ["head.json", "head_depth.png", "head_colour.png"]
    assert found.format == "depth"


def test_a_depth_scan_refuses_what_it_cannot_hold(tmp_path):
    scan = planted_scan()
    with pytest.raises(InputError, match="no camera"):
        write_depth_scan(tmp_path / "a.json", RangeImage(scan.points))
    with pytest.raises(InputError, match="rays"):
        write_depth_scan(tmp_path / "a.json", RangeImage(scan.points + np.array([5.0, 0, 0]), None, CAMERA))
    with pytest.raises(InputError, match=r"at least 0\.01"):
        write_depth_scan(tmp_path / "a.json", scan, unit_mm=0.001)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("colour", [True, False])
@pytest.mark.parametrize("kind", ["float", "double"])
@pytest.mark.parametrize("form", ["full", "grid"])
@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_every_form_of_ply_reads_the_same(tmp_path, encoding, form, kind, colour):
    scan = planted_scan(colour=colour)
    path = write(tmp_path / "scan.ply", ply_bytes(scan, encoding, form, kind))
    found = read_scan(path, "mm").scan
    exact = encoding == "ascii" or kind == "double"
    expected = scan.points if exact else scan.points.astype(np.float32).astype(np.float64)
    np.testing.assert_array_equal(found.points, expected)
    if colour:
        valid = scan.valid if form == "grid" else np.ones_like(scan.valid)
        np.testing.assert_array_equal(found.colour[valid], scan.colour[valid])
    else:
        assert found.colour is None


@pytest.mark.parametrize("unit", UNITS)
def test_units_are_applied_and_reported(tmp_path, unit):
    scan = planted_scan()
    path = write(tmp_path / "s.ply", ply_bytes(scan, "binary_little_endian", "full", "double", 1 / UNITS[unit]))
    found = read_scan(path, unit)
    np.testing.assert_allclose(found.scan.points, scan.points, rtol=1e-14)
    assert (found.unit, found.assumed, found.warnings) == (unit, f"{unit}, as asked", ())
    np.savez(tmp_path / "s.npz", points=scan.points / UNITS[unit])
    np.testing.assert_allclose(read_scan(tmp_path / "s.npz", unit).scan.points, scan.points, rtol=1e-14)


def test_a_wrong_unit_is_warned_of_with_the_right_one(tmp_path):
    scan = planted_scan()
    metres = write(tmp_path / "metres.ply", ply_bytes(scan, "binary_little_endian", "full", "double", 1e-3))
    found = read_scan(metres)
    assert found.assumed == "mm assumed: the file names no unit"
    assert len(found.warnings) == 1
    assert "rather m than mm" in found.warnings[0]
    write_ply(tmp_path / "mm.ply", scan)
    found = read_scan(tmp_path / "mm.ply", "m")
    assert "names mm" in found.warnings[0]
    assert "rather mm or cm than m" in found.warnings[1] or "rather mm than m" in found.warnings[1]
    with pytest.raises(InputError, match="mm, cm or m"):
        read_scan(metres, "inch")


def test_a_range_grid_from_bottom_to_top_is_turned_and_said(tmp_path):
    scan = planted_scan()
    path = write(tmp_path / "s.ply", ply_bytes(scan, "binary_big_endian", "grid", "double", upwards=True))
    found = read_scan(path, "mm")
    np.testing.assert_array_equal(found.scan.points, scan.points)
    np.testing.assert_array_equal(found.scan.colour[scan.valid], scan.colour[scan.valid])
    assert found.assumed.endswith("turned")
    full = write(tmp_path / "f.ply", ply_bytes(scan, "binary_big_endian", "full", "double", upwards=True))
    assert any("on its head" in warning for warning in read_scan(full).warnings)


def test_a_camera_that_contradicts_the_points_is_left_out(tmp_path):
    scan = planted_scan()
    np.savez(tmp_path / "s.npz", points=scan.points, camera=[90.0, 90.0, 15.2, 11.7])
    found = read_scan(tmp_path / "s.npz")
    assert found.scan.camera is None
    assert "left out" in found.warnings[0]


@pytest.mark.parametrize("dtype", ["<f4", ">f8", "<i4"])
@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_npz_in_every_layout(tmp_path, dtype, order, save):
    points = np.asarray(planted_scan(missing=False).points.astype(dtype), order=order)
    save(tmp_path / "s.npz", points=points)
    np.testing.assert_array_equal(read_scan(tmp_path / "s.npz").scan.points, points.astype(np.float64))


@pytest.mark.parametrize(("suffix", "dtype"), [(".png", np.uint16), (".tif", np.uint16), (".tif", np.float32)])
def test_depth_images_of_other_kinds(tmp_path, suffix, dtype):
    depth = np.full((24, 32), 6500, dtype=dtype)
    depth[0, 0] = 0
    if dtype == np.float32:
        depth[1, 1], depth[2, 2], depth[3, 3] = np.nan, np.inf, -4
    cv2.imwrite(str(tmp_path / f"d{suffix}"), depth)
    fields = {"depth": f"d{suffix}", "unit_mm": 0.1, "fx": 60, "fy": 60.0, "cx": 15.5, "cy": 11.5, "note": "x"}
    (tmp_path / "s.json").write_text(json.dumps(fields))
    scan = read_scan(tmp_path / "s.json").scan
    assert (~scan.valid).sum() == (1 if dtype == np.uint16 else 4)
    np.testing.assert_allclose(scan.points[scan.valid][:, 2], -650.0, atol=1e-9)
    assert scan.colour is None


def test_disparity_becomes_depth(tmp_path):
    disparity = np.full((24, 32), 255, dtype=np.uint8)
    disparity[:, :16] = 51
    cv2.imwrite(str(tmp_path / "d.png"), disparity)
    cv2.imwrite(str(tmp_path / "c.png"), np.full((48, 64, 3), (10, 20, 30), dtype=np.uint8))
    fields = {"disparity": "d.png", "colour": "c.png", "disparity_min": 1.0, "disparity_max": 3.5, "focal_35mm": 26}
    (tmp_path / "s.json").write_text(json.dumps(fields))
    found = read_scan(tmp_path / "s.json")
    np.testing.assert_allclose(-found.scan.points[:, 16:, 2], 1000 / 3.5)
    np.testing.assert_allclose(-found.scan.points[:, :16, 2], 1000 / 1.5)
    assert found.scan.camera.fx == pytest.approx(26 * 40 / np.hypot(36, 24), rel=1e-5)
    assert (found.scan.colour == (30, 20, 10)).all()
    assert found.scan.colour.shape == (24, 32, 3)
    assert any("scaled from 64 x 48" in warning for warning in found.warnings)
    assert any("coarse" in warning for warning in found.warnings)


def test_the_first_bytes_decide_where_the_ending_says_nothing(tmp_path):
    scan = planted_scan()
    for name, writer in (("a.scan", write_npz), ("b", write_ply)):
        writer(tmp_path / name, scan)
        np.testing.assert_array_equal(read_scan(tmp_path / name).scan.points, scan.points)


def test_a_unit_for_a_file_that_states_its_own_is_said_not_to_apply(tmp_path):
    write_depth_scan(tmp_path / "s.json", planted_scan())
    found = read_scan(tmp_path / "s.json", "cm")
    assert found.unit == "mm"
    assert "not applied" in found.warnings[-1]
