"""PLY headers and range grids that lie."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from engine.files.scan import read_scan
from tests.engine.files.planted import planted_scan, ply_bytes, write
from tests.engine.files.refusals import SMALL, refused


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
