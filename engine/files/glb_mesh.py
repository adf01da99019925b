"""GLB as a mesh: all triangles of its scene in one, in their places, with base colour."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.glb_materials import GlbMaterials, encoded
from engine.files.glb_scene import Instance, attribute, check_extensions, instances, placed, triangles
from engine.files.gltf_data import GltfData
from engine.files.mesh_parts import RawMesh, check_counts
from engine.mesh import BoolArray, FloatArray, IntArray


@dataclass
class _Merged:
    """What the primitives add up to."""

    vertices: list[FloatArray] = field(default_factory=list)
    faces: list[IntArray] = field(default_factory=list)
    uv: list[FloatArray] = field(default_factory=list)
    placed: list[BoolArray] = field(default_factory=list)
    colours: list[FloatArray] = field(default_factory=list)
    materials: list[IntArray] = field(default_factory=list)
    count: int = 0
    triangles: int = 0
    coloured: bool = False
    skipped: int = 0
    bent: int = 0


def read_glb_mesh(path: Path) -> RawMesh:
    """Read the default scene of a GLB file as one mesh, in metres.

    Node transforms are applied; morph targets and skins are left at rest; primitives that are no triangles are passed
    over. Colour comes from the base-colour texture and factor and from ``COLOR_0``.

    Raises
    ------
    InputError
        On data that is not in the file, indices of nothing, loops of nodes, or an extension it cannot do without.
    """
    data = GltfData(path)
    check_extensions(data)
    merged, materials = _Merged(), GlbMaterials(data)
    for instance in instances(data):
        merged.bent += instance.first and instance.skinned
        _add(data, instance, merged, materials)
    notes = materials.notes
    if merged.skipped:
        notes.append(f"{merged.skipped} primitives of points, lines or nothing were left out")
    if merged.bent:
        notes.append(f"{merged.bent} meshes with bones are shown at rest")
    if not merged.faces:
        raise InputError(str(path), "holds no triangles", "export the surface, not only points or lines")
    has_chart = any(block.any() for block in merged.placed)
    uv = np.concatenate(merged.uv)
    faces = np.concatenate(merged.faces)
    uv_faces = np.where(np.concatenate(merged.placed)[faces], faces, -1)
    colours = None
    if merged.coloured:
        colours = np.clip(np.rint(255 * encoded(np.concatenate(merged.colours))), 0, 255).astype(np.uint8)
    return RawMesh(
        np.concatenate(merged.vertices), faces, np.concatenate(merged.materials), materials.made,
        uv if has_chart else None, uv_faces if has_chart else None, colours, "m",
        tuple(dict.fromkeys(notes)), tuple(materials.files),
    )  # fmt: skip


def _add(data: GltfData, instance: Instance, merged: _Merged, materials: GlbMaterials) -> None:
    found = triangles(data, instance)
    if found is None:
        merged.skipped += 1
        return
    positions, faces = found
    count = len(positions)
    check_counts(str(data.path), merged.count + count, merged.triangles + len(faces))
    key, channel, transform = materials.material(instance.primitive.get("material"))
    uv = np.zeros((count, 2))
    has_uv: BoolArray = np.zeros(count, dtype=bool)
    coordinates = None if channel is None else attribute(data, instance, f"TEXCOORD_{channel}", ("VEC2",), count)
    if coordinates is not None:
        sound = np.isfinite(coordinates).all(axis=1, keepdims=True)
        moved = np.where(sound, coordinates, 0.0) @ transform[:2, :2].T + transform[:2, 2]
        uv = np.where(sound, moved, np.nan)
        has_uv = np.ones(count, dtype=bool)
    shade = attribute(data, instance, "COLOR_0", ("VEC3", "VEC4"), count)
    merged.coloured |= shade is not None
    merged.vertices.append(placed(positions, instance.place))
    merged.faces.append(faces + merged.count)
    merged.uv.append(uv)
    merged.placed.append(has_uv)
    merged.colours.append(np.ones((count, 3)) if shade is None else np.clip(np.nan_to_num(shade[:, :3]), 0, 1))
    merged.materials.append(np.full(len(faces), key))
    merged.count += count
    merged.triangles += len(faces)
