"""Depth images as float TIFF and OpenEXR, in millimetres and metres; what a sensor cannot measure is counted."""

from __future__ import annotations

import importlib.util
import json

import cv2
import numpy as np
import pytest

from engine.errors import InputError
from engine.files.exr import ExrDamagedError, exr_size
from engine.files.images import image_size, read_grey, read_image
from engine.files.scan import read_scan
from tests.engine.files.planted import CAMERA, planted_scan, write

OpenEXR = pytest.importorskip("OpenEXR", reason="the extra exr is not installed")

SCAN = planted_scan(colour=False)


def exr(path, compression="ZIP", **channels):
    """Write an EXR file of scan lines."""
    header = {"compression": getattr(OpenEXR, f"{compression}_COMPRESSION"), "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, dict(channels)).write(str(path))
    return path


def described(folder, name: str, unit_mm: float):
    fields = {"depth": name, "unit_mm": unit_mm, "fx": CAMERA.fx, "fy": CAMERA.fy, "cx": CAMERA.cx, "cy": CAMERA.cy}
    (folder / "s.json").write_text(json.dumps(fields))
    return folder / "s.json"


def depth(unit_mm: float) -> np.ndarray:
    return (-SCAN.points[..., 2] / unit_mm).astype(np.float32)


@pytest.mark.parametrize(("unit_mm", "step"), [(1.0, 2**-14), (1000.0, 1000 * 2**-24)])
@pytest.mark.parametrize("kind", ["tif", "exr"])
def test_float_depth_in_millimetres_and_metres(tmp_path, kind, unit_mm, step):
    stored = depth(unit_mm)
    if kind == "tif":
        cv2.imwrite(str(tmp_path / "d.tif"), stored)
    else:
        exr(tmp_path / "d.exr", Z=stored)
    found = read_scan(described(tmp_path, f"d.{kind}", unit_mm))
    np.testing.assert_array_equal(found.scan.valid, SCAN.valid)
    error = np.abs(found.scan.points - SCAN.points)[SCAN.valid]
    assert error.max() <= 2 * step
    assert found.warnings == ()


def test_what_no_sensor_measures_is_counted(tmp_path):
    stored = depth(1.0)
    stored[10, 10:14] = -5, np.inf, 1e10, 1e10
    cv2.imwrite(str(tmp_path / "d.tif"), stored)
    found = read_scan(described(tmp_path, "d.tif", 1.0))
    assert not found.scan.valid[10, 10:14].any()
    assert found.scan.valid.sum() == SCAN.valid.sum() - 4
    assert [warning.split(":")[0] for warning in found.warnings] == [
        "1 depths are negative",
        "1 depths are infinite",
        "2 depths are at a renderer's far end",
    ]


@pytest.mark.parametrize("compression", ["NO", "RLE", "ZIPS", "ZIP", "PIZ"])
@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_exr_is_lossless(tmp_path, compression, kind):
    stored = np.nan_to_num(depth(1.0)).astype(kind)
    path = exr(tmp_path / "d.exr", compression, depth=stored)
    assert image_size(path) == (SCAN.width, SCAN.height)
    np.testing.assert_array_equal(read_grey(path), stored.astype(np.float32))


def test_the_channel_of_depth(tmp_path):
    stored, other = depth(1.0), np.zeros((24, 32), np.float32)
    np.testing.assert_array_equal(read_grey(exr(tmp_path / "a.exr", Z=stored, A=other)), stored)
    np.testing.assert_array_equal(read_grey(exr(tmp_path / "b.exr", distance=stored)), stored)
    with pytest.raises(InputError, match="no channel of depth among a, b; name it Z"):
        read_grey(exr(tmp_path / "c.exr", a=stored, b=other))
    with pytest.raises(InputError, match="read for depth only"):
        read_image(tmp_path / "a.exr")


def test_without_the_extra_its_name_is_told(tmp_path, monkeypatch):
    path = exr(tmp_path / "d.exr", Z=depth(1.0))
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"needs the package OpenEXR; install quasiface-studio\[exr\]"):
        read_grey(path)


def test_headers_that_lie_are_refused_before_the_library_sees_them(tmp_path):
    data = exr(tmp_path / "d.exr", Z=depth(1.0)).read_bytes()
    window = data.index(b"box2i\0") + 10
    for corner in ((10**9, 10**9), (-5, 10), (2**31 - 1, 0), (10**5, 10**5)):
        lie = data[: window + 8] + np.array(corner, "<i4").tobytes() + data[window + 16 :]
        with pytest.raises(InputError, match=r"million|its size|channels of"):
            read_grey(write(tmp_path / "lie.exr", lie))
    for length in range(4, window + 40, 3):
        with pytest.raises(ExrDamagedError):
            exr_size(data[:length])
    with pytest.raises(InputError, match="tiled, deep or in several parts"):
        read_grey(write(tmp_path / "tiles.exr", data[:5] + b"\2" + data[6:]))


def test_damage_is_seen_and_nothing_is_printed(tmp_path, capfd):
    ramp = np.tile(np.arange(200, dtype=np.float32), (40, 1))  # packs well, so that no line is stored as it is
    data = bytearray(exr(tmp_path / "d.exr", Z=ramp).read_bytes())
    data[-60:-10] = bytes(50)
    for damaged in (bytes(data), bytes(data[:-200])):
        with pytest.raises(InputError, match="damaged EXR image, or cut off"):
            read_grey(write(tmp_path / "bad.exr", damaged))
    assert capfd.readouterr() == ("", "")
