"""Which triangle every pixel of a pinhole camera sees, with exact depth and barycentric coordinates."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, TriangleMesh
from engine.progress import Progress, silent
from engine.scan.range_image import Camera

NEAREST_MM = 1.0
_CANDIDATES = 1 << 20

MOST_CANDIDATES = 24_000_000
"""Most pairs of a face and a sample in its box that are tried, or `MOST_LAYERS` times the samples if that is more."""

MOST_LAYERS = 10
"""Surfaces one behind the other for which there is room at any size of the picture."""


@dataclass(frozen=True)
class Raster:
    """The surface seen through an image grid.

    Attributes
    ----------
    face_index : (H, W) int
        Face of the mesh that the ray through each sample meets first; -1 where it meets none.
    barycentric : (H, W, 3) float
        Where on that face, as weights of its corners; 0 where there is none.
    points : (H, W, 3) float
        The meeting points in mm, computed from the plane of the face; NaN where there is none.
    """

    face_index: IntArray
    barycentric: FloatArray
    points: FloatArray

    def interpolate(self, corner_indices: IntArray, values: FloatArray) -> FloatArray:
        """Return values (N, C) at the corners (F, 3) of the faces carried to the samples (H, W, C); 0 where empty."""
        hit = self.face_index >= 0
        result = np.zeros((*self.face_index.shape, values.shape[1]))
        corners = corner_indices[self.face_index[hit]]
        weights = self.barycentric[hit]
        result[hit] = sum(weights[:, k, None] * values[corners[:, k]] for k in range(3))
        return result


@dataclass(frozen=True)
class RayHits:
    """Where single rays meet a mesh first: ``face_index`` (k,), -1 for none, ``points`` (k, 3) mm, NaN for none."""

    face_index: IntArray
    points: FloatArray


def rasterise(
    mesh: TriangleMesh, camera: Camera, width: int, height: int, supersampling: int = 1, progress: Progress = silent
) -> Raster:
    """Return what each pixel of a width x height image sees of a mesh in the camera's frame.

    Every face is met from both sides. A z-buffer over the pixels in the bounding boxes of the projected triangles
    finds the candidates; inside or outside is decided by the triple products of ray and corners (Moeller & Trumbore
    1997, without the division), which agree exactly on an edge that two triangles share, so no ray slips through.

    Parameters
    ----------
    mesh : TriangleMesh
        Positions in mm, in front of the camera (z < -1).
    camera : Camera
        Intrinsics in pixels of the width x height image.
    supersampling : int
        With s > 1 the grid has s x s samples per pixel and (s H, s W) rows and columns; their mean is the pixel.

    Raises
    ------
    InputError
        Where the mesh reaches behind the camera, and where so many large faces lie one behind the other that it
        would take minutes (`MOST_CANDIDATES`, `MOST_LAYERS`).
    """
    vertices, faces = mesh.vertices, mesh.faces
    _check_in_front(mesh)
    s = supersampling
    shape = (height * s, width * s)
    fine = Camera(camera.fx * s, camera.fy * s, camera.cx * s + (s - 1) / 2, camera.cy * s + (s - 1) / 2)
    first, columns, counts = _boxes(fine.project(vertices)[faces], shape)
    total, most = int(counts.sum()), max(MOST_CANDIDATES, MOST_LAYERS * shape[0] * shape[1])
    if total > most:
        problem = f"its faces overlap {total // (shape[0] * shape[1])} times over the picture, counted by their boxes"
        raise InputError("mesh", problem, "remove large faces that lie one behind the other, or look at less of it")
    # What lies outside the picture takes no part, so that a large mesh costs what is seen of it.
    inside = np.flatnonzero(counts)
    first, columns, counts = first[inside], columns[inside], counts[inside]
    corners = vertices[faces[inside]]
    plane = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    offset = np.einsum("fi,fi->f", plane, corners[:, 0])
    sides = [np.cross(corners[:, (k + 1) % 3], corners[:, (k + 2) % 3]) for k in range(3)]

    nearest = np.full(shape[0] * shape[1], np.inf)
    face_index = np.full(shape[0] * shape[1], -1, dtype=np.int64)
    done = 0
    for face, inside_box in _candidates(counts):
        progress(done / total, "looking at the mesh")
        done += len(face)
        row = first[face, 1] + inside_box // columns[face]
        column = first[face, 0] + inside_box % columns[face]
        ray = _rays(fine, column, row)
        one, two, three = (np.einsum("ci,ci->c", side[face], ray) for side in sides)
        hit = (np.minimum(np.minimum(one, two), three) >= 0) | (np.maximum(np.maximum(one, two), three) <= 0)
        face, ray, pixel = face[hit], ray[hit], (row * shape[1] + column)[hit]
        slope = np.einsum("ci,ci->c", plane[face], ray)
        seen = slope != 0
        face, pixel = face[seen], pixel[seen]
        depth = offset[face] / slope[seen]
        closer = depth < nearest[pixel]
        face, pixel, depth = face[closer], pixel[closer], depth[closer]
        # Written from back to front: the last write to a pixel is its nearest face.
        order = np.argsort(-depth, kind="stable")
        nearest[pixel[order]], face_index[pixel[order]] = depth[order], face[order]

    hit = face_index >= 0
    row, column = np.divmod(np.flatnonzero(hit), shape[1])
    ray = _rays(fine, column, row)
    points = np.full((len(nearest), 3), np.nan)
    points[hit] = nearest[hit, None] * ray
    barycentric = np.zeros((len(nearest), 3))
    barycentric[hit] = _barycentric(corners[face_index[hit]], points[hit])
    face_index[hit] = inside[face_index[hit]]
    return Raster(face_index.reshape(shape), barycentric.reshape(*shape, 3), points.reshape(*shape, 3))


def cast_rays(mesh: TriangleMesh, camera: Camera, pixels: FloatArray) -> RayHits:
    """Return where the rays through sub-pixel positions (k, 2) first meet a mesh in the camera's frame.

    Meant for some hundreds of positions: every ray looks through the boxes of all projected faces.

    Raises
    ------
    InputError
        Where the mesh reaches behind the camera.
    """
    _check_in_front(mesh)
    projected = camera.project(mesh.vertices)[mesh.faces]
    low, high = projected.min(axis=1) - 1e-6, projected.max(axis=1) + 1e-6
    face_index = np.full(len(pixels), -1, dtype=np.int64)
    points = np.full((len(pixels), 3), np.nan)
    for i, ray in enumerate(_rays(camera, pixels[:, 0], pixels[:, 1])):
        near = np.flatnonzero(((low <= pixels[i]) & (high >= pixels[i])).all(axis=1))
        corners = mesh.vertices[mesh.faces[near]]
        plane = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        signed = np.stack([np.cross(corners[:, (k + 1) % 3], corners[:, (k + 2) % 3]) @ ray for k in range(3)], axis=1)
        slope = plane @ ray
        # A ray aimed at a vertex may miss all its faces by a rounding error: let them reach out a little.
        reach = 1e-8 * np.abs(signed.sum(axis=1)) + 1e-9
        inside = (signed >= -reach[:, None]).all(axis=1) | (signed <= reach[:, None]).all(axis=1)
        hit = np.flatnonzero(inside & (slope != 0))
        if len(hit):
            depth = np.einsum("fi,fi->f", plane[hit], corners[hit, 0]) / slope[hit]
            k = int(np.argmin(depth))
            face_index[i], points[i] = near[hit[k]], depth[k] * ray
    return RayHits(face_index, points)


def _check_in_front(mesh: TriangleMesh) -> None:
    if mesh.vertices[mesh.faces, 2].max(initial=-np.inf) > -NEAREST_MM:
        raise InputError("mesh", "reaches behind the camera", "move it along -Z, or use frontal_camera to place it")


def _rays(camera: Camera, column: FloatArray | IntArray, row: FloatArray | IntArray) -> FloatArray:
    """Directions (k, 3) of the rays through pixel positions, with depth 1 along the optical axis."""
    x = (column - camera.cx) / camera.fx
    y = -(row - camera.cy) / camera.fy
    return np.stack([x, y, np.full(len(x), -1.0)], axis=-1)


def _boxes(projected: FloatArray, shape: tuple[int, int]) -> tuple[IntArray, IntArray, IntArray]:
    """First pixel (F, 2), number of columns (F,) and of pixels (F,) of the boxes round projected triangles."""
    limit = np.array([shape[1], shape[0]])
    low = np.clip(np.ceil(projected.min(axis=1) - 1e-6), 0, limit).astype(np.int64)
    high = np.clip(np.floor(projected.max(axis=1) + 1e-6), -1, limit - 1).astype(np.int64)
    size = np.maximum(high - low + 1, 0)
    return low, np.maximum(size[:, 0], 1), size[:, 0] * size[:, 1]


def _candidates(counts: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield (faces, places in their boxes) of all samples in the boxes, about ``_CANDIDATES`` at a time."""
    ends = np.cumsum(counts)
    starts = ends - counts
    begins = np.flatnonzero(np.diff(starts // _CANDIDATES, prepend=-1))
    for begin, end in pairwise([*begins, len(counts)]):
        for low in range(int(starts[begin]), int(ends[end - 1]), 2 * _CANDIDATES):
            high = min(low + 2 * _CANDIDATES, int(ends[end - 1]))
            one, last = np.searchsorted(ends, [low, high - 1], side="right")
            number = np.minimum(ends[one : last + 1], high) - np.maximum(starts[one : last + 1], low)
            face = np.repeat(np.arange(one, last + 1), number)
            yield face, np.arange(low, high) - starts[face]


def _barycentric(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Weights (k, 3) of points (k, 3) in their triangles (k, 3, 3), relative to the first corner for precision."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = points - corners[:, 0]
    normal = np.cross(a, b)
    square = np.einsum("ci,ci->c", normal, normal)
    weight_1 = np.einsum("ci,ci->c", np.cross(p, b), normal) / square
    weight_2 = np.einsum("ci,ci->c", np.cross(a, p), normal) / square
    return np.stack([1 - weight_1 - weight_2, weight_1, weight_2], axis=-1)
