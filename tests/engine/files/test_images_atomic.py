"""Pictures keep their pixels and channel order; a file that could not be finished leaves the old one."""

from __future__ import annotations

import os

import cv2
import numpy as np
import PIL.Image
import pytest

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.images import encode_image, image_size, read_grey, read_image, write_image
from engine.files.source import MAX_PIXELS
from tests.engine.files.planted import picture


@pytest.mark.parametrize("suffix", [".png", ".tif", ".tiff"])
def test_colour_is_lossless_and_rgb(tmp_path, suffix):
    path = tmp_path / f"p{suffix}"
    write_image(path, picture())
    np.testing.assert_array_equal(read_image(path), picture())
    with PIL.Image.open(path) as other:
        np.testing.assert_array_equal(np.asarray(other), picture())
    assert image_size(path) == (64, 48)


def test_jpeg_is_close_and_rgb(tmp_path):
    flat = np.full((32, 32, 3), (200, 120, 40), dtype=np.uint8)
    write_image(tmp_path / "p.jpg", flat)
    assert np.abs(read_image(tmp_path / "p.jpg").astype(int) - flat).max() <= 3


@pytest.mark.parametrize(("suffix", "dtype"), [(".png", "u1"), (".png", "u2"), (".tif", "u2"), (".tif", "f4")])
def test_grey_keeps_its_type(tmp_path, suffix, dtype):
    values = (np.arange(48 * 64).reshape(48, 64) % 251).astype(dtype)
    write_image(tmp_path / f"d{suffix}", values)
    found = read_grey(tmp_path / f"d{suffix}")
    assert found.dtype == values.dtype
    np.testing.assert_array_equal(found, values)
    assert (read_image(tmp_path / f"d{suffix}").shape if dtype == "u1" else (48, 64, 3)) == (48, 64, 3)


def test_pixels_stay_as_stored_whatever_the_metadata_say(tmp_path):
    # An EXIF orientation of 6 asks viewers to turn the picture; the depth image beside it is not turned.
    exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"
    data = encode_image(picture(), "jpeg")
    segment = b"\xff\xe1" + (len(exif) + 2).to_bytes(2, "big") + exif
    (tmp_path / "p.jpg").write_bytes(data[:2] + segment + data[2:])
    assert cv2.imread(str(tmp_path / "p.jpg")).shape == (64, 48, 3)
    assert read_image(tmp_path / "p.jpg").shape == (48, 64, 3)


def test_what_a_format_cannot_hold_is_refused(tmp_path):
    for name, image in (
        ("a.gif", picture()),
        ("a.png", picture().astype(np.float32)),
        ("a.png", np.zeros((4, 4), np.float32)),
        ("a.jpg", np.zeros((4, 4), np.uint16)),
        ("a.png", np.zeros((4, 4, 2), np.uint8)),
        ("a.png", np.zeros((0, 4, 3), np.uint8)),
    ):
        with pytest.raises(InputError):
            write_image(tmp_path / name, image)
    assert list(tmp_path.iterdir()) == []
    write_image(tmp_path / "c.png", picture())
    with pytest.raises(InputError, match="3 channels"):
        read_grey(tmp_path / "c.png")
    assert MAX_PIXELS >= 4096 * 3000


def test_a_block_that_raises_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")
    with pytest.raises(KeyError), atomic_write(path) as handle:
        handle.write(b"half of the new one")
        raise KeyError
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left on device"), atomic_write(path) as handle:
        handle.write(b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_is_followed_and_the_mask_respected(tmp_path):
    (tmp_path / "real").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with atomic_write(tmp_path / "link") as handle:
        handle.write(b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"
    with (tmp_path / "plain").open("wb"):
        pass
    assert (tmp_path / "real").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_no_folder_and_a_folder_in_the_way(tmp_path):
    for path in (tmp_path / "none" / "a.bin", tmp_path):
        with pytest.raises(InputError), atomic_write(path) as handle:
            handle.write(b"x")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    with pytest.raises(InputError), atomic_write(tmp_path / "loop" / "a") as handle:
        handle.write(b"x")
