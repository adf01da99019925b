"""PCD in every storage, frame and colour comes back as it was planted."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.lzf import LzfError, unpack_lzf
from engine.files.scan import read_scan
from tests.engine.files.foreign import OPTICAL, lzf_pack, pcd_bytes
from tests.engine.files.planted import CAMERA, planted_scan, write

SCAN = planted_scan(48, 36)
STORAGES = ("ascii", "binary", "binary_compressed")


def steps(values: np.ndarray) -> np.ndarray:
    """Half the distance of neighbouring 4-byte floats in metres, in mm."""
    return np.spacing(np.abs(values / 1000).astype(np.float32)).astype(np.float64) * 500


@pytest.mark.parametrize("colour", ["", "rgb F4", "rgba U4", "rgb U1", "rgb F4 channels"])
@pytest.mark.parametrize("storage", STORAGES)
def test_every_storage_and_colour(tmp_path, storage, colour):
    found = read_scan(write(tmp_path / "s.pcd", pcd_bytes(SCAN, storage, colour=colour)))
    np.testing.assert_array_equal(found.scan.valid, SCAN.valid)
    error = np.abs(found.scan.points - SCAN.points)[SCAN.valid]
    roundings = 2 if storage == "ascii" else 1
    assert (error <= roundings * steps(SCAN.points[SCAN.valid]) + 1e-9).all()
    if colour:
        np.testing.assert_array_equal(found.scan.colour, SCAN.colour)
    else:
        assert found.scan.colour is None
    assert (found.format, found.unit, found.warnings) == ("pcd", "m", ())
    assert found.assumed.startswith("m assumed")
    assert "+Y down and +Z away" in found.assumed
    for name in ("fx", "fy", "cx", "cy"):
        assert getattr(found.scan.camera, name) == pytest.approx(getattr(CAMERA, name), abs=1e-4)


@pytest.mark.parametrize("storage", STORAGES)
def test_doubles_among_other_fields_are_exact(tmp_path, storage):
    before = [("normal_x", "F4", 1), ("_", "U1", 3), ("label", "I2", 2)]
    if storage == "binary_compressed":
        before = before[::2]  # the library itself leaves padding out of it
    data = pcd_bytes(SCAN, storage, factor=1.0, kind="F8", axes=(1, 1, 1), before=before, version=".7")
    found = read_scan(write(tmp_path / "s.pcd", data))
    np.testing.assert_array_equal(found.scan.points, SCAN.points)
    np.testing.assert_array_equal(found.scan.colour, SCAN.colour)
    assert found.assumed.startswith("mm assumed")
    assert "turned" not in found.assumed


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("cm", 0.1), ("m", 0.001)])
def test_the_unit_asked_for_counts(tmp_path, unit, factor):
    path = write(tmp_path / "s.pcd", pcd_bytes(SCAN, factor=factor, kind="F8"))
    found = read_scan(path, unit)
    np.testing.assert_allclose(found.scan.points, SCAN.points, rtol=1e-14)
    assert found.assumed.startswith(f"{unit}, as asked")


def test_a_viewpoint_is_taken_back_where_the_points_need_it(tmp_path):
    angle, shift = np.radians(30), np.array([100.0, 20.0, -300.0])
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    text = f"0.1 0.02 -0.3 {np.cos(angle / 2)!r} 0 {np.sin(angle / 2)!r} 0".replace("np.float64(", "").replace(")", "")
    moved = (SCAN.points * OPTICAL) @ turn.T + shift
    world = type(SCAN)(moved, SCAN.colour)
    found = read_scan(write(tmp_path / "w.pcd", pcd_bytes(world, kind="F8", axes=(1, 1, 1), viewpoint=text)))
    np.testing.assert_allclose(found.scan.points, SCAN.points, atol=1e-9)
    assert "VIEWPOINT taken back" in found.assumed
    found = read_scan(write(tmp_path / "s.pcd", pcd_bytes(SCAN, kind="F8", viewpoint=text)))
    np.testing.assert_allclose(found.scan.points, SCAN.points, atol=1e-9)
    assert "VIEWPOINT left out" in found.assumed


@pytest.mark.parametrize(
    ("axes", "picture", "words"),
    [
        ((1, 1, 1), "", ()),
        ((1, -1, -1), "", ("+Y down and +Z away",)),
        ((-1, 1, -1), "", ("+X to the left and +Z away",)),
        ((1, 1, -1), "", ("Z turned",)),
        ((1, 1, 1), "rows", ("rows run upwards: turned",)),
        ((1, 1, 1), "columns", ("columns run to the left: turned",)),
        ((1, -1, -1), "columns", ("+Y down and +Z away", "columns run to the left: turned")),
    ],
)
def test_axes_and_rows_of_every_frame(tmp_path, axes, picture, words):
    points, colour = SCAN.points * axes, SCAN.colour
    if picture:
        flip = 0 if picture == "rows" else 1
        points, colour = np.flip(points, flip), np.flip(colour, flip)
    data = pcd_bytes(type(SCAN)(points, colour), kind="F8", axes=(1, 1, 1))
    found = read_scan(write(tmp_path / "s.pcd", data))
    np.testing.assert_allclose(found.scan.points, SCAN.points, rtol=1e-14)
    np.testing.assert_array_equal(found.scan.colour, SCAN.colour)
    assert all(word in found.assumed for word in words)
    assert bool(words) == ("turned" in found.assumed)
    assert any("left-handed" in warning for warning in found.warnings) == (axes == (1, 1, -1))


def test_points_at_the_origin_are_missing_and_counted(tmp_path):
    zeroed = type(SCAN)(np.where(SCAN.valid[..., None], SCAN.points, 0.0), SCAN.colour)
    found = read_scan(write(tmp_path / "s.pcd", pcd_bytes(zeroed)))
    np.testing.assert_array_equal(found.scan.valid, SCAN.valid)
    assert f"{(~SCAN.valid).sum()} points at the origin" in found.warnings[0]


def test_a_cloud_without_rows_finds_its_pixels(tmp_path):
    found = read_scan(write(tmp_path / "s.pcd", pcd_bytes(SCAN, holes=False)))
    np.testing.assert_array_equal(found.scan.valid, SCAN.valid)
    assert np.abs(found.scan.points - SCAN.points)[SCAN.valid].max() < 1e-4
    np.testing.assert_array_equal(found.scan.colour[SCAN.valid], SCAN.colour[SCAN.valid])
    rng = np.random.default_rng(1)
    loose = type(SCAN)(rng.normal(size=SCAN.points.shape) * 80 + (0, 0, -900), SCAN.colour)
    with pytest.raises(InputError, match=r"no grid of pixels .*; export it with rows and columns"):
        read_scan(write(tmp_path / "loose.pcd", pcd_bytes(loose, holes=False)))


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        (b"FIELDS x y z", b"FIELDS x y x", "twice"),
        (b"FIELDS x y z", b"FIELDS x y w", "no field z"),
        (b"FIELDS x y z", b"FIELDS x y", "SIZE: has 4 of 3"),
        (b"SIZE 4", b"SIZE 3", "TYPE and SIZE"),
        (b"TYPE F", b"TYPE Q", "TYPE and SIZE"),
        (b"COUNT 1", b"COUNT 0", "COUNT"),
        (b"COUNT 1", b"COUNT 2", "COUNT"),
        (b"COUNT 1 1 1 1", b"COUNT 1 1 1 99999999999999999999", "COUNT"),
        (b"WIDTH 48", b"WIDTH 1000000000", "POINTS"),
        (b"WIDTH 48", b"WIDTH -48", "WIDTH"),
        (b"HEIGHT 36", b"HEIGHT 0", "POINTS"),
        (b"POINTS 1728", b"POINTS 1727", "POINTS"),
        (b"WIDTH 48\nHEIGHT 36\n", b"WIDTH 48\nWIDTH 48\nHEIGHT 36\n", "WIDTH: stands there twice"),
        (b"VIEWPOINT 0 0 0 1", b"VIEWPOINT 0 0 0 0", "VIEWPOINT"),
        (b"VIEWPOINT 0 0 0 1", b"VIEWPOINT 0 nan 0 1", "VIEWPOINT"),
        (b"DATA binary", b"DATA binary_zipped", "DATA"),
        (b"VERSION 0.7", b"VERSION 7", "VERSION"),
        (b"# .PCD", b"#" + b" " * 5000 + b".PCD", "header"),
    ],
)
def test_headers_that_lie(tmp_path, old, new, word):
    data = pcd_bytes(SCAN, "binary")
    assert old in data
    with pytest.raises(InputError, match=word):
        read_scan(write(tmp_path / "s.pcd", data.replace(old, new, 1)))


@pytest.mark.parametrize("storage", STORAGES)
def test_a_size_that_the_file_does_not_bear_out(tmp_path, storage):
    data = pcd_bytes(SCAN, storage)
    for width, height in ((49, 36), (4000, 4000), (10**6, 10**6)):
        lie = data.replace(b"WIDTH 48", b"WIDTH %d" % width).replace(b"HEIGHT 36", b"HEIGHT %d" % height)
        lie = lie.replace(b"POINTS 1728", b"POINTS %d" % (width * height))
        with pytest.raises(InputError, match=r"cut off|do not make|million"):
            read_scan(write(tmp_path / "s.pcd", lie))


@settings(max_examples=200, deadline=None)
@given(st.one_of(st.binary(max_size=300), st.lists(st.sampled_from([b"abc", b"a", bytes(40)])).map(b"".join)))
def test_lzf_unpacks_what_was_packed(data):
    packed = lzf_pack(data)
    assert unpack_lzf(packed, len(data)) == data
    for length in (len(data) + 1, max(0, len(data) - 1)):
        if length != len(data):
            with pytest.raises(LzfError):
                unpack_lzf(packed, length)


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=200), st.integers(0, 5000))
def test_lzf_of_noise_is_an_error_or_has_the_length(packed, length):
    try:
        assert len(unpack_lzf(packed, length)) == length
    except LzfError as error:
        assert "\n" not in str(error)


def test_lzf_is_not_trusted_with_sizes(tmp_path):
    bomb = b"\0a" + b"\xe0\xff\x00" * 100_000
    with pytest.raises(LzfError, match="more than 1000 bytes"):
        unpack_lzf(bomb, 1000)
    with pytest.raises(LzfError, match="before the beginning"):
        unpack_lzf(b"\0a\x20\x05", 4)
    data = pcd_bytes(SCAN, "binary_compressed")
    place = data.index(b"compressed\n") + 11
    for sizes in ((10**9, 48 * 36 * 16), (100, 48 * 36 * 16), (100, 2**32 - 1)):
        with pytest.raises(InputError, match=r"cut off|do not make|unpacks to"):
            read_scan(write(tmp_path / "s.pcd", data[:place] + struct.pack("<II", *sizes) + data[place + 8 :]))
