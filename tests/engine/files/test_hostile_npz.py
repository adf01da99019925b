"""NumPy archives that lie, and pickles."""

from __future__ import annotations

import os
import struct
import zipfile
from io import BytesIO

import numpy as np
import pytest

from engine.files.scan import read_scan
from tests.engine.files.planted import planted_scan, write
from tests.engine.files.refusals import SMALL, refused


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
