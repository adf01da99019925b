"""A small face with shapes, and a performance that only some of them explain: everything takes milliseconds."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.files.rig_out import write_rig
from engine.mesh import TriangleMesh
from engine.motion import WeightCurves
from engine.shapes import ExpressionBasis, Rig

NAMES = ("smile_L", "smile_R", "brow", "jaw", "pucker")
FRAMES, FPS = 60, 30.0
WIDE, HIGH = 15, 17


def face() -> TriangleMesh:
    """Half an ellipsoid of 150 x 220 x 90 mm, its left and right mirrored, with one part that is no skin."""
    u, v = np.meshgrid(np.linspace(-1, 1, WIDE), np.linspace(-1, 1, HIGH))
    x, y = 75 * u, 110 * v
    z = 90 * np.sqrt(np.maximum(0.0, 1 - 0.45 * u**2 - 0.45 * v**2))
    index = np.arange(WIDE * HIGH).reshape(HIGH, WIDE)
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, 1:].ravel(), index[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    count = len(faces)
    parts = {"skin": np.arange(count - 20), "eyes": np.arange(count - 20, count)}
    return TriangleMesh(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), faces, parts=parts)


def bumps(mesh: TriangleMesh) -> np.ndarray:
    """Return a smooth displacement for every name, (5, N, 3) mm."""
    places = {
        "smile_L": (30, -40, (3, 4, 1)),
        "smile_R": (-30, -40, (-3, 4, 1)),
        "brow": (0, 45, (0, 5, 2)),
        "jaw": (0, -75, (0, -12, 2)),
        "pucker": (0, -45, (0, 0, 7)),
    }
    vertices = mesh.vertices
    found = []
    for x, y, direction in places.values():
        near = np.exp(-((vertices[:, 0] - x) ** 2 + (vertices[:, 1] - y) ** 2) / (2 * 28.0**2))
        found.append(near[:, None] * np.array(direction, dtype=np.float64))
    return np.array(found)


def hand_rig() -> Rig:
    """Return the shapes as an artist made them: near the performer's, but not the same."""
    mesh = face()
    vertices = mesh.vertices
    own = bumps(mesh)
    wave = np.sin(vertices[:, :1] / 17.0) * np.cos(vertices[:, 1:2] / 23.0)
    return Rig(mesh, ExpressionBasis(mesh.vertices, NAMES, own + 0.9 * wave * np.array([0.2, 1.0, -0.6])))


def weights() -> np.ndarray:
    """Return what the performer does, (60, 5), at rest in the first frame."""
    t = np.arange(FRAMES) / FPS
    rates = np.array([0.9, 1.1, 1.7, 2.3, 3.1])
    return 0.5 * (1 - np.cos(2 * np.pi * t[:, None] * rates)) * np.array([0.9, 0.8, 1.0, 0.7, 0.9])


def take() -> np.ndarray:
    """Return the performance: positions (60, N, 3) of every vertex, mm."""
    mesh = face()
    return mesh.vertices + np.tensordot(weights(), bumps(mesh), axes=1)


def write_files(folder: Path) -> tuple[Path, Path, Path]:
    """Write rig, performance and curves; return their paths."""
    rig, motion, curves = folder / "artist.npz", folder / "take.npz", folder / "curves.csv"
    write_rig(rig, hand_rig())
    np.savez(motion, vertices=take(), fps=np.float64(FPS), unit=np.array("mm"))
    from engine.files.weights_csv import write_weights

    write_weights(curves, WeightCurves(NAMES, weights(), FPS))
    return rig, motion, curves
