"""A motion in small orthonormal coordinates, and the frame that they belong to (ours)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engine.mesh import FloatArray, IntArray


@dataclass(frozen=True)
class Reduced:
    """A motion and some shapes in one orthonormal frame of the displacements over the metric's vertices (ours).

    A displacement over V vertices is a vector of 3V numbers. The frame's columns are orthonormal there, so inner
    products, norms and distances of coordinates are those of the displacements, to rounding. The first p columns span
    the shapes; the others hold what is left of a factored or driven motion.

    Attributes
    ----------
    vertices : (V,) int or None
        The metric's vertices; None = all.
    fps : float
        Frames a second of the motion.
    frames : (L, p) float
        Coordinates of every frame's displacement along the span of the shapes, mm.
    outside : (L,) float
        Squared length of what is outside that span of every frame, mm^2; from the remainder itself, never a difference.
    rest : (L, q) float or None
        Coordinates of what is outside, mm; None for dense and streamed motion, of which only the length is kept.
    shapes : (s, p) float
        Coordinates of the shapes, which the span holds whole, mm.
    along_neutral : (L,) float
        Inner product of every displacement with the neutral face about ``origin``, mm^2.
    neutral_squared : float
        Squared length of the neutral face about ``origin``, mm^2.
    origin : (3,) float
        Centroid of the neutral face over the metric's vertices, mm: the origin of eq. 6 here.
    columns : Columns
        The frame itself.
    """

    vertices: IntArray | None
    fps: float
    frames: FloatArray
    outside: FloatArray
    rest: FloatArray | None
    shapes: FloatArray
    along_neutral: FloatArray
    neutral_squared: float
    origin: FloatArray
    columns: Columns

    def __len__(self) -> int:
        return len(self.frames)

    @property
    def count(self) -> int:
        """Number of vertices of the metric."""
        return len(self.columns.span) // 3

    @cached_property
    def moved_squared(self) -> FloatArray:
        """|d*|^2 of every frame (L,), mm^2."""
        return squares(self.frames) + self.outside

    @cached_property
    def placed_squared(self) -> FloatArray:
        """|v*|^2 of every frame (L,) about ``origin``, mm^2: the denominator of eq. 6, squared."""
        return np.maximum(self.neutral_squared + 2 * self.along_neutral + self.moved_squared, 0)

    @cached_property
    def _rest_moment(self) -> FloatArray:
        assert self.rest is not None
        return np.asarray(self.rest.T @ self.rest)

    def vertex_mean_square(self, errors: FloatArray) -> FloatArray:
        """Return the mean over frames of every vertex' squared error (V,), mm^2, of a factored or driven motion.

        Uses the second moment of the coordinates, never the errors of vertices themselves.

        Parameters
        ----------
        errors : (L, p) float
            Coordinates of the errors along the span of the shapes; outside it an error is what the span lacks.
        """
        assert self.rest is not None
        across = errors.T @ self.rest
        moment = np.block([[errors.T @ errors, across], [across.T, self._rest_moment]]) / len(errors)
        return self.columns.vertex_squares(moment)


@dataclass(frozen=True)
class Columns:
    """Orthonormal columns ``[Q (x) I3, span] turn`` over V vertices; Q and the turn may be missing (ours).

    Attributes
    ----------
    spread : (V, k) float or None
        Q, orthonormal columns of a factored motion.
    span : (3V, j) float
        Orthonormal columns beside Q (x) I3.
    turn : (3k + j, r) float or None
        Orthogonal; None = none.
    """

    spread: FloatArray | None
    span: FloatArray
    turn: FloatArray | None

    def vertex_squares(self, moment: FloatArray) -> FloatArray:
        """Return the mean squared length (V,) of every vertex from the second moment (r, r) of coordinates."""
        if self.turn is not None:
            moment = self.turn @ moment @ self.turn.T
        count = len(self.span) // 3
        k = 0 if self.spread is None else self.spread.shape[1]
        span = self.span.reshape(count, 3, -1)
        own = moment[3 * k :, 3 * k :]
        total = np.einsum("vcj,vcj->v", (self.span @ own).reshape(span.shape), span)
        if self.spread is not None:
            inner = np.einsum("acbc->ab", moment[: 3 * k, : 3 * k].reshape(k, 3, k, 3))
            across = np.ascontiguousarray(moment[: 3 * k, 3 * k :]).reshape(k, -1)
            total += np.einsum("vk,vk->v", self.spread @ inner, self.spread)
            total += 2 * np.einsum("vcj,vcj->v", (self.spread @ across).reshape(span.shape), span)
        return np.asarray(np.maximum(total, 0), dtype=np.float64)


def squares(vectors: FloatArray) -> FloatArray:
    """Return the squared length (L,) of every row."""
    return np.asarray(np.einsum("lr,lr->l", vectors, vectors), dtype=np.float64)
