"""Small motions with known axes, in every form that a motion comes in, and the plain answer to compare with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from engine.mesh import FloatArray
from engine.motion import MeshMotion
from engine.shapes import ExpressionBasis


def factored(vertices: int = 120, markers: int = 9, frames: int = 320, seed: int = 0, fade: float = 0.5) -> MeshMotion:
    """Return a motion in which every marker moves less than the one before it, by the factor ``fade``."""
    random = np.random.default_rng(seed)
    phi = random.normal(size=(vertices, markers))
    moved = random.normal(size=(frames, markers, 3)) * (3.0 * fade ** np.arange(markers))[:, None] + 0.5
    return MeshMotion.factored(phi, moved, 80.0 * random.normal(size=(vertices, 3)), 120.0)


def driven(vertices: int = 120, shapes: int = 12, frames: int = 320, seed: int = 0, mean: bool = False) -> MeshMotion:
    """Return a rig under random weights, about a mean of its own if wanted."""
    random = np.random.default_rng(seed)
    neutral = 80.0 * random.normal(size=(vertices, 3))
    names = tuple(f"shape {i}" for i in range(shapes))
    moved = random.normal(size=(shapes, vertices, 3)) * 0.7 ** np.arange(shapes)[:, None, None]
    basis = ExpressionBasis(neutral, names, moved, random.normal(size=neutral.shape) if mean else None)
    return MeshMotion.driven(basis, random.uniform(0, 1, (frames, shapes)), 60.0)


def dense(motion: MeshMotion, dtype: Any = np.float64) -> MeshMotion:
    """Return the same motion as positions."""
    positions = (motion.neutral + motion.displacements(0, len(motion))).astype(dtype)
    return MeshMotion.dense(positions, motion.neutral, motion.fps)


def streamed(motion: MeshMotion) -> MeshMotion:
    """Return the same motion through a reader."""
    positions = motion.neutral + motion.displacements(0, len(motion))
    return MeshMotion.streamed(lambda start, stop: positions[start:stop], len(motion), motion.neutral, motion.fps)


class Reference:
    """Principal axes by numpy's singular value decomposition of all frames in double precision."""

    def __init__(self, motion: MeshMotion, vertices: Any = None, train: tuple[int, int] | None = None) -> None:
        start, stop = train or (0, len(motion))
        moved = motion.displacements(start, stop)
        self.mean = moved.mean(axis=0)
        centred = moved - self.mean
        metric = (centred if vertices is None else centred[:, vertices]).reshape(len(moved), -1)
        shares, singular, _ = np.linalg.svd(metric, full_matrices=False)
        rank = int((singular > 1e-9 * singular[0]).sum())
        self.eigenvalues: FloatArray = singular[:rank] ** 2 / len(moved)
        self.total = float((metric**2).sum() / len(moved))
        self.axes = np.tensordot((shares[:, :rank] / singular[:rank]).T, centred, axes=1)


def misaligned(axes: FloatArray, reference: FloatArray) -> float:
    """Return the largest distance of an axis from the reference's of either sign, over the length of that."""
    worst = 0.0
    for axis, wanted in zip(axes, reference, strict=True):
        distance = min(np.linalg.norm(axis - wanted), np.linalg.norm(axis + wanted))
        worst = max(worst, float(distance / np.linalg.norm(wanted)))
    return worst


FORMS: dict[str, Callable[[], MeshMotion]] = {
    "factored": factored,
    "driven": driven,
    "driven about a mean": lambda: driven(mean=True),
    "dense": lambda: dense(factored()),
    "dense, few frames": lambda: dense(factored(frames=60)),
    "dense, few vertices": lambda: dense(factored(vertices=80, markers=20, frames=900, fade=0.7)),
    "streamed": lambda: streamed(driven()),
    "streamed, few frames": lambda: streamed(factored(frames=60)),
}
