"""Rigs go out and come back the same: GLB to float32, OBJ to its text, npz to the bit; other readers agree."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pygltflib
import pytest
import trimesh

from engine.errors import InputError
from engine.files.glb_rig_out import write_glb_rig
from engine.files.rig import RigFile, read_rig
from engine.files.rig_out import write_rig
from engine.motion import WeightCurves
from engine.shapes import ExpressionBasis, Rig
from tests.engine.files.planted import picture
from tests.engine.files.rig_samples import NAMES, planted_rig
from tests.engine.files.test_glb import document, validate


def is_same(read: RigFile, rig: Rig, atol: float) -> None:
    """The same vertices in the same order, faces, chart, parts, names, displacements and mean."""
    basis = read.rig.basis
    assert basis.names == rig.basis.names
    np.testing.assert_allclose(basis.neutral, rig.basis.neutral, rtol=0, atol=atol)
    np.testing.assert_allclose(basis.displacements, rig.basis.displacements, rtol=0, atol=atol)
    assert (basis.mean is None) == (rig.basis.mean is None)
    if basis.mean is not None:
        np.testing.assert_allclose(basis.mean, rig.basis.mean, rtol=0, atol=atol)
    np.testing.assert_array_equal(read.rig.mesh.faces, rig.mesh.faces)
    np.testing.assert_allclose(
        read.rig.mesh.uv[read.rig.mesh.uv_faces], rig.mesh.uv[rig.mesh.uv_faces], rtol=0, atol=1e-7
    )
    assert set(read.rig.mesh.parts) == set(rig.mesh.parts)
    for name, faces in rig.mesh.parts.items():
        np.testing.assert_array_equal(read.rig.mesh.parts[name], faces)
    np.testing.assert_array_equal(read.rig.skin, rig.skin)


@pytest.mark.parametrize("mean", [False, True])
@pytest.mark.parametrize("parts", [False, True])
@pytest.mark.parametrize(("name", "atol"), [("r.glb", 2e-5), ("r.npz", 0.0), ("folder", 3e-5)])
def test_a_round_trip_returns_the_same_rig(tmp_path: Path, name: str, atol: float, parts: bool, mean: bool) -> None:
    rig = planted_rig(mean, parts)
    written = write_rig(tmp_path / name, rig)
    assert all(path.is_file() for path in written)
    read = read_rig(tmp_path / name)
    is_same(read, rig, atol)
    assert read.warnings == ("1 shapes move nothing: still",)
    assert set(read.source_files) >= set(written)
    # What has been rounded once stays as it is.
    write_rig(tmp_path / "again.glb", read.rig)
    once = read_rig(tmp_path / "again.glb")
    write_rig(tmp_path / "third.glb", once.rig)
    is_same(read_rig(tmp_path / "third.glb"), once.rig, 0.0)


@pytest.mark.parametrize("mean", [False, True])
@pytest.mark.parametrize("look", ["plain", "texture", "animated", "morph normals", "no chart"])
def test_the_validator_finds_nothing(tmp_path: Path, look: str, mean: bool) -> None:
    rig = planted_rig(mean)
    if look == "no chart":
        mesh = type(rig.mesh)(rig.mesh.vertices, rig.mesh.faces, parts=rig.mesh.parts)
        rig = Rig(mesh, rig.basis)
    weights = np.random.default_rng(1).random((7, 2))
    curves = WeightCurves(("Jaw_Open", "whole"), weights, 120.0) if look == "animated" else None
    texture = picture() if look == "texture" else None
    path = tmp_path / "a.glb"
    write_glb_rig(path, rig, texture=texture, curves=curves, morph_normals=look == "morph normals", name="a head")
    report = validate(path)
    assert (report["issues"]["numErrors"], report["issues"]["numWarnings"]) == (0, 0), report["issues"]["messages"]
    assert {m["code"] for m in report["issues"]["messages"]} <= {"IMAGE_NPOT_DIMENSIONS", "UNUSED_OBJECT"}
    assert report["info"]["hasMorphTargets"]


def test_the_validator_can_say_no_to_a_rig(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    write_rig(path, planted_rig())
    data = path.read_bytes()
    path.write_bytes(data.replace(b'"weights":[0.0,0.0', b'"weights":[0.0    '))
    assert validate(path)["issues"]["numErrors"] > 0


def _by_pygltflib(path: Path) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return names, source numbers (V,) and displacements (t, V, 3) in mm as pygltflib finds them, all primitives."""
    gltf = pygltflib.GLTF2().load_binary(str(path))
    blob = gltf.binary_blob()

    def block(view: int, offset: int, dtype: str, width: int, count: int) -> np.ndarray:
        start = gltf.bufferViews[view].byteOffset + (offset or 0)
        return np.frombuffer(blob, dtype, count * width, start).reshape(count, width)

    def values(number: int) -> np.ndarray:
        accessor = gltf.accessors[number]
        width = {"SCALAR": 1, "VEC3": 3}[accessor.type]
        if accessor.bufferView is not None:
            found = block(accessor.bufferView, accessor.byteOffset, "<f4", width, accessor.count).copy()
        else:
            found = np.zeros((accessor.count, width), "<f4")
        if accessor.sparse is not None:
            part = accessor.sparse
            kind = {5123: "<u2", 5125: "<u4"}[part.indices.componentType]
            at = block(part.indices.bufferView, part.indices.byteOffset, kind, 1, part.count)[:, 0]
            found[at] = block(part.values.bufferView, part.values.byteOffset, "<f4", width, part.count)
        return found

    mesh = gltf.meshes[0]
    source = np.concatenate([values(p.attributes._SOURCE)[:, 0] for p in mesh.primitives])
    moved = [
        np.concatenate([values(p.targets[k]["POSITION"]) for p in mesh.primitives]) for k in range(len(mesh.weights))
    ]
    return mesh.extras["targetNames"], source.astype(int), 1000.0 * np.stack(moved)


def test_other_readers_find_the_same_names_and_displacements(tmp_path: Path) -> None:
    rig = planted_rig(mean=True)
    write_rig(tmp_path / "a.glb", rig, texture=picture())
    names, source, moved = _by_pygltflib(tmp_path / "a.glb")
    assert names == [*NAMES, "mean"]
    wanted = np.concatenate([rig.basis.displacements, rig.basis.mean[None]])[:, source]
    np.testing.assert_allclose(moved, wanted, rtol=2e-7, atol=1e-9)
    scene = trimesh.load(tmp_path / "a.glb", process=False)
    by_material = {mesh.visual.material.name: mesh for mesh in scene.geometry.values()}
    assert set(by_material) == {"skin", "eyes", "face"}
    triangles = Counter()
    for mesh in scene.geometry.values():
        own = np.asarray(mesh.vertex_attributes["_SOURCE"]).ravel().astype(int)
        np.testing.assert_allclose(1000.0 * mesh.vertices, rig.mesh.vertices[own], rtol=0, atol=2e-5)
        triangles.update(map(tuple, own[mesh.faces].tolist()))
    assert triangles == Counter(map(tuple, rig.mesh.faces.tolist()))


def test_vtk_reads_all_targets_although_it_needs_more_than_the_format_asks_for(tmp_path: Path) -> None:
    vtk_to_numpy = pytest.importorskip("vtkmodules.util.numpy_support").vtk_to_numpy
    vtk_files = pytest.importorskip("vtkmodules.vtkIOGeometry")
    rig = planted_rig()
    write_rig(tmp_path / "a.glb", rig)
    reader = vtk_files.vtkGLTFReader()
    reader.SetFileName(str(tmp_path / "a.glb"))
    reader.Update()
    waiting, seen = [reader.GetOutput()], 0
    while waiting:
        block = waiting.pop()
        if hasattr(block, "GetNumberOfBlocks"):
            waiting += [block.GetBlock(k) for k in range(block.GetNumberOfBlocks())]
            continue
        data = block.GetPointData()
        source = vtk_to_numpy(data.GetArray("_SOURCE")).ravel().astype(int)
        for k, shape in enumerate(rig.basis.displacements):
            moved = 1000.0 * vtk_to_numpy(data.GetArray(f"target{k}_position"))
            np.testing.assert_allclose(moved, shape[source], rtol=2e-7, atol=1e-9)
        seen += 1
    assert seen == 4


def test_what_stands_still_takes_no_room_and_offsets_are_written(tmp_path: Path) -> None:
    rig = planted_rig(parts=False)
    write_rig(tmp_path / "a.glb", rig)
    found = document(tmp_path / "a.glb")
    targets = [target["POSITION"] for target in found["meshes"][0]["primitives"][0]["targets"]]
    sparse = ["sparse" in found["accessors"][number] for number in targets]
    assert sparse == [True, True, True, True, False]
    for accessor in found["accessors"]:
        if "sparse" in accessor:
            assert accessor["sparse"]["indices"]["byteOffset"] == accessor["sparse"]["values"]["byteOffset"] == 0
            assert accessor["byteOffset"] == 0
    bases = {found["accessors"][number].get("bufferView") for number in targets[:4]}
    assert len(bases) == 1 and None not in bases
    looks = {m["name"]: m["pbrMetallicRoughness"] for m in found["materials"]}
    assert looks["face"]["metallicFactor"] == 0
    write_rig(tmp_path / "b.glb", planted_rig())
    looks = {m["name"]: m["pbrMetallicRoughness"] for m in document(tmp_path / "b.glb")["materials"]}
    assert looks["eyes"]["roughnessFactor"] < looks["skin"]["roughnessFactor"]


def test_the_mean_rests_at_one_and_a_shape_of_that_name_keeps_it(tmp_path: Path) -> None:
    rig = planted_rig(mean=True)
    basis = rig.basis
    rig = rig.with_basis(ExpressionBasis(basis.neutral, ("mean", *NAMES[1:]), basis.displacements, basis.mean))
    write_rig(tmp_path / "a.glb", rig)
    mesh = document(tmp_path / "a.glb")["meshes"][0]
    assert mesh["weights"] == [0.0] * 5 + [1.0]
    assert mesh["extras"]["targetNames"] == ["mean", *NAMES[1:], "mean 2"]
    is_same(read_rig(tmp_path / "a.glb"), rig, 2e-5)


def test_morph_normals_are_those_of_the_moved_face(tmp_path: Path) -> None:
    from engine.geometry.normals import vertex_normals

    rig = planted_rig(parts=False)
    write_glb_rig(tmp_path / "a.glb", rig, morph_normals=True)
    data = pygltflib.GLTF2().load_binary(str(tmp_path / "a.glb"))
    primitive = data.meshes[0].primitives[0]
    accessor = data.accessors[primitive.targets[4]["NORMAL"]]
    start = data.bufferViews[accessor.bufferView].byteOffset
    turned = np.frombuffer(data.binary_blob(), "<f4", 3 * accessor.count, start).reshape(-1, 3)
    faces, rest = rig.mesh.faces, rig.mesh.vertices
    wanted = vertex_normals(rest + rig.basis.displacements[4], faces) - vertex_normals(rest, faces)
    from engine.files.seams import split_at_seams

    np.testing.assert_allclose(turned, wanted[split_at_seams(rig.mesh).source], atol=1e-6)


def test_the_animation_is_found_again_by_name(tmp_path: Path) -> None:
    from engine.files.motion import read_motion

    rig = planted_rig(mean=True)
    weights = np.random.default_rng(2).random((31, 3))
    curves = WeightCurves(("whole", "jaw_open", "headYaw"), weights, 60.0)
    write_rig(tmp_path / "a.glb", rig, curves=curves)
    found = read_motion(tmp_path / "a.glb").data
    assert found.fps == pytest.approx(60.0)
    at = {name: k for k, name in enumerate(found.names)}
    np.testing.assert_allclose(found.weights[:, at["whole"]], weights[:, 0], atol=1e-6)
    np.testing.assert_allclose(found.weights[:, at["jawOpen"]], weights[:, 1], atol=1e-6)
    assert not found.weights[:, at["lid/Ä"]].any()
    is_same(read_rig(tmp_path / "a.glb"), rig, 2e-5)


@pytest.mark.parametrize("name", ["a.glb", "folder"])
def test_the_texture_comes_back(tmp_path: Path, name: str) -> None:
    rig = planted_rig()
    write_rig(tmp_path / name, rig, texture=picture())
    read = read_rig(tmp_path / name)
    np.testing.assert_array_equal(read.texture, picture())
    is_same(read, rig, 3e-5)


def test_what_does_not_fit_a_format_is_refused(tmp_path: Path) -> None:
    rig = planted_rig()
    curves = WeightCurves(("jawOpen",), np.zeros((3, 1)), 30.0)
    for name in ("a.npz", "folder"):
        with pytest.raises(InputError, match="cannot hold curves"):
            write_rig(tmp_path / name, rig, curves=curves)
    with pytest.raises(InputError, match="none of its curves"):
        write_rig(tmp_path / "a.glb", rig, curves=WeightCurves(("nose",), np.zeros((3, 1)), 30.0))
    with pytest.raises(InputError, match="no known ending"):
        write_rig(tmp_path / "a.fbx", rig)
    with pytest.raises(InputError, match="cannot be made"):
        write_rig(tmp_path / "no" / "folder", rig)
    assert not list(tmp_path.iterdir())


def test_names_that_no_file_may_have_come_back_from_a_folder(tmp_path: Path) -> None:
    rig = planted_rig()
    names = ("neutral", "A", "a", "../x", "mean")
    rig = rig.with_basis(ExpressionBasis(rig.basis.neutral, names, rig.basis.displacements))
    written = write_rig(tmp_path / "f", rig)
    assert len({path.name.lower() for path in written}) == len(written) == 7
    assert all(path.parent == tmp_path / "f" for path in written)
    assert read_rig(tmp_path / "f").rig.basis.names == names
    assert read_rig(tmp_path / "f" / "neutral.obj").rig.basis.names == names
    assert json.loads((tmp_path / "f" / "shapes.json").read_text("utf-8"))["unit"] == "mm"
