"""Box-bounded least squares of frames that share one matrix: daqp, warm from frame to frame, every frame checked."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from engine.mesh import FloatArray, IntArray
from engine.progress import Progress, silent

FLOOR = 1e-12
"""Smallest ridge, as a share of the mean squared length of the shapes: rounding leaves no curvature below it."""
DEPENDENT_FLOOR = 1e-9
"""The same for dependent shapes: of all optima it picks the one of least norm, and costs 1e-9 of it squared."""
SETTLED = 1e-7
"""Largest slope of a frame's error that is left along an allowed direction, as a share of shape times frame."""
AT_BOUND = 1e-8
"""Distance from a bound, as a share of the bounds' width, from which a weight stands at it."""
SMALL_ERROR = 1e-2
"""Error, as a share of the frame, below which dependent shapes are solved once more."""
UNBOUNDED = 1e30
BATCH = 256


def solve_bounded(
    factor: FloatArray,
    targets: FloatArray,
    free: FloatArray,
    bounds: tuple[float, float],
    ridge: float = 0.0,
    *,
    progress: Progress = silent,
) -> FloatArray:
    """Return argmin ``|t - w factor|^2 + ridge |w|^2`` with ``lo <= w <= hi`` of every target (L, n).

    A frame whose free optimum lies within the bounds is done. The others go one after the other through one active-set
    solver that starts from the frame before: neighbours press against nearly the same bounds. Then the conditions of
    Karush, Kuhn and Tucker are checked on all frames at once, and a frame that fails them is solved anew.

    Parameters
    ----------
    factor : (n, k) float
        Of full column rank; k < n for dependent shapes.
    targets : (L, k) float
    free : (L, n) float
        The optimum without bounds.
    bounds : (lo, hi)
        lo < hi, infinite for none.
    ridge : float
        Absolute.

    Raises
    ------
    Cancelled
        Raised by ``progress``.
    """
    low, high = bounds
    todo = np.flatnonzero(((free < low) | (free > high)).any(axis=1))
    if not len(todo):
        progress(1.0, "Solving weights")
        return np.array(free)
    n = len(factor)
    scale = float(np.einsum("nk,nk->", factor, factor)) / n
    gram = factor @ factor.T / scale
    slope = -(targets[todo] @ factor.T) / scale
    floor = max(ridge / scale, FLOOR if factor.shape[1] == n else DEPENDENT_FLOOR)
    regular = gram + floor * np.eye(n)
    found = snapped(_sequence(regular, slope, bounds, progress), bounds)
    gram[np.diag_indices(n)] += ridge / scale
    left = unsettled(gram, slope, found, bounds)
    for k in left:
        found[k] = _alone(regular, slope[k], bounds)
    if factor.shape[1] < n and not ridge:
        # The floor leaves 1e-6 of a frame where its error could vanish: a second one about the first answer does not.
        near = np.linalg.norm(targets[todo] - found @ factor, axis=1) < SMALL_ERROR * np.linalg.norm(
            targets[todo], axis=1
        )
        if near.any():
            found[near] = snapped(_sequence(regular, slope[near] - floor * found[near], bounds, progress), bounds)
    solved = np.array(free)
    solved[todo] = found
    progress(1.0, "Solving weights")
    return solved


def snapped(weights: FloatArray, bounds: tuple[float, float]) -> FloatArray:
    """Return weights within the bounds, those at a bound to rounding exactly there."""
    low, high = bounds
    width = high - low if np.isfinite(high - low) else max(abs(side) for side in bounds if np.isfinite(side)) or 1.0
    inside = np.where(weights <= low + AT_BOUND * width, low, weights)
    return np.asarray(np.where(inside >= high - AT_BOUND * width, high, inside), dtype=np.float64)


def unsettled(gram: FloatArray, slope: FloatArray, weights: FloatArray, bounds: tuple[float, float]) -> IntArray:
    """Return the rows of ``weights`` (L, n) that are not the optimum of ``w gram w / 2 + slope w`` within bounds."""
    low, high = bounds
    gradient = weights @ gram + slope
    gradient[(weights <= low) & (gradient > 0)] = 0
    gradient[(weights >= high) & (gradient < 0)] = 0
    size = np.abs(slope).max(axis=1) + np.abs(weights).max(axis=1) * np.abs(gram).max()
    wrong: IntArray = np.flatnonzero(~(np.abs(gradient).max(axis=1) <= SETTLED * size))
    return wrong


def _limits(bounds: tuple[float, float], n: int) -> tuple[FloatArray, FloatArray]:
    low, high = bounds
    return np.full(n, float(max(low, -UNBOUNDED))), np.full(n, float(min(high, UNBOUNDED)))


def _sequence(gram: FloatArray, slope: FloatArray, bounds: tuple[float, float], progress: Progress) -> FloatArray:
    import daqp

    lower, upper = _limits(bounds, len(gram))
    found = np.zeros(slope.shape)
    model: Any = daqp.Model()
    model.setup(gram, slope[0].copy(), np.zeros((0, len(gram))), upper, lower)
    model.settings = {"primal_tol": 1e-10}
    for start in range(0, len(slope), BATCH):
        progress(start / len(slope), "Solving weights")
        time.sleep(0)  # lets the thread of a window draw
        for k in range(start, min(start + BATCH, len(slope))):
            model.update(f=slope[k])
            found[k] = model.solve()[0]
    return found


def _alone(gram: FloatArray, slope: FloatArray, bounds: tuple[float, float]) -> FloatArray:
    """Return the optimum of one frame, by the solver from nothing, or else by bounded-variable least squares."""
    import daqp

    lower, upper = _limits(bounds, len(gram))
    found, _, flag, _ = daqp.solve(gram, slope, np.zeros((0, len(gram))), upper, lower)
    found = snapped(found, bounds)
    if flag > 0 and not len(unsettled(gram, slope[None], found[None], bounds)):
        return np.asarray(found, dtype=np.float64)
    from scipy.optimize import lsq_linear

    upright = np.linalg.cholesky(gram).T
    target = np.linalg.solve(upright.T, -slope)
    exact = lsq_linear(upright, target, bounds, method="bvls", max_iter=50 * len(gram), tol=1e-14)
    return snapped(np.asarray(exact.x, dtype=np.float64), bounds)
