"""Damaged and malicious files: one InputError of one line, whatever is in them."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.files.depth_json import write_depth_scan
from engine.files.images import encode_image, read_grey, read_image
from engine.files.landmarks_json import read_fiducials, write_fiducials
from engine.files.npz import write_npz
from engine.files.ply import write_ply
from engine.files.scan import read_scan
from tests.engine.files.planted import picture, planted_scan, ply_bytes, write
from tests.engine.files.refusals import SMALL, refused, refused_or_read

ENCODINGS = ("ascii", "binary_little_endian", "binary_big_endian")
FORMS = [f"{encoding}-{form}" for encoding in ENCODINGS for form in ("full", "grid")]


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
