"""Thin-plate spline: the smoothest map that carries one set of points exactly onto another."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.spatial.distance import cdist

from engine.errors import InputError
from engine.mesh import FloatArray, frozen


class ThinPlateSpline:
    """Interpolating thin-plate spline in the plane or in space.

    F(u) = A(u) + sum_j lambda_j phi(|u - u_j|) with A affine, phi(r) = r^2 log r in the plane and r in space, under
    the side conditions sum lambda = 0 and sum lambda u = 0 that make the bending energy finite and the system
    solvable. Source points are centred and scaled to a unit box first, which keeps the condition number near 1e4
    where raw pixels give 1e15.

    Parameters
    ----------
    source : (k, 2) or (k, 3) float
        Points to be carried, any unit.
    target : (k, m) float
        Where they go; usually m equals the dimension of the source.

    Raises
    ------
    InputError
        With too few points, two at one place, or all on a line (in space: in a plane).

    Notes
    -----
    Yano & Harada 2009, section 3.1, with the side conditions the paper leaves out; Bookstein 1989.
    """

    def __init__(self, source: ArrayLike, target: ArrayLike) -> None:
        self._system = _System(np.asarray(source, dtype=np.float64))
        values = np.asarray(target, dtype=np.float64)
        if values.ndim != 2 or len(values) != len(self._system.nodes):
            raise InputError(
                "thin-plate target", f"has shape {values.shape}", f"give {len(self._system.nodes)} rows, one a point"
            )
        if not np.isfinite(values).all():
            raise InputError("thin-plate target", "has a value that is not finite", "place every point first")
        self._shift = values.mean(axis=0)
        self._weights = frozen(self._system.solve(values - self._shift), np.float64)

    def __call__(self, points: ArrayLike) -> FloatArray:
        """Return F at ``points`` (n, d) as (n, m)."""
        result: FloatArray = self._system.terms(np.asarray(points, dtype=np.float64)) @ self._weights + self._shift
        return result

    def jacobian(self, points: ArrayLike) -> FloatArray:
        """Return dF_i/du_j at ``points`` (n, d) as (n, m, d), analytically.

        The kernel r of space has no derivative at its own node; its share there is taken as zero.
        """
        gradient = self._system.term_gradients(np.asarray(points, dtype=np.float64))
        result: FloatArray = np.einsum("ntd,tm->nmd", gradient, self._weights)
        return result


def warp_operator(source: ArrayLike, points: ArrayLike) -> FloatArray:
    """Return the matrix (n, k) that turns any target of ``source`` into the spline's values at ``points``.

    The spline is linear in its target, so where source and evaluation points stay (a template whose fiducials are
    dragged) a whole warp is one small product.

    Parameters
    ----------
    source : (k, d) float
        The spline's nodes.
    points : (n, d) float
        Where it will be evaluated.

    Raises
    ------
    InputError
        As ``ThinPlateSpline``.
    """
    system = _System(np.asarray(source, dtype=np.float64))
    terms = system.terms(np.asarray(points, dtype=np.float64))
    return frozen(terms @ system.solve(np.eye(len(system.nodes))), np.float64)


class _System:
    """The linear system of one set of nodes, in unit-box coordinates."""

    def __init__(self, source: FloatArray) -> None:
        _check_nodes(source)
        self.dimension = source.shape[1]
        self.centre = source.mean(axis=0)
        self.scale = float(np.ptp(source, axis=0).max())
        self.nodes = (source - self.centre) / self.scale
        count, extra = len(source), self.dimension + 1
        polynomial = np.hstack([np.ones((count, 1)), self.nodes])
        matrix = np.zeros((count + extra, count + extra))
        matrix[:count, :count] = self._kernel(cdist(self.nodes, self.nodes))
        matrix[:count, count:] = polynomial
        matrix[count:, :count] = polynomial.T
        self._matrix, self._factor = matrix, lu_factor(matrix)

    def solve(self, values: FloatArray) -> FloatArray:
        """Return the weights (k + d + 1, m); one step of refinement keeps the residual at rounding level."""
        right = np.vstack([values, np.zeros((self.dimension + 1, values.shape[1]))])
        weights = lu_solve(self._factor, right)
        weights += lu_solve(self._factor, right - self._matrix @ weights)
        return np.asarray(weights, dtype=np.float64)

    def terms(self, points: FloatArray) -> FloatArray:
        """Return kernel and polynomial values (n, k + d + 1) at ``points``."""
        scaled = (points - self.centre) / self.scale
        return np.hstack([self._kernel(cdist(scaled, self.nodes)), np.ones((len(scaled), 1)), scaled])

    def term_gradients(self, points: FloatArray) -> FloatArray:
        """Return the gradients (n, k + d + 1, d) of the terms in the caller's unit."""
        scaled = (points - self.centre) / self.scale
        offsets = scaled[:, None, :] - self.nodes[None]
        radius = np.linalg.norm(offsets, axis=2)
        safe = np.where(radius > 0, radius, 1.0)
        factor = np.where(radius > 0, 2 * np.log(safe) + 1 if self.dimension == 2 else 1 / safe, 0.0)
        gradient = np.zeros((len(scaled), len(self.nodes) + self.dimension + 1, self.dimension))
        gradient[:, : len(self.nodes)] = factor[..., None] * offsets
        gradient[:, len(self.nodes) + 1 :] = np.eye(self.dimension)
        return gradient / self.scale

    def _kernel(self, radius: NDArray[Any]) -> FloatArray:
        if self.dimension == 3:
            return np.asarray(radius, dtype=np.float64)
        return radius**2 * np.log(np.where(radius > 0, radius, 1.0))


def _check_nodes(source: FloatArray) -> None:
    if source.ndim != 2 or source.shape[1] not in (2, 3):
        raise InputError("thin-plate source", f"has shape {source.shape}", "give rows of 2 or 3 coordinates")
    dimension = source.shape[1]
    if len(source) < dimension + 1:
        raise InputError("thin-plate source", f"has {len(source)} points", f"give at least {dimension + 1}")
    if not np.isfinite(source).all():
        raise InputError("thin-plate source", "has a coordinate that is not finite", "place every point first")
    extent = float(np.ptp(source, axis=0).max())
    distances = cdist(source, source)
    distances[np.diag_indices(len(source))] = np.inf
    first, second = np.unravel_index(int(distances.argmin()), distances.shape)
    if distances[first, second] <= 1e-9 * max(extent, 1e-300):
        raise InputError("thin-plate source", f"points {first} and {second} are at one place", "move one of them")
    spread = np.linalg.svd(source - source.mean(axis=0), compute_uv=False)
    if spread[-1] <= 1e-7 * spread[0]:
        flat = "on one line" if dimension == 2 else "in one plane"
        raise InputError("thin-plate source", f"all points lie {flat}", "add one beside it")
