"""GLB, the binary form of glTF 2.0: metres, Y up, the texture inside."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.images import encode_image
from engine.files.seams import split_at_seams
from engine.mesh import FloatArray, TriangleMesh
from engine.scan.range_image import ColourImage

GENERATOR = "Quasiface Studio"
METRES_PER_MM = 1e-3

_FLOAT, _UINT = 5126, 5125
_VERTEX_DATA, _INDEX_DATA = 34962, 34963
_LARGEST_SOURCE = 1 << 24


class _Buffer:
    """Collects the binary part and what the JSON says of it."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, data: bytes, target: int | None = None) -> int:
        self.data += bytes(-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.views.append(view if target is None else {**view, "target": target})
        self.data += data
        return len(self.views) - 1

    def accessor(self, values: NDArray[Any], kind: str, target: int, limits: bool = False) -> int:
        code = _FLOAT if values.dtype == np.float32 else _UINT
        accessor: dict[str, Any] = {
            "bufferView": self.view(values.tobytes(), target),
            "byteOffset": 0,
            "componentType": code,
            "count": len(values),
            "type": kind,
        }
        if limits:
            accessor |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


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
    if len(mesh.vertices) > _LARGEST_SOURCE:
        raise InputError("mesh", f"has {len(mesh.vertices)} vertices", f"{_LARGEST_SOURCE} can be numbered in a GLB")
    split = split_at_seams(mesh)
    buffer = _Buffer()
    positions = (mesh.vertices[split.source] * METRES_PER_MM).astype(np.float32)
    attributes = {"POSITION": buffer.accessor(positions, "VEC3", _VERTEX_DATA, limits=True)}
    if normals is not None:
        directions = unit_normals(normals, len(mesh.vertices))[split.source].astype(np.float32)
        attributes["NORMAL"] = buffer.accessor(directions, "VEC3", _VERTEX_DATA)
    if split.uv is not None:
        attributes["TEXCOORD_0"] = buffer.accessor(split.uv.astype(np.float32), "VEC2", _VERTEX_DATA)
    attributes["_SOURCE"] = buffer.accessor(split.source.astype(np.float32), "SCALAR", _VERTEX_DATA)
    indices = buffer.accessor(split.faces.astype(np.uint32).ravel(), "SCALAR", _INDEX_DATA)
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
        document |= _texture(buffer, material, mesh, texture, texture_format, name)
    document |= {"accessors": buffer.accessors, "bufferViews": buffer.views}
    buffer.data += bytes(-len(buffer.data) % 4)
    document["buffers"] = [{"byteLength": len(buffer.data)}]
    with atomic_write(path) as handle:
        for block in _container(document, bytes(buffer.data)):
            handle.write(block)


def unit_normals(normals: FloatArray, count: int) -> FloatArray:
    """Return ``count`` normals (N, 3) scaled to length 1; +Z where one is zero or not finite."""
    normals = np.asarray(normals, dtype=np.float64)
    if normals.shape != (count, 3):
        raise InputError("normals", f"have shape {normals.shape}", f"give one for each of the {count} vertices")
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    usable = np.isfinite(length) & (length > 1e-12)
    return np.where(usable, normals / np.where(usable, length, 1.0), [0.0, 0.0, 1.0])


def check_texture(mesh: TriangleMesh, texture: ColourImage) -> None:
    """Raise InputError when ``texture`` is no (H, W, 3) uint8 picture, or the mesh has nothing to place it with."""
    if mesh.uv is None:
        raise InputError("texture", "cannot be placed: the mesh has no texture coordinates", "leave the texture out")
    if texture.ndim != 3 or texture.shape[2] != 3 or texture.dtype != np.uint8 or texture.size == 0:
        raise InputError("texture", f"is {texture.dtype} of shape {texture.shape}", "give H x W x 3 bytes")


def _texture(
    buffer: _Buffer, material: dict[str, Any], mesh: TriangleMesh, texture: ColourImage, kind: str, name: str
) -> dict[str, Any]:
    check_texture(mesh, texture)
    if kind not in ("png", "jpeg"):
        raise InputError("texture_format", f"{kind!r} is not known", "choose png or jpeg")
    view = buffer.view(encode_image(texture, kind))
    material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    linear, linear_mipmap, clamp = 9729, 9987, 33071
    return {
        "images": [{"name": name, "bufferView": view, "mimeType": f"image/{kind}"}],
        "samplers": [{"magFilter": linear, "minFilter": linear_mipmap, "wrapS": clamp, "wrapT": clamp}],
        "textures": [{"name": name, "sampler": 0, "source": 0}],
    }


def _container(document: dict[str, Any], data: bytes) -> tuple[bytes, ...]:
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(data)
    if total >= 1 << 32:
        raise InputError("mesh", f"needs {total} bytes, more than a GLB can hold", "use a coarser mesh or texture")
    head = struct.pack("<4sII", b"glTF", 2, total)
    return head, struct.pack("<I4s", len(text), b"JSON"), text, struct.pack("<I4s", len(data), b"BIN\0"), data
