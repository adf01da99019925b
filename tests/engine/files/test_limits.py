"""The worst files in a process of their own, whose memory is limited and measured."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
import zipfile
import zlib
from pathlib import Path

import pytest

from engine.files.depth_json import write_depth_scan
from tests.engine.files.planted import planted_scan, ply_bytes

pytestmark = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is measured on Linux only")

ROOT = Path(__file__).parents[3]
MEGABYTE = 1 << 20

# Importing cv2 and numpy is paid for by everybody, so memory is counted from there.
READER = """
import json, resource, sys
from engine.errors import InputError
from engine.files.scan import read_scan
def peak():  # of this program alone; ru_maxrss would count the one that started it
    return int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
start = peak()
resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[2]), int(sys.argv[2])))
try:
    read_scan(sys.argv[1])
    message = None
except InputError as error:
    message = str(error)
print(json.dumps([message, peak() - start]))
"""


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def zeros(length: int) -> bytes:
    packer = zlib.compressobj(9)
    pieces = [packer.compress(bytes(MEGABYTE)) for _ in range(length // MEGABYTE)]
    return b"".join([*pieces, packer.compress(bytes(length % MEGABYTE)), packer.flush()])


def png_bomb(width: int, height: int, length: int) -> bytes:
    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zeros(length)) + chunk(b"IEND", b"")


def depth_with(folder: Path, data: bytes) -> Path:
    write_depth_scan(folder / "s.json", planted_scan())
    (folder / "s_depth.png").write_bytes(data)
    path = folder / "s.json"
    fields = json.loads(path.read_text())
    del fields["colour"]
    path.write_text(json.dumps(fields))
    return path


def npz_bomb(folder: Path, shape: tuple[int, ...], length: int) -> Path:
    text = repr({"descr": "<f8", "fortran_order": False, "shape": shape}).encode().ljust(118) + b"\n"
    with (
        zipfile.ZipFile(folder / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as out,
        out.open("points.npy", "w", force_zip64=True) as member,
    ):
        member.write(b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text)
        for _ in range(length // MEGABYTE):
            member.write(bytes(MEGABYTE))
    return folder / "bomb.npz"


def ply_with(folder: Path, data: bytes) -> Path:
    (folder / "s.ply").write_bytes(data)
    return folder / "s.ply"


def sparse_ply(folder: Path) -> Path:
    header = ply_bytes(planted_scan(), "binary_little_endian", "full").split(b"end_header")[0]
    path = ply_with(folder, header.replace(b"vertex 768", b"vertex 9000000") + b"end_header\n")
    with path.open("r+b") as handle:
        handle.truncate(900 * MEGABYTE)
    return path


LARGEST = 3840 * (1 + 2 * 4096)
HEADER = ply_bytes(planted_scan(), "ascii", "full").split(b"end_header")[0]
WORST = {
    "png that unpacks to 400 MB": lambda folder: depth_with(folder, png_bomb(32, 24, 400 * MEGABYTE)),
    "png of 10^5 x 10^5": lambda folder: depth_with(folder, png_bomb(10**5, 10**5, MEGABYTE)),
    "png of the largest size, all missing": lambda folder: depth_with(folder, png_bomb(4096, 3840, LARGEST)),
    "npz of 400 MB of zeros, small shape": lambda folder: npz_bomb(folder, (24, 32, 3), 400 * MEGABYTE),
    "npz of 10^9 x 10^9": lambda folder: npz_bomb(folder, (10**9, 10**9, 3), MEGABYTE),
    "npz that announces more than it holds": lambda folder: npz_bomb(folder, (4000, 4000, 3), 10 * MEGABYTE),
    "ply of 900 MB of nothing": sparse_ply,
    "text ply of one line": lambda folder: ply_with(folder, HEADER + b"end_header\n" + b"1" * 100 * MEGABYTE),
    "json of 100 MB": lambda folder: ply_with(folder, b"[" * 100 * MEGABYTE).rename(folder / "s.json"),
    "colour of 15 million pixels beside a small depth": lambda folder: colour_bomb(folder),
}


def colour_bomb(folder: Path) -> Path:
    write_depth_scan(folder / "s.json", planted_scan())
    (folder / "s_colour.png").write_bytes(png_bomb(4096, 3840, LARGEST))
    return folder / "s.json"


@pytest.mark.parametrize("kind", WORST)
def test_the_worst_files_are_refused_in_little_memory(tmp_path, kind):
    path = WORST[kind](tmp_path)
    try:
        done = subprocess.run(
            [sys.executable, "-c", READER, str(path), str(1500 * MEGABYTE)],
            cwd=ROOT, capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip
    finally:
        for left in tmp_path.iterdir():
            left.unlink()
    assert done.returncode == 0, done.stderr
    message, kilobytes = json.loads(done.stdout)
    assert message is not None
    assert "\n" not in message
    assert kilobytes < 200 * 1024
    assert done.stderr == ""


def test_the_limit_of_that_measurement_bites(tmp_path):
    code = READER.replace("read_scan(sys.argv[1])", "import numpy; numpy.ones(200_000_000)")
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path), str(1500 * MEGABYTE)],
        cwd=ROOT, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert "MemoryError" in done.stderr
