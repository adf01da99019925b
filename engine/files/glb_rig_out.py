"""Rigs as GLB: one mesh, a primitive per part, a named morph target per shape, and weights over time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.glb_build import (
    GENERATOR,
    INDEX_DATA,
    LARGEST_SOURCE,
    METRES_PER_MM,
    VERTEX_DATA,
    GlbBuffer,
    texture_objects,
)
from engine.files.runs import to_runs
from engine.files.seams import SplitMesh, split_at_seams
from engine.geometry.normals import vertex_normals
from engine.mesh import FloatArray, IntArray, TriangleMesh
from engine.motion import WeightCurves, driven_by
from engine.scan.range_image import ColourImage
from engine.shapes import Rig

MEAN_KEY = "meanTarget"
"""Entry of a mesh's ``extras`` that names the morph target that is the mean of an affine basis."""

FACES_KEY, PARTS_KEY = "sourceFaces", "parts"
"""Entries of a primitive's ``extras``: runs (first, count, ...) of the faces it holds, and the parts they belong to."""

_MOST_RUNS = 20_000
_LOOKS = {
    "skin": ((0.60, 0.36, 0.27), 0.55),
    "eyes": ((0.85, 0.85, 0.83), 0.08),
    "teeth": ((0.78, 0.71, 0.58), 0.25),
    "tongue": ((0.45, 0.13, 0.13), 0.35),
}
"""Linear base colour and roughness of the parts that have a name everybody uses."""
_PLAIN = ((0.55, 0.53, 0.50), 0.6)


def write_glb_rig(
    path: str | Path,
    rig: Rig,
    *,
    name: str = "face",
    texture: ColourImage | None = None,
    texture_format: str = "png",
    curves: WeightCurves | None = None,
    normals: bool = True,
    morph_normals: bool = False,
    extras: Mapping[str, Any] | None = None,
) -> None:
    """Write a rig as one GLB file with a morph target per shape.

    Positions and displacements are in metres. Vertices are split at texture seams; the attribute ``_SOURCE`` (float)
    holds each vertex's index in the mesh. The mean of an affine basis is one more target of weight 1, which the mesh's
    ``extras`` name. Displacements that are zero at most vertices become sparse accessors.

    Parameters
    ----------
    path : str or Path
        The file to make.
    rig : Rig
        In mm; its parts become primitives with materials of their own.
    name : str
        Name of the node and the mesh.
    texture : (H, W, 3) uint8, optional
        RGB picture for the mesh's chart.
    texture_format : {"png", "jpeg"}
        How the picture is stored.
    curves : WeightCurves, optional
        Becomes an animation of the weights; curves are matched to the shapes by name as in ``motion.driven_by``, and
        those that no shape has are left out.
    normals, morph_normals : bool
        Whether to write normals of the resting face, and how every shape changes them.
    extras : mapping, optional
        Added to the ``extras`` of the asset.

    Raises
    ------
    InputError
        When the mesh has no faces or too many vertices, texture or curves do not fit, or the file cannot be written.

    References
    ----------
    Khronos Group, glTF 2.0 Specification, sections 3.6.2.3, 3.7.2.2 and 3.11.
    """
    mesh, basis = rig.mesh, rig.basis
    if len(mesh.faces) == 0:
        raise InputError("mesh", "has no faces", "import a face first")
    if len(mesh.vertices) > LARGEST_SOURCE:
        raise InputError("mesh", f"has {len(mesh.vertices)} vertices", f"{LARGEST_SOURCE} can be numbered in a GLB")
    buffer = GlbBuffer()
    targets, names, weights = _targets(rig)
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": GENERATOR, "extras": {"unit": "m", **dict(extras or {})}},
        "scene": 0,
        "scenes": [{"name": name, "nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0}],
    }
    if texture is not None:
        document |= texture_objects(buffer, mesh, texture, texture_format, name)
    told: dict[str, Any] = {"targetNames": names}
    if basis.mean is not None:
        told[MEAN_KEY] = names[-1]
    groups = _groups(mesh)
    turned = _turned(rig, targets) if morph_normals else None
    resting = vertex_normals(basis.neutral, mesh.faces) if normals or morph_normals else None
    split = split_at_seams(mesh)
    primitives = []
    for number, (parts, faces) in enumerate(groups):
        piece = _piece(split, faces, with_unused=number == 0)
        primitive = _primitive(buffer, basis.neutral, targets, piece, resting, turned)
        runs = to_runs(faces)
        told_here: dict[str, Any] = {PARTS_KEY: list(parts)}
        if len(runs) <= _MOST_RUNS:
            told_here[FACES_KEY] = runs
        primitives.append({**primitive, "material": number, "mode": 4, "extras": told_here})
    document["meshes"] = [{"name": name, "primitives": primitives, "weights": weights, "extras": told}]
    document["materials"] = [_material(parts[0] if parts else name, texture is not None) for parts, _ in groups]
    if curves is not None:
        document["animations"] = [_animation(buffer, rig, curves, name)]
    buffer.save(path, document)


def _targets(rig: Rig) -> tuple[FloatArray, list[str], list[float]]:
    """Return displacements (t, N, 3), names and default weights of all targets: the shapes, then the mean."""
    basis = rig.basis
    names, weights = list(basis.names), [0.0] * len(basis)
    if basis.mean is None:
        return basis.displacements, names, weights
    mean, number = "mean", 2
    while mean in names:
        mean, number = f"mean {number}", number + 1
    return np.concatenate([basis.displacements, basis.mean[None]]), [*names, mean], [*weights, 1.0]


def _turned(rig: Rig, targets: FloatArray) -> FloatArray:
    """Return by how much every target changes the unit normals (t, N, 3)."""
    faces, rest = rig.mesh.faces, rig.basis.neutral
    before = vertex_normals(rest, faces)
    return np.stack([vertex_normals(rest + target, faces) - before for target in targets])


def _groups(mesh: TriangleMesh) -> list[tuple[tuple[str, ...], IntArray]]:
    """Return (names of parts, faces) for every set of faces that belong to the same parts."""
    code = np.zeros(len(mesh.faces), dtype=object if len(mesh.parts) > 62 else np.int64)
    names = list(mesh.parts)
    for bit, name in enumerate(names):
        code[mesh.parts[name]] |= 1 << bit
    kinds = sorted(set(code.tolist()), key=lambda kind: (kind == 0, kind & -kind, kind))
    return [
        (tuple(name for bit, name in enumerate(names) if kind >> bit & 1), np.flatnonzero(code == kind))
        for kind in kinds
    ]


def _piece(split: SplitMesh, faces: IntArray, with_unused: bool) -> SplitMesh:
    """Return some faces with the vertices they use, and on wish those that no face uses."""
    own = split.faces[faces]
    used: IntArray = np.unique(own)
    if with_unused:
        used = np.union1d(used, np.setdiff1d(np.arange(len(split.source)), split.faces))
    return SplitMesh(split.source[used], np.searchsorted(used, own), None if split.uv is None else split.uv[used])


def _primitive(
    buffer: GlbBuffer,
    neutral: FloatArray,
    targets: FloatArray,
    piece: SplitMesh,
    normals: FloatArray | None,
    turned: FloatArray | None,
) -> dict[str, Any]:
    source = piece.source
    positions = _metres(neutral[source])
    attributes = {"POSITION": buffer.accessor(positions, "VEC3", VERTEX_DATA, limits=True)}
    if normals is not None:
        attributes["NORMAL"] = buffer.accessor(normals[source].astype(np.float32), "VEC3", VERTEX_DATA)
    if piece.uv is not None:
        attributes["TEXCOORD_0"] = buffer.accessor(piece.uv.astype(np.float32), "VEC2", VERTEX_DATA)
    attributes["_SOURCE"] = buffer.accessor(source.astype(np.float32), "SCALAR", VERTEX_DATA)
    indices = buffer.accessor(piece.faces.astype(np.uint32).ravel(), "SCALAR", INDEX_DATA)
    found = []
    for k, target in enumerate(targets):
        entry = {"POSITION": buffer.displacement(_metres(target[source]))}
        if turned is not None:
            entry["NORMAL"] = buffer.displacement(turned[k][source].astype(np.float32), limits=False)
        found.append(entry)
    return {"attributes": attributes, "indices": indices, "targets": found}


def _metres(millimetres: FloatArray) -> NDArray[np.float32]:
    return (millimetres * METRES_PER_MM).astype(np.float32)


def _material(part: str, textured: bool) -> dict[str, Any]:
    colour, roughness = _LOOKS.get(part, _PLAIN)
    surface: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": roughness}
    if textured:
        surface["baseColorTexture"] = {"index": 0}
    else:
        surface["baseColorFactor"] = [*colour, 1.0]
    return {"name": part, "pbrMetallicRoughness": surface, "doubleSided": True}


def _animation(buffer: GlbBuffer, rig: Rig, curves: WeightCurves, name: str) -> dict[str, Any]:
    motion, _, _ = driven_by(rig.basis, curves)
    assert motion.weights is not None
    weights = motion.weights
    if rig.basis.mean is not None:
        weights = np.concatenate([weights, np.ones((len(weights), 1))], axis=1)
    times = (np.arange(len(weights)) / curves.fps).astype(np.float32)
    if len(times) > 1 and not (np.diff(times) > 0).all():
        problem = f"are {len(times)} frames at {curves.fps:g} fps, more than a GLB can tell apart"
        raise InputError("curves", problem, "write a shorter range")
    return {
        "name": name,
        "samplers": [
            {
                "input": buffer.accessor(times, "SCALAR", limits=True),
                "output": buffer.accessor(weights.astype(np.float32).ravel(), "SCALAR"),
                "interpolation": "LINEAR",
            }
        ],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
        "extras": {"fps": curves.fps},
    }
