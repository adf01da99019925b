"""GLB rigs of other programs: sparse, quantised, interleaved, in several meshes, with and without names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.errors import InputError
from engine.files.rig import read_rig
from engine.files.rig_out import write_rig
from tests.engine.files.rig_samples import MorphGlb, planted_rig
from tests.engine.files.test_glb import document

MOVE = np.array([[0, 0, 0], [0, 0.01, 0], [0, 0, 0], [0.02, 0, -0.03]])
OTHER = np.array([[0.001, 0, 0], [0, 0, 0], [0, 0, 0.004], [0, 0, 0]])


def test_sparse_targets_over_zeros_and_over_a_view_without_offsets(tmp_path: Path) -> None:
    glb = MorphGlb()
    base = glb.view(OTHER.astype("<f4").tobytes())
    targets = [glb.sparse(4, [1, 3], MOVE[[1, 3]], offsets=False), glb.sparse(4, [1], [[0.5, 0, 0]], base=base), None]
    targets.append(len(glb.document["accessors"]))
    glb.document["accessors"].append({"componentType": 5126, "count": 4, "type": "VEC3"})
    glb.meshes({"primitives": [glb.triangle(targets)], "extras": {"targetNames": ["a", "b", "c", "d"]}})
    found = read_rig(glb.save(tmp_path / "a.glb"))
    over = OTHER.copy()
    over[1] = [0.5, 0, 0]
    np.testing.assert_allclose(found.rig.basis.shape("a"), 1000 * MOVE, atol=1e-4)
    np.testing.assert_allclose(found.rig.basis.shape("b"), 1000 * over, atol=1e-4)
    assert not found.rig.basis.shape("c").any() and not found.rig.basis.shape("d").any()
    assert found.warnings == ("2 shapes move nothing: c, d",)


@pytest.mark.parametrize(
    ("dtype", "code", "normalised"), [("<i2", 5122, True), ("i1", 5120, True), ("<i2", 5122, False)]
)
def test_quantised_positions_and_targets_under_a_node(tmp_path: Path, dtype: str, code: int, normalised: bool) -> None:
    glb = MorphGlb()
    top = np.iinfo(dtype).max if normalised else 1
    size = 250 if top > 1000 else 1
    scale, shift = (0.25, 0.1) if normalised else (0.001, 0.1)
    values = np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0], [100, 100, 50]], dtype) * np.array(size, dtype)
    moves = np.array([[0, 0, 0], [0, -20, 0], [0, 0, 0], [10, 0, 30]], dtype) * np.array(size, dtype)

    def packed(rows: np.ndarray) -> int:
        # Vectors of 3 are padded to 4 bytes each, as the extension asks.
        wide = np.zeros((4, 4), dtype)
        wide[:, :3] = rows
        view = glb.view(wide.tobytes(), byteStride=4 * np.dtype(dtype).itemsize)
        entry = {"bufferView": view, "componentType": code, "count": 4, "type": "VEC3", "normalized": normalised}
        glb.document["accessors"].append(entry)
        return len(glb.document["accessors"]) - 1

    indices = glb.accessor(np.array([0, 1, 2, 1, 3, 2], "<u2"), "SCALAR", 5123)
    primitive = {
        "attributes": {"POSITION": packed(values)},
        "indices": indices,
        "targets": [{"POSITION": packed(moves)}],
    }
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    node = {"mesh": 0, "scale": [scale] * 3, "translation": [shift, 0, 0], "rotation": [0, 0, 0.5**0.5, 0.5**0.5]}
    glb.meshes({"primitives": [primitive]}, nodes=[node])
    glb.document["extensionsRequired"] = glb.document["extensionsUsed"] = ["KHR_mesh_quantization"]
    found = read_rig(glb.save(tmp_path / "q.glb"), "m").rig.basis
    step = 1000 * scale / top
    np.testing.assert_allclose(found.neutral, step * values @ turn.T + [1000 * shift, 0, 0], atol=1e-9)
    np.testing.assert_allclose(found.shape("shape 1"), step * moves @ turn.T, atol=1e-9)


def test_interleaved_positions_and_targets(tmp_path: Path) -> None:
    glb = MorphGlb()
    points = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0.2, 0.2, 0.1]])
    view = glb.view(np.concatenate([points, MOVE, OTHER], axis=1).astype("<f4").tobytes(), byteStride=36)
    for offset in (0, 12, 24):
        entry = {"bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 4, "type": "VEC3"}
        glb.document["accessors"].append(entry)
    indices = glb.accessor(np.array([0, 1, 2, 1, 3, 2], "<u2"), "SCALAR", 5123)
    targets = [{"POSITION": 1}, {"POSITION": 2}]
    primitive = {"attributes": {"POSITION": 0}, "indices": indices, "targets": targets}
    glb.meshes({"primitives": [primitive], "extras": {"targetNames": ["move", "other"]}})
    basis = read_rig(glb.save(tmp_path / "i.glb")).rig.basis
    np.testing.assert_allclose(basis.neutral, 1000 * points, atol=1e-4)
    np.testing.assert_allclose(basis.displacements, 1000 * np.stack([MOVE, OTHER]), atol=1e-4)


def test_meshes_are_merged_and_their_targets_matched_by_name(tmp_path: Path) -> None:
    glb = MorphGlb()
    glb.document["materials"] = [{"name": "M_Skin"}, {"name": "EyeBall_L"}, {"name": "lambert1"}]
    skin = {"primitives": [glb.triangle([MOVE, OTHER], material=0), glb.triangle([OTHER, MOVE], 0.3, material=1)]}
    skin["extras"] = {"targetNames": ["jawOpen", "blink"]}
    teeth = {
        "primitives": [glb.triangle([MOVE], 0.6, material=2)],
        "extras": {"targetNames": ["jawOpen"]},
        "name": "LowerTeeth",
    }
    tongue = {"primitives": [glb.triangle([], 0.9)]}
    del tongue["primitives"][0]["targets"]
    lips = {"primitives": [glb.triangle([OTHER], -0.3, extras={"targetNames": ["pucker"]})]}
    nodes = [{"mesh": 0}, {"mesh": 1, "scale": [-2, 1, 1]}, {"mesh": 2, "name": "Tongue"}, {"mesh": 3}]
    glb.meshes(skin, teeth, tongue, lips, nodes=nodes)
    found = read_rig(glb.save(tmp_path / "m.glb"))
    basis = found.rig.basis
    assert basis.names == ("jawOpen", "blink", "pucker")
    zero = np.zeros_like(MOVE)
    wanted = {
        "jawOpen": [MOVE, OTHER, MOVE * [-2, 1, 1], zero, zero],
        "blink": [OTHER, MOVE, zero, zero, zero],
        "pucker": [zero, zero, zero, zero, OTHER],
    }
    for name, blocks in wanted.items():
        np.testing.assert_allclose(basis.shape(name), 1000 * np.concatenate(blocks), atol=1e-4)
    parts = {name: faces.tolist() for name, faces in found.rig.mesh.parts.items()}
    assert parts == {"skin": [0, 1], "eyes": [2, 3], "teeth": [4, 5], "tongue": [6, 7]}
    np.testing.assert_array_equal(found.rig.skin, [0, 1, 2, 3])
    corners = basis.neutral[found.rig.mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normals[:, 2] > 0).all()  # the mirrored mesh keeps its outside
    assert any("1 of 5 primitives have no shapes" in warning for warning in found.warnings)


def test_names_are_found_where_programs_put_them_or_counted(tmp_path: Path) -> None:
    for key, extras in (("mesh", ["a", "b"]), ("primitive", ["a", "b"]), ("none", None), ("short", ["a"])):
        glb = MorphGlb()
        primitive = glb.triangle([MOVE, OTHER])
        mesh = {"primitives": [primitive]}
        if extras:
            (primitive if key == "primitive" else mesh)["extras"] = {"targetNames": extras}
        found = read_rig(glb.meshes(mesh).save(tmp_path / f"{key}.glb"))
        wanted = {"none": ("shape 1", "shape 2"), "short": ("a", "shape 2")}.get(key, ("a", "b"))
        assert found.rig.basis.names == wanted
        numbered = 2 - len(extras or [])
        assert any("no name" in w for w in found.warnings) == bool(numbered)


def test_a_mean_is_known_by_its_mark_and_supposed_by_its_name(tmp_path: Path) -> None:
    for mark in (True, False):
        glb = MorphGlb()
        name = "average" if mark else "mean"
        extras = {"targetNames": ["a", name]} | ({"meanTarget": "average"} if mark else {})
        glb.meshes({"primitives": [glb.triangle([MOVE, OTHER])], "extras": extras, "weights": [0.25, 1]})
        found = read_rig(glb.save(tmp_path / "a.glb"))
        assert found.rig.basis.names == ("a",)
        np.testing.assert_allclose(found.rig.basis.mean, 1000 * OTHER, atol=1e-4)
        assert any("rests in a pose (a)" in w for w in found.warnings)
        assert any("was taken for the mean" in w for w in found.warnings) != mark


def _seamed(normals: np.ndarray, moves: np.ndarray) -> MorphGlb:
    """Two triangles that share an edge whose vertices are stored twice."""
    glb = MorphGlb()
    points = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0.2, 0, 0], [0.2, 0.2, 0.1], [0, 0.2, 0]], "<f4")
    attributes = {
        "POSITION": glb.accessor(points, "VEC3", 5126),
        "NORMAL": glb.accessor(normals.astype("<f4"), "VEC3", 5126),
        "TEXCOORD_0": glb.accessor(np.linspace(0, 1, 12).reshape(6, 2).astype("<f4"), "VEC2", 5126),
    }
    indices = glb.accessor(np.arange(6, dtype="<u2"), "SCALAR", 5123)
    target = {"POSITION": glb.accessor(moves.astype("<f4"), "VEC3", 5126)}
    return glb.meshes({"primitives": [{"attributes": attributes, "indices": indices, "targets": [target]}]})


def test_copies_along_a_seam_are_joined_but_touching_lips_are_not(tmp_path: Path) -> None:
    up = np.tile([0.0, 0, 1], (6, 1))
    move = np.array([[0, 0, 0], [0, 0.01, 0], [0, 0, 0], [0, 0.01, 0], [0, 0, 0.02], [0, 0, 0]])
    joined = read_rig(_seamed(up, move).save(tmp_path / "a.glb"))
    assert len(joined.rig.basis.neutral) == 4 and any("2 of 6 vertices were copies" in w for w in joined.warnings)
    np.testing.assert_array_equal(joined.rig.mesh.faces, [[0, 1, 2], [1, 3, 2]])
    np.testing.assert_allclose(joined.rig.mesh.uv[joined.rig.mesh.uv_faces].ravel(), np.linspace(0, 1, 12), atol=1e-6)
    apart = move.copy()
    apart[3, 1] = 0.02
    assert len(read_rig(_seamed(up, apart).save(tmp_path / "b.glb")).rig.basis.neutral) == 5
    # Smooth lips have opposite normals; a mesh of facets has other normals at every copy.
    lips = up.copy()
    lips[[3, 5]] = [0, 0, -1]
    grid = _lips(np.array([0, 0, 1.0]), np.array([0, 0, -1.0]))
    assert len(read_rig(grid.save(tmp_path / "c.glb")).rig.basis.neutral) == 18
    assert len(read_rig(_seamed(lips, move).save(tmp_path / "d.glb")).rig.basis.neutral) == 4


def _lips(upper: np.ndarray, lower: np.ndarray) -> MorphGlb:
    """Two smooth sheets of 3 x 3 vertices that touch along a row, under a shape that does not part them."""
    glb = MorphGlb()
    x, y = np.meshgrid([0, 0.1, 0.2], [0, 0.1, 0.2])
    sheet = np.stack([x, y, 0 * x], axis=2).reshape(-1, 3)
    points = np.concatenate([sheet, sheet * [1, -1, 1]]).astype("<f4")
    faces = np.array([(a, a + 1, a + 4, a, a + 4, a + 3) for a in (0, 1, 3, 4)]).reshape(-1, 3)
    attributes = {
        "POSITION": glb.accessor(points, "VEC3", 5126),
        "NORMAL": glb.accessor(np.repeat([upper, lower], 9, axis=0).astype("<f4"), "VEC3", 5126),
    }
    indices = glb.accessor(np.concatenate([faces, faces[:, ::-1] + 9]).astype("<u2").ravel(), "SCALAR", 5123)
    move = np.zeros((18, 3), "<f4")
    move[4] = 0.01
    target = {"POSITION": glb.accessor(move, "VEC3", 5126)}
    return glb.meshes({"primitives": [{"attributes": attributes, "indices": indices, "targets": [target]}]})


def test_source_numbers_that_lie_are_passed_over_and_told(tmp_path: Path) -> None:
    rig = planted_rig(parts=False)
    write_rig(tmp_path / "a.glb", rig)
    data = (tmp_path / "a.glb").read_bytes()
    found = document(tmp_path / "a.glb")
    accessor = found["accessors"][found["meshes"][0]["primitives"][0]["attributes"]["_SOURCE"]]
    start = data.index(b"BIN\0") + 4 + found["bufferViews"][accessor["bufferView"]]["byteOffset"]
    count = accessor["count"]
    for numbers in (np.roll(np.arange(count), 3), np.zeros(count), np.full(count, np.nan), np.arange(count) * 1e6):
        changed = bytearray(data)
        changed[start : start + 4 * count] = numbers.astype("<f4").tobytes()
        (tmp_path / "b.glb").write_bytes(bytes(changed))
        read = read_rig(tmp_path / "b.glb")
        kept = np.array_equal(numbers, np.roll(np.arange(count), 3))
        assert any("_SOURCE" in w for w in read.warnings) != kept
        # Without them the copies along the seam are found by where they are and how they move.
        assert len(read.rig.basis.neutral) == (count if kept else len(rig.basis.neutral))


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "without Draco"),
        ({"extensionsRequired": ["EXT_meshopt_compression"]}, "meshopt compression (gltfpack"),
        ({"extensionsRequired": ["XX_other"]}, "XX_other"),
    ],
)
def test_compressed_rigs_say_what_to_do(tmp_path: Path, change: dict, word: str) -> None:
    glb = MorphGlb().meshes({"primitives": []})
    glb.document |= change
    with pytest.raises(InputError) as told:
        read_rig(glb.save(tmp_path / "a.glb"))
    assert word in str(told.value)


@pytest.mark.parametrize(
    ("names", "targets", "word"),
    [
        (["a", "a"], [MOVE, OTHER], "'a' stands for several shapes"),
        ([], [], "no morph targets"),
        (["a"], [MOVE[:3]], "moves 3 vertices, its primitive has 4"),
        (["a"], [MOVE * np.nan], "shape a: holds numbers that are not finite"),
        (["a"], [MOVE * 1e35], "more than 1e+06 mm"),
        (["a"], [99], "accessors"),
        (["mean"], [MOVE], None),
    ],
)
def test_what_is_no_rig_names_the_place(tmp_path: Path, names: list, targets: list, word: str | None) -> None:
    glb = MorphGlb()
    mesh = {"primitives": [glb.triangle(targets)], "extras": {"targetNames": names}, "weights": [1] * len(targets)}
    path = glb.meshes(mesh).save(tmp_path / "a.glb")
    if word is None:
        assert read_rig(path).rig.basis.names == ("mean",)
        return
    with pytest.raises(InputError) as told:
        read_rig(path)
    assert word in str(told.value) and str(path) in str(told.value), told.value


def test_primitives_of_one_mesh_agree_and_weights_are_numbers(tmp_path: Path) -> None:
    glb = MorphGlb()
    glb.meshes({"primitives": [glb.triangle([MOVE]), glb.triangle([MOVE, OTHER], 0.3)]})
    with pytest.raises(InputError, match="has 2 targets, another of its mesh 1"):
        read_rig(glb.save(tmp_path / "a.glb"))
    for weights in ([1, 2], ["a"], [1e300], "x"):
        glb = MorphGlb()
        glb.meshes({"primitives": [glb.triangle([MOVE])], "weights": weights})
        with pytest.raises(InputError, match="weights: is not 1 numbers"):
            read_rig(glb.save(tmp_path / "b.glb"))
