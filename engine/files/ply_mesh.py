"""PLY as a mesh: text or binary of either byte order, with colours or a texture named in a comment."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.mesh_parts import RawMesh, byte_colours, check_counts, check_faces, fans
from engine.files.ply_header import PlyHeader, read_ply_header
from engine.files.ply_rows import PlyLists, PlyTable, ply_tables
from engine.files.scan_file import MM_PER_UNIT
from engine.files.source import beside, checked_file
from engine.files.textures import Material, PictureBudget
from engine.mesh import FloatArray, IntArray

_LARGEST = 512 << 20
_INDICES = ("vertex_indices", "vertex_index")
_COLOURS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
_PLACES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
_WANTED = frozenset(
    ["x", "y", "z", "texcoord", "texnumber", *_INDICES, *(name for names in (*_COLOURS, *_PLACES) for name in names)]
)
_MOST_PICTURES = 64


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
        tables = ply_tables(path, handle, header, _WANTED)
    vertex, face = tables["vertex"], tables["face"]
    vertices = np.column_stack([_column(vertex, axis, subject) for axis in "xyz"])
    polygons = next((face[name] for name in _INDICES if isinstance(face.get(name), PlyLists)), None)
    if not isinstance(polygons, PlyLists):
        raise InputError(f"{subject}, face", "has no list of vertex_indices", "export it again")
    check_counts(subject, len(vertices), int(np.maximum(polygons.sizes - 2, 0).sum()))
    corners, polygon = fans(polygons.sizes)
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


def _stack(table: PlyTable, names: tuple[str, ...]) -> FloatArray | None:
    columns = [table[name] for name in names]
    if any(isinstance(column, PlyLists) for column in columns):
        return None
    return np.column_stack([np.asarray(column, dtype=np.float64) for column in columns])


def _column(table: PlyTable, name: str, subject: str) -> FloatArray:
    column = table.get(name)
    if column is None or isinstance(column, PlyLists):
        raise InputError(f"{subject}, vertex", f"has no {name}", "export it again")
    with np.errstate(invalid="ignore", over="ignore"):
        return column.astype(np.float64)


def _places(
    vertex: PlyTable, face: PlyTable, polygons: PlyLists, corners: IntArray, faces: IntArray, notes: list[str]
) -> tuple[FloatArray | None, IntArray | None]:
    uv: FloatArray | None = None
    uv_faces = faces
    own = face.get("texcoord")
    if isinstance(own, PlyLists):
        if np.array_equal(own.sizes, 2 * polygons.sizes):
            uv, uv_faces = own.values.reshape(-1, 2).astype(np.float64), corners
        else:
            notes.append("its texcoord lists do not fit the faces: left out")
    if uv is None:
        names = next((names for names in _PLACES if set(names) <= set(vertex)), None)
        uv = None if names is None else _stack(vertex, names)
    if uv is None:
        return None, None
    return np.column_stack([uv[:, 0], 1.0 - uv[:, 1]]), uv_faces


def _pictures(path: Path, header: PlyHeader, notes: list[str]) -> tuple[list[Material], tuple[Path, ...]]:
    names = [comment.split(None, 1)[1] for comment in header.comments if comment.lower().startswith("texturefile ")]
    materials, files, budget = [], [], PictureBudget()
    for name in names[:_MOST_PICTURES]:
        try:
            file = beside(path, name.strip().strip('"').replace("\\", "/"), "TextureFile")
            materials.append(Material(budget.read(file)))
            files.append(file)
        except InputError as error:
            notes.append(f"TextureFile {name[:80]!r} {error.problem}: left out")
            materials.append(Material())
    return materials, tuple(files)
