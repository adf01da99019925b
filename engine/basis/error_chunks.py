"""Distances between a motion and its reconstruction, every vertex of a few frames at a time (ours)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.basis.reduce import moved, reduce_motion, restricted
from engine.basis.weights import split, stacked
from engine.mesh import FloatArray, IntArray
from engine.motion import MeshMotion
from engine.shapes import ExpressionBasis

Chunk = tuple[int, Callable[[], NDArray[Any]]]
"""The first frame of a chunk, and a function that returns the distances (c, V) in mm; it may run in any thread."""
CHUNK_VALUES = 1 << 21
"""Distances that are looked at together."""


class SmallErrors:
    """Errors of a factored or driven motion, chunk by chunk from their small coordinates, in single precision.

    The coordinates are those of the errors, computed in double precision, so that rounding is 1e-6 of an error.
    """

    def __init__(self, basis: ExpressionBasis, motion: MeshMotion, weights: FloatArray, at: IntArray | None) -> None:
        reduced = reduce_motion(motion, stacked(basis), vertices=at)
        assert reduced.rest is not None and reduced.columns.turn is not None
        shapes, mean = split(basis, reduced.shapes)
        errors = np.concatenate([reduced.frames - mean - weights @ shapes, reduced.rest], axis=1)
        self.vertices, self.points = reduced.vertices, reduced.count
        spread, span = reduced.columns.spread, reduced.columns.span.reshape(reduced.count, 3, -1)
        plain = errors @ reduced.columns.turn.T
        self._k = 0 if spread is None else spread.shape[1]
        inner = plain[:, : 3 * self._k].reshape(len(plain), self._k, 3)
        own = plain[:, 3 * self._k :]
        self._rows = [np.concatenate([inner[:, :, axis], own], axis=1) for axis in range(3)]
        beside = np.zeros((reduced.count, 0)) if spread is None else spread
        self._columns = [np.concatenate([beside, span[:, axis]], axis=1) for axis in range(3)]

    def chunks(self) -> Iterator[Chunk]:
        """Yield the start of every chunk and what computes its distances."""
        rows = [np.ascontiguousarray(part, dtype=np.float32) for part in self._rows]
        columns = [np.ascontiguousarray(part.T, dtype=np.float32) for part in self._columns]

        def distances(at: slice) -> NDArray[np.float32]:
            sizes = rows[0][at] @ columns[0]
            np.multiply(sizes, sizes, out=sizes)
            term = np.empty_like(sizes)
            for axis in (1, 2):
                np.matmul(rows[axis][at], columns[axis], out=term)
                np.multiply(term, term, out=term)
                sizes += term
            np.sqrt(sizes, out=sizes)
            return sizes

        step = max(1, CHUNK_VALUES // self.points)
        for start in range(0, len(rows[0]), step):
            yield start, partial(distances, slice(start, start + step))

    def exact(self, frames: IntArray, places: IntArray) -> FloatArray:
        """Return the distances of some vertices, each in its frame, in double precision, mm."""
        found = np.zeros(len(frames))
        for row, column in zip(self._rows, self._columns, strict=True):
            for start in range(0, len(frames), 4096):
                at = slice(start, start + 4096)
                found[at] += np.einsum("ik,ik->i", row[frames[at]], column[places[at]]) ** 2
        return np.asarray(np.sqrt(found), dtype=np.float64)


class LargeErrors:
    """Errors of a dense or streamed motion, chunk by chunk from the frames themselves, in double precision."""

    def __init__(self, basis: ExpressionBasis, motion: MeshMotion, weights: FloatArray, at: IntArray | None) -> None:
        self.vertices, self._motion, self._weights = at, motion, weights
        self._shapes = restricted(basis.displacements, at)
        self._mean = None if basis.mean is None else restricted(basis.mean, at)
        self.points = self._shapes.shape[1] // 3

    def chunks(self) -> Iterator[Chunk]:
        """Yield the start of every chunk and what computes its distances; frames are read here, in order."""

        def distances(start: int, found: FloatArray) -> FloatArray:
            errors = found - self._weights[start : start + len(found)] @ self._shapes
            if self._mean is not None:
                errors -= self._mean
            return np.asarray(np.linalg.norm(errors.reshape(len(errors), -1, 3), axis=2))

        for start, found in moved(self._motion, self.vertices):
            yield start, partial(distances, start, found)
