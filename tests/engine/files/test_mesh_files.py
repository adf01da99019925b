"""Meshes from OBJ, PLY and GLB: what our writers and trimesh write comes back; units, colours, materials."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from engine.errors import InputError
from engine.files.glb import write_glb
from engine.files.images import write_image
from engine.files.mesh_file import read_mesh
from engine.files.mesh_unit import mesh_unit, mm_per_unit
from engine.files.obj import write_obj
from engine.files.scan import read_scan
from tests.engine.files.mesh_samples import Glb, bumpy, checks, corners, uv_corners


def test_our_own_obj_and_glb_come_back_with_their_texture(tmp_path: Path) -> None:
    mesh, picture = bumpy(), checks()
    write_obj(tmp_path / "a.obj", mesh, texture=picture)
    write_glb(tmp_path / "a.glb", mesh, texture=picture)
    for name, accuracy in (("a.obj", 1e-5), ("a.glb", 1e-4)):
        read = read_mesh(tmp_path / name)
        np.testing.assert_allclose(corners(read.mesh), corners(mesh), atol=accuracy)
        np.testing.assert_allclose(uv_corners(read.mesh), uv_corners(mesh), atol=1e-6)
        np.testing.assert_array_equal(read.texture, picture)
        assert read.warnings == () and read.colours is None
    assert read_mesh(tmp_path / "a.glb").unit == "m"
    obj = read_mesh(tmp_path / "a.obj")
    assert [path.name for path in obj.source_files] == ["a.obj", "a.mtl", "a_texture.png"]
    assert obj.mesh.vertices.shape == mesh.vertices.shape


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
def test_ply_of_trimesh_with_colours(tmp_path: Path, encoding: str) -> None:
    mesh = bumpy()
    shades = np.random.default_rng(1).integers(0, 255, (len(mesh.vertices), 4)).astype(np.uint8)
    reference = trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_colors=shades, process=False)
    reference.export(tmp_path / "a.ply", encoding="ascii" if encoding == "ascii" else "binary")
    read = read_mesh(tmp_path / "a.ply")
    np.testing.assert_allclose(corners(read.mesh), corners(mesh), atol=1e-4)
    np.testing.assert_array_equal(read.colours, shades[:, :3])


def test_glb_of_trimesh_with_nodes_and_normalised_colours(tmp_path: Path) -> None:
    mesh = bumpy()
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    turn[:3, 3] = (0.01, -0.02, 0.03)
    scene = trimesh.Scene()
    piece = trimesh.Trimesh(mesh.vertices / 1000, mesh.faces, process=False)
    scene.add_geometry(piece, transform=turn)
    scene.add_geometry(piece.copy(), transform=np.eye(4))
    scene.export(tmp_path / "a.glb")
    read = read_mesh(tmp_path / "a.glb", "m")
    expected = scene.to_mesh().triangles * 1000
    assert len(read.mesh.faces) == 2 * len(mesh.faces)
    middle = lambda c: c.mean(axis=1)[np.lexsort(np.round(c.mean(axis=1), 1).T)]  # noqa: E731
    np.testing.assert_allclose(middle(corners(read.mesh)), middle(expected), atol=0.2)
    np.testing.assert_allclose(np.sort(corners(read.mesh), axis=None), np.sort(expected, axis=None), atol=1e-3)


def test_ply_with_polygons_texture_coordinates_of_faces_and_both_byte_orders(tmp_path: Path) -> None:
    write_image(tmp_path / "skin.png", checks())
    head = [
        "comment TextureFile skin.png", "comment unit cm", "element vertex 5", "property float x", "property float y",
        "property float z", "element face 2", "property list uchar int vertex_indices",
        "property list uchar float texcoord", "end_header",
    ]  # fmt: skip
    places = [(0, 0, 0), (10, 0, 0), (10, 10, 0), (0, 10, 0), (5, 15, 5)]
    rows = [((0, 1, 2, 3), (0, 0, 1, 0, 1, 1, 0, 1)), ((3, 2, 4), (0, 1, 1, 1, 0.5, 0.5))]
    found = []
    for order, name in (("", "ascii"), ("<", "binary_little_endian"), (">", "binary_big_endian")):
        path = tmp_path / f"{name}.ply"
        text = "\n".join(["ply", f"format {name} 1.0", *head]) + "\n"
        if order:
            data = np.array(places, order + "f4").tobytes()
            for indices, uv in rows:
                data += bytes([len(indices)]) + np.array(indices, order + "i4").tobytes()
                data += bytes([len(uv)]) + np.array(uv, order + "f4").tobytes()
            path.write_bytes(text.encode() + data)
        else:
            lines = [" ".join(map(str, row)) for row in places]
            lines += [" ".join(map(str, (len(i), *i, len(uv), *uv))) for i, uv in rows]
            path.write_text(text + "\n".join(lines) + "\n")
        found.append(read_mesh(path))
    for read in found:
        assert read.unit == "cm" and read.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [3, 2, 4]]
        np.testing.assert_array_equal(read.mesh.vertices, np.array(places) * 10.0)
        np.testing.assert_allclose(uv_corners(read.mesh)[2], [[0, 0], [1, 0], [0.5, 0.5]])
        np.testing.assert_array_equal(read.texture, checks())


def test_obj_of_every_form(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(
        "# forms\r\nv 0 0 0 1 0 0\r\nv\t100 0 0 0 1 0\r\nv 100 100 0 0 0 1\nv 0 100 0 1 1 1\nvt 0 0\nvt 1 0\nvt 1 1\n"
        "vn 0 0 1\nf 1/1 2/2 3/3\nf -4//1 -2//1 \\\n-1//1\nf 1 2 3 4\nf 1/1/1 3/3/1 4/2/1\nl 1 2\nf 1 2\n"
    )
    read = read_mesh(tmp_path / "a.obj")
    assert read.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3], [0, 2, 3]]
    assert read.colours is not None and read.colours.tolist()[:2] == [[255, 0, 0], [0, 255, 0]]
    assert "1 faces of one or two corners were left out" in read.warnings


def test_materials_become_one_picture_and_every_corner_keeps_its_colour(tmp_path: Path) -> None:
    write_image(tmp_path / "one.png", np.full((8, 8, 3), (250, 0, 0), np.uint8))
    write_image(tmp_path / "two.png", np.full((16, 4, 3), (0, 250, 0), np.uint8))
    (tmp_path / "a.mtl").write_text(
        "newmtl one\nmap_Kd -s 1 1 1 one.png\nnewmtl two\nmap_Kd C:\\work\\tex\\two.png\nnewmtl three\nKd 0 0 1\n"
        "newmtl four\nmap_Kd ../../secret.png\n"
    )
    faces = "".join(f"usemtl {name}\nf 1/1 2/2 3/3\n" for name in ("one", "two", "three", "four"))
    (tmp_path / "a.obj").write_text(
        "mtllib a.mtl\nv 0 0 0\nv 200 0 0\nv 0 200 0\nvt 0.2 0.2\nvt 0.8 0.2\nvt 3.2 3.8\n" + faces
    )
    read = read_mesh(tmp_path / "a.obj")
    assert read.texture is not None
    size = np.array(read.texture.shape[1::-1])
    texel = (uv_corners(read.mesh) * size).astype(int)
    shown = read.texture[texel[..., 1], texel[..., 0]]
    assert (shown[0] == (250, 0, 0)).all() and (shown[1] == (0, 250, 0)).all() and (shown[2] == (0, 0, 255)).all()
    assert any("secret.png" in warning and "left out" in warning for warning in read.warnings)
    assert any("repeat a picture" in warning for warning in read.warnings)


def test_indices_of_8_16_32_bits_strips_sparse_factor_and_mirrored_nodes(tmp_path: Path) -> None:
    square = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0.2, 0.2, 0]], "<f4")
    for code, kind in ((5121, "u1"), (5123, "<u2"), (5125, "<u4")):
        glb = Glb()
        position = glb.accessor(square, "VEC3", 5126)
        triangles = glb.accessor(np.array([0, 1, 2, 2, 1, 3], kind), "SCALAR", code)
        strip = glb.accessor(np.array([0, 1, 2, 3], kind), "SCALAR", code)
        shade = glb.accessor(np.full((4, 4), 255, "u1"), "VEC4", 5121, normalized=True)
        where = glb.view(np.array([3], "<u2").tobytes())
        value = glb.view(np.array([[0.2, 0.2, 0.1]], "<f4").tobytes())
        sparse = {
            "count": 1,
            "indices": {"bufferView": where, "componentType": 5123},
            "values": {"bufferView": value},
        }
        glb.document["accessors"].append(glb.document["accessors"][position] | {"sparse": sparse})
        lifted = len(glb.document["accessors"]) - 1
        glb.document["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]
        glb.document["meshes"] = [
            {
                "primitives": [
                    {"attributes": {"POSITION": position, "COLOR_0": shade}, "indices": triangles},
                    {"attributes": {"POSITION": lifted}, "indices": strip, "mode": 5, "material": 0},
                    {"attributes": {"POSITION": position}, "mode": 1},
                ]
            }
        ]
        glb.document["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1]}]
        read = read_mesh(glb.save(tmp_path / f"{kind[-2:]}.glb"))
        assert read.mesh.faces.tolist() == [[2, 1, 0], [3, 1, 2], [6, 5, 4], [7, 5, 6]] or len(read.mesh.faces) == 4
        assert read.mesh.vertices[7].tolist() == pytest.approx([-200, 200, 100], abs=1e-3)
        normal = np.cross(*(corners(read.mesh)[0, 1:] - corners(read.mesh)[0, 0]))
        assert normal[2] > 0, "a mirrored node keeps its outside outside"
        assert read.texture is not None
        texel = (uv_corners(read.mesh) * read.texture.shape[1::-1]).astype(int)
        shown = read.texture[texel[..., 1], texel[..., 0]]
        assert (shown[2:] == (255, 0, 0)).all() and (shown[:2] == 255).all()
        assert "1 primitives of points, lines or nothing were left out" in read.warnings


@pytest.mark.parametrize(
    ("extent", "named", "unit", "word"),
    [
        (230.0, None, "mm", "mm assumed"), (23.0, None, "cm", "cm assumed"), (0.23, None, "m", "m assumed"),
        (2.3, None, "108.7 mm", "in mm, cm or m no head"), (0.23, "m", "m", "as in the file"),
    ],
)  # fmt: skip
def test_the_unit_follows_the_size_where_the_file_names_none(
    extent: float, named: str | None, unit: str, word: str
) -> None:
    found, why, warnings = mesh_unit(None, named, extent)
    assert found == unit and word in why and warnings == ()
    assert 90 <= extent * mm_per_unit(found) <= 900


@pytest.mark.parametrize(
    ("extent", "named", "size", "rather"),
    [(1.75, "m", "1750 mm", "check its unit"), (230.0, "m", "230000 mm", "rather mm than m"),
     (23.0, "mm", "23 mm", "rather cm than mm")],
)  # fmt: skip
def test_the_unit_that_a_file_names_is_kept_and_an_unlikely_size_told(
    extent: float, named: str, size: str, rather: str
) -> None:
    found, why, (warning,) = mesh_unit(None, named, extent)
    assert found == named and why == f"{named}, as in the file"
    assert size in warning and rather in warning


def test_a_body_in_metres_stays_a_body(tmp_path: Path) -> None:
    mesh = bumpy()
    tall = mesh.with_vertices(mesh.vertices * 1750 / np.ptp(mesh.vertices, axis=0).max())
    write_glb(tmp_path / "body.glb", tall)
    read = read_mesh(tmp_path / "body.glb")
    assert read.unit == "m" and any("1750 mm large" in warning for warning in read.warnings)
    np.testing.assert_allclose(np.ptp(read.mesh.vertices, axis=0).max(), 1750, rtol=1e-5)


def test_a_wish_for_a_unit_wins_and_is_doubted_aloud(tmp_path: Path) -> None:
    mesh = bumpy()
    write_obj(tmp_path / "a.obj", mesh)
    read = read_mesh(tmp_path / "a.obj", "85.5 mm")
    np.testing.assert_allclose(read.mesh.vertices, 85.5 * read_mesh(tmp_path / "a.obj").mesh.vertices)
    assert read.unit == "85.5 mm" and read.assumed.endswith("as asked") and "rather mm" in read.warnings[0]
    for wrong in ("inch", "-3 mm", "0 mm", "nan mm", "1e99 mm", ""):
        with pytest.raises(InputError, match="unit"):
            read_mesh(tmp_path / "a.obj", wrong)


def test_a_mesh_is_a_scan_and_a_range_image_takes_no_view(tmp_path: Path) -> None:
    from engine.scan.mesh_view import MeshView

    write_obj(tmp_path / "a.obj", bumpy(), texture=checks())
    file = read_scan(tmp_path / "a.obj", view=MeshView(distance_mm=900.0, width=80, height=60))
    assert (file.scan.width, file.scan.height) == (80, 60) and file.view is not None and file.format == "obj"
    import resources

    with pytest.raises(InputError, match="leave the view out"):
        read_scan(resources.sample_path("subject", "base.json"), view=MeshView())
