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
from engine.files.mesh_file import read_mesh
from engine.files.obj import write_obj
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
