"""What GLB files are put together from: buffer views and accessors, pictures, and the container."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.images import encode_image
from engine.mesh import FloatArray, TriangleMesh
from engine.scan.range_image import ColourImage

GENERATOR = "Quasiface Studio"
METRES_PER_MM = 1e-3
VERTEX_DATA, INDEX_DATA = 34962, 34963
LARGEST_SOURCE = 1 << 24
"""Vertices whose numbers a float32 attribute can hold."""

_CODES = {"float32": 5126, "uint32": 5125, "uint16": 5123}


class GlbBuffer:
    """Collects the binary part and what the JSON says of it."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self._zeros: dict[int, int] = {}

    def view(self, data: bytes, target: int | None = None) -> int:
        """Add bytes, aligned to 4; return the number of their buffer view."""
        self.data += bytes(-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.views.append(view if target is None else {**view, "target": target})
        self.data += data
        return len(self.views) - 1

    def accessor(self, values: NDArray[Any], kind: str, target: int | None = None, limits: bool = False) -> int:
        """Add an array of float32, uint32 or uint16; return the number of its accessor."""
        accessor: dict[str, Any] = {
            "bufferView": self.view(values.tobytes(), target),
            "byteOffset": 0,
            "componentType": _CODES[values.dtype.name],
            "count": len(values),
            "type": kind,
        }
        return self._added(accessor, values, limits)

    def displacement(self, values: NDArray[np.float32], limits: bool = True) -> int:
        """Add vectors (N, 3), sparse where that is shorter; return the number of the accessor.

        A sparse accessor changes a view of zeros, which all of one length share: it may be left out, as the
        ``byteOffset`` entries may that are 0, but some readers (VTK's) do not do without them.
        """
        moved = np.flatnonzero(values.any(axis=1))
        numbers = np.uint16 if len(values) <= 1 << 16 else np.uint32
        if len(moved) * (12 + numbers().itemsize) + 100 >= 12 * len(values):
            return self.accessor(values, "VEC3", VERTEX_DATA, limits)
        # A sparse part must name at least one vertex, even where none moves.
        moved = moved if len(moved) else np.zeros(1, dtype=np.int64)
        indices = {"bufferView": self.view(moved.astype(numbers).tobytes()), "byteOffset": 0}
        if len(values) not in self._zeros:
            self._zeros[len(values)] = self.view(bytes(values.nbytes), VERTEX_DATA)
            self.views[-1]["byteStride"] = 12
        accessor: dict[str, Any] = {
            "bufferView": self._zeros[len(values)],
            "byteOffset": 0,
            "componentType": _CODES["float32"],
            "count": len(values),
            "type": "VEC3",
            "sparse": {
                "count": len(moved),
                "indices": {**indices, "componentType": _CODES[np.dtype(numbers).name]},
                "values": {"bufferView": self.view(values[moved].tobytes()), "byteOffset": 0},
            },
        }
        return self._added(accessor, values, limits)

    def save(self, path: str | Path, document: dict[str, Any]) -> None:
        """Write the container: ``document`` with what was collected, and the binary part."""
        self.data += bytes(-len(self.data) % 4)
        document = {
            **document,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.data)}],
        }
        with atomic_write(path) as handle:
            for block in _container(document, self.data):
                handle.write(block)

    def _added(self, accessor: dict[str, Any], values: NDArray[Any], limits: bool) -> int:
        if limits:
            rows = values.reshape(len(values), -1)
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


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


def texture_objects(
    buffer: GlbBuffer, mesh: TriangleMesh, texture: ColourImage, kind: str, name: str
) -> dict[str, Any]:
    """Return image, sampler and texture 0 of the document; raise InputError where the mesh cannot carry it."""
    check_texture(mesh, texture)
    if kind not in ("png", "jpeg"):
        raise InputError("texture_format", f"{kind!r} is not known", "choose png or jpeg")
    view = buffer.view(encode_image(texture, kind))
    linear, linear_mipmap, clamp = 9729, 9987, 33071
    return {
        "images": [{"name": name, "bufferView": view, "mimeType": f"image/{kind}"}],
        "samplers": [{"magFilter": linear, "minFilter": linear_mipmap, "wrapS": clamp, "wrapT": clamp}],
        "textures": [{"name": name, "sampler": 0, "source": 0}],
    }


def _container(document: dict[str, Any], data: bytearray) -> tuple[bytes | bytearray, ...]:
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(data)
    if total >= 1 << 32:
        raise InputError("mesh", f"needs {total} bytes, more than a GLB can hold", "use a coarser mesh or texture")
    head = struct.pack("<4sII", b"glTF", 2, total)
    return head, struct.pack("<I4s", len(text), b"JSON"), text, struct.pack("<I4s", len(data), b"BIN\0"), data
