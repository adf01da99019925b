"""What every way to the principal axes hands over, and how many axes are kept of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from engine.errors import InputError
from engine.mesh import FloatArray, IntArray

Columns = IntArray | slice
"""Which of the 3 N coordinates of a frame the inner product is over."""
SIGN_MARGIN = 1e-3
"""Components this close to the largest count as equal (left and right of a face often are): the first one decides."""
COVERED = 1e-12
"""A coverage counts as reached this much below it, so that rounding adds no axis."""


@dataclass(frozen=True)
class Decomposition:
    """Mean, variances and axes of a motion.

    Attributes
    ----------
    mean : (N, 3) float
        Mean displacement, mm.
    eigenvalues : (r,) float
        Descending, all above 0, mm^2; empty when the motion does not move.
    total_variance : float
        Sum of all of them, those that are not known included, mm^2.
    axes : callable
        ``axes(m)`` returns the first m axes (m, N, 3), orthonormal over the vertices of the metric.
    """

    mean: FloatArray
    eigenvalues: FloatArray
    total_variance: float
    axes: Callable[[int], FloatArray]


def columns_of(vertices: IntArray | None) -> Columns:
    """Return the coordinates x, y, z of vertices among the 3 N of a frame; of all for None."""
    if vertices is None:
        return slice(None)
    columns: IntArray = (3 * vertices[:, None] + np.arange(3)).ravel()
    return columns


def axes_for(eigenvalues: FloatArray, total: float, wanted: float | int) -> int:
    """Return the number of axes for a coverage (float) or a count (int).

    Raises
    ------
    InputError
        When fewer axes are there than the count.
    """
    if isinstance(wanted, int):
        if wanted > len(eigenvalues):
            problem = f"is {wanted}, but the frames differ along {len(eigenvalues)} axes only"
            raise InputError("count", problem, f"give at most {len(eigenvalues)}")
        return wanted
    reached = np.cumsum(eigenvalues) >= wanted * (1 - COVERED) * total
    return int(np.argmax(reached)) + 1 if reached.any() else len(eigenvalues)


def rank_of(singular: FloatArray, rows: int, offset: float) -> int:
    """Return how many singular values (descending) of ``rows`` centred frames are more than rounding.

    ``offset`` is the length of what was subtracted from every frame: its rounding stays in them.
    """
    if not len(singular):
        return 0
    epsilon = float(np.finfo(np.float64).eps)
    floor = epsilon * max(max(rows, len(singular)) * float(singular[0]), 64 * np.sqrt(rows) * offset)
    return int((singular > floor).sum())


def fix_signs(axes: FloatArray, vertices: IntArray | None) -> None:
    """Turn axes (m, N, 3), in place, so that the largest component over ``vertices`` is positive."""
    for axis in axes:
        components = (axis if vertices is None else axis[vertices]).ravel()
        size = np.abs(components)
        if components[np.argmax(size >= (1 - SIGN_MARGIN) * size.max())] < 0:
            np.negative(axis, out=axis)


def stacked(triangle: FloatArray, rows: FloatArray) -> FloatArray:
    """Return the triangle of the QR factorisation of all rows so far: ``triangle`` and the next ones."""
    found: FloatArray = np.asarray(np.linalg.qr(np.vstack([triangle, rows]), mode="r"))
    return found


def orthonormal_over(rows: FloatArray, columns: Columns) -> FloatArray:
    """Return nearly orthonormal rows made so over ``columns``, each by those before it."""
    metric = rows[:, columns]
    lower = np.linalg.cholesky(metric @ metric.T)
    # As good as solving: rows that are nearly orthonormal leave ``lower`` near the identity.
    made: FloatArray = np.linalg.inv(lower) @ rows
    return made
