"""Small meshes with everything a file can say of them, and their files, written by our writers and by trimesh."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from engine.mesh import TriangleMesh


def bumpy(rings: int = 12, spokes: int = 16, size: float = 120.0, seed: int = 0) -> TriangleMesh:
    """Return a closed, uneven ball with a texture seam, mm."""
    rng = np.random.default_rng(seed)
    v, u = np.meshgrid(np.linspace(0.02, 0.98, rings), np.linspace(0, 1, spokes + 1), indexing="ij")
    radius = size * (1 + 0.1 * np.sin(7 * u * 2 * np.pi) * np.sin(5 * v))
    polar, turn = v * np.pi, u * 2 * np.pi
    points = np.stack(
        [radius * np.sin(polar) * np.cos(turn), radius * np.cos(polar), radius * np.sin(polar) * np.sin(turn)], axis=2
    )
    points[:, -1] = points[:, 0]
    flat = points[:, :-1].reshape(-1, 3) + rng.normal(scale=0.3, size=((rings) * spokes, 3))
    faces, uv_faces = [], []
    for i in range(rings - 1):
        for j in range(spokes):
            a, b = i * spokes + j, i * spokes + (j + 1) % spokes
            c, d = a + spokes, b + spokes
            p, q = i * (spokes + 1) + j, (i + 1) * (spokes + 1) + j
            faces += [(a, b, c), (b, d, c)]
            uv_faces += [(p, p + 1, q), (p + 1, q + 1, q)]
    uv = np.stack([u, v], axis=2).reshape(-1, 2)
    return TriangleMesh(flat, faces, uv, uv_faces)


def checks(width: int = 64, height: int = 48) -> np.ndarray:
    """Return a picture whose red grows to the right and green downwards."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    return np.stack([x * 255 // (width - 1), y * 255 // (height - 1), 40 + 0 * x], axis=2).astype(np.uint8)


def corners(mesh: TriangleMesh) -> np.ndarray:
    """Return positions (F, 3, 3) of all corners."""
    return mesh.vertices[mesh.faces]


def uv_corners(mesh: TriangleMesh) -> np.ndarray:
    """Return texture coordinates (F, 3, 2) of all corners."""
    assert mesh.uv is not None
    return mesh.uv[mesh.uv_faces]


class Glb:
    """Builds a GLB piece by piece."""

    def __init__(self) -> None:
        self.data = b""
        self.document: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}

    def view(self, data: bytes, **more: Any) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        self.document["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more}
        )
        self.data += data
        return len(self.document["bufferViews"]) - 1

    def accessor(self, values: np.ndarray, kind: str, code: int, **more: Any) -> int:
        entry = {"bufferView": self.view(values.tobytes()), "componentType": code, "count": len(values), "type": kind}
        self.document["accessors"].append(entry | more)
        return len(self.document["accessors"]) - 1

    def save(self, path: Path) -> Path:
        self.document["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        total = 12 + 8 + len(text) + 8 + len(data)
        path.write_bytes(
            struct.pack("<4sIII4s", b"glTF", 2, total, len(text), b"JSON")
            + text
            + struct.pack("<I4s", len(data), b"BIN\0")
            + data
        )
        return path
