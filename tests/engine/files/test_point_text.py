"""Point text and Minolta-style range images: holes, orders, digits and noise, against the planted scan."""

from __future__ import annotations

import gzip

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.pixel_grid import find_comb
from engine.files.scan import read_scan
from engine.scan.range_image import Camera, RangeImage
from tests.engine.files.foreign import OPTICAL, abs_bytes, xyz_bytes
from tests.engine.files.planted import planted_scan, write


def face(width: int = 96, height: int = 72) -> RangeImage:
    """A bump that fills the middle of the picture and touches its border, with holes and two columns missing."""
    camera = Camera(140.0, 138.0, 47.2, 36.7)
    rows, columns = np.indices((height, width))
    depth = 650 - 60 * np.exp(-((rows - 36) ** 2 + (columns - 50) ** 2) / 700)
    depth[((rows - 36) / 36) ** 2 + ((columns - 48) / 48) ** 2 > 1.02] = np.nan
    depth[:, 30:32] = np.nan
    depth[40:50, 60:75] = np.nan
    colour = np.random.default_rng(5).integers(0, 256, (height, width, 3), dtype=np.uint8)
    return RangeImage(camera.points(depth), colour, camera)


FACE = face()


def same(found: RangeImage, tolerance: float) -> None:
    """The same pixels, points and colours as ``FACE``."""
    np.testing.assert_array_equal(found.valid, FACE.valid)
    assert np.abs(found.points - FACE.points)[FACE.valid].max() <= tolerance
    if found.colour is not None:
        np.testing.assert_array_equal(found.colour[FACE.valid], FACE.colour[FACE.valid])


@pytest.mark.parametrize("order", ["rows", "columns"])
@pytest.mark.parametrize("axes", [(1, 1, 1), OPTICAL], ids=["ours", "optical"])
@pytest.mark.parametrize("digits", [1, 3, 6])
def test_points_with_holes_find_their_pixels(tmp_path, digits, axes, order):
    found = read_scan(write(tmp_path / "s.xyz", xyz_bytes(FACE, digits, axes=axes, order=order)))
    same(found.scan, 0.5 * 10**-digits + 1e-9)
    assert (found.format, found.unit, found.warnings) == ("xyz", "mm", ())
    assert "pixels found from x / z and y / z" in found.assumed
    assert found.scan.camera.fx == pytest.approx(140, abs=0.5 * 10**-digits)
    assert found.scan.camera.cx == pytest.approx(47.2, abs=2 * 10**-digits)
    assert found.scan.camera.cy == pytest.approx(36.7, abs=2 * 10**-digits)


@pytest.mark.parametrize("separator", [" ", "\t", ",", " ; ", ", "])
@pytest.mark.parametrize("colour", ["", "bytes", "fractions"])
def test_separators_and_colours(tmp_path, separator, colour):
    heading = "// a scan\nx y z\n\n# more\n" if colour else f"{FACE.valid.sum()}\n"
    data = xyz_bytes(FACE, 4, separator, colour, heading=heading)
    found = read_scan(write(tmp_path / "s.txt", data))
    same(found.scan, 1e-4)
    assert (found.scan.colour is None) == (not colour)


def test_points_in_no_order_are_the_same_scan(tmp_path):
    same(read_scan(write(tmp_path / "s.asc", xyz_bytes(FACE, 4, order="shuffled"))).scan, 1e-4)


def test_noise_and_spikes_do_not_move_the_grid(tmp_path):
    rng = np.random.default_rng(2)
    points = FACE.points + rng.normal(0, 0.4, FACE.points.shape)  # a pixel is 4.6 mm
    points[30, 50] *= 1.5
    noisy = RangeImage(points, FACE.colour)
    found = read_scan(write(tmp_path / "s.xyz", xyz_bytes(noisy, 6))).scan
    np.testing.assert_array_equal(found.valid, FACE.valid)
    np.testing.assert_allclose(found.points[FACE.valid], points[FACE.valid], atol=1e-6)
    assert found.camera.fx == pytest.approx(140, rel=1e-3)


def test_two_points_on_a_pixel_are_counted_and_the_nearest_kept(tmp_path):
    lines = xyz_bytes(FACE, 6, colour="").decode().splitlines()
    behind = [" ".join(f"{float(word) * 1.2:.6f}" for word in line.split()) for line in lines[100:150]]
    text = "\n".join([*lines[:120], *behind, *lines[120:], "5000000 0 -1"])
    found = read_scan(write(tmp_path / "s.xyz", text.encode()))
    same(found.scan, 1e-6)
    assert found.warnings[0].startswith("50 points fell on a pixel that another one has")
    assert found.warnings[1].startswith("1 points lie far outside")


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("cm", 0.1), ("m", 0.001)])
def test_units(tmp_path, unit, factor):
    path = write(tmp_path / "s.xyz", xyz_bytes(FACE, 7, factor=factor))
    same(read_scan(path, unit).scan, 1e-3)
    path = write(tmp_path / "s.abs", abs_bytes(FACE, 7, factor=factor))
    same(read_scan(path, unit).scan, 1e-3)
    assert any("rather" in warning for warning in read_scan(path).warnings) == (unit == "m")


def test_parallel_rays_are_a_grid_as_well(tmp_path):
    rows, columns = np.indices((60, 50))
    points = np.stack([columns * 0.7 - 20, 25 - rows * 0.7, 40 * np.exp(-((rows - 30) ** 2) / 200)], axis=2)
    points[:4, :6] = np.nan
    found = read_scan(write(tmp_path / "s.xyz", xyz_bytes(RangeImage(points), 4)))
    np.testing.assert_allclose(found.scan.points, points, atol=1e-4)
    assert "parallel rays" in found.assumed
    assert found.scan.camera is None


def test_points_on_no_grid_are_refused(tmp_path):
    rng = np.random.default_rng(4)
    loose = rng.normal(size=(60, 80, 3)) * (70, 90, 30) + (0, 0, -700)
    for digits in (6, 1):
        with pytest.raises(InputError, match="no grid of pixels"):
            read_scan(write(tmp_path / "s.xyz", xyz_bytes(RangeImage(loose), digits)))
    with pytest.raises(InputError, match="holds 50 points, too few"):
        read_scan(write(tmp_path / "few.xyz", b"\n".join(xyz_bytes(FACE).splitlines()[:50])))


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (b"hello\nworld\n", "holds no rows of numbers"),
        (b"1 2\n3 4\n", "2 numbers"),
        (b"1 2 3\n" * 200 + b"1 2\n", "row 201 has 2 columns, not 3"),
        (b"1 2 3\n" * 200 + b"1 2 x\n", "no number"),
        (b"1 2 3\n" * 200 + b"1 2 0x10\n", "no number"),
        (b"1 2 3\n" * 200 + b"1 2 \xff\n", "no number"),
        (b"1 2 3\n" * 200 + b"1 2 3\0\n", "no number"),
        (b"7\n" + b"1 2 3\n" * 200, "holds 200 points, its first line says 7"),
        (b"1 2 3 " * 5000, "too long"),
        (b"1 2 3\n" + b"4 " * 10**7, "too long|columns"),
    ],
)
def test_text_that_is_no_table(tmp_path, text, word):
    with pytest.raises(InputError, match=word):
        read_scan(write(tmp_path / "s.xyz", text))


@settings(max_examples=30, deadline=None)
@given(
    pitch=st.floats(1e-4, 10), offset=st.floats(-50, 50), teeth=st.integers(12, 900),
    noise=st.floats(0, 0.12), gap=st.floats(0, 0.4), seed=st.integers(0, 99),
)  # fmt: skip
def test_any_comb_is_found(pitch, offset, teeth, noise, gap, seed):
    rng = np.random.default_rng(seed)
    kept = np.flatnonzero(rng.random(teeth) >= gap)
    if len(kept) < 10 or np.gcd.reduce(np.diff(kept)) > 1:
        return
    index = rng.choice(kept, 6000)
    comb = find_comb(offset + pitch * (index + rng.normal(0, noise, len(index))))
    assert comb.pitch == pytest.approx(pitch, rel=0.02 / teeth + 1e-3 * noise)
    whole = (comb.offset - offset) / pitch
    assert abs(whole - np.rint(whole)) < 0.02 + 0.05 * noise


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_no_comb_is_found_in_noise(seed):
    rng = np.random.default_rng(seed)
    assert find_comb(rng.normal(size=3000)) is None
    assert find_comb(rng.random(3000)) is None


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("digits", [2, 6])
def test_minolta_text(tmp_path, packed, digits):
    scan = planted_scan(colour=False)
    path = write(tmp_path / ("s.abs.gz" if packed else "s.abs"), abs_bytes(scan, digits, packed))
    found = read_scan(path)
    np.testing.assert_array_equal(found.scan.valid, scan.valid)
    assert np.abs(found.scan.points - scan.points)[scan.valid].max() <= 0.5 * 10**-digits + 1e-9
    assert (found.format, found.unit, found.warnings) == ("abs", "mm", ())
    assert found.scan.camera.fx == pytest.approx(60, abs=10**-digits)
    anonymous = write(tmp_path / "scan.001", path.read_bytes())
    np.testing.assert_array_equal(read_scan(anonymous).scan.points, found.scan.points)


@pytest.mark.parametrize("ending", [".ppm", ".png"])
@pytest.mark.parametrize("name", ["s.abs", "s.abs.gz"])
def test_the_picture_beside_a_minolta_scan(tmp_path, name, ending):
    scan = planted_scan()
    path = write(tmp_path / name, abs_bytes(scan, packed=name.endswith("gz")))
    assert read_scan(path).scan.colour is None
    picture = tmp_path / f"s{ending}"
    cv2.imwrite(str(picture), scan.colour[..., ::-1])
    found = read_scan(path)
    np.testing.assert_array_equal(found.scan.colour, scan.colour)
    assert found.source_files == (path, picture)
    cv2.imwrite(str(picture), scan.colour[:10])
    assert "32 x 10 pixels: left out" in read_scan(path).warnings[0]
    picture.write_bytes(picture.read_bytes()[:80])
    assert "cut off: left out" in read_scan(path).warnings[0]


def test_odd_flags_and_numbers_are_counted(tmp_path):
    scan = planted_scan(colour=False, missing=False)
    lines = abs_bytes(scan).split(b"\n")
    lines[3] = lines[3].replace(b"1 1 1", b"2 1 0", 1)
    lines[4] = b" nan " + lines[4].split(b" ", 1)[1]
    found = read_scan(write(tmp_path / "s.abs", b"\n".join(lines)))
    assert found.scan.valid.sum() == scan.valid.sum() - 2
    assert found.warnings == (
        "1 flags are neither 0 nor 1: taken as measured",
        "1 measured points are no numbers: taken as missing",
    )


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cut=st.floats(0, 0.99), packed=st.booleans())
def test_a_minolta_scan_cut_off_is_refused(tmp_path, cut, packed):
    data = abs_bytes(planted_scan(colour=False), packed=packed)
    with pytest.raises(InputError):
        read_scan(write(tmp_path / "s.abs.gz", data[: max(1, int(cut * len(data)))]))


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (b"24 cols\n", "<n> rows"),
        (b"10000000000 rows\n1 columns\npixels (flag X Y Z):\n", "million"),
        (b"-1 rows\n1 columns\n", "<n> rows"),
        (b"99999 rows\n99999 columns\npixels (flag X Y Z):\n", "million"),
        (b"2000 rows\n2000 columns\npixels (flag X Y Z):\n1 1", "no room"),
        (b"2 rows\n2 columns\npixels:\n", "belongs"),
        (b"2 rows\n2 columns\npixels (flag X Y Z):\n" + b"0 " * 16, "every flag is 0"),
        (b"2 rows\n2 columns\npixels (flag X Y Z):\n" + b"1 " * 15 + b"x", "no number"),
        (b"2 rows\n2 columns\npixels (flag X Y Z):\n" + b"1 " * 17, "more than 16"),
    ],
)
def test_minolta_headers_that_lie(tmp_path, text, word):
    with pytest.raises(InputError, match=word):
        read_scan(write(tmp_path / "s.abs", text))


def test_a_packed_bomb_is_not_unpacked(tmp_path):
    header = b"24 rows\n32 columns\npixels (flag X Y Z):\n"
    bomb = gzip.compress(header + b" " * (60 << 20), 1)
    with pytest.raises(InputError, match="longer than 3072 numbers can be"):
        read_scan(write(tmp_path / "bomb.abs.gz", bomb))
