"""The corpus's performances: heads that lie, bombs, and numbers that are none."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

import numpy as np

from tests.engine.files import motion_samples as samples
from tests.engine.files.corpus_runner import Make


def motion_bombs() -> dict[str, Make]:
    """Return what writes each file, by name."""
    clip = samples.performance(6)
    nothing = np.full_like(clip, np.nan)
    huge = clip * 1e300
    number = struct.pack("<bB", 2, 0) + struct.pack("<H", 65535)
    texts = {
        "trc of no frames": ("m.trc", samples.trc_text(clip[:0])),
        "trc at 0 Hz": ("m.trc", samples.trc_text(clip, fps=1).replace("1\t1\t6\t9", "0\t0\t6\t9")),
        "trc of gaps alone": ("m.trc", samples.trc_text(nothing)),
        "trc of huge numbers": ("m.trc", samples.trc_text(huge)),
        "trc of ragged rows": ("m.trc", samples.trc_text(clip) + "7\t0.1\t1\t2\n"),
        "markers of gaps alone": ("m.csv", samples.marker_text(nothing)),
        "markers of huge numbers": ("m.csv", samples.marker_text(huge)),
        "markers of one name": ("m.csv", samples.marker_text(clip, ["a"] * 9)),
        "markers of ragged rows": ("m.csv", samples.marker_text(clip) + "1,2,3\n"),
        "markers in one place": ("m.csv", samples.marker_text(np.zeros((4, 9, 3)))),
        "markers that stand still in time": ("m.csv", samples.marker_text(clip).replace("0.00833", "0.0")),
        "markers: a hundred thousand columns": ("m.csv", ",".join(f"a{k}_x" for k in range(100_000)) + "\n1\n"),
        "markers: quote without end": ("m.csv", 'Frame,"a_x,a_y,a_z\n1,2,3,4\n'),
        "live link without rows": ("m.csv", "Timecode,BlendShapeCount,JawOpen\n"),
        "live link that goes back": (
            "m.csv", "Timecode,BlendShapeCount,A\n00:00:02:01.0,1,0\n00:00:01:01.0,1,0\n00:00:03:01.0,1,0\n",
        ),
        "live link of one time": ("m.csv", "Timecode,BlendShapeCount,A\n" + "00:00:02:01.0,1,0\n" * 5),
        "weights that stand still in time": ("m.csv", "frame,time_s,a\n1,0,0\n2,0,0\n3,0,0\n"),
        "weights far apart": ("m.csv", "frame,time_s,a\n1,0,0\n2,1e300,0\n"),
        "weights that are infinite": ("m.csv", "frame,time_s,a\n1,0,inf\n2,1,0\n"),
    }  # fmt: skip
    keys = np.arange(4) / 24
    files = {
        "c3d of 65535 markers": ("m.c3d", samples.c3d_bytes(clip, used=65535)),
        "c3d of 65535 frames": ("m.c3d", samples.c3d_bytes(clip, last=65535)),
        "c3d that counts more": ("m.c3d", samples.c3d_bytes(clip, last=65535, extra=[(b"LONG_FRAMES", number)])),
        "c3d at 0 Hz": ("m.c3d", samples.c3d_bytes(clip, fps=0)),
        "c3d at NaN Hz": ("m.c3d", samples.c3d_bytes(clip, fps=float("nan"))),
        "c3d of scale 0": ("m.c3d", samples.c3d_bytes(clip, scale=-0.0)),
        "c3d of gaps alone": ("m.c3d", samples.c3d_bytes(nothing)),
        "c3d of NaN": ("m.c3d", samples.c3d_bytes(clip, scale=-1).replace(b"\0\0\x80?", b"\0\0\xc0\x7f")),
        "c3d of one name": ("m.c3d", samples.c3d_bytes(clip, ["a"] * 9)),
        "c3d whose parameters go round": ("m.c3d", _looped(samples.c3d_bytes(clip))),
        "pc2 of 2 thousand million points": ("m.pc2", _pc2(2_000_000_000, 2_000_000_000)),
        "pc2 of fewer than no points": ("m.pc2", _pc2(-5, 3)),
        "pc2 of NaN": ("m.pc2", samples.pc2_bytes(nothing)),
        "pc2 of 0 frames a sample": ("m.pc2", samples.pc2_bytes(clip, rate=0)),
        "npz at 0 Hz": ("m.npz", samples.npz_bytes(vertices=clip, fps=0)),
        "npz of NaN": ("m.npz", samples.npz_bytes(vertices=nothing, fps=30)),
        "npz of a flat table": ("m.npz", samples.npz_bytes(vertices=clip[0], fps=30)),
        "npz without frames": ("m.npz", samples.npz_bytes(vertices=clip[:0], fps=30)),
        "npz of objects": ("m.npz", samples.npz_bytes(vertices=np.array([{}], dtype=object), fps=30)),
        "npz of whole numbers": ("m.npz", samples.npz_bytes(vertices=clip.astype(int), fps=30)),
        "glb that never ends": ("m.glb", samples.animated_glb(keys * 1e9, np.zeros(4), ("a",))),
        "glb that goes back": ("m.glb", samples.animated_glb(keys[::-1], np.zeros(4), ("a",))),
        "glb of NaN": ("m.glb", samples.animated_glb(keys, np.full(4, np.nan), ("a",))),
        "glb of too few values": ("m.glb", samples.animated_glb(keys, np.zeros(3), ("a",))),
        "glb of one name": ("m.glb", samples.animated_glb(keys, np.zeros(8), ("a", "a"))),
        "glb without keys": ("m.glb", samples.animated_glb(keys[:0], np.zeros(0), ("a",))),
    }
    found = {name: _written(file, data) for name, (file, data) in files.items()}
    found |= {name: _written(file, text.encode()) for name, (file, text) in texts.items()}
    found["pc2 of 16 GB that are nowhere"] = _sparse("m.pc2", _pc2(100_000_000, 100), 32)
    found["npz of 8 GB packed"] = _packed_bomb
    return found


def _written(name: str, data: bytes) -> Make:
    def make(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return make


def _sparse(name: str, head: bytes, length: int) -> Make:
    return _written(name, head[:length])


def _pc2(points: int, samples_: int) -> bytes:
    return struct.pack("<12siiffi", b"POINTCACHE2\0", 1, points, 0.0, 1.0, samples_) + bytes(600)


def _looped(data: bytes) -> bytes:
    """Let the first parameter lead back to itself."""
    place = data.index(b"POINT") + 5
    return data[:place] + struct.pack("<h", -7) + data[place + 2 :]


def _packed_bomb(folder: Path) -> Path:
    """An archive whose vertices unpack to 8 GB of zeros, of which only the first megabytes are there."""
    head = b"{'descr': '<f4', 'fortran_order': False, 'shape': (1000, 700000, 3), }"
    head = b"\x93NUMPY\1\0" + struct.pack("<H", len(head) + 1) + head + b"\n"
    length = len(head) + 4 * 1000 * 700000 * 3
    path = folder / "m.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("vertices.npy", head + bytes(1 << 20))
    data = bytearray(path.read_bytes())
    # Both heads of the member announce the whole length.
    for mark, place in ((b"PK\3\4", 22), (b"PK\1\2", 24)):
        at = data.index(mark) + place
        data[at : at + 4] = struct.pack("<I", min(length, 0xFFFFFFFE))
    path.write_bytes(bytes(data))
    return path
