"""Hand shapes for small motions, and the plain float64 answers that the small coordinates must give."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.basis.principal import PrincipalBasis
from engine.mesh import FloatArray
from engine.motion import MeshMotion
from engine.shapes import ExpressionBasis

SKIN = np.arange(7, 71)
"""A metric's vertices that leave out some at both ends."""


def random_hand(motion: MeshMotion, count: int, seed: int = 1, size: float = 4.0) -> ExpressionBasis:
    """Return shapes that have nothing to do with the motion."""
    shapes = size * np.random.default_rng(seed).normal(size=(count, *motion.neutral.shape))
    return ExpressionBasis(motion.neutral, tuple(f"shape {i}" for i in range(count)), shapes)


def likely_hand(motion: MeshMotion, count: int, seed: int = 1, away: float = 0.4) -> ExpressionBasis:
    """Return frames of the motion, each re-sculpted by a random field of ``away`` times its size."""
    random = np.random.default_rng(seed)
    chosen = random.choice(len(motion), count, replace=False)
    shapes = np.stack([motion.displacements(k, k + 1)[0] for k in chosen])
    fields = random.normal(size=shapes.shape)
    fields *= (
        away * np.linalg.norm(shapes, axis=(1, 2), keepdims=True) / np.linalg.norm(fields, axis=(1, 2), keepdims=True)
    )
    return ExpressionBasis(motion.neutral, tuple(f"shape {i}" for i in range(count)), shapes + fields)


def flat(values: FloatArray, vertices: Any = None) -> FloatArray:
    """Return (..., N, 3) as (..., 3V)."""
    kept = values if vertices is None else values[..., vertices, :]
    return kept.reshape(*kept.shape[:-2], -1)


def true_errors(motion: MeshMotion, basis: ExpressionBasis, weights: FloatArray) -> FloatArray:
    """Return the error (L, N, 3) of every vertex in every frame."""
    return motion.neutral + motion.displacements(0, len(motion)) - basis.evaluate(weights)


def true_alpha(motion: MeshMotion, errors: FloatArray, vertices: Any = None) -> tuple[FloatArray, float]:
    """Return eq. 6 about the centroid of the neutral face: of every frame, and pooled."""
    neutral = motion.neutral if vertices is None else motion.neutral[vertices]
    placed = flat(motion.neutral + motion.displacements(0, len(motion)) - neutral.mean(axis=0), vertices)
    error, size = np.linalg.norm(flat(errors, vertices), axis=1), np.linalg.norm(placed, axis=1)
    return 100 * error / size, float(100 * np.sqrt((error**2).sum() / (size**2).sum()))


def shares(principal: PrincipalBasis) -> FloatArray:
    """Return the standard deviation of every axis."""
    return np.sqrt(principal.eigenvalues[: principal.count])
