"""The binary side of a GLB: its two chunks, and accessors checked against the bytes that are there."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.source import read_bytes

_LARGEST = 512 << 20
_MAX_JSON = 32 << 20
_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_MOST_VALUES = 64_000_000
"""Most numbers of all accessors together, one that is read twice counted twice: 3 million vertices have 36 million."""


class GltfData:
    """The document of a GLB file and its binary part; every access says what is wrong by the path in the document."""

    def __init__(self, path: Path) -> None:
        self.path = path
        data = read_bytes(path, _LARGEST)
        self.document, self._binary = _chunks(data, str(path))
        self._decoded = 0

    def wrong(self, where: str, problem: str, remedy: str = "export it again") -> InputError:
        """Return the error for a place in the document."""
        return InputError(f"{self.path}, {where}" if where else str(self.path), problem, remedy)

    def items(self, key: str) -> list[Any]:
        """Return a list of the document; empty where it is missing."""
        value = self.document.get(key, [])
        if not isinstance(value, list) or len(value) > 200_000:
            raise self.wrong(key, "is no list that can be read")
        return value

    def item(self, key: str, index: Any) -> dict[str, Any]:
        """Return one object of a list of the document."""
        items = self.items(key)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(items):
            raise self.wrong(key, f"there is no number {str(index)[:20]}")
        if not isinstance(items[index], dict):
            raise self.wrong(f"{key}[{index}]", "is no object")
        found: dict[str, Any] = items[index]
        return found

    def number(self, value: Any, where: str, default: int | None = None) -> int:
        """Return a non-negative whole number below 2^32."""
        if value is None and default is not None:
            return default
        if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 1 << 32:
            raise self.wrong(where, f"{str(value)[:40]!r} is not a count")
        return value

    def view(self, index: Any) -> tuple[memoryview, int | None]:
        """Return the bytes of a buffer view and its stride."""
        where = f"bufferViews[{index}]"
        view = self.item("bufferViews", index)
        if self.number(view.get("buffer"), f"{where}.buffer") != 0 or "uri" in self.item("buffers", 0):
            raise self.wrong(where, "lies in another file", "export with all data embedded (GLB)")
        start = self.number(view.get("byteOffset"), f"{where}.byteOffset", 0)
        length = self.number(view.get("byteLength"), f"{where}.byteLength")
        if start + length > len(self._binary):
            raise self.wrong(where, f"needs {start + length} bytes, {len(self._binary)} are there")
        stride = view.get("byteStride")
        if stride is not None and not 4 <= self.number(stride, f"{where}.byteStride") <= 252:
            raise self.wrong(f"{where}.byteStride", f"is {stride}")
        return self._binary[start : start + length], stride

    def accessor(self, index: Any, kinds: tuple[str, ...]) -> tuple[NDArray[Any], bool]:
        """Return the values (count, width) of an accessor of one of ``kinds``, and whether they are normalised.

        Sparse accessors are filled in.
        """
        where = f"accessors[{index}]"
        accessor = self.item("accessors", index)
        kind, code = accessor.get("type"), accessor.get("componentType")
        if kind not in kinds or kind not in _WIDTHS or not isinstance(code, int) or code not in _TYPES:
            raise self.wrong(where, f"is {str(kind)[:20]} of {str(code)[:20]}")
        dtype, width = np.dtype(_TYPES[code]), _WIDTHS[kind]
        count = self.number(accessor.get("count"), f"{where}.count")
        self._decoded += count * width
        if self._decoded > _MOST_VALUES:
            problem = f"with its {count} values more than {_MOST_VALUES // 1_000_000} million are used"
            raise self.wrong(where, problem, "decimate the mesh")
        start = self.number(accessor.get("byteOffset"), f"{where}.byteOffset", 0)
        sparse = accessor.get("sparse")
        if "bufferView" in accessor:
            values = self._values(accessor["bufferView"], start, dtype, width, count, where)
        else:
            # Without a view all values are zero but for sparse ones: no more of them than the file could name.
            if count > len(self._binary):
                raise self.wrong(where, f"has {count} values that are nowhere")
            values = np.zeros((count, width), dtype)
        if sparse is not None:
            values = self._with_sparse(values, sparse, f"{where}.sparse")
        return values, accessor.get("normalized") is True

    def _values(self, view: Any, start: int, dtype: np.dtype[Any], width: int, count: int, where: str) -> NDArray[Any]:
        data, stride = self.view(view)
        size = dtype.itemsize * width
        step = stride or size
        if count and (step < size or start + (count - 1) * step + size > len(data)):
            raise self.wrong(where, f"needs {start + count * step} bytes, its view has {len(data)}")
        if not count:
            return np.zeros((0, width), dtype)
        return np.ndarray((count, width), dtype, data, start, (step, dtype.itemsize)).copy()

    def _with_sparse(self, values: NDArray[Any], sparse: Any, where: str) -> NDArray[Any]:
        if not isinstance(sparse, dict) or not all(isinstance(sparse.get(k), dict) for k in ("indices", "values")):
            raise self.wrong(where, "is no sparse part")
        count = self.number(sparse.get("count"), f"{where}.count")
        code = sparse["indices"].get("componentType")
        if not isinstance(code, int) or code not in (5121, 5123, 5125):
            raise self.wrong(f"{where}.indices", f"is of {str(code)[:20]}")
        parts = []
        for part, dtype, width in (
            (sparse["indices"], np.dtype(_TYPES[code]), 1),
            (sparse["values"], values.dtype, values.shape[1]),
        ):
            start = self.number(part.get("byteOffset"), f"{where}.byteOffset", 0)
            parts.append(self._values(part.get("bufferView"), start, dtype, width, count, where))
        places = parts[0][:, 0].astype(np.int64)
        if len(places) and places.max() >= len(values):
            raise self.wrong(f"{where}.indices", "an index is outside the accessor")
        values[places] = parts[1]
        return values


def _chunks(data: bytes, subject: str) -> tuple[dict[str, Any], memoryview]:
    if len(data) < 20 or data[:4] != b"glTF":
        raise InputError(subject, "does not begin like a GLB file", "export it as GLB, not as .gltf")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise InputError(subject, f"is glTF version {version}", "export it as glTF 2.0")
    if length > len(data):
        raise InputError(subject, f"is cut off: {length} bytes are announced, {len(data)} are there", "export it again")
    size, kind = struct.unpack_from("<I4s", data, 12)
    if kind != b"JSON" or 20 + size > length or size > _MAX_JSON:
        raise InputError(subject, "its first chunk is not the document", "export it again")
    try:
        document = json.loads(data[20 : 20 + size].decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(subject, "its document is no JSON that can be read", "export it again") from error
    if not isinstance(document, dict):
        raise InputError(subject, "its document is no JSON object", "export it again")
    place, binary = 20 + size, memoryview(b"")
    if place + 8 <= length:
        size, kind = struct.unpack_from("<I4s", data, place)
        if place + 8 + size > length:
            raise InputError(subject, "is cut off in its binary part", "export it again")
        if kind == b"BIN\0":
            binary = memoryview(data)[place + 8 : place + 8 + size]
    return document, binary
