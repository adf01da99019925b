"""Frames of a dense or streamed motion as rows of a matrix, a piece at a time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.mesh import FloatArray
from engine.motion import MeshMotion

CHUNK_BYTES = 32 << 20
"""More is no faster: products of this size keep the cores busy."""
CHUNK_FRAMES = 512
"""Sums in single precision over more frames than this lose digits."""


class FrameChunks:
    """Rows ``x(t) = v(t) - reference`` (3 N) of a motion, made piece by piece in a buffer.

    Parameters
    ----------
    motion : MeshMotion
        Dense or streamed.
    memory : int
        Most bytes for a piece.
    double : bool
        Compute in double precision also where the positions are kept in single.
    """

    def __init__(self, motion: MeshMotion, memory: int, double: bool = True) -> None:
        self.motion = motion
        self.columns = motion.neutral.size
        single = not double and motion.positions(0, 1).dtype == np.float32
        self.dtype: np.dtype[Any] = np.dtype(np.float32 if single else np.float64)
        self.bytes = max(1, min(memory, CHUNK_BYTES))
        self.reference: FloatArray = motion.neutral.ravel()

    def __len__(self) -> int:
        return len(self.motion)

    def sample(self, most: int) -> FloatArray:
        """Return at most so many frames evenly spread (s, 3 N), about their mean: the reference from now on."""
        at = np.unique(np.linspace(0, len(self) - 1, min(most, len(self))).round().astype(int))
        rows = np.empty((len(at), self.columns))
        for row, frame in zip(rows, at.tolist(), strict=True):
            row[:] = self.motion.positions(frame, frame + 1).ravel()
        # In the precision of the data the difference of near positions is exact, and so is the reference.
        self.reference = rows.mean(axis=0).astype(self.dtype).astype(np.float64)
        rows -= self.reference
        return rows

    def chunks(self, checked: bool = False) -> Iterator[NDArray[Any]]:
        """Yield rows (c, 3 N) over all frames; their buffer is used again.

        Raises
        ------
        InputError
            When ``checked``, with the first frame that holds numbers that are not finite.
        """
        reference = self.reference.astype(self.dtype)
        step = min(max(1, self.bytes // (self.dtype.itemsize * self.columns)), CHUNK_FRAMES, len(self))
        buffer = np.empty((step, self.columns), self.dtype)
        for start in range(0, len(self), step):
            stop = min(start + step, len(self))
            positions = self.motion.positions(start, stop, checked).reshape(stop - start, -1)
            yield np.subtract(positions, reference, out=buffer[: stop - start])

    def blocks(self) -> Iterator[tuple[int, FloatArray]]:
        """Yield ``(first, columns)``: displacements of the vertices from ``first`` on over all frames (L, 3 b).

        Raises
        ------
        InputError
            With the first frame that holds numbers that are not finite.
        """
        count = len(self.motion.neutral)
        step = int(np.clip(self.bytes // (24 * len(self)), 1, count))
        chunk = max(1, self.bytes // (8 * self.columns))
        for first in range(0, count, step):
            last = min(first + step, count)
            block = np.empty((len(self), 3 * (last - first)))
            for start in range(0, len(self), chunk):
                stop = min(start + chunk, len(self))
                positions = self.motion.positions(start, stop, first == 0)[:, first:last]
                np.subtract(positions, self.motion.neutral[first:last], out=block[start:stop].reshape(positions.shape))
            yield first, block
