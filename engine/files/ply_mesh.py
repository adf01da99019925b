"""PLY as a mesh: text or binary of either byte order, with colours or a texture named in a comment."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.mesh_parts import MAX_FACES, RawMesh, byte_colours, check_counts, check_faces, fans
from engine.files.ply_header import PlyElement, PlyHeader, read_ply_header
from engine.files.scan_file import MM_PER_UNIT
from engine.files.source import beside, checked_file
from engine.files.textures import MAX_TEXTURE_PIXELS, Material, read_texture
from engine.mesh import FloatArray, IntArray

_LARGEST = 512 << 20
_INDICES = ("vertex_indices", "vertex_index")
_COLOURS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
_PLACES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
_MOST_PICTURES = 64


@dataclass(frozen=True)
class _Lists:
    """A list property of many rows: how long each is, and all values one behind the other."""

    sizes: IntArray
    values: NDArray[Any]


_Table = dict[str, "NDArray[Any] | _Lists"]


def is_ply_mesh(path: Path) -> bool:
    """Whether a PLY file has faces and says nothing of rows and columns or a range grid, so that it is no scan.

    Raises
    ------
    InputError
        When its header cannot be read.
    """
    path = checked_file(path)
    with path.open("rb") as handle:
        header = read_ply_header(handle, str(path))
    names = {element.name for element in header.elements if element.count}
    return "face" in names and "range_grid" not in names and not {"num_cols", "num_rows"} & set(header.info)


def read_ply_mesh(path: Path) -> RawMesh:
    """Read the vertices and faces of a PLY file.

    Colours are ``red green blue`` of the vertices; texture coordinates either ``s t``, ``u v`` or ``texture_u
    texture_v`` of the vertices or the list ``texcoord`` of the faces, with the pictures that ``comment TextureFile``
    names. ``obj_info unit`` or ``comment unit`` is the file's word for its unit.

    Raises
    ------
    InputError
        On damaged headers, counts that the file does not bear out, or indices of nothing.
    """
    subject = str(path)
    if path.stat().st_size > _LARGEST:
        raise InputError(subject, f"has more than {_LARGEST >> 20} MB", "decimate it")
    with path.open("rb") as handle:
        header = read_ply_header(handle, subject)
        tables = _tables(path, handle, header)
    vertex, face = tables["vertex"], tables["face"]
    vertices = np.column_stack([_column(vertex, axis, subject) for axis in "xyz"])
    polygons = next((face[name] for name in _INDICES if isinstance(face.get(name), _Lists)), None)
    if not isinstance(polygons, _Lists):
        raise InputError(f"{subject}, face", "has no list of vertex_indices", "export it again")
    corners, polygon = fans(polygons.sizes)
    check_counts(subject, len(vertices), len(corners))
    indices = polygons.values.astype(np.int64)
    faces = indices[corners]
    check_faces(subject, faces, len(vertices))
    notes: list[str] = []
    thin = int((polygons.sizes < 3).sum())
    if thin:
        notes.append(f"{thin} faces of one or two corners were left out")
    materials, files = _pictures(path, header, notes)
    uv, uv_faces = _places(vertex, face, polygons, corners, faces, notes)
    which = face.get("texnumber")
    if isinstance(which, np.ndarray) and materials:
        numbers = which.astype(np.float64)[polygon]
        known = (numbers >= 0) & (numbers < len(materials))
        face_material = np.where(known, numbers, -1).astype(np.int64)
    else:
        face_material = np.full(len(faces), 0 if materials else -1)
    colours = next((_stack(vertex, names) for names in _COLOURS if set(names) <= set(vertex)), None)
    return RawMesh(
        vertices, faces, face_material, materials, uv, uv_faces, None if colours is None else byte_colours(colours),
        _unit(header), tuple(notes), files,
    )  # fmt: skip


def _unit(header: PlyHeader) -> str | None:
    comments = [comment.split() for comment in header.comments]
    word = header.info.get("unit") or next((w[1] for w in comments if len(w) == 2 and w[0].lower() == "unit"), None)
    return word if word in MM_PER_UNIT else None


def _stack(table: _Table, names: tuple[str, ...]) -> FloatArray | None:
    columns = [table[name] for name in names]
    if any(isinstance(column, _Lists) for column in columns):
        return None
    return np.column_stack([np.asarray(column, dtype=np.float64) for column in columns])


def _column(table: _Table, name: str, subject: str) -> FloatArray:
    column = table.get(name)
    if column is None or isinstance(column, _Lists):
        raise InputError(f"{subject}, vertex", f"has no {name}", "export it again")
    with np.errstate(invalid="ignore", over="ignore"):
        return column.astype(np.float64)


def _places(
    vertex: _Table, face: _Table, polygons: _Lists, corners: IntArray, faces: IntArray, notes: list[str]
) -> tuple[FloatArray | None, IntArray | None]:
    uv: FloatArray | None = None
    uv_faces = faces
    own = face.get("texcoord")
    if isinstance(own, _Lists):
        if np.array_equal(own.sizes, 2 * polygons.sizes):
            uv, uv_faces = own.values.reshape(-1, 2).astype(np.float64), corners
        else:
            notes.append("its texcoord lists do not fit the faces: left out")
    if uv is None:
        names = next((names for names in _PLACES if set(names) <= set(vertex)), None)
        uv = None if names is None else _stack(vertex, names)
    if uv is None:
        return None, None
    uv = np.where(np.isfinite(uv).all(axis=1, keepdims=True), uv, 0.0)
    return np.column_stack([uv[:, 0], 1.0 - uv[:, 1]]), uv_faces


def _pictures(path: Path, header: PlyHeader, notes: list[str]) -> tuple[list[Material], tuple[Path, ...]]:
    names = [comment.split(None, 1)[1] for comment in header.comments if comment.lower().startswith("texturefile ")]
    materials, files = [], []
    for name in names[:_MOST_PICTURES]:
        try:
            file = beside(path, name.strip().strip('"').replace("\\", "/"), "TextureFile")
            materials.append(Material(read_texture(file)))
            files.append(file)
        except InputError as error:
            notes.append(f"TextureFile {name[:80]!r} {error.problem}: left out")
            materials.append(Material())
    pixels = sum(material.texture.size // 3 for material in materials if material.texture is not None)
    if pixels > MAX_TEXTURE_PIXELS:
        raise InputError(str(path), f"its textures have {pixels} pixels together", "scale them down")
    return materials, tuple(files)


# -- the elements -------------------------------------------------------------------------------------------------


def _tables(path: Path, handle: BinaryIO, header: PlyHeader) -> dict[str, _Table]:
    subject = str(path)
    names = [element.name for element in header.elements]
    for needed in ("vertex", "face"):
        if needed not in names:
            raise InputError(subject, f"has no element {needed}", "export it as a mesh")
    last = max(names.index("vertex"), names.index("face"))
    tables: dict[str, _Table] = {}
    left = path.stat().st_size - handle.tell()
    for element in header.elements[: last + 1]:
        check_counts(subject, element.count if element.name == "vertex" else 0, 0)
        if element.count > 4 * MAX_FACES:
            raise InputError(subject, f"has {element.count} rows of {element.name[:40]}", "decimate it")
        least = element.count * (_least(element, header.order))
        if least > left:
            problem = f"is cut off: {element.count} rows of {element.name[:40]} need {least} bytes, {left} are there"
            raise InputError(subject, problem, "export it again")
    data = handle.read()
    if header.order:
        place = 0
        for element in header.elements[: last + 1]:
            tables[element.name], place = _binary(data, place, element, header.order, subject)
    else:
        words, place = data.split(), 0
        for element in header.elements[: last + 1]:
            tables[element.name], place = _text(words, place, element, subject)
    return tables


def _least(element: PlyElement, order: str) -> int:
    """Return the fewest bytes of a row."""
    if not order:
        return 2 * len(element.properties)
    return sum(np.dtype(item.length_type or item.type).itemsize for item in element.properties)


def _binary(data: bytes, start: int, element: PlyElement, order: str, subject: str) -> tuple[_Table, int]:
    if element.count == 0:
        return _split(element, {}, 0), start
    lengths = _row_lengths(data, start, element, order, subject)
    fields: list[Any] = []
    for item, length in zip(element.properties, lengths, strict=True):
        if item.length_type is not None:
            fields.append((f"n {item.name}", order + item.length_type))
        fields.append((item.name, order + item.type, (length,)) if item.length_type else (item.name, order + item.type))
    row = np.dtype(fields)
    stop = start + element.count * row.itemsize
    if stop <= len(data):
        table = np.frombuffer(data, row, element.count, start)
        lists = [(item, n) for item, n in zip(element.properties, lengths, strict=True) if item.length_type]
        if all((table[f"n {item.name}"] == n).all() for item, n in lists):
            return _split(element, {name: table[name] for name in element.names}, element.count), stop
    return _ragged(data, start, element, order, subject)


def _row_lengths(data: bytes, place: int, element: PlyElement, order: str, subject: str) -> list[int]:
    """Return the list lengths of the row at ``place``, 1 for what is no list."""
    lengths = []
    for item in element.properties:
        size, count = np.dtype(item.type).itemsize, 1
        if item.length_type is not None:
            step = np.dtype(item.length_type).itemsize
            if place + step > len(data):
                raise _cut_off(element, subject)
            count = int(np.frombuffer(data, order + item.length_type, 1, place)[0])
            place += step
        if count < 0 or place + count * size > len(data):
            raise _cut_off(element, subject)
        place += count * size
        lengths.append(count)
    return lengths


def _ragged(data: bytes, place: int, element: PlyElement, order: str, subject: str) -> tuple[_Table, int]:
    """Read rows of differing lengths one after the other."""
    plans = [
        (None if i.length_type is None else struct.Struct(order + _CODES[i.length_type]), np.dtype(i.type).itemsize)
        for i in element.properties
    ]
    starts: list[list[int]] = [[] for _ in plans]
    sizes: list[list[int]] = [[] for _ in plans]
    end = len(data)
    for _ in range(element.count):
        for (length, size), where, count in zip(plans, starts, sizes, strict=True):
            number = 1
            if length is not None:
                if place + length.size > end:
                    raise _cut_off(element, subject)
                (number,) = length.unpack_from(data, place)
                place += length.size
            if number < 0 or place + number * size > end:
                raise _cut_off(element, subject)
            where.append(place)
            count.append(number)
            place += number * size
    raw = np.frombuffer(data, np.uint8)
    columns: _Table = {}
    for item, where, count in zip(element.properties, starts, sizes, strict=True):
        width, kind = np.dtype(item.type).itemsize, np.dtype(order + item.type)
        many = np.array(count, dtype=np.int64)
        offset = np.repeat(np.array(where, dtype=np.int64) - width * (np.cumsum(many) - many), many)
        first = offset + width * np.arange(len(offset))
        values = raw[first[:, None] + np.arange(width)].reshape(-1).view(kind)
        columns[item.name] = values if item.length_type is None else _Lists(many, values)
    return columns, place


_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}


def _text(words: list[bytes], place: int, element: PlyElement, subject: str) -> tuple[_Table, int]:
    if element.count == 0:
        return _split(element, {}, 0), place
    try:
        lengths, first = [], place
        for item in element.properties:
            count = 1
            if item.length_type is not None:
                count, first = int(words[first]), first + 1
            if count < 0:
                raise ValueError
            lengths.append(count)
            first += count
        width = first - place
        stop = place + element.count * width
        if stop <= len(words):
            table = np.array(list(map(float, words[place:stop]))).reshape(element.count, width)
            columns, column, even = {}, 0, True
            for item, count in zip(element.properties, lengths, strict=True):
                if item.length_type is not None:
                    even &= bool((table[:, column] == count).all())
                    column += 1
                columns[item.name] = table[:, column : column + count]
                if item.length_type is None:
                    columns[item.name] = table[:, column]
                column += count
            if even:
                return _split(element, columns, element.count), stop
        return _ragged_text(words, place, element)
    except (ValueError, IndexError, OverflowError) as error:
        raise InputError(
            subject, f"its {element.name[:40]} rows are no numbers or cut off", "export it again"
        ) from error


def _ragged_text(words: list[bytes], place: int, element: PlyElement) -> tuple[_Table, int]:
    values: list[list[float]] = [[] for _ in element.properties]
    sizes: list[list[int]] = [[] for _ in element.properties]
    for _ in range(element.count):
        for item, kept, count in zip(element.properties, values, sizes, strict=True):
            number = 1
            if item.length_type is not None:
                number, place = int(words[place]), place + 1
            if number < 0 or place + number > len(words):
                raise ValueError
            kept.extend(map(float, words[place : place + number]))
            count.append(number)
            place += number
    columns: _Table = {}
    for item, kept, count in zip(element.properties, values, sizes, strict=True):
        array = np.array(kept)
        columns[item.name] = array if item.length_type is None else _Lists(np.array(count, dtype=np.int64), array)
    return columns, place


def _split(element: PlyElement, columns: dict[str, NDArray[Any]], count: int) -> _Table:
    """Return equal lists as ``_Lists`` and the rest as it is."""
    result: _Table = {}
    for item in element.properties:
        column = columns.get(item.name, np.zeros(0))
        if item.length_type is None:
            result[item.name] = column
        else:
            sizes = np.full(count, column.shape[1] if column.ndim == 2 else 0, dtype=np.int64)
            result[item.name] = _Lists(sizes, column.reshape(-1))
    return result


def _cut_off(element: PlyElement, subject: str) -> InputError:
    return InputError(subject, f"is cut off in its {element.name[:40]} rows", "export it again")
