"""Folders of OBJs and NumPy archives as rigs: names, neutral faces, topology, and what is refused."""

from __future__ import annotations

import io
import json
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest

from engine.errors import InputError
from engine.files.obj import write_obj
from engine.files.rig import read_rig
from engine.files.rig_out import write_rig
from engine.mesh import TriangleMesh
from tests.engine.files.mesh_samples import bumpy
from tests.engine.files.rig_samples import planted_rig

ICT = Path(__file__).parents[4] / "shared" / "data" / "rigs" / "ict_facekit.npz"
OBJ = "v 0 0 0\nv 200 0 0\nv 0 200 0\nv 200 200 {:g}\nf 1 2 3\nf 2 4 3\n"


def folder(tmp_path: Path, **files: str) -> Path:
    home = tmp_path / "rig"
    shutil.rmtree(home, ignore_errors=True)
    home.mkdir()
    for name, text in files.items():
        (home / f"{name}.obj").write_text(text)
    return home


def test_shapes_are_named_by_their_files_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    home = folder(tmp_path, Neutral=OBJ.format(100), s_10=OBJ.format(107), s_2=OBJ.format(103))
    (home / "note.txt").write_text("not mine")
    for path in (home, home / "s_2.obj"):
        found = read_rig(path)
        assert found.rig.basis.names == ("s_2", "s_10") and found.format == "obj"
        np.testing.assert_array_equal(found.rig.basis.displacements[:, 3], [[0, 0, 3], [0, 0, 7]])
        assert found.assumed.startswith("mm assumed")
    assert read_rig(home, "cm").rig.basis.displacements[1, 3, 2] == 70


@pytest.mark.parametrize("name", ["neutral", "REST", "base", "Basis", "head_neutral", "Base-mesh"])
def test_the_face_at_rest_is_known_by_its_name(tmp_path: Path, name: str) -> None:
    found = read_rig(folder(tmp_path, **{"a": OBJ.format(1), name: OBJ.format(0), "z": OBJ.format(2)}))
    assert found.rig.basis.names == ("a", "z") and not found.rig.basis.neutral[3, 2]


def test_a_mean_file_makes_an_affine_basis_and_says_so(tmp_path: Path) -> None:
    found = read_rig(folder(tmp_path, neutral=OBJ.format(0), mean=OBJ.format(5), a=OBJ.format(12)))
    assert found.rig.basis.mean[3, 2] == 5 and found.rig.basis.displacements[0, 3, 2] == 7
    assert any("mean.obj was taken for the mean" in w for w in found.warnings)


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({"a": OBJ.format(1), "b": OBJ.format(2)}, ("no neutral face among its files (a, b)", "neutral.obj")),
        ({"neutral": OBJ.format(1)}, ("a neutral face and no shapes",)),
        ({"neutral": OBJ.format(1), "base": OBJ.format(1), "a": OBJ.format(1)}, ("several neutral faces",)),
        ({}, ("holds no .obj files",)),
        (
            {"neutral": OBJ.format(1), "a": OBJ.format(1).replace("f", "v 9 9 9\nf", 1)},
            ("a.obj: has 5 vertices", "has 4"),
        ),
        ({"neutral": OBJ.format(1), "a": OBJ.format(1) + "f 1 2 4\n"}, ("a.obj: has 3 triangles, neutral.obj has 2",)),
        ({"neutral": OBJ.format(1), "a": OBJ.format(1).replace("2 4 3", "2 4 1")}, ("but 1 of 2 join other vertices",)),
        ({"neutral": OBJ.format(1), "a": OBJ.format(float("nan"))}, ("shape a: holds numbers that are not finite",)),
        ({"neutral": "v 0 0 0\n", "a": "v 0 0 0\n"}, ("holds no triangles",)),
        ({"neutral": OBJ.format(1), "a": "v x\n"}, ("a.obj, v: a line",)),
    ],
)
def test_what_is_wrong_with_a_folder_names_the_file(tmp_path: Path, files: dict[str, str], words: tuple) -> None:
    with pytest.raises(InputError) as told:
        read_rig(folder(tmp_path, **files))
    assert all(word in str(told.value) for word in words), told.value


def test_a_list_may_not_lead_out_of_its_folder_nor_miss_a_file(tmp_path: Path) -> None:
    home = folder(tmp_path, neutral=OBJ.format(0), a=OBJ.format(1))
    (tmp_path / "out.obj").write_text(OBJ.format(2))
    good = {"unit": "mm", "neutral": "neutral.obj", "shapes": [{"name": "x", "file": "a.obj"}]}
    listed = home / "shapes.json"
    listed.write_text(json.dumps(good))
    assert read_rig(home).rig.basis.names == ("x",)
    for change, word in (
        ({"shapes": [{"name": "x", "file": "../out.obj"}]}, "does not lie beside"),
        ({"shapes": [{"name": "x", "file": "gone.obj"}]}, "there is no such file"),
        ({"shapes": []}, "shapes"),
        ({"shapes": [*good["shapes"], *good["shapes"]]}, "x stands for several shapes"),
        ({"unit": "ell"}, "'ell' is not known"),
        ({"parts": {"skin": [0, 10**7]}}, None),
        ({"parts": {"skin": [-1, 1]}}, "parts"),
    ):
        listed.write_text(json.dumps(good | change))
        if word is None:
            assert not len(read_rig(home).rig.mesh.parts["skin"])
            continue
        with pytest.raises(InputError) as told:
            read_rig(home)
        assert word in str(told.value), told.value


def test_a_file_that_is_spelled_another_way_is_read_alike(tmp_path: Path) -> None:
    """The quick way for faces that are byte for byte alike, and the long way, find the same positions."""
    rig = planted_rig(parts=False)
    write_rig(tmp_path / "f", rig)
    quick = read_rig(tmp_path / "f").rig
    for path in (tmp_path / "f").glob("*.obj"):
        if path.name != "neutral.obj":
            path.write_text(path.read_text().replace("\nf ", "\n# other\nf ", 1).replace("v ", "v  "))
    np.testing.assert_array_equal(read_rig(tmp_path / "f").rig.basis.displacements, quick.basis.displacements)


def test_groups_and_materials_name_the_parts(tmp_path: Path) -> None:
    text = OBJ.format(0).replace("f 1 2 3", "g Face\nf 1 2 3").replace("f 2 4 3", "g other\nusemtl Eye_L\nf 2 4 3")
    found = read_rig(folder(tmp_path, neutral=text, a=OBJ.format(1)))
    assert {name: faces.tolist() for name, faces in found.rig.mesh.parts.items()} == {"skin": [0], "eyes": [1]}


def arrays(**change: object) -> dict[str, np.ndarray]:
    rig = planted_rig()
    found = {
        "neutral": rig.basis.neutral, "faces": rig.mesh.faces, "names": np.array(rig.basis.names),
        "displacements": rig.basis.displacements, "unit": np.array("mm"),
    }  # fmt: skip
    found |= {key: np.asarray(value) for key, value in change.items()}
    return {key: value for key, value in found.items() if value.dtype != object or value.ndim}


def test_other_names_and_small_numbers_are_understood(tmp_path: Path) -> None:
    rig = planted_rig()
    values = {
        "neutral": rig.basis.neutral.astype("f4"), "triangles": rig.mesh.faces.astype("u2"),
        "expression_names": np.array([name.encode() for name in rig.basis.names]),
        "expressions": np.asfortranarray(rig.basis.displacements.astype("f2")),
        "uv": rig.mesh.uv.astype("f4"), "uv_triangles": rig.mesh.uv_faces.astype("i4"),
        "identities": np.zeros(3),
    }  # fmt: skip
    np.savez(tmp_path / "a.npz", **values)
    found = read_rig(tmp_path / "a.npz", "mm")
    assert found.rig.basis.names == rig.basis.names
    np.testing.assert_array_equal(found.rig.basis.displacements, rig.basis.displacements.astype("f2").astype(float))
    np.testing.assert_array_equal(found.rig.mesh.uv_faces, rig.mesh.uv_faces)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"names": ["a", "a", "b", "c", "d"]}, "a stands for several shapes"),
        ({"names": ["a", "", "b", "c", "d"]}, "shape 2 has none"),
        ({"names": ["a"]}, "it must be 1 x"),
        ({"names": np.zeros((0,), "U1"), "displacements": np.zeros((0, 108, 3))}, "names"),
        ({"displacements": np.full((5, 108, 3), np.nan)}, "shape jawOpen, smile left"),
        ({"neutral": np.full((108, 3), np.inf)}, "108 positions are not finite"),
        ({"neutral": np.full((108, 3), 1e-9)}, "units large"),
        ({"faces": [[0, 1, 108]]}, "an index is outside the 108 vertices"),
        ({"faces": np.array([[0, 1, 2**63 + 5]], "u8")}, "an index is outside"),
        ({"faces": np.eye(3)}, "give whole numbers"),
        ({"mean": np.full((108, 3), np.nan)}, "mean"),
        ({"uv": np.zeros((7, 2))}, "no uv_faces"),
        ({"unit": "furlong"}, "'furlong' is not known"),
        ({"part_skin": [10**6]}, "outside the mesh"),
        ({"displacements": np.ones((5, 108, 3), complex)}, "stores complex"),
    ],
)
def test_what_is_wrong_with_an_archive_is_named(tmp_path: Path, change: dict, word: str) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, **arrays(**change))
    with pytest.raises(InputError) as told:
        read_rig(path)
    assert word in str(told.value) and str(path) in str(told.value), told.value


def test_missing_arrays_pickles_and_headers_that_lie(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    for key in ("neutral", "faces", "names", "displacements"):
        values = arrays()
        del values[key]
        np.savez(path, **values)
        with pytest.raises(InputError, match=f"{key}: is missing"):
            read_rig(path)
    np.savez(path, points=np.zeros((2, 2, 3)))
    with pytest.raises(InputError, match="looks like a scan"):
        read_rig(path)
    np.savez(path, **(arrays() | {"names": np.array(list("abcde"), dtype=object)}))
    with pytest.raises(InputError, match="never loaded"):
        read_rig(path)
    np.savez(path, **arrays())
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    lied = io.BytesIO()
    np.lib.format.write_array_header_1_0(lied, {"descr": "<f8", "fortran_order": False, "shape": (5, 108, 3)})
    shapes = (((10**6, 108, 3), "it must be"), ((5, 108, 4), "must be"), ((-5, 108, 3), "must"))
    for shape, word in shapes:
        head = io.BytesIO()
        np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": shape})
        with zipfile.ZipFile(path, "w") as archive:
            for name, data in members.items():
                content = head.getvalue() + data[len(lied.getvalue()) :] if name == "displacements.npy" else data
                archive.writestr(name, content)
        with pytest.raises(InputError, match=word):
            read_rig(path)


def test_no_rig_at_all(tmp_path: Path) -> None:
    (tmp_path / "a.fbx").write_bytes(b"Kaydara")
    with pytest.raises(InputError, match="is not a rig that can be read"):
        read_rig(tmp_path / "a.fbx")
    with pytest.raises(InputError, match="no such file"):
        read_rig(tmp_path / "gone.glb")
    with pytest.raises(InputError, match="'ell' is not known"):
        read_rig(tmp_path, "ell")
    write_obj(tmp_path / "only.obj", TriangleMesh(bumpy(4, 5).vertices, bumpy(4, 5).faces))
    with pytest.raises(InputError, match="no neutral face"):
        read_rig(tmp_path / "only.obj")


@pytest.mark.skipif(not ICT.exists(), reason="needs ../shared/data/rigs/ict_facekit.npz")
def test_the_light_stage_head_is_read_in_its_unit(tmp_path: Path) -> None:
    found = read_rig(ICT)
    assert (found.unit, len(found.rig.basis), found.rig.basis.neutral.shape) == ("cm", 57, (26719, 3))
    assert "338 mm" in found.assumed and found.warnings == ()
    with np.load(ICT) as data:
        np.testing.assert_allclose(found.rig.basis.displacements[5], 10.0 * data["expressions"][5].astype(float))
    write_rig(tmp_path / "a.glb", found.rig)
    again = read_rig(tmp_path / "a.glb")
    np.testing.assert_allclose(again.rig.basis.displacements, found.rig.basis.displacements, rtol=0, atol=4e-6)
    np.testing.assert_array_equal(again.rig.mesh.faces, found.rig.mesh.faces)
