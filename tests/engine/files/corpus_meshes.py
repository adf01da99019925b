"""The corpus's meshes that cost far more than their size: overlapping faces, pictures, endless lines, idle rows."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from engine.files.images import encode_image
from tests.engine.files.corpus_runner import Make
from tests.engine.files.mesh_samples import Glb

TRIANGLE = b"v 0 0 0\nv 100 0 0\nv 0 100 0\n"
AXES = b"property float x\nproperty float y\nproperty float z\n"
FACES = b"element face %d\nproperty list uchar int vertex_indices\nend_header\n"
CORNERS = np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0]], "<f4").tobytes() + b"\3" + struct.pack("<3i", 0, 1, 2)


def costly_meshes() -> dict[str, Make]:
    """Return what writes meshes for ``read_mesh``."""
    return {
        "obj of continued lines": _files({"m.obj": TRIANGLE + b"f 1 2 3\n" + b"\\\n" * 300_000}),
        "obj with a picture behind 300,000 options": _clothed(b"map_Kd " + b"-clamp " * 300_000 + b"x.png\n"),
        "obj with a hundred libraries": _files(
            {f"{k}.mtl": b"newmtl a\n" * 400_000 for k in range(100)}
            | {"m.obj": b"".join(b"mtllib %d.mtl\n" % k for k in range(100)) + TRIANGLE + b"f 1 2 3\n"}
        ),
        "obj with forty large pictures": _many_pictures,
        "obj with one picture in 400 tints": _tints,
        "glb with one picture forty times": _glb_pictures(40, tail=False),
        "glb with forty pictures": _glb_pictures(40, tail=True),
        "glb of primitives without a triangle": _primitives(1000, 1_000_000),
        "glb of 100,000 primitives": _primitives(100_000, 3),
        "glb of one node 200,000 times": _nodes,
        "glb with a picture that is no ASCII": _uri("data:image/png;base64,\u00e9"),
        "glb with an endless colour": _endless_colour,
        "ply of 8 million idle rows": _idle(7_999_000),
        "ply of 12 million idle rows": _idle(11_999_998),
        "ply of idle rows of text": _idle_text(3_900_000),
        "ply of mixed rows with 1000 properties": _wide,
        "ply with a list of 400 million": _one_list,
        "ply with 100 MB behind it": _text_tail(b"1 " * 50_000_000),
        "ply with a word of 100 MB behind it": _text_tail(b"1" * 100_000_000),
        "ply with a face of 10^15 corners": _files({"m.ply": _text_head(1) + b"0 " * 9 + b"1000000000000000 1 2 3"}),
    }  # fmt: skip


def costly_scans() -> dict[str, Make]:
    """Return what writes meshes for ``read_scan``, which also looks at them."""
    return {
        "500 sheets": _sheets(500),
        "20,000 sheets": _sheets(20_000),
        "200,000 times one of 200 sheets": _sheets(200_000),
        "texture coordinates of 1e300": _clothed(b"map_Kd t.png\n", b"vt 1e300 0\nvt -1e300 1\nvt 0 1e308\n"),
        "texture coordinates of nan": _clothed(b"map_Kd t.png\n", b"vt nan 0\nvt inf 1\nvt 0 -inf\n"),
        "texture coordinates of 1e6": _clothed(b"map_Kd t.png\n", b"vt 1e6 0\nvt -1e6 1\nvt 0 1e6\n"),
    }


def _files(content: dict[str, bytes]) -> Make:
    def make(folder: Path) -> Path:
        for name, data in content.items():
            (folder / name).write_bytes(data)
        return folder / name

    return make


def _clothed(line: bytes, places: bytes = b"vt 0 0\nvt 1 0\nvt 0 1\n") -> Make:
    return _files({
        "t.png": encode_image(np.full((64, 64, 3), 90, dtype=np.uint8)),
        "m.mtl": b"newmtl a\n" + line,
        "m.obj": b"mtllib m.mtl\nusemtl a\n" + TRIANGLE + places + b"f 1/1 2/2 3/3\n",
    })  # fmt: skip


def _large() -> bytes:
    return encode_image(np.zeros((4000, 4000, 3), dtype=np.uint8))


def _many_pictures(folder: Path) -> Path:
    data = _large()
    for k in range(40):
        (folder / f"{k}.png").write_bytes(data + bytes([k]))
    (folder / "m.mtl").write_text("".join(f"newmtl {k}\nmap_Kd {k}.png\n" for k in range(40)))
    return _uses(folder, 40)


def _tints(folder: Path) -> Path:
    glb = _covered([_large()] * 400)
    for k, material in enumerate(glb.document["materials"]):
        material["pbrMetallicRoughness"]["baseColorFactor"] = [k / 400, 0.5, 0.5, 1]
    return glb.save(folder / "m.glb")


def _uses(folder: Path, count: int) -> Path:
    faces = "".join(f"usemtl {k}\nf 1/1 2/1 3/1\n" for k in range(count))
    (folder / "m.obj").write_text("mtllib m.mtl\n" + TRIANGLE.decode() + "vt 0 0\n" + faces)
    return folder / "m.obj"


def _base(count: int = 3) -> Glb:
    glb = Glb()
    positions = np.zeros((count, 3), "<f4")
    positions[1:3] = [[0.1, 0, 0], [0, 0.1, 0]]
    glb.accessor(positions, "VEC3", 5126)
    glb.document["nodes"], glb.document["scenes"] = [{"mesh": 0}], [{"nodes": [0]}]
    glb.document["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}}]}]
    return glb


def _covered(pictures: list[bytes]) -> Glb:
    """Return a triangle for each picture; the same bytes are stored once, as views of their own."""
    glb = _base()
    places = glb.accessor(np.array([[0, 0], [1, 0], [0, 1]], "<f4"), "VEC2", 5126)
    views = {data: glb.view(data) for data in dict.fromkeys(pictures)}
    many = range(len(pictures))
    glb.document["images"] = [{"bufferView": views[data], "mimeType": "image/png"} for data in pictures]
    glb.document["textures"] = [{"source": k} for k in many]
    glb.document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": k}}} for k in many]
    glb.document["meshes"][0]["primitives"] = [
        {"attributes": {"POSITION": 0, "TEXCOORD_0": places}, "material": k} for k in many
    ]
    return glb


def _glb_pictures(count: int, tail: bool) -> Make:
    def make(folder: Path) -> Path:
        data = _large()
        return _covered([data + bytes([k]) if tail else data for k in range(count)]).save(folder / "m.glb")

    return make


def _primitives(number: int, count: int) -> Make:
    def make(folder: Path) -> Path:
        glb = _base(count)
        line = glb.accessor(np.array([0, 1], "<u4"), "SCALAR", 5125)
        glb.document["meshes"][0]["primitives"] *= number
        glb.document["meshes"][0]["primitives"][0] = {"attributes": {"POSITION": 0}, "indices": line}
        glb.document["meshes"][0]["primitives"][1:] = [{"attributes": {"POSITION": 0}, "indices": line}] * (number - 1)
        return glb.save(folder / "m.glb")

    return make


def _nodes(folder: Path) -> Path:
    glb = _base()
    glb.document["scenes"] = [{"nodes": [0] * 200_000}]
    return glb.save(folder / "m.glb")


def _uri(uri: str) -> Make:
    def make(folder: Path) -> Path:
        glb = _covered([b"x"])
        glb.document["images"] = [{"uri": uri}]
        return glb.save(folder / "m.glb")

    return make


def _endless_colour(folder: Path) -> Path:
    glb = _covered([b"x"])
    glb.document["materials"][0]["pbrMetallicRoughness"] = {"baseColorFactor": [[0] * 3_000_000, 1, 1, 1]}
    glb.document["meshes"][0]["primitives"] *= 9_000
    return glb.save(folder / "m.glb")


def _ply(idle: bytes, order: bytes = b"binary_little_endian", faces: int = 1) -> bytes:
    return b"ply\nformat " + order + b" 1.0\n" + idle + b"element vertex 3\n" + AXES + FACES % faces


def _idle(rows: int) -> Make:
    head = _ply(b"element junk %d\nproperty list uchar uchar a\n" % rows)
    return _files({"m.ply": head + b"\0\1\0" * (rows // 2) + b"\0" * (rows % 2) + CORNERS})


def _idle_text(rows: int) -> Make:
    head = _ply(b"element junk %d\nproperty list uchar uchar a\n" % rows, b"ascii")
    return _files({"m.ply": head + b"0\n1 0\n" * (rows // 2) + b"0 0 0 100 0 0 0 100 0 3 0 1 2\n"})


def _wide(folder: Path) -> Path:
    properties = b"".join(b"property uchar p%d\n" % k for k in range(1000)) + b"property list uchar uchar a\n"
    rows = b"".join(bytes(1001) + bytes(1000) + b"\1\0" for _ in range(25_000))
    (folder / "m.ply").write_bytes(_ply(b"element junk 50000\n" + properties) + rows + CORNERS)
    return folder / "m.ply"


def _one_list(folder: Path) -> Path:
    head = _ply(b"", faces=2).replace(b"list uchar int", b"list uint uchar")
    long = 400_000_000
    with (folder / "m.ply").open("wb") as handle:
        handle.write(head + CORNERS[:36] + struct.pack("<I3B", 3, 0, 1, 2) + struct.pack("<I", long))
        handle.truncate(handle.tell() + long)
    return folder / "m.ply"


def _text_head(faces: int) -> bytes:
    return _ply(b"", b"ascii", faces)


def _text_tail(tail: bytes) -> Make:
    return _files({"m.ply": _text_head(1) + b"0 0 0\n100 0 0\n0 100 0\n3 0 1 2\n" + tail})


def _sheets(faces: int, most: int = 200) -> Make:
    def make(folder: Path) -> Path:
        number = faces if faces <= 20_000 else most
        corners = "".join(f"v -100 -100 {k * 0.1}\nv 300 -100 {k * 0.1}\nv -100 300 {k * 0.1}\n" for k in range(number))
        each = (3 * (k % number) + 1 for k in range(faces))
        (folder / "s.obj").write_text(corners + "".join(f"f {k} {k + 1} {k + 2}\n" for k in each))
        return folder / "s.obj"

    return make
