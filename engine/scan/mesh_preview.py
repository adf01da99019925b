"""A mesh made light, so that what a virtual camera sees of it can follow the hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.mesh import TriangleMesh, frozen
from engine.scan.mesh_view import TexturedMesh
from engine.scan.range_image import ColourImage

LIGHT_FACES = 40_000
_PLAIN = 190


@dataclass(frozen=True)
class LightMesh:
    """A mesh of at most about ``LIGHT_FACES`` faces, with its texture where it kept all of them, else with colours."""

    mesh: TriangleMesh
    texture: ColourImage | None
    colours: NDArray[np.uint8] | None


def vertex_colours(thing: TexturedMesh) -> NDArray[np.uint8]:
    """Return an sRGB colour (N, 3) per vertex: what texture and colours show there, else light grey."""
    mesh = thing.mesh
    if thing.texture is None or mesh.uv is None or mesh.uv_faces is None:
        plain = np.full((len(mesh.vertices), 3), _PLAIN, dtype=np.uint8)
        return plain if thing.colours is None else np.asarray(thing.colours, dtype=np.uint8)
    height, width = thing.texture.shape[:2]
    place = np.zeros((len(mesh.vertices), 2))
    place[mesh.faces.ravel()] = mesh.uv[mesh.uv_faces.ravel()]
    column = np.clip((np.mod(place[:, 0], 1.0) * width).astype(np.int64), 0, width - 1)
    row = np.clip((np.mod(place[:, 1], 1.0) * height).astype(np.int64), 0, height - 1)
    shade = thing.texture[row, column]
    if thing.colours is not None:
        shade = np.rint(shade * (thing.colours / 255.0)).astype(np.uint8)
    return np.asarray(shade, dtype=np.uint8)


def light_copy(thing: TexturedMesh, most: int = LIGHT_FACES) -> LightMesh:
    """Return a mesh of about ``most`` faces at most: the same, or with its vertices gathered in the cells of a grid.

    References
    ----------
    Rossignac & Borrel 1993 (vertex clustering).
    """
    mesh = thing.mesh
    if len(mesh.faces) <= most:
        return LightMesh(mesh, thing.texture, thing.colours)
    colours = vertex_colours(thing).astype(np.float64)
    used = np.unique(mesh.faces)
    low, high = mesh.vertices[used].min(axis=0), mesh.vertices[used].max(axis=0)
    # A surface of n faces passes through about n / 2 cells, some six of its grid's sides squared.
    side = float(np.linalg.norm(high - low)) / max(2.0, np.sqrt(most / 2 / 2.0))
    vertices, faces, shade = mesh.vertices, mesh.faces, colours
    for _ in range(8):
        cell = np.floor((mesh.vertices - low) / side).astype(np.int64)
        _, group = np.unique(cell, axis=0, return_inverse=True)
        group = group.reshape(-1)
        number = np.bincount(group).astype(np.float64)
        vertices = np.column_stack([np.bincount(group, mesh.vertices[:, k]) / number for k in range(3)])
        shade = np.column_stack([np.bincount(group, colours[:, k]) / number for k in range(3)])
        faces = group[mesh.faces]
        different = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
        faces = faces[different]
        if len(faces) <= most:
            break
        side *= 1.15 * np.sqrt(len(faces) / most)
    return LightMesh(TriangleMesh(vertices, faces), None, frozen(np.rint(shade), np.uint8))
