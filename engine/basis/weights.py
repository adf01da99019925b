"""The weights that bring a basis closest to a motion: least squares, free or within bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.basis.bounded import solve_bounded
from engine.basis.reduce import DEPENDENT, STILL, reduce_motion
from engine.errors import InputError
from engine.mesh import FloatArray, IntArray
from engine.motion import MeshMotion
from engine.progress import Progress, part, silent
from engine.shapes import ExpressionBasis, check_topology

Bounds = Sequence[float | None] | float | None
"""``(lo, hi)`` (None = no bound on that side), one number b for ``(-b, b)``, or None for free weights."""
BOUNDS: dict[str, tuple[float, float] | None] = {"0..1": (0.0, 1.0), "-1..2": (-1.0, 2.0), "free": None}
"""The bounds every basis is reported under (METHODS: hand in [0, 1] against quasi-eigen free compares two things)."""
SHAPE_PRECISION = 2e-5
"""Share of the largest direction of shapes of one length below which a direction is the rounding of a file.

Files keep float32 (6e-8 of a shape) or 5 decimals of a mm (some 5e-6 of one): what is below says nothing of the shapes
and would take weights of 1e5 to reach.
"""


def check_bounds(bounds: Bounds) -> tuple[float, float] | None:
    """Return bounds as ``(lo, hi)``, infinite where there is none, or None for free weights.

    Raises
    ------
    InputError
        Unless lo < hi, both finite or None; a single number must be above 0.
    """
    if bounds is None:
        return None
    remedy = "give two numbers LO < HI, one number above 0 for -B..B, or leave the weights free"
    if not isinstance(bounds, (int, float, np.number)) and any(isinstance(side, str) for side in bounds):
        raise InputError("bounds", f"are {str(bounds)[:40]!r}", remedy)
    if isinstance(bounds, (int, float, np.number)):
        if not (np.isfinite(bounds) and bounds > 0):
            raise InputError("bounds", f"are {float(bounds):g}", remedy)
        return -float(bounds), float(bounds)
    pair: list[Any] = list(bounds)
    if len(pair) != 2:
        raise InputError("bounds", f"are {len(pair)} numbers", remedy)
    if any(side is not None and not np.isfinite(side) for side in pair):
        raise InputError("bounds", "are not finite", remedy)
    low = -np.inf if pair[0] is None else float(pair[0])
    high = np.inf if pair[1] is None else float(pair[1])
    if not low < high:
        raise InputError("bounds", f"{low:g} is not below {high:g}", remedy)
    return None if np.isinf(low) and np.isinf(high) else (low, high)


def check_ridge(ridge: float) -> float:
    """Return ``ridge`` when it is finite and not below 0, else raise InputError."""
    if not (np.isfinite(ridge) and ridge >= 0):
        raise InputError("ridge", f"is {ridge:g}", "give a number from 0 (none) up; 0.001 is small")
    return float(ridge)


def solve_weights(
    basis: ExpressionBasis,
    frames: FloatArray | MeshMotion,
    bounds: Bounds = None,
    ridge: float = 0.0,
    *,
    vertices: IntArray | None = None,
    progress: Progress = silent,
) -> FloatArray:
    """Return the weights (L, n) that bring a basis closest to every frame (Kim & Ko 2007, eq. 5).

    Each frame minimises ``|d* - mean - sum_i w_i e_i|^2 + ridge s^2 |w|^2`` over the metric's vertices, ``s^2`` being
    the mean squared length of the shapes, so that a ridge has no unit (bounds and ridge: ours). Displacements are
    compared: those of a `MeshMotion` from its own neutral face, those of positions from the basis' neutral face.
    Free weights of dependent shapes are those of least norm; bounded ones come within 1e-8 |d*|^2 of the optimum.
    Shapes count as dependent to the precision that files keep, `SHAPE_PRECISION`.

    Parameters
    ----------
    basis : ExpressionBasis
    frames : (L, N, 3) float or MeshMotion
        Positions in mm, or a motion.
    bounds : (lo, hi), float or None
        One pair for all weights; None on a side, or for both, leaves it free; a number b means -b..b.
    ridge : float
        0 or above.
    vertices : (V,) int, optional
        The metric's vertices; all where left out.

    Raises
    ------
    InputError
        On another topology, numbers that are not finite, or bounds or a ridge that cannot be.
    Cancelled
        Raised by ``progress``.
    """
    pair, ridge = check_bounds(bounds), check_ridge(ridge)
    motion = frames if isinstance(frames, MeshMotion) else MeshMotion.dense(np.asarray(frames), basis.neutral, 1.0)
    check_topology("basis", len(basis.neutral), len(motion.neutral), "the motion")
    reduced = reduce_motion(motion, stacked(basis), vertices=vertices, progress=part(progress, 0, 0.5))
    shapes, mean = split(basis, reduced.shapes)
    return solve_reduced(reduced.frames - mean, shapes, pair, ridge, progress=part(progress, 0.5, 1))


def stacked(basis: ExpressionBasis) -> FloatArray:
    """Return the displacements of a basis (n, N, 3), its mean as one more where it has one, mm."""
    if basis.mean is None:
        return basis.displacements
    return np.concatenate([basis.displacements, basis.mean[None]])


def split(basis: ExpressionBasis, coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return coordinates (n, r) of the shapes and (r,) of the mean (0 without one) from those of `stacked`."""
    shapes = coordinates[: len(basis)]
    return shapes, np.zeros(coordinates.shape[1]) if basis.mean is None else coordinates[len(basis)]


def solve_reduced(
    targets: FloatArray,
    shapes: FloatArray,
    bounds: tuple[float, float] | None,
    ridge: float = 0.0,
    *,
    progress: Progress = silent,
) -> FloatArray:
    """Return the weights (L, n) that bring shapes (n, r) closest to targets (L, r), all in `Reduced` coordinates.

    Parameters
    ----------
    bounds : (lo, hi) or None
        As `check_bounds` returns them.
    """
    scale = float(np.einsum("nr,nr->", shapes, shapes)) / len(shapes)
    if not scale:
        within = (0.0, 0.0) if bounds is None else bounds
        return np.full((len(targets), len(shapes)), float(np.clip(0.0, *within)))
    factor, right = _factors(shapes)
    inner = targets @ right.T
    left, sizes, turn = np.linalg.svd(factor, full_matrices=False)
    kept = sizes > DEPENDENT * max(shapes.shape) * sizes[0]
    left, sizes, turn = left[:, kept], sizes[kept], turn[kept]
    free = (inner @ turn.T * (sizes / (sizes**2 + ridge * scale))) @ left.T
    if bounds is None:
        progress(1.0, "Solving weights")
        return np.asarray(free, dtype=np.float64)
    return solve_bounded(factor, inner, free, bounds, ridge * scale, progress=progress)


def _factors(shapes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ``factor`` (n, k) and orthonormal ``right`` (k, r): their product is the shapes to the precision of files.

    Judged on shapes of one length: a small shape is no rounding because another is large.
    """
    length = np.linalg.norm(shapes, axis=1)[:, None]
    units = np.divide(shapes, length, out=np.zeros_like(shapes), where=length > STILL * length.max())
    left, sizes, right = np.linalg.svd(units, full_matrices=False)
    kept = sizes > SHAPE_PRECISION * sizes[0]
    return length * left[:, kept] * sizes[kept], right[kept]
