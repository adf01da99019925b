"""GLB as a rig: all triangles of its scene in one mesh, and its morph targets by name."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from engine.errors import InputError, some
from engine.files.glb_materials import GlbMaterials
from engine.files.glb_morphs import MorphTargets, displacement
from engine.files.glb_rig_out import FACES_KEY, PARTS_KEY
from engine.files.glb_scene import Instance, attribute, check_extensions, instances, placed, triangles
from engine.files.gltf_data import GltfData
from engine.files.mesh_parts import FARTHEST_PLACE, MAX_FACES, check_counts
from engine.files.part_names import part_name
from engine.files.rig_raw import RawRig, check_size
from engine.files.runs import from_runs
from engine.files.textures import cover
from engine.files.weld import Welded, by_source, by_touch
from engine.mesh import FloatArray, IntArray

_MEAN = "mean"


@dataclass
class _Piece:
    """One primitive: where its vertices begin, what covers it, and what its shapes are called."""

    instance: Instance
    first: int
    vertices: FloatArray
    faces: IntArray
    uv: FloatArray | None
    normals: FloatArray | None
    source: FloatArray | None
    material: int
    parts: tuple[str, ...]
    order: IntArray | None
    targets: list[str]


@dataclass
class _Scene:
    pieces: list[_Piece] = field(default_factory=list)
    targets: MorphTargets = field(default_factory=MorphTargets)
    vertices: int = 0
    faces: int = 0
    skipped: int = 0
    bent: int = 0
    unplaced: int = 0


def read_glb_rig(path: Path) -> RawRig:
    """Read the default scene of a GLB file as one rig, in metres.

    All meshes are merged and their morph targets matched by name; node transforms are applied, bones are not. Parts
    are named by materials, meshes and nodes. Vertices that the attribute ``_SOURCE`` numbers go back to these numbers;
    where there is none, those that a texture seam or a sharp edge has split are joined again.

    Raises
    ------
    InputError
        Without morph targets, on names that stand for two of one mesh, compressed geometry, and whatever a mesh is
        refused for.
    """
    data = GltfData(path)
    check_extensions(data)
    scene, materials = _Scene(), GlbMaterials(data)
    for instance in instances(data):
        _add(data, instance, scene, materials)
    targets = scene.targets
    if not scene.pieces:
        raise InputError(str(path), "holds no triangles", "export the surface, not only points or lines")
    if not targets.names:
        raise InputError(str(path), "has no morph targets", "export it with its shape keys (blend shapes)")
    check_size(str(path), len(targets.names), scene.vertices)
    shapes = _displacements(data, scene)
    notes = [*materials.notes, *_told(scene)]
    welded = _welded(scene, shapes, notes)
    order = _face_order(scene)
    faces = np.concatenate([piece.faces + piece.first for piece in scene.pieces])[order]
    material = np.concatenate([np.full(len(piece.faces), piece.material) for piece in scene.pieces])[order]
    uv, uv_faces = _chart(scene, faces)
    texture = None
    if any(made.texture is not None for made in materials.made):
        covering = cover(materials.made, material, uv, uv_faces)
        if covering.texture is not None:
            texture, uv, uv_faces = covering.texture, covering.uv, covering.uv_faces
    names, mean = _mean(targets, shapes, welded, notes)
    kept = [targets.names.index(name) for name in names]
    vertices = np.concatenate([piece.vertices for piece in scene.pieces])[welded.first]
    return RawRig(
        vertices, welded.index[faces], names, _packed(shapes, kept, welded.first), mean, uv, uv_faces,
        _parts(scene, order), texture, "m", tuple(dict.fromkeys(notes)), tuple(materials.files),
    )  # fmt: skip


def _add(data: GltfData, instance: Instance, scene: _Scene, materials: GlbMaterials) -> None:
    scene.bent += instance.first and instance.skinned
    found = triangles(data, instance)
    if found is None:
        scene.skipped += 1
        return
    positions, faces = found
    count = len(positions)
    check_counts(str(data.path), scene.vertices + count, scene.faces + len(faces))
    key, channel, transform = materials.material(instance.primitive.get("material"))
    uv = attribute(data, instance, f"TEXCOORD_{channel or 0}", ("VEC2",), count)
    if uv is not None:
        lost = ~(np.abs(uv) <= FARTHEST_PLACE).all(axis=1, keepdims=True)
        scene.unplaced += int(lost.sum())
        uv = np.where(lost, 0.0, uv) @ transform[:2, :2].T + transform[:2, 2]
    normals = attribute(data, instance, "NORMAL", ("VEC3",), count)
    source = attribute(data, instance, "_SOURCE", ("SCALAR",), count)
    parts, order = _stored(data, instance, len(faces))
    targets = scene.targets.add(data, instance)
    vertices = placed(positions, instance.place)
    scene.pieces.append(
        _Piece(instance, scene.vertices, vertices, faces, uv, normals, source, key, parts, order, targets)
    )
    scene.vertices += count
    scene.faces += len(faces)


def _stored(data: GltfData, instance: Instance, faces: int) -> tuple[tuple[str, ...], IntArray | None]:
    """Return the parts of a primitive, by its own word or by names, and the numbers of its faces where it has them."""
    extras = instance.primitive.get("extras")
    extras = extras if isinstance(extras, dict) else {}
    parts, runs = extras.get(PARTS_KEY), extras.get(FACES_KEY)
    order = None
    if isinstance(runs, list) and all(type(number) is int and 0 <= number < 1 << 31 for number in runs):
        found = from_runs(runs, MAX_FACES) if sum(runs[1::2]) == faces else None
        order = found if found is not None and len(found) == faces else None
    if isinstance(parts, list) and all(isinstance(name, str) and name.strip() for name in parts) and len(parts) < 64:
        return tuple(name[:64] for name in parts), order
    material = instance.primitive.get("material")
    names = [
        None if material is None else data.item("materials", material).get("name"),
        data.item("meshes", instance.mesh).get("name"),
        data.item("nodes", instance.node).get("name"),
    ]
    named = part_name(*(name[:200] for name in names if isinstance(name, str)))
    return (() if named is None else (named,)), order


def _displacements(data: GltfData, scene: _Scene) -> FloatArray:
    place = {name: k for k, name in enumerate(scene.targets.names)}
    shapes = np.zeros((len(place), scene.vertices, 3))
    for piece in scene.pieces:
        for number, name in enumerate(piece.targets):
            found = displacement(data, piece.instance, number, len(piece.vertices))
            if found is not None:
                shapes[place[name], piece.first : piece.first + len(found)] = found
    return shapes


def _packed(shapes: FloatArray, kept: list[int], first: IntArray) -> FloatArray:
    """Return some shapes (k, V, 3) at some vertices, in the memory of ``shapes`` itself, which may be large."""
    flat, width = shapes.reshape(-1), 3 * len(first)
    for k, row in enumerate(kept):
        # Row k ends before row k of the original does, and what is read lies at or behind it.
        flat[k * width : (k + 1) * width] = shapes[row, first].ravel()
    return flat[: len(kept) * width].reshape(len(kept), len(first), 3)


def _told(scene: _Scene) -> list[str]:
    notes = []
    if scene.skipped:
        notes.append(f"{scene.skipped} primitives of points, lines or nothing were left out")
    if scene.bent:
        notes.append(f"{scene.bent} meshes with bones are shown at rest")
    if scene.unplaced:
        notes.append(f"{scene.unplaced} texture coordinates are no numbers or too large: put into the corner")
    if scene.targets.unnamed:
        notes.append(f"{scene.targets.unnamed} shapes have no name in the file and are numbered")
    bare = [piece for piece in scene.pieces if not piece.targets]
    if bare and len(bare) < len(scene.pieces):
        notes.append(f"{len(bare)} of {len(scene.pieces)} primitives have no shapes and stay still")
    return notes


def _welded(scene: _Scene, shapes: FloatArray, notes: list[str]) -> Welded:
    """Join what is one vertex, node by node; ``notes`` says how many were."""
    index, first, made = [], [], 0
    joined = 0
    start = 0
    while start < len(scene.pieces):
        stop = start + 1
        while stop < len(scene.pieces) and scene.pieces[stop].instance.node == scene.pieces[start].instance.node:
            stop += 1
        pieces = scene.pieces[start:stop]
        begin, end = pieces[0].first, pieces[-1].first + len(pieces[-1].vertices)
        positions = np.concatenate([piece.vertices for piece in pieces])
        own = shapes[:, begin:end]
        found = by_source([piece.source for piece in pieces], positions, own)
        if found is None:
            if any(piece.source is not None for piece in pieces):
                notes.append("_SOURCE does not number the vertices any more: it was passed over")
            normals = [piece.normals for piece in pieces]
            directions = (
                None if any(n is None for n in normals) else np.concatenate([n for n in normals if n is not None])
            )
            found = by_touch(positions, own, directions, sum(len(piece.faces) for piece in pieces))
            joined += len(positions) - len(found.first)
        index.append(found.index + made)
        first.append(found.first + begin)
        made += len(found.first)
        start = stop
    if joined:
        notes.append(f"{joined} of {scene.vertices} vertices were copies along seams and edges: joined")
    return Welded(np.concatenate(index), np.concatenate(first))


def _face_order(scene: _Scene) -> IntArray:
    """Return the places of all faces in the order they had; the file's own where it does not say."""
    orders = [piece.order for piece in scene.pieces]
    if any(order is None for order in orders):
        return np.arange(scene.faces)
    numbers = np.concatenate([order for order in orders if order is not None])
    if numbers.max() >= scene.faces or (np.bincount(numbers, minlength=scene.faces) != 1).any():
        return np.arange(scene.faces)
    return np.argsort(numbers)


def _chart(scene: _Scene, faces: IntArray) -> tuple[FloatArray | None, IntArray | None]:
    if all(piece.uv is None for piece in scene.pieces):
        return None, None
    uv = np.concatenate([np.zeros((len(p.vertices), 2)) if p.uv is None else p.uv for p in scene.pieces])
    unique, places = np.unique(uv, axis=0, return_inverse=True)
    return unique, places.reshape(-1)[faces]


def _parts(scene: _Scene, order: IntArray) -> dict[str, IntArray]:
    names = dict.fromkeys(name for piece in scene.pieces for name in piece.parts)
    sizes = [len(piece.faces) for piece in scene.pieces]
    return {
        name: np.flatnonzero(np.repeat([name in piece.parts for piece in scene.pieces], sizes)[order]) for name in names
    }


def _mean(
    targets: MorphTargets, shapes: FloatArray, welded: Welded, notes: list[str]
) -> tuple[list[str], FloatArray | None]:
    """Return the names that are shapes, and the mean displacement; ``notes`` says what the face is not shown at."""
    mean = targets.mean
    if mean is None and targets.weights.get(_MEAN) == 1.0 and len(targets.names) > 1:
        mean = _MEAN
        notes.append("the target 'mean' of weight 1 was taken for the mean of an affine basis")
    names = [name for name in targets.names if name != mean]
    posed = [name for name in names if targets.weights.get(name)]
    if posed:
        notes.append(f"the file rests in a pose ({some(posed)}): weights start from the neutral face all the same")
    return names, None if mean is None else shapes[targets.names.index(mean)][welded.first]
