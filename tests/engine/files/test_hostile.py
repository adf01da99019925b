"""Damaged and malicious files: one InputError of one line, whatever is in them."""

from __future__ import annotations

import json
import os
import re
import struct
import zipfile
import zlib
from io import BytesIO

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.depth_json import write_depth_scan
from engine.files.images import encode_image, read_grey, read_image
from engine.files.landmarks_json import read_fiducials, write_fiducials
from engine.files.npz import write_npz
from engine.files.ply import write_ply
from engine.files.scan import read_scan
from tests.engine.files.planted import picture, planted_scan, ply_bytes, write

ENCODINGS = ("ascii", "binary_little_endian", "binary_big_endian")
FORMS = [f"{encoding}-{form}" for encoding in ENCODINGS for form in ("full", "grid")]
SMALL = {"width": 8, "height": 6}


def refused(reader, path) -> str:
    """The message of the InputError that ``reader`` raises; anything else fails the test."""
    with pytest.raises(InputError) as caught:
        reader(path)
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 400 + len(str(path)) * 2
    return message


def refused_or_read(reader, path) -> None:
    """Read, or be refused: damage that happens to be legal cannot be told from data."""
    try:
        reader(path)
    except InputError as error:
        assert "\n" not in str(error)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """One good file of every format: name -> (reader, bytes)."""
    folder, scan = tmp_path_factory.mktemp("good"), planted_scan(**SMALL)
    write_npz(folder / "s.npz", scan)
    write_ply(folder / "s.ply", scan)
    write_fiducials(folder / "f.json", {"chin": (1.0, 2.0), "nose": (3.0, 4.5)}, (8, 6))
    files = {name: (read_scan, (folder / name).read_bytes()) for name in ("s.npz", "s.ply")}
    files["f.json"] = (read_fiducials, (folder / "f.json").read_bytes())
    for form in FORMS:
        files[f"{form}.ply"] = (read_scan, ply_bytes(scan, *form.split("-")))
    for name, kind in (("p.png", "png"), ("p.jpg", "jpeg"), ("p.tif", "tiff")):
        files[name] = (read_image, encode_image(picture(16, 12), kind))
    depth = (np.arange(192, dtype=np.uint16) * 331).reshape(12, 16)
    files["d.png"], files["d.tif"] = (read_grey, encode_image(depth)), (read_grey, encode_image(depth, "tiff"))
    return files


NAMES = ["s.npz", "s.ply", "f.json", "p.png", "p.jpg", "p.tif", "d.png", "d.tif", *(f"{form}.ply" for form in FORMS)]


@pytest.mark.parametrize("name", NAMES)
def test_cut_off_anywhere(tmp_path, good, name, capfd):
    reader, data = good[name]
    reader(write(tmp_path / name, data))
    end = len(data.rstrip())  # the last line break of a text may go
    for length in sorted({*range(min(64, end)), *range(0, end, max(1, end // 60)), *range(max(0, end - 12), end)}):
        path = write(tmp_path / name, data[:length])
        if name.startswith("ascii") and length > end - 12:
            refused_or_read(reader, path)  # a shorter last number is a number
        else:
            refused(reader, path)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("name", NAMES)
def test_flipped_bits(tmp_path, good, name):
    reader, data = good[name]
    rng = np.random.default_rng(11)
    places = {*range(min(160, len(data))), *rng.integers(0, len(data), 120).tolist()}
    for place in sorted(places):
        damaged = bytearray(data)
        damaged[place] ^= 1 << int(rng.integers(8))
        refused_or_read(reader, write(tmp_path / name, bytes(damaged)))


@pytest.mark.parametrize("name", ["p.png", "d.png", "s.npz"])
def test_no_flipped_bit_passes_where_there_is_a_checksum(tmp_path, good, name):
    reader, data = good[name]
    # From the middle of the data; a zip's directory has parts that mean nothing.
    for place in range(len(data) // 3, len(data) // 2, 5):
        damaged = bytearray(data)
        damaged[place] ^= 16
        refused(reader, write(tmp_path / name, bytes(damaged)))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.sampled_from(NAMES), data=st.data())
def test_anything_spliced_into_a_good_file(tmp_path, good, name, data):
    reader, whole = good[name]
    start = data.draw(st.integers(0, len(whole)))
    stop = data.draw(st.integers(start, min(len(whole), start + 40)))
    middle = data.draw(st.binary(max_size=40))
    refused_or_read(reader, write(tmp_path / name, whole[:start] + middle + whole[stop:]))


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(suffix=st.sampled_from([".ply", ".npz", ".json", "", ".obj"]), tail=st.binary(max_size=200), magic=st.booleans())
def test_noise(tmp_path, suffix, tail, magic):
    starts = {".ply": b"ply\nformat ascii 1.0\n", ".npz": b"PK\x03\x04", ".json": b"{"}
    start = starts.get(suffix, b"") if magic else b""
    refused(read_scan, write(tmp_path / f"noise{suffix}", start + tail))
    refused(read_fiducials, tmp_path / f"noise{suffix}")
    refused(read_image, tmp_path / f"noise{suffix}")


JSON_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(field=st.sampled_from(["depth", "colour", "unit_mm", "fx", "fy", "cx", "cy"]), value=JSON_VALUES)
def test_any_value_in_any_field(tmp_path, field, value):
    if not (tmp_path / "good.json").exists():
        write_depth_scan(tmp_path / "good.json", planted_scan(**SMALL))
    fields = json.loads((tmp_path / "good.json").read_text())
    fields[field] = value
    (tmp_path / "s.json").write_text(json.dumps(fields))
    refused_or_read(read_scan, tmp_path / "s.json")


@pytest.mark.parametrize("reader", [read_scan, read_fiducials, read_image, read_grey])
def test_what_is_no_file(tmp_path, reader):
    (tmp_path / "folder.ply").mkdir()
    os.mkfifo(tmp_path / "pipe.ply")
    (tmp_path / "gone.ply").symlink_to(tmp_path / "nowhere")
    (tmp_path / "loop.ply").symlink_to(tmp_path / "loop.ply")
    (tmp_path / "empty.ply").touch()
    for name in ("folder.ply", "pipe.ply", "gone.ply", "loop.ply", "empty.ply", "none.ply", "x" * 300, "a\0b"):
        refused(reader, tmp_path / name)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may read everything")
def test_a_file_that_may_not_be_read(tmp_path):
    path = write(tmp_path / "s.ply", b"ply\n")
    path.chmod(0)
    assert "rights" in refused(read_scan, path)


def test_a_refusal_by_the_system_is_an_input_error(tmp_path, monkeypatch):
    path = write(tmp_path / "s.ply", b"ply\n")

    def denied(self, *args, **kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "open", denied)
    assert "Permission denied" in refused(read_scan, path)


# --- JSON -----------------------------------------------------------------------------------------------------------


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


# --- PLY ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "change",
    [
        (b"num_cols 8", b"num_cols 1000000000"),
        (b"num_cols 8", b"num_cols 99999999999999999999"),
        (b"num_cols 8", b"num_cols -8"),
        (b"num_cols 8", b"num_cols 0"),
        (b"num_cols 8", "num_cols ٨".encode()),
        (b"num_cols 8", b"num_cols 7"),
        (b"obj_info num_cols 8\n", b""),
        (b"element vertex 48", b"element vertex 1000000000"),
        (b"element vertex 48", b"element vertex 99999999999999999999999"),
        (b"element vertex 48", b"element vertex 49"),
        (b"element vertex 48", b"element vertex 0"),
        (b"element vertex 48", b"element vertex -1"),
        (b"element vertex 48", b"element vertex 48\nelement vertex 48"),
        (b"element vertex 48", b"element camera 1000000000\nproperty double a\nelement vertex 48"),
        (b"element vertex 48", b"element face 2\nproperty list uchar int a\nelement vertex 48"),
        (b"element vertex", b"element vertices"),
        (b"property float z", b"property float x"),
        (b"property float z", b"property float w"),
        (b"property float z", b"property float"),
        (b"property float z", b"property quad z"),
        (b"property float z", b"property list float int z"),
        (b"property float z", b"property list uchar float z"),
        (b"1.0\n", b"2.0\n"),
        (b"end_header", b"end_headers"),
        (b"comment", b"nonsense"),
        (b"comment planted\n", b"comment " + b"x" * 10**6 + b"\n"),
        (b"comment planted\n", b"comment x\n" * 10**5),
    ],
)
@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
def test_ply_headers_that_lie(tmp_path, encoding, change):
    data = ply_bytes(planted_scan(**SMALL), encoding, "full")
    assert change[0] in data
    refused(read_scan, write(tmp_path / "s.ply", data.replace(*change, 1)))


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ((b"\n1 0\n", b"\n1 4000\n"), "range_grid"),
        ((b"\n1 0\n", b"\n1 -1\n"), "range_grid"),
        ((b"\n1 0\n", b"\n2 0 1\n"), "range_grid"),
        ((b"\n1 0\n", b"\n1000000000 0\n"), "range_grid"),
        ((b"element range_grid 48", b"element range_grid 47"), "range_grid"),
        ((b"element range_grid 48", b"element range_grid 1000000000"), "range_grid"),
        ((b"list uchar int vertex_indices", b"list uchar float vertex_indices"), "range_grid"),
        ((b"list uchar int vertex_indices", b"int vertex_indices"), "range_grid"),
    ],
)
def test_range_grids_that_lie(tmp_path, change, word):
    data = ply_bytes(planted_scan(**SMALL), "ascii", "grid")
    assert change[0] in data
    assert word in refused(read_scan, write(tmp_path / "s.ply", data.replace(*change, 1)))


def test_a_ply_that_is_no_organised_scan_says_so(tmp_path):
    axes = b"property float x\nproperty float y\nproperty float z\n"
    mesh = b"ply\nformat ascii 1.0\nelement vertex 1\n" + axes + b"end_header\n0 0 0\n"
    assert "organised scan" in refused(read_scan, write(tmp_path / "mesh.ply", mesh))
    nothing = ply_bytes(planted_scan(**SMALL), "binary_little_endian", "full")
    start = nothing.index(b"end_header\n") + 11
    row = struct.pack("<fffBBB", np.nan, np.nan, np.nan, 0, 0, 0)
    assert "no valid pixel" in refused(read_scan, write(tmp_path / "nothing.ply", nothing[:start] + row * 48))


# --- NPZ ------------------------------------------------------------------------------------------------------------


class Trap:
    """Would leave a trace if a pickle of it were ever loaded."""

    def __reduce__(self):
        return os.mkdir, ("loaded_a_pickle",)


def npy(array: np.ndarray, **changes: object) -> bytes:
    """An ``.npy`` file whose header may lie."""
    buffer = BytesIO()
    np.save(buffer, array)
    data = buffer.getvalue()
    if not changes:
        return data
    header = {"descr": array.dtype.str, "fortran_order": False, "shape": array.shape, **changes}
    text = repr(header).encode().ljust(118) + b"\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text + array.tobytes()


def archive(path, compression=zipfile.ZIP_DEFLATED, **members: bytes):
    with zipfile.ZipFile(path, "w", compression) as out:
        for name, data in members.items():
            out.writestr(f"{name}.npy", data)
    return path


POINTS = planted_scan(**SMALL).points


def test_a_pickle_is_never_loaded(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    trap = np.empty((6, 8, 3), dtype=object)
    trap[...] = Trap()
    good = {"points": POINTS}
    for name, arrays in (("a", {"points": trap}), ("b", {**good, "colour": trap}), ("c", {**good, "camera": trap})):
        np.savez(tmp_path / f"{name}.npz", allow_pickle=True, **arrays)
        assert "pickle" in refused(read_scan, tmp_path / f"{name}.npz")
    np.save(tmp_path / "d.npy", trap, allow_pickle=True)
    (tmp_path / "d.npy").rename(tmp_path / "d.npz")
    refused(read_scan, tmp_path / "d.npz")
    assert not (tmp_path / "loaded_a_pickle").exists()


@pytest.mark.parametrize(
    "members",
    [
        {},
        {"pts": npy(POINTS)},
        {"points": b""},
        {"points": b"\x93NUMPY"},
        {"points": b"\x93NUMPY\2\0\xff\xff\xff\x7f" + b" " * 100},
        {"points": b"\x93NUMPY\3\0\xff\0\0\0" + b" " * 300},
        {"points": npy(POINTS, shape=(10**9, 10**9, 3))},
        {"points": npy(POINTS, shape=(10**5, 10**5, 3))},
        {"points": npy(POINTS, shape=(6, 9, 3))},
        {"points": npy(POINTS, shape=(-6, -8, 3))},
        {"points": npy(POINTS, shape=(True, 48, 3))},
        {"points": npy(POINTS, shape=(6.0, 8, 3))},
        {"points": npy(POINTS, descr="|O")},
        {"points": npy(POINTS, descr="V8")},
        {"points": npy(POINTS, descr="<c16")},
        {"points": npy(POINTS, descr=[("a", "<f8")])},
        {"points": npy(POINTS, descr="__import__('os')")},
        {"points": npy(POINTS, fortran_order="x")},
        {"points": npy(POINTS[..., :2])},
        {"points": npy(POINTS.reshape(-1, 3))},
        {"points": npy(POINTS[:1, :1])},
        {"points": npy(POINTS[:0])},
        {"points": npy(np.full_like(POINTS, np.nan))},
        {"points": npy(np.full_like(POINTS, np.inf))},
        {"points": npy(POINTS) + b"more"},
        {"points": npy(POINTS), "colour": npy(np.zeros((6, 9, 3), np.uint8))},
        {"points": npy(POINTS), "colour": npy(np.zeros((6, 8), np.uint8))},
        {"points": npy(POINTS), "colour": npy(np.zeros((6, 8, 3)))},
        {"points": npy(POINTS), "camera": npy(np.array([0.0, 1, 2, 3]))},
        {"points": npy(POINTS), "camera": npy(np.array([1, 1, np.nan, 3]))},
        {"points": npy(POINTS), "camera": npy(np.ones(3))},
        {"points": npy(POINTS), "unit": npy(np.array("inch"))},
        {"points": npy(POINTS), "unit": npy(np.array("m" * 10**6))},
        {"points": npy(POINTS), "unit": npy(np.array(["mm", "mm"]))},
    ],
)
def test_npz_that_lies(tmp_path, members):
    refused(read_scan, archive(tmp_path / "s.npz", **members))


@pytest.mark.parametrize("compression", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_packings_that_numpy_does_not_use(tmp_path, compression):
    refused(read_scan, archive(tmp_path / "s.npz", compression, points=npy(POINTS)))


def test_a_zip_directory_that_lies(tmp_path):
    data = archive(tmp_path / "s.npz", points=npy(POINTS)).read_bytes()
    place = data.index(b"PK\x01\x02")
    for offset in (24, 42):  # unpacked size, place of the member
        for value in (1, 10**9, 2**32 - 1):
            lie = bytearray(data)
            lie[place + offset : place + offset + 4] = value.to_bytes(4, "little")
            refused(read_scan, write(tmp_path / "lie.npz", bytes(lie)))


# --- images ---------------------------------------------------------------------------------------------------------


def png(width: int, height: int, data: bytes, bits: int = 16, colour: int = 0) -> bytes:
    """A PNG with right checksums, whatever its header says."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


@pytest.mark.parametrize(
    "data",
    [
        png(10**9, 10**9, b""),
        png(2**32 - 1, 1, b""),
        png(10**5, 10**5, zlib.compress(bytes(100))),
        png(0, 10, zlib.compress(bytes(100))),
        png(10, 10, b""),
        png(10, 10, b"no zlib"),
        png(10, 10, zlib.compress(bytes(100))),
        png(10, 10, zlib.compress(bytes(210))[:-6]),
        png(10, 10, zlib.compress(bytes(211))),
        png(10, 10, zlib.compress(bytes(210)), bits=3),
        png(10, 10, zlib.compress(bytes(210)), colour=7),
    ],
)
def test_png_headers_that_lie(tmp_path, data, capfd):
    refused(read_grey, write(tmp_path / "d.png", data))
    assert capfd.readouterr().err == ""


def test_image_headers_of_the_other_formats_that_lie(tmp_path):
    data = encode_image(picture(16, 12), "jpeg")
    place = data.index(b"\xff\xc0") + 5
    for size in (b"\xff\xff\xff\xff", b"\0\0\0\x10", b"\0\x0c\0\0"):
        refused(read_image, write(tmp_path / "p.jpg", data[:place] + size + data[place + 4 :]))
    tiff = bytearray(encode_image(np.zeros((12, 16), np.uint16), "tiff"))
    (start,) = struct.unpack_from("<I", tiff, 4)
    for index in range(struct.unpack_from("<H", tiff, start)[0]):
        for value in (10**9, 2**32 - 1, 0):
            lie = bytearray(tiff)
            struct.pack_into("<I", lie, start + 10 + 12 * index, value)
            refused_or_read(read_grey, write(tmp_path / "d.tif", bytes(lie)))
            if struct.unpack_from("<H", tiff, start + 2 + 12 * index)[0] in (256, 257):
                refused(read_grey, write(tmp_path / "d.tif", bytes(lie)))


def test_numbers_beyond_measure_are_missing_or_warned_of(tmp_path):
    data = ply_bytes(planted_scan(**SMALL), "binary_little_endian", "full")
    start = data.index(b"end_header\n") + 11 + 20 * 15
    signalling, huge = struct.pack("<I", 0x7F800001), struct.pack("<f", 3e38)
    data = data[:start] + signalling + data[start + 4 : start + 15] + 20 * (huge + data[start + 4 : start + 15])
    data += ply_bytes(planted_scan(**SMALL), "binary_little_endian", "full")[len(data) :]
    found = read_scan(write(tmp_path / "s.ply", data), "m")
    assert not found.scan.valid[2, 4]
    assert any("unlikely for a face" in warning for warning in found.warnings)
