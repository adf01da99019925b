"""Wavefront OBJ with its material (MTL) and texture (PNG) beside it, in mm."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.glb_build import check_texture, unit_normals
from engine.files.images import encode_image
from engine.mesh import FloatArray, TriangleMesh
from engine.scan.range_image import ColourImage


def write_obj(
    path: str | Path,
    mesh: TriangleMesh,
    *,
    normals: FloatArray | None = None,
    texture: ColourImage | None = None,
    name: str = "face",
) -> tuple[Path, ...]:
    """Write a mesh as OBJ, and with a texture ``STEM.mtl`` and ``STEM_texture.png`` beside it.

    Vertices keep their order and are not split: a seam is kept by separate texture indices. Texture coordinates are
    written with the origin at the bottom left, as the format has it. In the names of the two other files everything
    but letters, digits, dot, dash and underscore becomes an underscore, since readers break such lines at spaces.

    Parameters
    ----------
    path : str or Path
        The OBJ file.
    mesh : TriangleMesh
        In mm; written with 5 decimals.
    normals : (N, 3) float, optional
        One per vertex, of any length.
    texture : (H, W, 3) uint8, optional
        RGB picture for ``mesh.uv``.
    name : str
        Name of the object and its material.

    Returns
    -------
    tuple of Path
        All files that were written, the OBJ first.

    Raises
    ------
    InputError
        When the mesh is empty, an array does not fit it, or a file cannot be written.
    """
    path = Path(path)
    if len(mesh.faces) == 0:
        raise InputError("mesh", "has no faces", "fit or import a face first")
    directions = None if normals is None else unit_normals(normals, len(mesh.vertices))
    word = obj_word(name)
    written = obj_files(path, texture is not None)
    lines = [f"# Quasiface Studio, mm, +Y up; {len(mesh.vertices)} vertices, {len(mesh.faces)} triangles"]
    if texture is not None:
        check_texture(mesh, texture)
        _, material, picture = written
        _save(picture, encode_image(texture))
        looks = f"newmtl {word}\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {picture.name}\n"
        _save(material, looks.encode())
        lines.append(f"mtllib {material.name}")
    lines.append(f"o {word}")
    settings = [] if texture is None else [f"usemtl {word}"]
    text = vertex_text(mesh.vertices) + face_text(mesh, directions, settings)
    _save(path, ("\n".join(lines) + "\n" + text).encode("ascii"))
    return written


def vertex_text(vertices: FloatArray) -> str:
    """Return the ``v`` lines of positions (N, 3), with 5 decimals."""
    return ("v %.5f %.5f %.5f\n" * len(vertices)) % tuple(vertices.ravel().tolist())


def face_text(mesh: TriangleMesh, directions: FloatArray | None = None, settings: Sequence[str] = ()) -> str:
    """Return all lines behind the positions: chart, unit normals (N, 3), ``settings``, faces."""
    lines: list[str] = []
    corners = [mesh.faces + 1]
    pattern = "{}"
    if mesh.uv is not None and mesh.uv_faces is not None:
        lines += [f"vt {u:.7f} {1.0 - v:.7f}" for u, v in mesh.uv.tolist()]
        corners.append(mesh.uv_faces + 1)
        pattern = "{}/{}"
    if directions is not None:
        lines += [f"vn {x:.6f} {y:.6f} {z:.6f}" for x, y, z in directions.tolist()]
        corners.append(mesh.faces + 1)
        pattern = "{}/{}/{}" if mesh.uv is not None else "{}//{}"
    lines += settings
    row = "f " + " ".join([pattern] * 3)
    lines += [row.format(*face) for face in np.stack(corners, axis=2).reshape(len(mesh.faces), -1).tolist()]
    return "\n".join(lines) + "\n"


def obj_files(path: str | Path, textured: bool) -> tuple[Path, ...]:
    """Return the files that ``write_obj`` makes or replaces: the OBJ and, with a texture, material and picture."""
    path = Path(path)
    stem = obj_word(path.stem)
    return (path, path.with_name(f"{stem}.mtl"), path.with_name(f"{stem}_texture.png")) if textured else (path,)


def obj_word(text: str) -> str:
    """Return a name as one word of letters, digits, dot, dash and underscore."""
    return re.sub(r"[^A-Za-z0-9._-]", "_", text) or "face"


def _save(path: Path, data: bytes) -> None:
    with atomic_write(path) as handle:
        handle.write(data)
