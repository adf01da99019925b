"""Faces that are symmetric by construction, and the permutation that says how."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.mesh import TriangleMesh


@dataclass(frozen=True)
class Planted:
    """A mesh and the vertex on the other side of every vertex."""

    mesh: TriangleMesh
    mirror: np.ndarray


def half_face(columns: int = 9, rows: int = 7, seed: int = 0, shuffled: bool = True, eyes: bool = True) -> Planted:
    """Return a curved sheet of quadrilaterals around x = 0, each cut the same way on both sides, and two eyes.

    Cut the same way, triangles are not symmetric: only the quadrilaterals are.
    """
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(-80, 80, 2 * columns + 1), np.linspace(-100, 100, rows), indexing="ij")
    points = np.stack([x, y, 60 - 0.006 * x**2 - 0.003 * y**2], axis=2)
    bump = rng.normal(scale=2.0, size=points.shape)
    # Uneven, but evenly so on both sides.
    points += bump + bump[::-1] * [-1, 1, 1]
    index = np.arange(points[..., 0].size).reshape(2 * columns + 1, rows)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=2).reshape(-1, 4)
    # Holes that are the same on both sides, so that the sheet is not one grid.
    hole = np.isin(np.arange(len(quads)) // (rows - 1), (3, 2 * columns - 4)) & (
        np.arange(len(quads)) % (rows - 1) == 3
    )
    quads = quads[~hole]
    vertices, mirror = points.reshape(-1, 3), index[::-1].reshape(-1)
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    if eyes:
        ring = np.array(
            [(12 * np.cos(a), 9 * np.sin(a), 4 * np.cos(2 * a + 0.4)) for a in np.arange(7) * 2 * np.pi / 7]
        )
        fan = np.array([(7, k, (k + 1) % 7) for k in range(7)])
        ball = np.concatenate([ring, [[1.0, 0.5, 8.0]]])
        first, second = len(vertices), len(vertices) + 8
        left = ball + np.array([35, 30, 70])
        right = left * [-1, 1, 1]
        faces = np.concatenate([faces, fan + first, fan[:, ::-1] + second])
        vertices = np.concatenate([vertices, left, right])
        mirror = np.concatenate([mirror, np.arange(8) + second, np.arange(8) + first])
    if shuffled:
        order = rng.permutation(len(vertices))
        place = np.argsort(order)
        vertices, mirror, faces = vertices[order], place[mirror[order]], place[faces]
    return Planted(TriangleMesh(vertices, faces), mirror)


def uneven(face: Planted, size: float = 4.0, seed: int = 1) -> TriangleMesh:
    """Return the face sculpted smoothly and unevenly, so that nearest points in the mid plane are wrong."""
    rng = np.random.default_rng(seed)
    points = face.mesh.vertices
    waves = [rng.normal(size=3)[None] * np.sin(points @ rng.normal(scale=0.02, size=3) + k)[:, None] for k in range(4)]
    bump = 6 * np.exp(-(((points - [40, 0, 50]) / 30) ** 2).sum(axis=1))
    return face.mesh.with_vertices(points + size * sum(waves) + bump[:, None] * [1.0, 1.5, 0.5])
