"""The sample's true heads: coarse cages and poses, subdivided into the very surfaces that the scans were taken of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

EYE_RINGS, EYE_SPOKES = 72, 96
CORNEA_HEIGHT, CORNEA_WIDTH = 0.082, 0.41


@dataclass(frozen=True)
class Surface:
    """One scan's true surface in the scanner's frame, mm: camera at the origin, looking along -Z.

    ``parts`` names the faces of skin, teeth, tongue and eyes; ``face_skin`` are the skin faces between forehead and
    chin that a camera in front can see with the mouth closed.
    """

    vertices: FloatArray
    faces: IntArray
    uv: FloatArray
    parts: Mapping[str, IntArray]
    face_skin: IntArray


class Heads:
    """The heads of ``truth.npz``.

    Attributes
    ----------
    scans : tuple of str
        ``base, car, man, she, eel, too`` of the subject, and ``stranger``.
    fiducials, anatomy : mapping of str to int
        Vertices of the dense surface: those of both schemes as most scans have them (``fiducials_of`` knows the
        exceptions), and ten more that no scheme names.
    """

    def __init__(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        self._data = dict(arrays)
        self.scans = tuple(str(name) for name in self._data["scans"])
        self.fiducials = _named(self._data, "fiducial")
        self.anatomy = _named(self._data, "anatomy")

    @classmethod
    def load(cls, path: Path) -> Heads:
        """Read ``truth.npz``."""
        with np.load(path, allow_pickle=False) as stored:
            return cls({name: stored[name] for name in stored.files})

    def fiducials_of(self, scan: str) -> Mapping[str, int]:
        """Return the fiducial vertices of one scan: the common ones, but for points that this scan hides."""
        own = {name: f"fiducial_{name}_{scan}" for name in self.fiducials}
        return self.fiducials | {name: int(self._data[key]) for name, key in own.items() if key in self._data}

    def surface(self, scan: str) -> Surface:
        """Return the true surface of one scan, about 190,000 triangles, in its scanner's frame."""
        vertices = self.vertices(scan)
        k = self.scans.index(scan)
        rotation, translation = self._data["rotations"][k], self._data["translations"][k]
        placed = vertices @ rotation.T + translation
        return Surface(placed, self.faces, self.uv, self.parts, self._data["face_skin"].astype(np.int64))

    def vertices(self, scan: str) -> FloatArray:
        """Return the dense vertices (N, 3) of one scan in the head's own frame, mm, before its rigid motion."""
        return self.dense(self.cage(scan), self.eyes(scan))

    def cage(self, scan: str) -> FloatArray:
        """Return the coarse cage (n, 3) of one scan in the head's own frame, mm."""
        identity = "stranger" if scan == "stranger" else "subject"
        cage: FloatArray = self._data[f"cage_{identity}"].astype(np.float64)
        if f"pose_{scan}" in self._data:
            cage = cage + self._data[f"pose_{scan}"]
        return cage

    def eyes(self, scan: str) -> FloatArray:
        """Return centre and radius (2, 4) of both eyeballs, subject's left first, mm."""
        return self._data["eyes_stranger" if scan == "stranger" else "eyes_subject"].astype(np.float64)

    def dense(self, cage: FloatArray, eyes: FloatArray) -> FloatArray:
        """Return the dense vertices (N, 3) of a cage (n, 3) with eyeballs (2, 4), mm."""
        balls = [eyes[k, :3] + eyes[k, 3] * _eyeball()[0] for k in range(2)]
        return np.vstack([self.subdivision @ cage, *balls])

    @cached_property
    def subdivision(self) -> sp.csr_matrix:
        """Matrix that carries values on the cage (n, ...) to the dense skin, teeth and tongue."""
        return self._subdivided[0]

    @property
    def faces(self) -> IntArray:
        """Triangles (F, 3) of the dense surface, the same for every scan."""
        return self._faces[0]

    @property
    def parts(self) -> Mapping[str, IntArray]:
        """Faces of skin, teeth_upper, teeth_lower, tongue, eye_left and eye_right; the skin's vertices come first."""
        return self._faces[1]

    @cached_property
    def uv(self) -> FloatArray:
        """Texture coordinates (N, 2) in ``skin.jpg``, origin top left; all but skin points to its white spot."""
        own = self.subdivision @ self._data["cage_uv"].astype(np.float64)
        return np.vstack([own, np.repeat(self._data["white_uv"][None], 2 * len(_eyeball()[0]), axis=0)])

    @cached_property
    def _subdivided(self) -> tuple[sp.csr_matrix, dict[str, IntArray]]:
        count = len(self._data["cage_uv"])
        blocks, quads, start = [], {}, 0
        for part in ("skin", "teeth_upper", "teeth_lower", "tongue"):
            used, local = np.unique(self._data[f"quads_{part}"], return_inverse=True)
            pick = sp.csr_matrix((np.ones(len(used)), (np.arange(len(used)), used)), (len(used), count))
            matrix, fine = subdivide(local.reshape(-1, 4), len(used), int(self._data[f"levels_{part}"]))
            blocks.append(matrix @ pick)
            quads[part] = fine + start
            start += matrix.shape[0]
        return sp.vstack(blocks).tocsr(), quads

    @cached_property
    def _faces(self) -> tuple[IntArray, dict[str, IntArray]]:
        matrix, quads = self._subdivided
        pieces = {name: np.vstack([q[:, [0, 1, 2]], q[:, [0, 2, 3]]]) for name, q in quads.items()}
        points, triangles = _eyeball()
        pieces["eye_left"] = triangles + matrix.shape[0]
        pieces["eye_right"] = triangles + matrix.shape[0] + len(points)
        parts, start = {}, 0
        for name, faces in pieces.items():
            parts[name] = np.arange(start, start + len(faces))
            start += len(faces)
        return np.vstack(list(pieces.values())), parts


def subdivide(quads: IntArray, count: int, levels: int) -> tuple[sp.csr_matrix, IntArray]:
    """Return the Catmull-Clark matrix (fine, count) of ``levels`` steps and the fine quads (Catmull & Clark 1978)."""
    matrix = sp.identity(count, format="csr")
    for _ in range(levels):
        step, quads = _catmull_clark(quads, matrix.shape[0])
        matrix = (step @ matrix).tocsr()
    return matrix, quads


def _catmull_clark(quads: IntArray, count: int) -> tuple[sp.csr_matrix, IntArray]:
    number = len(quads)
    sides = np.vstack([np.stack([quads[:, k], quads[:, (k + 1) % 4]], axis=1) for k in range(4)])
    edges, edge_of, uses = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge_of = edge_of.reshape(-1)
    border = (uses == 1).astype(float)
    each_quad, each_edge = np.repeat(np.arange(number), 4), np.repeat(np.arange(len(edges)), 2)

    face_point = sp.csr_matrix((np.full(4 * number, 0.25), (each_quad, quads.ravel())), (number, count))
    middle = sp.csr_matrix((np.full(2 * len(edges), 0.5), (each_edge, edges.ravel())), (len(edges), count))
    beside = sp.csr_matrix((np.ones(4 * number), (edge_of, np.tile(np.arange(number), 4))), (len(edges), number))
    faces_of_edge = sp.diags(1 / uses) @ beside @ face_point
    edge_point = sp.diags(0.5 + 0.5 * border) @ middle + sp.diags(0.5 - 0.5 * border) @ faces_of_edge

    edges_at = sp.csr_matrix((np.ones(2 * len(edges)), (edges.ravel(), each_edge)), (count, len(edges)))
    faces_at = sp.csr_matrix((np.ones(4 * number), (quads.ravel(), each_quad)), (count, number))
    faces_at.data[:] = 1
    valence = np.maximum(np.asarray(edges_at.sum(axis=1)).ravel(), 1)
    around = np.maximum(np.asarray(faces_at.sum(axis=1)).ravel(), 1)
    border_at = edges_at @ sp.diags(border)
    border_count = np.asarray(border_at.sum(axis=1)).ravel()
    inside = (
        sp.diags((valence - 3) / valence)
        + sp.diags(1 / (valence * around)) @ faces_at @ face_point
        + sp.diags(2 / valence**2) @ edges_at @ middle
    )
    on_border = 0.5 * sp.identity(count) + sp.diags(0.5 / np.maximum(border_count, 1)) @ border_at @ middle
    is_border = (border_count > 0).astype(float)
    vertex_point = sp.diags(1 - is_border) @ inside + sp.diags(is_border) @ on_border

    edge_id = count + edge_of.reshape(4, number)
    middle_id = count + len(edges) + np.arange(number)
    fine = [np.stack([quads[:, k], edge_id[k], middle_id, edge_id[k - 1]], axis=1) for k in range(4)]
    return sp.vstack([vertex_point, edge_point, face_point]).tocsr(), np.vstack(fine)


def _eyeball() -> tuple[FloatArray, IntArray]:
    """Front of a unit eyeball with its cornea, looking along +Z: vertices (n, 3), triangles."""
    polar = np.linspace(0, 1, EYE_RINGS + 1)[1:] ** 1.25 * np.deg2rad(105)
    angle = np.arange(EYE_SPOKES) / EYE_SPOKES * 2 * np.pi
    radius, height = np.sin(polar)[:, None], np.cos(polar)[:, None]
    height = height + CORNEA_HEIGHT * np.exp(-((radius / CORNEA_WIDTH) ** 2)) * (height > 0)
    ring = np.stack(np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), height), axis=2).reshape(-1, 3)
    points = np.vstack([[[0.0, 0.0, 1 + CORNEA_HEIGHT]], ring])
    here = np.arange(EYE_SPOKES)
    after = (here + 1) % EYE_SPOKES
    triangles = [np.stack([np.zeros_like(here), 1 + here, 1 + after], axis=1)]
    for k in range(EYE_RINGS - 1):
        a, b = 1 + k * EYE_SPOKES, 1 + (k + 1) * EYE_SPOKES
        triangles += [np.stack([a + here, b + here, b + after], axis=1)]
        triangles += [np.stack([a + here, b + after, a + after], axis=1)]
    return points, np.vstack(triangles)


def eyeball_points() -> FloatArray:
    """Return the points (n, 3) of a unit eyeball that looks along +Z, in the order of the dense surface."""
    return _eyeball()[0]


def _named(arrays: Mapping[str, NDArray[Any]], kind: str) -> dict[str, int]:
    return {str(n): int(v) for n, v in zip(arrays[f"{kind}_names"], arrays[f"{kind}_vertices"], strict=True)}
