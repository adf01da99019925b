"""GLB against the Khronos validator and against trimesh."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from engine.errors import InputError
from engine.files.glb import write_glb
from engine.mesh import TriangleMesh
from tests.engine.files.planted import picture, seamed_mesh

ROOT = Path(__file__).parents[3]
SCRIPT = Path(__file__).with_name("validate_glb.mjs")


def validate(path: Path) -> dict:
    """The report of gltf-validator; where it is not installed the test fails, it is not skipped."""
    assert (ROOT / "node_modules" / "gltf-validator").is_dir(), "gltf-validator is missing: run 'make' to install it"
    node = Path(sys.executable).with_name("node.exe" if os.name == "nt" else "node")
    done = subprocess.run([node, SCRIPT, path], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def read(path: Path) -> trimesh.Trimesh:
    (mesh,) = trimesh.load(path, process=False).geometry.values()
    return mesh


def document(path: Path) -> dict:
    data = path.read_bytes()
    return json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])


@pytest.mark.parametrize("with_normals", [True, False])
@pytest.mark.parametrize(
    ("chart", "kind"),
    [("seam", "png"), ("seam", "jpeg"), ("seam", None), ("plain", "png"), ("plain", "jpeg"), ("none", None)],
)
def test_the_validator_finds_nothing(tmp_path, chart, kind, with_normals):
    mesh, normals = seamed_mesh()
    if chart == "plain":
        mesh = TriangleMesh(mesh.vertices, mesh.faces, np.random.default_rng(1).random((len(mesh.vertices), 2)))
    if chart == "none":
        mesh = TriangleMesh(mesh.vertices, mesh.faces)
    path = tmp_path / "face.glb"
    write_glb(
        path,
        mesh,
        normals=normals * 3 if with_normals else None,
        texture=None if kind is None else picture(50, 37),
        texture_format=kind or "png",
        name="a face",
        extras={"version": "1.2.3"},
    )
    report = validate(path)
    assert (report["issues"]["numErrors"], report["issues"]["numWarnings"]) == (0, 0), report["issues"]["messages"]
    # Only remarks on pictures without a power of two, and on coordinates that no texture uses.
    assert {m["code"] for m in report["issues"]["messages"]} <= {"IMAGE_NPOT_DIMENSIONS", "UNUSED_OBJECT"}
    assert report["info"]["totalTriangleCount"] == len(mesh.faces)
    assert document(path)["asset"]["extras"] == {"unit": "m", "version": "1.2.3"}


def test_the_validator_can_say_no(tmp_path):
    mesh, normals = seamed_mesh()
    path = tmp_path / "face.glb"
    write_glb(path, mesh, normals=normals)
    data = path.read_bytes()
    path.write_bytes(data.replace(b'"VEC3"', b'"VEC2"'))
    assert validate(path)["issues"]["numErrors"] > 0


def test_another_reader_finds_the_same_mesh(tmp_path):
    mesh, normals = seamed_mesh()
    path = tmp_path / "face.glb"
    write_glb(path, mesh, normals=normals, texture=picture())
    found = read(path)
    source = np.asarray(found.vertex_attributes["_SOURCE"]).ravel()
    assert len(source) == len(mesh.uv)  # split exactly at the seam
    assert (source == np.round(source)).all()
    source = source.astype(int)
    np.testing.assert_allclose(found.vertices * 1000.0, mesh.vertices[source], atol=1e-4)
    np.testing.assert_array_equal(source[found.faces], mesh.faces)
    uv = found.visual.uv * [1, -1] + [0, 1]  # trimesh counts v from below
    np.testing.assert_allclose(uv[found.faces], mesh.uv[mesh.uv_faces], atol=1e-6)
    np.testing.assert_allclose(found.vertex_normals, normals[source], atol=1e-6)
    image = np.asarray(found.visual.material.baseColorTexture.convert("RGB"))
    np.testing.assert_array_equal(image, picture())


def test_without_a_seam_the_order_stays_and_no_vertex_is_lost(tmp_path):
    vertices = np.array([(0, 0, 0), (10, 0, 0), (5, 5, 5), (0, 10, 0), (9, 9, 9)], dtype=float)
    mesh = TriangleMesh(vertices, [(0, 1, 3)], np.linspace(0, 1, 10).reshape(5, 2))
    write_glb(tmp_path / "a.glb", mesh)
    found = read(tmp_path / "a.glb")
    np.testing.assert_array_equal(found.vertex_attributes["_SOURCE"].ravel(), np.arange(5))
    apart = TriangleMesh(vertices, [(0, 1, 3)], [(0.5, 0.5), (0, 0), (1, 0), (0, 1)], [(1, 2, 3)])
    write_glb(tmp_path / "b.glb", apart)
    source = read(tmp_path / "b.glb").vertex_attributes["_SOURCE"].ravel()
    assert sorted(source) == [0, 1, 2, 3, 4]


def test_normals_without_direction_are_still_valid(tmp_path):
    mesh, normals = seamed_mesh()
    normals[3], normals[4] = 0.0, np.nan
    write_glb(tmp_path / "a.glb", mesh, normals=normals)
    report = validate(tmp_path / "a.glb")
    assert report["issues"]["numErrors"] == report["issues"]["numWarnings"] == 0


def test_what_does_not_fit_is_refused_and_the_old_file_stays(tmp_path):
    mesh, normals = seamed_mesh()
    path = tmp_path / "a.glb"
    path.write_bytes(b"old")
    bare = TriangleMesh(mesh.vertices, mesh.faces)
    for bad, arguments in (
        (TriangleMesh(mesh.vertices, np.zeros((0, 3))), {}),
        (mesh, {"normals": normals[:-1]}),
        (mesh, {"texture": picture().astype(float)}),
        (mesh, {"texture": picture()[..., 0]}),
        (mesh, {"texture": picture(), "texture_format": "gif"}),
        (bare, {"texture": picture()}),
    ):
        with pytest.raises(InputError):
            write_glb(path, bad, **arguments)
    assert path.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == 1
