"""The triangle mesh that every stage passes on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def frozen(array: Any, dtype: Any) -> NDArray[Any]:
    """Return a read-only, contiguous array of ``dtype``; copies when the input can still be written to."""
    result = np.ascontiguousarray(array, dtype=dtype)
    if result.flags.writeable:
        result = result.copy() if result is array or result.base is not None else result
        result.flags.writeable = False
    return result


@dataclass(frozen=True)
class TriangleMesh:
    """Triangles in space, with an optional texture chart and named parts.

    Parameters
    ----------
    vertices : (N, 3) float
        Positions in mm.
    faces : (F, 3) int
        Vertex indices, counter-clockwise seen from outside.
    uv : (U, 2) float, optional
        Texture coordinates, origin at the **top left** of the image, u = (x + 0.5) / W.
    uv_faces : (F, 3) int, optional
        Indices into ``uv`` per face corner; ``faces`` themselves where U = N and it is left out.
    parts : mapping of str to (P,) int, optional
        Face indices of named parts (skin, eyes, teeth, tongue).

    Raises
    ------
    InputError
        On wrong shapes, indices outside their array, or positions that are not finite.
    """

    vertices: FloatArray
    faces: IntArray
    uv: FloatArray | None = None
    uv_faces: IntArray | None = None
    parts: Mapping[str, IntArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        vertices, faces = frozen(self.vertices, np.float64), frozen(self.faces, np.int64)
        _check_table("vertices", vertices, 3)
        _check_indices("faces", faces, len(vertices))
        if not np.isfinite(vertices).all():
            bad = int((~np.isfinite(vertices)).any(axis=1).sum())
            raise InputError("vertices", f"{bad} positions are not finite", "remove them first")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)
        if self.uv is not None:
            uv = frozen(self.uv, np.float64)
            _check_table("uv", uv, 2)
            uv_faces = faces if self.uv_faces is None else frozen(self.uv_faces, np.int64)
            _check_indices("uv_faces", uv_faces, len(uv))
            if uv_faces.shape != faces.shape:
                raise InputError("uv_faces", f"{len(uv_faces)} rows for {len(faces)} faces", "give one row a face")
            object.__setattr__(self, "uv", uv)
            object.__setattr__(self, "uv_faces", uv_faces)
        elif self.uv_faces is not None:
            raise InputError("uv_faces", "given without uv", "give both or neither")
        parts = {}
        for name, indices in (self.parts or {}).items():
            part = frozen(indices, np.int64).reshape(-1)
            if len(part) and (part.min() < 0 or part.max() >= len(faces)):
                raise InputError(f"parts[{name}]", "a face index is outside the mesh", "check the part's faces")
            parts[str(name)] = part
        object.__setattr__(self, "parts", MappingProxyType(parts))

    def __reduce__(self) -> tuple[type[TriangleMesh], tuple[Any, ...]]:
        # Sent to another process it is made anew: checked and read-only again; a read-only mapping cannot be sent.
        return TriangleMesh, (self.vertices, self.faces, self.uv, self.uv_faces, dict(self.parts))

    def with_vertices(self, vertices: Any) -> TriangleMesh:
        """Return the same faces, chart and parts at other positions (N, 3), mm."""
        return TriangleMesh(vertices, self.faces, self.uv, self.uv_faces if self.uv is not None else None, self.parts)


def _check_table(name: str, array: NDArray[Any], width: int) -> None:
    if array.ndim != 2 or array.shape[1] != width:
        raise InputError(name, f"has shape {array.shape}", f"give one row of {width} numbers each")


def _check_indices(name: str, array: NDArray[Any], count: int) -> None:
    _check_table(name, array, 3)
    if len(array) and (array.min() < 0 or array.max() >= count):
        raise InputError(name, f"an index is outside 0..{count - 1}", "check the indices (they start at 0)")
