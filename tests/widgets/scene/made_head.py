"""A made-up rig: a ball for a head with a nose and a chin, on shoulders, with two eyeballs and a row of teeth."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from engine.mesh import FloatArray, TriangleMesh

RADIUS = 80.0


def ball(rings: int, spokes: int, radius: float, centre: tuple[float, float, float]) -> tuple[FloatArray, np.ndarray]:
    """Return a closed ball whose poles lie on the Z axis."""
    polar = np.linspace(0, np.pi, rings + 1)[1:-1]
    angle = np.arange(spokes) / spokes * 2 * np.pi
    x, y = np.outer(np.sin(polar), np.cos(angle)), np.outer(np.sin(polar), np.sin(angle))
    z = np.repeat(np.cos(polar)[:, None], spokes, axis=1)
    points = np.concatenate([[[0, 0, 1.0]], np.stack([x, y, z], axis=2).reshape(-1, 3), [[0, 0, -1.0]]])
    here, after = np.arange(spokes), (np.arange(spokes) + 1) % spokes
    faces = [np.stack([np.zeros(spokes, int), 1 + here, 1 + after], axis=1)]
    for k in range(rings - 2):
        a, b = 1 + k * spokes, 1 + (k + 1) * spokes
        faces += [np.stack([a + here, b + here, b + after], axis=1), np.stack([a + here, b + after, a + after], axis=1)]
    last = 1 + (rings - 2) * spokes
    faces.append(np.stack([last + here, np.full(spokes, len(points) - 1), last + after], axis=1))
    return radius * points + np.array(centre), np.vstack(faces)


@lru_cache(maxsize=1)
def head() -> TriangleMesh:
    """Return the neutral face; its parts are skin, eye_left, eye_right and teeth."""
    skin, faces = ball(36, 60, RADIUS, (0.0, 0.0, 0.0))
    nose = 22.0 * np.exp(-((skin[:, 0] / 12) ** 2) - (skin[:, 1] / 18) ** 2) * (skin[:, 2] > 0)
    skin = skin + nose[:, None] * [0.0, 0.0, 1.0]
    parts, points, triangles, start = {}, [], [], 0
    pieces = {
        "skin": (skin, faces),
        "eye_left": ball(24, 24, 14.0, (28.0, 24.0, 66.0)),
        "eye_right": ball(24, 24, 14.0, (-28.0, 24.0, 66.0)),
        "teeth": ball(6, 8, 9.0, (0.0, -30.0, 66.0)),
    }
    for name, (vertices, own) in pieces.items():
        parts[name] = np.arange(start, start + len(own))
        start += len(own)
        triangles.append(own + sum(len(p) for p in points))
        points.append(vertices)
    return TriangleMesh(np.vstack(points), np.vstack(triangles), parts=parts)


def skin_vertices() -> np.ndarray:
    """Return the vertices of the part ``skin``."""
    mesh = head()
    return np.unique(mesh.faces[mesh.parts["skin"]])


def bump(centre: tuple[float, float, float], height: float = 8.0, width: float = 26.0) -> FloatArray:
    """Return displacements (N, 3) in mm that swell the head around a place."""
    vertices = head().vertices
    near = np.exp(-((vertices - np.array(centre)) ** 2).sum(axis=1) / width**2)
    return height * near[:, None] * vertices / np.linalg.norm(vertices, axis=1, keepdims=True)


HAND = (35.0, -30.0, 60.0)
QUASI = (-35.0, -30.0, 60.0)
