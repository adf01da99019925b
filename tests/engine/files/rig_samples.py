"""Small rigs with everything a file can say of them, and GLBs that other programs would have written."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.mesh import TriangleMesh
from engine.shapes import ExpressionBasis, Rig
from tests.engine.files.mesh_samples import Glb, bumpy

NAMES = ("jawOpen", "smile left", "lid/Ä", "still", "whole")


def planted_rig(mean: bool = False, parts: bool = True, seed: int = 0) -> Rig:
    """Return a rig with a texture seam, parts in shuffled faces, a shape that stands still, local and global shapes."""
    rng = np.random.default_rng(seed)
    mesh = bumpy(9, 12)
    named = {}
    if parts:
        kind = rng.integers(0, 4, len(mesh.faces))
        named = {
            "skin": np.flatnonzero(kind <= 1),
            "eyes": np.flatnonzero(kind == 2),
            "lips": np.flatnonzero(kind == 1),
        }
    mesh = TriangleMesh(mesh.vertices, mesh.faces, mesh.uv, mesh.uv_faces, named)
    shapes = rng.normal(scale=3.0, size=(len(NAMES), len(mesh.vertices), 3))
    for k in range(3):
        shapes[k, rng.permutation(len(mesh.vertices))[10:]] = 0.0
    shapes[3] = 0.0
    offset = rng.normal(scale=0.5, size=mesh.vertices.shape) if mean else None
    return Rig(mesh, ExpressionBasis(mesh.vertices, NAMES, shapes, offset))


class MorphGlb(Glb):
    """Builds a GLB with morph targets piece by piece; positions in metres."""

    def triangle(self, targets: list[Any], shift: float = 0.0, **more: Any) -> dict[str, Any]:
        """Return a primitive of two triangles whose ``targets`` are displacements (4, 3), accessors, or None."""
        points = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0.2, 0.2, 0.1]], "<f4") + np.float32(shift)
        position = self.accessor(points.astype("<f4"), "VEC3", 5126)
        indices = self.accessor(np.array([0, 1, 2, 1, 3, 2], "<u2"), "SCALAR", 5123)
        made = []
        for target in targets:
            if target is None:
                made.append({})
            else:
                number = target if isinstance(target, int) else self.accessor(np.asarray(target, "<f4"), "VEC3", 5126)
                made.append({"POSITION": number})
        return {"attributes": {"POSITION": position}, "indices": indices, "targets": made, **more}

    def sparse(self, count: int, places: list[int], values: Any, base: int | None = None, offsets: bool = True) -> int:
        """Add a sparse accessor of ``count`` vectors, over a buffer view or over zeros."""
        at, of = self.view(np.array(places, "<u2").tobytes()), self.view(np.asarray(values, "<f4").tobytes())
        zero = {"byteOffset": 0} if offsets else {}
        entry: dict[str, Any] = {"componentType": 5126, "count": count, "type": "VEC3"}
        entry["sparse"] = {
            "count": len(places),
            "indices": {"bufferView": at, "componentType": 5123, **zero},
            "values": {"bufferView": of, **zero},
        }
        if base is not None:
            entry["bufferView"] = base
        self.document["accessors"].append(entry)
        return len(self.document["accessors"]) - 1

    def meshes(self, *meshes: dict[str, Any], nodes: list[dict[str, Any]] | None = None) -> MorphGlb:
        """Set the meshes, one node each where none are given."""
        self.document["meshes"] = list(meshes)
        self.document["nodes"] = nodes or [{"mesh": k} for k in range(len(meshes))]
        return self
