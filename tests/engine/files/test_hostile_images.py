"""Image headers that lie, and numbers beyond measure."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest

from engine.files.images import encode_image, read_grey, read_image
from engine.files.scan import read_scan
from tests.engine.files.planted import picture, planted_scan, ply_bytes, write
from tests.engine.files.refusals import SMALL, refused, refused_or_read


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
