"""Range grids of PLY files: block by block the same as row by row, and given up at the first wrong row."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from engine.errors import InputError
from engine.files import ply_grid
from engine.files.ply_grid import read_range_grid
from engine.files.ply_header import PlyElement, PlyProperty

CODES = {"u1": "B", "u2": "H", "i4": "i", "i8": "q"}
BEHIND = b"7 behind the grid\n"


def encoded(rows: np.ndarray, order: str, length: str, index: str) -> bytes:
    if not order:
        gaps = ("\n", "\r\n", " \n\n")
        return "".join((f"1 {row}" if row >= 0 else "0") + gaps[k % 3] for k, row in enumerate(rows)).encode()
    one, none = struct.pack(order + CODES[length], 1), struct.pack(order + CODES[length], 0)
    return b"".join(one + struct.pack(order + CODES[index], row) if row >= 0 else none for row in rows)


def read(tmp_path, data: bytes, count: int, vertices: int, order: str, length: str = "u1", index: str = "i4"):
    path = tmp_path / "grid.ply"
    path.write_bytes(data)
    element = PlyElement("range_grid", count, (PlyProperty("vertex_indices", index, length),))
    with path.open("rb") as handle:
        return read_range_grid(path, handle, order, element, vertices), handle.read()


@pytest.mark.parametrize(
    ("order", "length", "index"), [("", "u1", "i4"), ("<", "u1", "i4"), (">", "u1", "i4"), ("<", "u2", "i4")]
)
@pytest.mark.parametrize("block", [64, 1 << 20])
def test_every_row_is_found_whatever_the_blocks(tmp_path, monkeypatch, order, length, index, block):
    monkeypatch.setattr(ply_grid, "_BYTES_AT_ONCE", block)
    monkeypatch.setattr(ply_grid, "_ROWS_AT_ONCE", 7)
    rng = np.random.default_rng(3)
    # Indices that look like lengths, in binary: 0, 1, 256, 65536.
    rows = rng.choice([-1, 0, 1, 256, 257, 65536, 65537, 99_999], 1000)
    found, rest = read(tmp_path, encoded(rows, order, length, index) + BEHIND, 1000, 100_000, order, length, index)
    np.testing.assert_array_equal(found, rows)
    assert rest.lstrip() == BEHIND


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_a_wrong_row_is_named_and_nothing_behind_it_is_read(tmp_path, order):
    good = encoded(np.array([0, -1, 3]), order, "u1", "i4")
    wrong = encoded(np.array([123456789]), order, "u1", "i4")
    with pytest.raises(InputError, match="row 3 names vertex 123456789, there are 4"):
        read(tmp_path, good + wrong + b"\xff" * 2999, 900, 4, order)
    with pytest.raises(InputError, match="damaged or cut off in row 3 "):
        read(tmp_path, good + b"\xff" * 2999, 900, 4, order)
    with pytest.raises(InputError, match="range_grid"):
        read(tmp_path, good + b"0\n" * 200, 200, 3, order)  # as many vertices as the largest index: one too few


def test_a_negative_index_is_not_taken_for_a_missing_pixel(tmp_path):
    with pytest.raises(InputError, match="row 0 names vertex -"):
        read(tmp_path, struct.pack("<Bi", 1, -1) * 2, 2, 5, "<")


@pytest.mark.parametrize("line", [b"1\n", b"0 0\n", b"2 0 1\n", b"1 0 0\n", b"1 1e3\n", b"1 0000000001\n", b"-1 0\n"])
def test_text_rows_are_one_length_and_its_index(tmp_path, line):
    with pytest.raises(InputError, match="damaged or cut off in row 2 "):
        read(tmp_path, b"1 0\n0\n" + line + b"1 1\n" * 9, 9, 2, "")


def test_a_file_too_short_for_the_rows_is_refused_before_any_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(ply_grid, "_parse_text", pytest.fail)
    with pytest.raises(InputError, match="16000000 rows of its range_grid need 31999999 bytes or more, 8 are there"):
        read(tmp_path, b"1 0\n" * 2, 16_000_000, 4, "")
    with pytest.raises(InputError, match="16000000 bytes or more, 10 are there"):
        read(tmp_path, struct.pack("<Bi", 1, 0) * 2, 16_000_000, 4, "<")
