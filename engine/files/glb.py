"""GLB, the binary form of glTF 2.0: metres, Y up, the texture inside."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from engine.errors import InputError
from engine.files.glb_build import (
    GENERATOR,
    INDEX_DATA,
    LARGEST_SOURCE,
    METRES_PER_MM,
    VERTEX_DATA,
    GlbBuffer,
    texture_objects,
    unit_normals,
)
from engine.files.seams import split_at_seams
from engine.mesh import FloatArray, TriangleMesh
from engine.scan.range_image import ColourImage


def write_glb(
    path: str | Path,
    mesh: TriangleMesh,
    *,
    normals: FloatArray | None = None,
    texture: ColourImage | None = None,
    name: str = "face",
    texture_format: str = "png",
    extras: Mapping[str, Any] | None = None,
) -> None:
    """Write a mesh as one GLB file.

    Positions are in metres, in the mesh's own frame (+Y up, +Z out of the face, as glTF has it). Vertices are split at
    texture seams; the attribute ``_SOURCE`` (float) holds each vertex's index in ``mesh``.

    Parameters
    ----------
    path : str or Path
        The file to make.
    mesh : TriangleMesh
        In mm. Its ``uv`` has the origin at the top left, as glTF has it.
    normals : (N, 3) float, optional
        One per mesh vertex, of any length; where one has no direction, +Z is written.
    texture : (H, W, 3) uint8, optional
        RGB picture for ``mesh.uv``.
    name : str
        Name of the node and the mesh.
    texture_format : {"png", "jpeg"}
        How the picture is stored.
    extras : mapping, optional
        Added to the ``extras`` of the asset, beside the unit (the writing product's version, for instance).

    Raises
    ------
    InputError
        When the mesh is empty or too large, an array does not fit it, or the file cannot be written.

    References
    ----------
    Khronos Group, glTF 2.0 Specification, sections 3.6, 3.7 and 4.4.
    """
    if len(mesh.faces) == 0:
        raise InputError("mesh", "has no faces", "fit or import a face first")
    if len(mesh.vertices) > LARGEST_SOURCE:
        raise InputError("mesh", f"has {len(mesh.vertices)} vertices", f"{LARGEST_SOURCE} can be numbered in a GLB")
    split = split_at_seams(mesh)
    buffer = GlbBuffer()
    positions = (mesh.vertices[split.source] * METRES_PER_MM).astype(np.float32)
    attributes = {"POSITION": buffer.accessor(positions, "VEC3", VERTEX_DATA, limits=True)}
    if normals is not None:
        directions = unit_normals(normals, len(mesh.vertices))[split.source].astype(np.float32)
        attributes["NORMAL"] = buffer.accessor(directions, "VEC3", VERTEX_DATA)
    if split.uv is not None:
        attributes["TEXCOORD_0"] = buffer.accessor(split.uv.astype(np.float32), "VEC2", VERTEX_DATA)
    attributes["_SOURCE"] = buffer.accessor(split.source.astype(np.float32), "SCALAR", VERTEX_DATA)
    indices = buffer.accessor(split.faces.astype(np.uint32).ravel(), "SCALAR", INDEX_DATA)
    material: dict[str, Any] = {
        "name": name,
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.6},
        "doubleSided": True,
    }
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": GENERATOR, "extras": {"unit": "m", **dict(extras or {})}},
        "scene": 0,
        "scenes": [{"name": name, "nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0}],
        "meshes": [
            {"name": name, "primitives": [{"attributes": attributes, "indices": indices, "material": 0, "mode": 4}]}
        ],
        "materials": [material],
    }
    if texture is not None:
        document |= texture_objects(buffer, mesh, texture, texture_format, name)
        material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    buffer.save(path, document)
