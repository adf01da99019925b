"""OBJ, MTL and PNG against trimesh."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from engine.errors import InputError
from engine.files.images import read_image
from engine.files.obj import write_obj
from engine.mesh import TriangleMesh
from tests.engine.files.planted import picture, seamed_mesh


def rows(path, word: str) -> np.ndarray:
    lines = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith(word + " ")]
    return np.array(lines, dtype=float)


def corners(path) -> np.ndarray:
    lines = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith("f ")]
    return np.array([[corner.split("/") for corner in line] for line in lines])


def test_another_reader_finds_the_same_face(tmp_path):
    mesh, normals = seamed_mesh()
    path = tmp_path / "my face ü.obj"
    written = write_obj(path, mesh, normals=normals, texture=picture(), name="my face")
    assert [p.name for p in written] == ["my face ü.obj", "my_face__.mtl", "my_face___texture.png"]
    assert all(p.is_file() for p in written)
    assert len(list(tmp_path.iterdir())) == 3
    found = trimesh.load(path, process=False, force="mesh")
    # trimesh splits at seams in an order of its own: compare corner by corner.
    np.testing.assert_allclose(found.vertices[found.faces], mesh.vertices[mesh.faces], atol=1e-5)
    uv = found.visual.uv * [1, -1] + [0, 1]
    np.testing.assert_allclose(uv[found.faces], mesh.uv[mesh.uv_faces], atol=1e-6)
    np.testing.assert_array_equal(np.asarray(found.visual.material.image.convert("RGB")), picture())
    np.testing.assert_array_equal(read_image(written[2]), picture())


def test_indices_and_order_are_kept(tmp_path):
    mesh, normals = seamed_mesh()
    path = tmp_path / "a.obj"
    write_obj(path, mesh, normals=normals)
    np.testing.assert_allclose(rows(path, "v"), mesh.vertices, atol=5e-6)
    np.testing.assert_allclose(rows(path, "vn"), normals, atol=5e-7)
    np.testing.assert_allclose(rows(path, "vt"), mesh.uv * [1, -1] + [0, 1], atol=5e-8)
    found = corners(path).astype(int) - 1
    np.testing.assert_array_equal(found[..., 0], mesh.faces)
    np.testing.assert_array_equal(found[..., 1], mesh.uv_faces)
    np.testing.assert_array_equal(found[..., 2], mesh.faces)
    assert "mtllib" not in path.read_text()
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("with_normals", [True, False])
def test_without_a_chart(tmp_path, with_normals):
    mesh, normals = seamed_mesh()
    bare = TriangleMesh(mesh.vertices, mesh.faces)
    write_obj(tmp_path / "a.obj", bare, normals=normals if with_normals else None)
    found = trimesh.load(tmp_path / "a.obj", process=False, force="mesh")
    np.testing.assert_allclose(found.vertices[found.faces], mesh.vertices[mesh.faces], atol=1e-5)
    with pytest.raises(InputError, match="no texture coordinates"):
        write_obj(tmp_path / "b.obj", bare, texture=picture())
