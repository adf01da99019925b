"""Meshes that somebody has damaged or made to hurt: one line says what is wrong, soon, and nothing else happens."""

from __future__ import annotations

import json
import struct
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.errors import InputError
from engine.files.glb import write_glb
from engine.files.images import write_image
from engine.files.mesh_file import read_mesh
from engine.files.obj import write_obj
from engine.files.textures import PictureBudget
from engine.scan.mesh_view import MeshView, view_mesh
from tests.engine.files.mesh_samples import Glb, bumpy, checks

BINARY = (
    b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
)


def small(folder: Path) -> dict[str, bytes]:
    """Return sound files of each format."""
    mesh = bumpy(4, 5)
    write_obj(folder / "s.obj", mesh)
    write_glb(folder / "s.glb", mesh, texture=checks(8, 8))
    data = BINARY + np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0]], "<f4").tobytes() + b"\x03"
    return {
        ".obj": (folder / "s.obj").read_bytes(),
        ".glb": (folder / "s.glb").read_bytes(),
        ".ply": data + np.array([0, 1, 2], "<i4").tobytes(),
    }


def is_calm(path: Path) -> None:
    """Read a file: either it is a mesh, or one line says why not."""
    try:
        read_mesh(path)
    except InputError as error:
        assert "\n" not in str(error) and len(str(error)) < 1500


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from([".obj", ".glb", ".ply"]), st.data())
def test_flipped_and_cut_bytes(tmp_path: Path, suffix: str, data: Any) -> None:
    content = bytearray(small(tmp_path)[suffix])
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place] = data.draw(st.integers(0, 255))
    if data.draw(st.booleans()):
        del content[data.draw(st.integers(1, len(content) - 1)) :]
    path = tmp_path / f"damaged{suffix}"
    path.write_bytes(bytes(content))
    is_calm(path)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(
        st.sampled_from(
            [
                "v 1 2 3",
                "v 4 5",
                "v nan inf 1e400",
                "vt 1 2",
                "vt 1",
                "f 1 2 3",
                "f -1 -2 -3",
                "f 1//1 2//2",
                "f 0 1 2",
                "f 1/2/3 1 2",
                "f a b c",
                "f 99999999999999999999 1 2",
                "usemtl x",
                "mtllib ..",
                "\\",
            ]
        ),
        max_size=12,
    )
)
def test_obj_lines_in_any_order(tmp_path: Path, lines: list[str]) -> None:
    path = tmp_path / "any.obj"
    path.write_text("\n".join(["#", *lines]) + "\n")
    is_calm(path)


def planted(**changes: Any) -> Glb:
    glb = Glb()
    glb.accessor(np.eye(3, dtype="<f4") * 0.2, "VEC3", 5126)
    glb.accessor(np.array([0, 1, 2], "<u2"), "SCALAR", 5123)
    glb.document["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    glb.document["nodes"] = [{"mesh": 0}]
    glb.document |= changes
    return glb


def edited(where: str, value: Any) -> Glb:
    glb = planted()
    target: Any = glb.document
    *path, last = where.split(".")
    for key in path:
        target = target[int(key)] if key.isdigit() else target[key]
    target[int(last) if last.isdigit() else last] = value
    return glb


@pytest.mark.parametrize(
    ("where", "value", "word"),
    [
        ("accessors.0.count", 10**9, "accessors[0]"), ("accessors.0.count", -1, "accessors[0].count"),
        ("accessors.0.count", 4, "accessors[0]"), ("accessors.0.byteOffset", 10**9, "accessors[0]"),
        ("accessors.0.type", "MAT4", "accessors[0]"), ("accessors.0.componentType", 7, "accessors[0]"),
        ("accessors.0.componentType", [], "accessors[0]"), ("accessors.1.componentType", 5126, "accessors[1]"),
        ("bufferViews.0.byteLength", 2**31, "bufferViews[0]"), ("bufferViews.0.byteStride", 1, "byteStride"),
        ("bufferViews.0.buffer", 3, "bufferViews[0]"), ("bufferViews.0", 5, "bufferViews[0]"),
        ("nodes.0.children", [1, 1], "nodes"), ("scenes", [{"nodes": [0, {}]}], "nodes"),
        ("nodes.0.matrix", [1, 2], "matrix"),
        ("nodes.0.rotation", [0, 0, 0, 0], "rotation"), ("nodes.0.translation", ["a", 1, 2], "translation"),
        ("nodes.0.mesh", 9, "meshes"), ("meshes.0.primitives", 3, "primitives"),
        ("meshes.0.primitives.0.attributes", [], "primitive"), ("meshes.0.primitives.0.mode", 0, "no triangles"),
        ("nodes", {}, "nodes"), ("extensionsRequired", ["KHR_draco_mesh_compression"], "KHR_draco"),
    ],
)  # fmt: skip
def test_a_glb_that_lies_names_the_place(tmp_path: Path, where: str, value: Any, word: str) -> None:
    path = edited(where, value).save(tmp_path / "lie.glb")
    with pytest.raises(InputError) as told:
        read_mesh(path)
    assert word in str(told.value), told.value


def test_nodes_below_themselves(tmp_path: Path) -> None:
    for nodes in ([{"mesh": 0, "children": [0]}], [{"children": [1]}, {"children": [0]}]):
        glb = planted(nodes=nodes, scenes=[{"nodes": [0]}])
        with pytest.raises(InputError, match="below itself"):
            read_mesh(glb.save(tmp_path / "loop.glb"))


def test_an_index_outside_and_a_sparse_part_outside(tmp_path: Path) -> None:
    glb = planted()
    glb.document["accessors"][1]["bufferView"] = glb.view(np.array([0, 1, 7], "<u2").tobytes())
    with pytest.raises(InputError, match="outside the 3 vertices"):
        read_mesh(glb.save(tmp_path / "a.glb"))
    glb = planted()
    at = glb.view(np.array([9], "<u2").tobytes())
    with_ = glb.view(np.zeros((1, 3), "<f4").tobytes())
    glb.document["accessors"][0]["sparse"] = {
        "count": 1, "indices": {"bufferView": at, "componentType": 5123}, "values": {"bufferView": with_},
    }  # fmt: skip
    with pytest.raises(InputError, match="outside the accessor"):
        read_mesh(glb.save(tmp_path / "b.glb"))
    empty = planted()
    empty.document["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": 10**7, "sparse": {}}
    with pytest.raises(InputError, match="nowhere"):
        read_mesh(empty.save(tmp_path / "c.glb"))


def test_one_mesh_a_million_times_is_too_much_soon(tmp_path: Path) -> None:
    mesh = planted()
    mesh.document["accessors"][1]["bufferView"] = mesh.view(np.tile([0, 1, 2], 20_000).astype("<u2").tobytes())
    mesh.document["accessors"][1]["count"] = 60_000
    mesh.document["nodes"] = [{"mesh": 0}] * 10_000
    start = time.monotonic()
    with pytest.raises(InputError, match="decimate"):
        read_mesh(mesh.save(tmp_path / "many.glb"))
    assert time.monotonic() - start < 10


def test_pictures_that_cannot_be_used_are_left_out_and_told(tmp_path: Path) -> None:
    for number, image in enumerate(
        [{"uri": "../../etc/passwd"}, {"uri": "/etc/passwd"}, {"uri": "data:image/png;base64,%%"},
         {"bufferView": 77}, {"bufferView": 0}]
    ):  # fmt: skip
        glb = planted(images=[image], textures=[{"source": 0}])
        glb.document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        glb.document["meshes"][0]["primitives"][0]["material"] = 0
        read = read_mesh(glb.save(tmp_path / f"{number}.glb"))
        assert read.texture is None and any("left out" in warning for warning in read.warnings)


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (BINARY.replace(b"vertex 3", b"vertex 3000000000"), "3000000000"),
        (BINARY.replace(b"vertex 3", b"vertex 2000000"), "cut off"),
        (BINARY.replace(b"face 1", b"face 900000000") + bytes(40), "900000000"),
        (BINARY + bytes(36) + b"\xff" + bytes(12), "cut off"),
        (BINARY + bytes(36) + b"\x03" + struct.pack("<3i", 0, 1, 3), "outside the 3 vertices"),
        (BINARY + bytes(36) + b"\x03" + struct.pack("<3i", 0, 1, -1), "outside the 3 vertices"),
        (BINARY + np.full(9, np.nan, "<f4").tobytes() + b"\x03" + struct.pack("<3i", 0, 1, 2), "no triangles"),
        (BINARY + np.full(9, 3e38, "<f4").tobytes() + b"\x03" + struct.pack("<3i", 0, 1, 2), "units large"),
        (BINARY.replace(b"vertex_indices", b"something") + bytes(49), "vertex_indices"),
    ],
)
def test_a_ply_that_lies(tmp_path: Path, content: bytes, word: str) -> None:
    path = tmp_path / "lie.ply"
    path.write_bytes(content)
    with pytest.raises(InputError) as told:
        read_mesh(path)
    assert word in str(told.value)


def test_too_many_of_anything_in_an_obj(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 1 2 3\n" * 4 + "f " + "1 " * 3_100_000 + "\n")
    with pytest.raises(InputError, match="more than 3 million"):
        read_mesh(path)
    (tmp_path / "b.obj").write_bytes(b"v" * (40 << 20))
    with pytest.raises(InputError, match="too long"):
        read_mesh(tmp_path / "b.obj")
    deep = json.dumps({"a": 1}).replace("1", "[" * 50_000 + "]" * 50_000).encode()
    (tmp_path / "c.glb").write_bytes(struct.pack("<4sIII4s", b"glTF", 2, 20 + len(deep), len(deep), b"JSON") + deep)
    with pytest.raises(InputError, match="no JSON"):
        read_mesh(tmp_path / "c.glb")


def test_texture_coordinates_that_mean_nothing_are_counted_in_every_format(tmp_path: Path) -> None:
    write_image(tmp_path / "t.png", checks(8, 8))
    (tmp_path / "m.mtl").write_text("newmtl a\nmap_Kd t.png\n")
    for bad in (1e300, -2e6, np.nan, np.inf):
        uv = np.array([[0, 0], [1, 0], [0, 1], [bad, 0.5]])
        points, faces = np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0], [100, 100, 0]]), ((0, 1, 2), (1, 3, 2))
        obj = "mtllib m.mtl\nusemtl a\n" + "".join("v {:g} {:g} {:g}\n".format(*tuple(p)) for p in points)
        obj += "".join("vt {!r} {!r}\n".format(*tuple(map(float, p))) for p in uv) + "f 1/1 2/2 3/3\nf 2/2 4/4 3/3\n"
        (tmp_path / "m.obj").write_text(obj)
        ply = "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 4\n"
        ply += "".join(f"property double {name}\n" for name in "xyzuv")
        ply += "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
        ply += "".join(
            f"{p[0]} {p[1]} {p[2]} {float(q[0])!r} {float(q[1])!r}\n" for p, q in zip(points, uv, strict=True)
        )
        (tmp_path / "m.ply").write_text(ply + "3 0 1 2\n3 1 3 2\n")
        glb = Glb()
        glb.accessor((points / 1000).astype("<f4"), "VEC3", 5126)
        with np.errstate(over="ignore"):
            glb.accessor(uv.astype("<f4"), "VEC2", 5126)
        glb.accessor(np.array(faces, "<u2").ravel(), "SCALAR", 5123)
        primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}
        glb.document |= {"nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}], "textures": [{"source": 0}]}
        glb.document |= {"images": [{"uri": "t.png"}]}
        glb.document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        glb.save(tmp_path / "m.glb")
        for name in ("m.obj", "m.ply", "m.glb"):
            read = read_mesh(tmp_path / name)
            assert any(w.startswith("1 faces have texture coordinates") for w in read.warnings), (name, bad)
            assert read.texture is not None and 0 <= read.mesh.uv.min() <= read.mesh.uv.max() <= 1
            view_mesh(read, MeshView(look_at_mm=(50, 50, 0), width=60, height=80))


def test_a_picture_is_decoded_once_and_those_beyond_the_budget_are_left_out_by_their_headers(tmp_path: Path) -> None:
    write_image(tmp_path / "a.png", checks(64, 48))
    write_image(tmp_path / "b.png", checks(64, 49))
    (tmp_path / "c.png").write_bytes((tmp_path / "a.png").read_bytes())
    budget = PictureBudget(pixels=64 * 48 + 100)
    first = budget.read(tmp_path / "a.png")
    assert budget.read(tmp_path / "a.png") is first and budget.read(tmp_path / "c.png") is first
    broken = bytearray((tmp_path / "b.png").read_bytes())
    with pytest.raises(InputError, match="64 x 49"):
        budget.decode(bytes(broken), "b")
    with pytest.raises(InputError, match="too large together"):
        PictureBudget(length=10).read(tmp_path / "a.png")


def test_an_escaped_name_of_a_picture_is_understood_but_leads_nowhere_else(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    write_image(tmp_path / "in" / "my skin.png", checks(8, 8))
    write_image(tmp_path / "out.png", checks(8, 8))
    for uri, found in (
        ("my%20skin.png", True),
        ("my skin.png", True),
        ("%2e%2e/out.png", False),
        ("..%2Fout.png", False),
    ):
        glb = planted(images=[{"uri": uri}], textures=[{"source": 0}])
        glb.document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        glb.document["meshes"][0]["primitives"][0]["material"] = 0
        glb.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = glb.accessor(
            np.eye(3, 2, dtype="<f4"), "VEC2", 5126
        )
        read = read_mesh(glb.save(tmp_path / "in" / "m.glb"))
        assert (read.texture is not None) == found, uri


def test_rows_that_differ_in_length_and_rows_that_are_passed_over_are_read_alike(tmp_path: Path) -> None:
    """Triangles and quads in turn, behind an element of no use, with and without text: the same mesh."""
    rng = np.random.default_rng(3)
    points = rng.normal(scale=80, size=(500, 3)).astype("<f4")
    polygons = [rng.choice(500, size=rng.integers(1, 6), replace=False) for _ in range(400)]
    head = "ply\nformat %s 1.0\nelement idle 50\nproperty list uchar short a\nproperty float b\nelement vertex 500\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += "element face 400\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n"
    idle = [rng.integers(-9, 9, size=k % 4) for k in range(50)]
    text = "".join(f"{len(row)} {' '.join(map(str, row))} 0.5\n" for row in idle)
    text += "".join(" ".join(repr(float(value)) for value in point) + "\n" for point in points)
    text += "".join(f"7 {len(p)} {' '.join(map(str, p))}\n" for p in polygons)
    (tmp_path / "t.ply").write_text(head % "ascii" + text + "something else\n")
    for order, name in (("<", "binary_little_endian"), (">", "binary_big_endian")):
        data = b"".join(struct.pack(f"{order}B{len(row)}hf", len(row), *row.tolist(), 0.5) for row in idle)
        data += points.astype(f"{order}f4").tobytes()
        data += b"".join(struct.pack(f"{order}BB{len(p)}i", 7, len(p), *p.tolist()) for p in polygons)
        (tmp_path / f"{name}.ply").write_bytes((head % name).encode() + data + b"something else")
    read = [read_mesh(path, "mm") for path in sorted(tmp_path.glob("*.ply"))]
    fans = [(p[0], p[k], p[k + 1]) for p in polygons for k in range(1, len(p) - 1)]
    assert len(read) == 3
    for one in read:
        np.testing.assert_array_equal(one.mesh.faces, fans)
        np.testing.assert_array_equal(one.mesh.vertices, points.astype(np.float64))
