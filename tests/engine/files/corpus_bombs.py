"""The corpus's hand-made files: bombs, sizes that lie, tricks with paths, encodings and databases."""

from __future__ import annotations

import gzip
import json
import os
import sqlite3
import struct
import zipfile
import zlib
from pathlib import Path

from tests.engine.files.corpus_meshes import costly_meshes, costly_scans
from tests.engine.files.corpus_motions import motion_bombs
from tests.engine.files.corpus_rigs import rig_bombs
from tests.engine.files.corpus_runner import Make
from tests.engine.files.corpus_seeds import Seed
from tests.engine.files.foreign import pcd_bytes
from tests.engine.files.planted import planted_scan, ply_bytes

MB = 1 << 20
PIXELS = 4000 * 4000


def written(name: str, data: bytes) -> Make:
    """Return what writes one file."""

    def make(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return make


def sparse(name: str, head: bytes, length: int) -> Make:
    """Return what writes a file of ``length`` bytes that takes no room on the disk."""

    def make(folder: Path) -> Path:
        with (folder / name).open("wb") as handle:
            handle.write(head)
            handle.truncate(length)
        return folder / name

    return make


def zeros(length: int, wbits: int = 15) -> bytes:
    """Return so many packed zeros."""
    packer = zlib.compressobj(9, zlib.DEFLATED, wbits)
    pieces = [packer.compress(bytes(MB)) for _ in range(length // MB)]
    return b"".join([*pieces, packer.compress(bytes(length % MB)), packer.flush()])


def png(width: int, height: int, length: int) -> bytes:
    """Return a PNG of one 16-bit channel with right checksums, whatever its header says."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zeros(length)) + chunk(b"IEND", b"")


def bombs(seeds: dict[str, Seed]) -> dict[str, tuple[str, Make]]:
    """Return (reader, what writes it) by name."""
    found: dict[str, tuple[str, Make]] = {}
    found |= {f"scan: {name}": ("scan", make) for name, make in _scans().items()}
    found |= {f"image: {name}": ("grey", make) for name, make in _images().items()}
    found |= {f"mesh: {name}": ("mesh", make) for name, make in _meshes(seeds).items()}
    found |= {f"mesh: {name}": ("mesh", make) for name, make in costly_meshes().items()}
    found |= {f"seen: {name}": ("scan", make) for name, make in costly_scans().items()}
    found |= {f"project: {name}": ("project", make) for name, make in _projects(seeds).items()}
    found |= {f"rig: {name}": ("rig", make) for name, make in rig_bombs().items()}
    found |= {f"motion: {name}": ("motion", make) for name, make in motion_bombs().items()}
    for reader, name in _TEXT_READERS.items():
        for label, data in _texts().items():
            found[f"{reader}: {label}"] = (reader, written(name, data))
    for reader, name in {
        **_TEXT_READERS,
        "scan": "s.pcd",
        "mesh": "m.obj",
        "rig": "r.glb",
        "project": "p.qface",
        "image": "p.png",
    }.items():
        for label, make in _places(name).items():
            found[f"{reader}: {label}"] = (reader, make)
    return found


_TEXT_READERS = {
    "fiducials": "f.json",
    "motion": "m.csv",
    "pairs": "MARKERS.json",
    "landmarks": "l.ljson",
    "mapping": "m.toml",
    "scheme": "s.toml",
    "template": "t.json",
    "journal": "j.json",
    "limits": "l.toml",
}


def _texts() -> dict[str, bytes]:
    laughs = 'a0 = "' + "ha" * 50 + '"\n' + "".join(f"a{n} = [" + f'"a{n - 1}", ' * 10 + "]\n" for n in range(1, 300))
    return {
        "10^6 brackets": b"[" * 10**6,
        "10^5 objects in each other": b'{"a":' * 10**5,
        "deep toml": b"a = " + b"[" * 10**5 + b"]" * 10**5,
        "dotted keys": b".".join([b"a"] * 20_000) + b" = 1\n",
        "many laughs": laughs.encode(),
        "digits without end": b'{"a": ' + b"9" * 10**6 + b"}",
        "toml digits": b"a = " + b"9" * 10**6,
        "utf-16": '{"name": "a"}'.encode("utf-16"),
        "latin-1": '{"name": "Gesicht für Größe"}'.encode("latin-1"),
        "zeros": bytes(1000),
        "null": b"null",
        "a key twice": b'{"name": "a", "name": "b"}',
        "a table twice": b"[a]\nb = 1\n[a]\nb = 2\n",
        "20 MB of blanks": b" " * (20 * MB),
        "a lone surrogate": b'{"name": "\\ud800"}',
    }


def _places(name: str) -> dict[str, Make]:
    def fifo(folder: Path) -> Path:
        os.mkfifo(folder / name)
        return folder / name

    def link(target: str) -> Make:
        def make(folder: Path) -> Path:
            (folder / name).symlink_to(target)
            return folder / name

        return make

    def subfolder(folder: Path) -> Path:
        (folder / name).mkdir()
        return folder / name

    return {
        "a pipe": fifo,
        "/dev/zero": link("/dev/zero"),
        "/dev/stdin": link("/dev/stdin"),
        "a link to itself": link(name),
        "a link to nothing": link("nowhere"),
        "a folder": subfolder,
        "no file": lambda folder: folder / name,
        "a name too long": lambda folder: folder / ("x" * 300 + name),
        "an empty file": written(name, b""),
        "2 GB of nothing": sparse(name, b"", 2 << 30),
    }


def _scans() -> dict[str, Make]:
    header = ply_bytes(planted_scan(), "binary_little_endian", "full").split(b"end_header")[0]
    text = ply_bytes(planted_scan(), "ascii", "full").split(b"end_header")[0]
    pcd = pcd_bytes(planted_scan(), "binary")
    body = pcd.index(b"DATA binary\n") + 12
    large = pcd[:body].replace(b"WIDTH 32", b"WIDTH 4000").replace(b"HEIGHT 24", b"HEIGHT 4000")
    large = large.replace(b"POINTS 768", b"POINTS 16000000")
    packed = pcd[:body].replace(b"binary\n", b"binary_compressed\n")
    large_packed = large.replace(b"binary\n", b"binary_compressed\n")
    lzf = b"\0a" + b"\xe0\xff\x00" * 40_000
    abs_head = b"2000 rows\n2000 columns\npixels (flag X Y Z):\n"
    grown = header.replace(b"cols 32", b"cols 4000").replace(b"rows 24", b"rows 4000")
    grown = grown.replace(b"vertex 768", b"vertex 16000000") + b"end_header\n"
    return {
        "npz that unpacks to 400 MB": _npz((24, 32, 3), 400 * MB),
        "npz of 10^9 x 10^9": _npz((10**9, 10**9, 3), MB),
        "npz of the largest size": _npz((4000, 4000, 3), PIXELS * 24),
        "npz that announces more than it holds": _npz((4000, 4000, 3), 10 * MB),
        "npz with a negative size": _npz((-24, -32, 3), MB),
        "npz full of members": _members,
        "npz in npz": _nested,
        "npz with a path": _npz_path,
        "ply of 900 MB of nothing": sparse("s.ply", header.replace(b"768", b"9000000") + b"end_header\n", 900 * MB),
        "ply of the largest size": sparse("s.ply", grown, len(grown) + PIXELS * 15),
        "ply of one line": written("s.ply", text + b"end_header\n" + b"1" * (60 * MB)),
        "ply of blanks": written("s.ply", text + b"end_header\n" + b"\n" * (60 * MB)),
        "pcd of the largest size": sparse("s.pcd", large, len(large) + PIXELS * 16),
        "pcd of 1 GB of nothing": sparse("s.pcd", pcd[:body], (1 << 30) - 1),
        "pcd lzf bomb": written("s.pcd", packed + struct.pack("<II", len(lzf), 32 * 24 * 16) + lzf),
        "pcd lzf of the largest size": _lzf(large_packed, b"\xe0\xff\x00"),
        "pcd lzf in tiny pieces": _lzf(large_packed, b"\0a"),
        "pcd lzf that announces 4 GB": written("s.pcd", packed + struct.pack("<II", 2**32 - 1, 2**32 - 1) + lzf),
        "abs bomb": written(
            "s.abs.gz", gzip.compress(abs_head[:-1].replace(b"2000", b"20") + b"\n" + bytes(50 * MB), 1)
        ),
        "abs bomb of blanks": _gzip_blanks(b"24 rows\n32 columns\npixels (flag X Y Z):\n", 500 * MB),
        "abs of 4 million pixels": _gzip_ones(abs_head, 16_000_000),
        "abs that holds nothing": written("s.abs.gz", gzip.compress(abs_head)),
        "xyz of one point 5 million times": written("s.xyz", b"1 2 3\n" * 5_000_000),
        "xyz on a line": written("s.xyz", b"".join(b"%d 2 900\n" % n for n in range(20_000))),
        "xyz far apart": written("s.xyz", b"1e300 2 3\n-1e300 1e-300 4\n" * 200),
        "xyz of nan": written("s.xyz", b"nan nan nan\n" * 2000),
        "xyz of comments": written("s.xyz", b"# comment\n" * 3_000_000),
        "xyz with a giant line": written("s.xyz", b"1 2 3\n" + b"4 " * (30 * MB)),
        "xyz grid with one stray": written("s.xyz", _grid_text() + b"1e9 1e9 -1\n"),
        "json of 100 MB": written("s.json", b"[" * (100 * MB)),
        "depth of the largest size": _depth(png(4000, 4000, 4000 * 8001)),
        "depth that unpacks to 400 MB": _depth(png(32, 24, 400 * MB)),
        **{f"depth named {name[:24]!r}": _named(name) for name in _OUTSIDE},
        "depth is a link out": _link_out("s_depth.png"),
        "depth is a device": _device("s_depth.png"),
        "exr of 10^9 pixels": written("s.exr", b"v/1\x01" + bytes(100)),
    }


_OUTSIDE = (
    "../../etc/passwd",
    "/etc/passwd",
    "..\\x.png",
    "C:\\x.png",
    "\\\\server\\x.png",
    "a/../../x.png",
    "",
    "a\0b",
)


def _named(name: str) -> Make:
    def make(folder: Path) -> Path:
        fields = {"depth": name, "unit_mm": 0.1, "fx": 60, "fy": 60, "cx": 15, "cy": 11}
        (folder / "s.json").write_text(json.dumps(fields))
        return folder / "s.json"

    return make


def _depth(data: bytes) -> Make:
    def make(folder: Path) -> Path:
        (folder / "d.png").write_bytes(data)
        return _named("d.png")(folder)

    return make


def _link_out(name: str) -> Make:
    def make(folder: Path) -> Path:
        (folder.parent / "corpus-outside.png").write_bytes(png(4, 4, 36))
        (folder / name).symlink_to(folder.parent / "corpus-outside.png")
        return _named(name)(folder)

    return make


def _device(name: str) -> Make:
    def make(folder: Path) -> Path:
        os.mkfifo(folder / name)
        return _named(name)(folder)

    return make


def _npz(shape: tuple[int, ...], length: int) -> Make:
    def make(folder: Path) -> Path:
        text = repr({"descr": "<f8", "fortran_order": False, "shape": shape}).encode().ljust(118) + b"\n"
        with (
            zipfile.ZipFile(folder / "s.npz", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as out,
            out.open("points.npy", "w", force_zip64=True) as member,
        ):
            member.write(b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text)
            for _ in range(length // MB):
                member.write(bytes(MB))
            member.write(bytes(length % MB))
        return folder / "s.npz"

    return make


def _members(folder: Path) -> Path:
    with zipfile.ZipFile(folder / "s.npz", "w") as out:
        for number in range(20_000):
            out.writestr(f"{number}.npy", b"")
    return folder / "s.npz"


def _nested(folder: Path) -> Path:
    with zipfile.ZipFile(folder / "s.npz", "w") as out:
        out.writestr("points.npy", _npz((24, 32, 3), MB)(folder).read_bytes())
    return folder / "s.npz"


def _npz_path(folder: Path) -> Path:
    with zipfile.ZipFile(folder / "s.npz", "w") as out:
        out.writestr("../../points.npy", b"\x93NUMPY")
    return folder / "s.npz"


def _lzf(head: bytes, piece: bytes) -> Make:
    length = PIXELS * 16
    makes = 264 if len(piece) == 3 else 1
    data = b"\0a" + piece * min(length // makes, 25_000_000)
    return written("s.pcd", head + struct.pack("<II", len(data), length) + data)


def _gzip_blanks(head: bytes, length: int) -> Make:
    return written("s.abs.gz", gzip.compress(head, 1) + gzip.compress(b" " * MB, 6) * (length // MB))


def _gzip_ones(head: bytes, count: int) -> Make:
    return written("s.abs.gz", gzip.compress(head, 1) + gzip.compress(b"1 " * 500_000, 6) * (count // 500_000))


def _grid_text() -> bytes:
    return b"".join(b"%.4f %.4f -900\n" % (column * 0.5, row * 0.5) for row in range(40) for column in range(50))


def _images() -> dict[str, Make]:
    return {
        "png of 30000 x 30000": written("d.png", png(30_000, 30_000, MB)),
        "png of 10^9 x 10^9": written("d.png", png(10**9, 10**9, 0)),
        "png of no pixel": written("d.png", png(0, 10, 0)),
        "png that unpacks to 400 MB": written("d.png", png(32, 24, 400 * MB)),
        "png of the largest size": written("d.png", png(4000, 4000, 4000 * 8001)),
        "ppm of 10^9 pixels": written("d.ppm", b"P6 999999999 999999999 255\n" + bytes(100)),
        "ppm with endless comments": written("d.ppm", b"P6 " + b"#\n" * 10**6),
        "exr of 10^9 pixels": written("d.exr", _exr_head(10**9, 10**9)),
        "exr of negative size": written("d.exr", _exr_head(-7, 4)),
        "exr of many channels": written("d.exr", _exr_head(4000, 4000, 1000)),
        "exr without lines": written("d.exr", _exr_head(32, 24) + bytes(24 * 8)),
        "exr cut off": written("d.exr", _exr_head(32, 24)[:60]),
    }


def _exr_head(width: int, height: int, channels: int = 1) -> bytes:
    def attribute(name: str, kind: str, data: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(data)) + data

    names = b"".join(b"Z%d\0" % n + struct.pack("<iiii", 2, 0, 1, 1) for n in range(channels)) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    return b"v/1\x01\2\0\0\0" + b"".join([
        attribute("channels", "chlist", names), attribute("compression", "compression", b"\0"),
        attribute("dataWindow", "box2i", window), attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", bytes(8)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)), b"\0",
    ])  # fmt: skip


def _meshes(seeds: dict[str, Seed]) -> dict[str, Make]:
    triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    glb = seeds["glb"].data
    axes = b"property float x\nproperty float y\nproperty float z\n"
    faces = b"property list uchar int vertex_indices\nend_header\n"
    tri = b"ply\nformat ascii 1.0\nelement vertex 3\n" + axes + b"element face %s\n" + faces + b"0 0 0\n1 0 0\n0 1 0\n"
    return {
        "obj index 10^9": written("m.obj", triangle + b"f 1 2 1000000000\n"),
        "obj index -10^9": written("m.obj", triangle + b"f -1000000000 2 1\n"),
        "obj index 10^30": written("m.obj", triangle + b"f 1 2 " + b"9" * 30 + b"\n"),
        "obj index 0": written("m.obj", triangle + b"f 0 1 2\n"),
        "obj of nan": written("m.obj", b"v nan nan nan\n" * 3 + b"f 1 2 3\n"),
        "obj of inf": written("m.obj", b"v inf 1e999 0\n" * 3 + b"f 1 2 3\n"),
        "obj with a giant line": written("m.obj", triangle + b"f" + b" 1" * (20 * MB)),
        "obj with a giant polygon": written("m.obj", triangle + b"f" + b" 1 2 3" * 300_000 + b"\n"),
        "obj of one vertex 3 million times": written("m.obj", b"v 0 0 0\n" * 3_000_000 + b"f 1 2 3\n"),
        "obj with materials outside": written("m.obj", b"mtllib ../../x.mtl\nmtllib /etc/x\n" + triangle),
        "obj of zeros": written("m.obj", bytes(50 * MB)),
        "obj in utf-16": written("m.obj", "v 0 0 0\n".encode("utf-16")),
        "ply face of 10^9": written("m.ply", tri % b"1000000000" + b"3 0 1 2\n"),
        "ply face -1": written("m.ply", tri % b"1" + b"3 0 1 -1\n"),
        "ply face index 10^9": written("m.ply", tri % b"1" + b"3 0 1 1000000000\n"),
        "ply face of 255 corners": written("m.ply", tri % b"1" + b"255 0 1 2\n"),
        "glb length 4 GB": written("m.glb", glb[:8] + b"\xff\xff\xff\xff" + glb[12:]),
        "glb chunk 4 GB": written("m.glb", glb[:12] + b"\xff\xff\xff\xff" + glb[16:]),
        "glb of deep json": written("m.glb", _glb(b'{"a":' * 50_000)),
        "glb of accessors": written("m.glb", _glb(_gltf(10**9, 10**9))),
        "glb of negative offsets": written("m.glb", _glb(_gltf(-5, -9))),
        "glb of nodes in a ring": written("m.glb", _glb(_RING)),
        "glb that names a file outside": written("m.glb", _glb(_OUTSIDE_BUFFER)),
    }  # fmt: skip


_RING = (
    b'{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],'
    b'"nodes":[{"children":[1],"mesh":0},{"children":[0]}]}'
)
_OUTSIDE_BUFFER = b'{"asset":{"version":"2.0"},"buffers":[{"uri":"../../../etc/passwd","byteLength":9}]}'


def _glb(text: bytes) -> bytes:
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text


def _gltf(count: int, offset: int) -> bytes:
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteOffset": offset, "byteLength": 9}], "buffers": [{"byteLength": 9}],
    }).encode()  # fmt: skip


def _projects(seeds: dict[str, Seed]) -> dict[str, Make]:
    data = seeds["qface"].data

    def altered(*statements: str) -> Make:
        def make(folder: Path) -> Path:
            path = folder / "p.qface"
            path.write_bytes(data)
            connection = sqlite3.connect(path, isolation_level=None)
            try:
                connection.execute("PRAGMA writable_schema = ON")
                for statement in statements:
                    connection.execute(statement)
            finally:
                connection.close()
            return path

        return make

    connection = sqlite3.connect(":memory:")
    connection.deserialize(data)
    tables = [row[0] for row in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
    connection.close()
    endless = "WITH RECURSIVE n(a) AS (SELECT 1 UNION ALL SELECT a + 1 FROM n) SELECT a, a, a, a FROM n"
    found = {
        "another application": altered("PRAGMA application_id = 1"),
        "a version to come": altered("PRAGMA user_version = 999999"),
        "a negative version": altered("PRAGMA user_version = -5"),
        "a database of nothing": lambda folder: _empty_database(folder / "p.qface"),
        "pages of 2^31": written("p.qface", data[:28] + struct.pack(">I", 2**31 - 1) + data[32:]),
        "a page size of 1": written("p.qface", data[:16] + b"\0\1" + data[18:]),
        "a write-ahead log": written("p.qface", data[:18] + b"\2\2" + data[20:]),
    }
    for table in tables:
        found[f"{table} dropped"] = altered(f'DROP TABLE "{table}"')
        found[f"{table} emptied"] = altered(f'DELETE FROM "{table}"')
        found[f"{table} an endless view"] = altered(f'DROP TABLE "{table}"', f'CREATE VIEW "{table}" AS {endless}')
        columns = _columns(data, table)
        for column in columns:
            for label, value in (("null", "NULL"), ("number", "1e308"), ("text", "'x'"), ("1 MB", "zeroblob(1000000)")):
                found[f"{table}.{column} {label}"] = altered(f'UPDATE OR IGNORE "{table}" SET "{column}" = {value}')
    return found


def _columns(data: bytes, table: str) -> list[str]:
    connection = sqlite3.connect(":memory:")
    try:
        connection.deserialize(data)
        return [row[1] for row in connection.execute(f'PRAGMA table_info("{table}")')]
    finally:
        connection.close()


def _empty_database(path: Path) -> Path:
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute("CREATE TABLE hollow (a)")
    connection.close()
    return path
