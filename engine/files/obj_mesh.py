"""Wavefront OBJ as it comes from photogrammetry and sculpting programs, with its materials."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.mesh_parts import MAX_FACES, MAX_VERTICES, RawMesh, byte_colours, check_counts, check_faces, fans
from engine.files.mtl import read_materials
from engine.files.textures import Material
from engine.mesh import FloatArray, IntArray

_BLOCK = 8 << 20
_LARGEST = 512 << 20
_MOST_CONTINUED = 1000
_LONGEST_LABEL = 200


@dataclass
class _Content:
    """What has been read so far, in pieces; ``faces`` are corners (vertex, texture coordinate) with -1 for none."""

    positions: list[FloatArray] = field(default_factory=list)
    shades: list[FloatArray] = field(default_factory=list)
    coordinates: list[FloatArray] = field(default_factory=list)
    corners: list[IntArray] = field(default_factory=list)
    materials: list[IntArray] = field(default_factory=list)
    vertices: int = 0
    shaded: int = 0
    places: int = 0
    triangles: int = 0
    thin: int = 0
    names: dict[str, int] = field(default_factory=dict)
    current: int = -1
    groups: list[IntArray] = field(default_factory=list)
    labels: dict[tuple[str, str, str], int] = field(default_factory=dict)
    label: tuple[str, str, str] = ("", "", "")
    libraries: list[str] = field(default_factory=list)


def read_obj_mesh(path: Path, pictures: bool = True) -> RawMesh:
    """Read an OBJ file: ``v`` (with colours), ``vt``, ``f`` with any of its forms, ``usemtl`` and ``mtllib``.

    Polygons are cut into fans; negative indices count back from where they stand; all else is passed over. Without
    ``pictures`` materials are not looked up.

    Raises
    ------
    InputError
        On lines that are no numbers, indices of nothing, or a mesh that is too large.
    """
    subject, content = str(path), _Content()
    if path.stat().st_size > _LARGEST:
        raise InputError(subject, f"has more than {_LARGEST >> 20} MB", "decimate it, or export it as PLY or GLB")
    with path.open("rb") as handle:
        for block in _blocks(handle, subject):
            _take(block, content, subject)
    vertices = _joined(content.positions, 3, np.float64)
    corners = _joined(content.corners, 6, np.int64).reshape(-1, 3, 2)
    faces, uv_faces = np.ascontiguousarray(corners[..., 0]), np.ascontiguousarray(corners[..., 1])
    check_faces(subject, faces, len(vertices))
    uv = _joined(content.coordinates, 2, np.float64)
    if len(uv_faces) and (uv_faces.max() >= len(uv) or uv_faces.min() < -1):
        raise InputError(f"{subject}, faces", f"an index is outside the {len(uv)} texture coordinates", "export again")
    notes = (f"{content.thin} faces of one or two corners were left out",) if content.thin else ()
    uv[:, 1] = 1.0 - uv[:, 1]
    colours = None
    if content.shaded == content.vertices and content.shaded:
        colours = byte_colours(_joined(content.shades, 3, np.float64))
    materials, files, more = read_materials(path, content.libraries if pictures else [], list(content.names))
    if colours is not None and all(material.texture is None for material in materials):
        materials = [Material()] * len(materials)
    face_material = np.concatenate(content.materials) if content.materials else np.zeros(0, dtype=np.int64)
    placed = len(uv) > 0 and bool((uv_faces >= 0).any())
    return RawMesh(
        vertices, faces, face_material, materials, uv if placed else None, uv_faces if placed else None, colours,
        notes=(*notes, *more), files=files,
        face_group=np.concatenate(content.groups) if content.groups else np.zeros(0, dtype=np.int64),
        group_names=tuple(" ".join(filter(None, label)) for label in content.labels),
    )  # fmt: skip


def _blocks(handle: BinaryIO, subject: str) -> Iterator[list[bytes]]:
    """Yield the lines of the file in blocks of some megabytes, continued lines joined."""
    kept = b""
    while fresh := handle.read(_BLOCK):
        data = kept + fresh
        end, continued = data.rfind(b"\n") + 1, 0
        while data[max(end - 3, 0) : end].rstrip(b"\r\n").endswith(b"\\"):
            end, continued = data.rfind(b"\n", 0, end - 1) + 1, continued + 1
            if continued > _MOST_CONTINUED:
                raise InputError(subject, f"continues a line over more than {_MOST_CONTINUED} lines", "export it again")
        if end <= 0 and len(data) > 2 * _BLOCK:
            raise InputError(subject, "has a line that is too long for text", "export it again")
        kept = data[end:]
        yield _lines(data[:end])
    yield _lines(kept)


def _lines(data: bytes) -> list[bytes]:
    if b"\\" in data:
        data = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    return data.replace(b"\t", b" ").split(b"\n")


def _take(lines: list[bytes], content: _Content, subject: str) -> None:
    lines = [line.lstrip() for line in lines]
    where_v = [k for k, line in enumerate(lines) if line[:2] == b"v "]
    where_t = [k for k, line in enumerate(lines) if line[:3] == b"vt "]
    where_f = [k for k, line in enumerate(lines) if line[:2] == b"f "]
    _take_vertices([lines[k] for k in where_v], content, subject)
    if where_t:
        content.coordinates.append(_table([lines[k] for k in where_t], 2, f"{subject}, vt")[:, :2])
        content.places += len(where_t)
    material, group = _take_materials(lines, content, where_f, subject)
    if where_f:
        before = (
            content.vertices - len(where_v) + np.searchsorted(where_v, where_f),
            content.places - len(where_t) + np.searchsorted(where_t, where_f),
        )
        _take_faces([lines[k] for k in where_f], before, (material, group), content, subject)
    check_counts(subject, content.vertices, content.triangles)
    if content.places > MAX_FACES * 3:
        raise InputError(subject, f"has {content.places} texture coordinates", "decimate it")


def _take_vertices(lines: list[bytes], content: _Content, subject: str) -> None:
    if not lines:
        return
    if content.vertices + len(lines) > MAX_VERTICES:
        check_counts(subject, content.vertices + len(lines), 0)
    table = _table(lines, 3, f"{subject}, v")
    content.positions.append(table[:, :3])
    content.vertices += len(table)
    if table.shape[1] >= 6:
        content.shades.append(table[:, 3:6] if table.shape[1] == 6 else table[:, 4:7])
        content.shaded += len(table)


def _table(lines: list[bytes], least: int, subject: str) -> FloatArray:
    """Return the numbers behind the first word of every line; as many columns as the shortest line has."""
    try:
        words = b" ".join(lines).split()
        columns, rest = divmod(len(words), len(lines))
        if rest == 0 and columns > least and words[::columns].count(words[0]) == len(lines):
            numbers = np.array(list(map(float, b" ".join(lines).replace(words[0] + b" ", b"").split())))
            if len(numbers) == len(lines) * (columns - 1):
                return numbers.reshape(len(lines), columns - 1)
        rows = [line.split()[1:] for line in lines]
        shortest = min(map(len, rows))
        if shortest < least:
            raise InputError(subject, f"a line has {shortest} numbers", "export it again")
        return np.array([list(map(float, row[:shortest])) for row in rows])
    except (ValueError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(subject, "a line holds something else than numbers", "export it again") from error


def _take_materials(
    lines: list[bytes], content: _Content, where_f: list[int], subject: str
) -> tuple[IntArray, IntArray]:
    """Return the material (f,) and the group (f,) of every face line, and remember the names."""
    where, which = [-1], [content.current]
    behind, labels = [-1], [content.labels.setdefault(content.label, len(content.labels))]
    for k, line in enumerate(lines):
        if line[:7] == b"usemtl ":
            name = line[7:].strip().decode("utf-8", "replace")
            content.current = content.names.setdefault(name, len(content.names))
            where.append(k)
            which.append(content.current)
            content.label = (name[:_LONGEST_LABEL], *content.label[1:])
        elif line[:2] in (b"g ", b"o "):
            name = line[2:].strip().decode("utf-8", "replace")[:_LONGEST_LABEL]
            material, group, thing = content.label
            content.label = (material, name, thing) if line[:1] == b"g" else (material, group, name)
        elif line[:7] == b"mtllib " and len(content.libraries) < 100:
            content.libraries.append(line[7:].strip().decode("utf-8", "replace"))
            continue
        else:
            continue
        behind.append(k)
        labels.append(content.labels.setdefault(content.label, len(content.labels)))
        if max(len(content.names), len(content.labels)) > 100_000:
            problem = f"names {len(content.names)} materials and {len(content.labels)} groups"
            raise InputError(subject, problem, "export it again")
    return (
        np.array(which)[np.searchsorted(where, where_f, side="right") - 1],
        np.array(labels)[np.searchsorted(behind, where_f, side="right") - 1],
    )


def _take_faces(
    lines: list[bytes],
    before: tuple[NDArray[Any], NDArray[Any]],
    of: tuple[IntArray, IntArray],
    content: _Content,
    subject: str,
) -> None:
    rows = [line.split() for line in lines]
    sizes = np.array([len(row) - 1 for row in rows])
    content.thin += int((sizes < 3).sum())
    words = [word for row in rows for word in row[1:]]
    try:
        corners = _corners(words)
    except (ValueError, OverflowError) as error:
        raise InputError(f"{subject}, f", "a line holds something else than indices", "export it again") from error
    if (corners[:, 0] == 0).any():
        raise InputError(f"{subject}, f", "an index is 0", "indices of OBJ begin at 1: export it again")
    for column, seen in enumerate(before):
        values = corners[:, column]
        back = values < 0
        values[back] += np.repeat(seen, sizes)[back]
        if (values[back] < 0).any():
            raise InputError(f"{subject}, f", "an index counts back beyond the first", "export it again")
        values[~back] -= 1
    triangles, polygon = fans(sizes)
    content.triangles += len(triangles)
    check_counts(subject, content.vertices, content.triangles)
    content.corners.append(corners[triangles].reshape(-1, 6))
    content.materials.append(of[0][polygon])
    content.groups.append(of[1][polygon])


def _corners(words: list[bytes]) -> IntArray:
    """Return (vertex, texture coordinate) as written, 0 for none; ``v``, ``v/t``, ``v/t/n`` and ``v//n``."""
    text = b" ".join(words)
    slashes, double = text.count(b"/"), text.count(b"//")
    first = words[0].count(b"/") if words else 0
    for share, skip, width in ((0, False, 1), (1, False, 2), (2, False, 3), (2, True, 2)):
        if first == share and slashes == share * len(words) and double == (len(words) if skip else 0):
            numbers = list(map(int, text.replace(b"/", b" ").split()))
            if len(numbers) == width * len(words):
                table = np.array(numbers, dtype=np.int64).reshape(-1, width)
                place = table[:, 1] if width > 1 and not skip else np.zeros(len(table), dtype=np.int64)
                return np.stack([table[:, 0], place], axis=1)
    parts = [word.split(b"/") for word in words]
    return np.array([[int(p[0]), int(p[1]) if len(p) > 1 and p[1] else 0] for p in parts], dtype=np.int64).reshape(
        -1, 2
    )


def _joined(pieces: list[NDArray[Any]], width: int, dtype: Any) -> NDArray[Any]:
    return np.concatenate(pieces).astype(dtype, copy=False) if pieces else np.zeros((0, width), dtype=dtype)
