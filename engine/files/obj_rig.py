"""Rigs as folders of OBJs of one topology: a neutral face, and a file per shape."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from engine.errors import InputError, some
from engine.files.atomic import atomic_write
from engine.files.json_text import checked, load_json
from engine.files.mesh_parts import RawMesh
from engine.files.obj import face_text, obj_word, vertex_text, write_obj
from engine.files.obj_mesh import read_obj_mesh
from engine.files.obj_twin import ObjTwin
from engine.files.part_names import part_name
from engine.files.rig_raw import MAX_SHAPES, RawRig, check_size
from engine.files.runs import from_runs, to_runs
from engine.files.source import beside, checked_file
from engine.files.textures import cover
from engine.mesh import FloatArray, IntArray
from engine.scan.range_image import ColourImage
from engine.shapes import Rig

LIST_NAME = "shapes.json"
"""File beside the OBJs that keeps the order and the names of the shapes."""

NEUTRALS = ("neutral", "rest", "base", "basis")
"""What the face at rest may be called."""

_MEAN = "mean"
_Count = Annotated[int, Field(ge=0, le=10_000_000)]
_Text = Annotated[str, Field(min_length=1, max_length=256)]


class _Shape(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: _Text
    file: _Text


class _List(BaseModel):
    model_config = ConfigDict(extra="forbid")
    unit: _Text
    neutral: _Text
    mean: _Text | None = None
    shapes: Annotated[list[_Shape], Field(min_length=1, max_length=MAX_SHAPES)]
    parts: Annotated[dict[_Text, list[_Count]], Field(max_length=1000)] = {}


def read_obj_rig(folder: Path) -> RawRig:
    """Read a folder of OBJ files as one rig.

    ``neutral.obj`` (or ``rest``, ``base``, ``basis``; or the one file with such a word in its name) is the face at
    rest, ``mean.obj`` the rest of an affine basis, and every other file a shape that bears its name. Where
    ``shapes.json`` lists names and order, it counts.

    Raises
    ------
    InputError
        Without a neutral face or shapes, and for a file of another topology, with both counts.
    """
    listed = folder / LIST_NAME
    try:
        stated = checked(_List, load_json(listed), listed) if listed.is_file() else None
        found = sorted((path for path in folder.iterdir() if path.suffix.lower() == ".obj"), key=_order)
    except OSError as error:
        raise InputError(str(folder), f"cannot be read ({error.strerror})", "check the folder's rights") from error
    if stated is not None:
        at_rest = beside(listed, stated.neutral, "neutral")
        mean_file = None if stated.mean is None else beside(listed, stated.mean, "mean")
        files = [(shape.name, beside(listed, shape.file, f"shapes, {shape.name}")) for shape in stated.shapes]
    else:
        at_rest, mean_file, files = _by_names(folder, found)
    neutral = read_obj_mesh(checked_file(at_rest))
    count = len(neutral.vertices)
    check_size(str(folder), len(files), count)
    notes = list(neutral.notes)
    mean, twin = None, ObjTwin(at_rest, count)
    if mean_file is not None:
        mean = _moved(mean_file, at_rest, neutral, twin) - neutral.vertices
        if stated is None:
            notes.append(f"{mean_file.name} was taken for the mean of an affine basis")
    base = neutral.vertices if mean is None else neutral.vertices + mean
    displacements = np.zeros((len(files), count, 3))
    with np.errstate(invalid="ignore", over="ignore"):
        for k, (_, path) in enumerate(files):
            displacements[k] = _moved(path, at_rest, neutral, twin) - base
    faces = len(neutral.faces)
    parts = _parts(neutral) if stated is None else {n: from_runs(r, faces) for n, r in stated.parts.items()}
    covering = cover(neutral.materials, neutral.face_material, neutral.uv, neutral.uv_faces)
    uv, uv_faces = neutral.uv, neutral.uv_faces
    if covering.texture is not None:
        uv, uv_faces = covering.uv, covering.uv_faces
    elif uv_faces is not None and (uv_faces < 0).any():
        uv = uv_faces = None
    read = (listed,) if stated is not None else ()
    return RawRig(
        neutral.vertices, neutral.faces, [name for name, _ in files], displacements, mean, uv, uv_faces, parts,
        covering.texture, None if stated is None else stated.unit, tuple(notes),
        (at_rest, *read, *neutral.files, *([] if mean_file is None else [mean_file]), *(path for _, path in files)),
    )  # fmt: skip


def write_obj_rig(
    folder: str | Path, rig: Rig, *, name: str = "face", texture: ColourImage | None = None
) -> tuple[Path, ...]:
    """Write a rig as a folder of OBJs in mm, ``neutral.obj`` and one a shape, with ``shapes.json`` beside them.

    A shape's file is the face under its full weight. The mean of an affine basis is ``mean.obj``, and its shapes are
    added to it.

    Parameters
    ----------
    folder : str or Path
        Is made where it is missing; files of the same names are replaced.
    rig : Rig
        In mm; written with 5 decimals.
    name : str
        Name of the object and its material.
    texture : (H, W, 3) uint8, optional
        RGB picture for the mesh's chart, written beside ``neutral.obj``.

    Returns
    -------
    tuple of Path
        All files, ``neutral.obj`` first.
    """
    folder, mesh, basis = Path(folder), rig.mesh, rig.basis
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(str(folder), f"cannot be made ({error.strerror})", "choose another folder") from error
    written = list(write_obj(folder / "neutral.obj", mesh.with_vertices(basis.neutral), texture=texture, name=name))
    tail = face_text(mesh)
    base = basis.neutral if basis.mean is None else basis.neutral + basis.mean
    taken = {*NEUTRALS, _MEAN}
    named = [(shape, _file(shape, taken), basis.displacements[k]) for k, shape in enumerate(basis.names)]
    poses = [] if basis.mean is None else [(_MEAN, f"{_MEAN}.obj", np.zeros_like(base))]
    for shape, file, displacement in [*poses, *named]:
        head = f"# Quasiface Studio, mm, +Y up\no {obj_word(shape)}\n"
        with atomic_write(folder / file) as handle:
            handle.write((head + vertex_text(base + displacement) + tail).encode("ascii"))
        written.append(folder / file)
    shapes = [{"name": shape, "file": file} for shape, file, _ in named]
    listed: dict[str, Any] = {"unit": "mm", "neutral": "neutral.obj", "shapes": shapes}
    if poses:
        listed["mean"] = poses[0][1]
    if mesh.parts:
        listed["parts"] = {part: to_runs(np.sort(faces)) for part, faces in mesh.parts.items()}
    with atomic_write(folder / LIST_NAME) as handle:
        handle.write(json.dumps(listed, indent=1, ensure_ascii=False).encode())
    return (*written, folder / LIST_NAME)


def _file(shape: str, taken: set[str]) -> str:
    """Return a file name for a shape that no other has, also where case does not count."""
    word = obj_word(shape)[:80].strip(".") or "shape"
    found, number = word, 2
    while found.lower() in taken:
        found, number = f"{word}_{number}", number + 1
    taken.add(found.lower())
    return f"{found}.obj"


def _order(path: Path) -> list[tuple[int, str]]:
    """Sort ``shape_2`` before ``shape_10``."""
    return [(int(word), "") if word.isdigit() else (-1, word) for word in re.split(r"([0-9]{1,15})", path.stem.lower())]


def _by_names(folder: Path, found: list[Path]) -> tuple[Path, Path | None, list[tuple[str, Path]]]:
    """Return the neutral face, the mean and the shapes of a folder by the names of its files."""
    if not found:
        raise InputError(str(folder), "holds no .obj files", "give the folder with neutral.obj and its shapes")
    exact = [path for path in found if path.stem.lower() in NEUTRALS]
    likely = exact or [path for path in found if set(re.findall("[a-z]+", path.stem.lower())) & set(NEUTRALS)]
    if not likely:
        problem = f"has no neutral face among its files ({some((p.stem for p in found), 4)})"
        raise InputError(str(folder), problem, "call the face at rest neutral.obj")
    if len(likely) > 1:
        problem = f"has several neutral faces ({some(path.name for path in likely)})"
        raise InputError(str(folder), problem, "call one of them neutral.obj and take the others away")
    mean = next((path for path in found if path.stem.lower() == _MEAN), None)
    files = [(path.stem, path) for path in found if path not in (likely[0], mean)]
    if not files:
        raise InputError(str(folder), "has a neutral face and no shapes", "export every shape as an .obj beside it")
    return likely[0], mean, files


def _moved(path: Path, at_rest: Path, neutral: RawMesh, twin: ObjTwin) -> FloatArray:
    """Return the positions of a shape's file, which must be of the neutral face's topology."""
    quick = twin.positions(path)
    if quick is not None:
        return quick
    mesh = read_obj_mesh(checked_file(path), pictures=False)
    remedy = "both must be of one topology; export them from one mesh, with its vertices in order"
    for kind, have, want in (
        ("vertices", len(mesh.vertices), len(neutral.vertices)),
        ("triangles", len(mesh.faces), len(neutral.faces)),
    ):
        if have != want:
            raise InputError(str(path), f"has {have} {kind}, {at_rest.name} has {want}", remedy)
    differ = int((mesh.faces != neutral.faces).any(axis=1).sum())
    if differ:
        problem = f"has as many triangles as {at_rest.name}, but {differ} of {len(mesh.faces)} join other vertices"
        raise InputError(str(path), problem, remedy)
    return mesh.vertices


def _parts(neutral: RawMesh) -> dict[str, IntArray]:
    """Return faces by the parts that groups and materials name."""
    if neutral.face_group is None:
        return {}
    named = [part_name(label) for label in neutral.group_names]
    found = {}
    for part in dict.fromkeys(name for name in named if name is not None):
        found[part] = np.flatnonzero(np.isin(neutral.face_group, [k for k, name in enumerate(named) if name == part]))
    return {part: faces for part, faces in found.items() if len(faces)}
