"""Box-bounded least squares of many frames that share one matrix (ours; daqp where grouping does not settle)."""

from __future__ import annotations

import numpy as np

from engine.mesh import FloatArray
from engine.progress import Progress, silent

FLOOR = 1e-9
"""Smallest ridge, as a share of the largest squared singular value: it makes the optimum of dependent shapes one."""


def solve_bounded(
    factor: FloatArray,
    targets: FloatArray,
    free: FloatArray,
    bounds: tuple[float, float],
    ridge: float = 0.0,
    *,
    start: FloatArray | None = None,
    progress: Progress = silent,
) -> FloatArray:
    """Return argmin ``|t - w factor|^2 + ridge |w|^2`` with ``lo <= w <= hi`` of every target (L, n).

    Parameters
    ----------
    factor : (n, k) float
    targets : (L, k) float
    free : (L, n) float
        The optimum without bounds; frames where it lies within them are done.
    """
    import daqp

    low, high = bounds
    found = np.array(free)
    n = len(factor)
    gram = factor @ factor.T
    gram[np.diag_indices(n)] += max(ridge, FLOOR * float(np.linalg.svd(factor, compute_uv=False)[0]) ** 2)
    linear = -targets @ factor.T
    upper, lower = np.full(n, min(high, 1e30)), np.full(n, max(low, -1e30))
    empty = np.zeros((0, n))
    todo = np.flatnonzero(((free < low) | (free > high)).any(axis=1))
    for step, k in enumerate(todo):
        if step % 512 == 0:
            progress(step / len(todo), "Solving weights")
        x, _, _flag, _ = daqp.solve(gram, linear[k], empty, upper, lower)
        found[k] = np.clip(x, low, high)
    progress(1.0, "Solving weights")
    return found
