"""Principal axes of a long dense motion: a block Krylov iteration whose products stream over the frames (ours).

The space starts as the principal axes of frames spread evenly over the motion and a few random directions. Every pass
over the frames multiplies one block by the covariance (1/L) X^T X, takes the best axes that the space holds
(Rayleigh-Ritz) and adds their residuals as the next block, until the residuals of the wanted axes are small. The total
variance is that of all frames, from the first pass, so a coverage is never that of a sample.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from engine.basis.frame_chunks import FrameChunks
from engine.basis.spectrum import Columns, Decomposition, axes_for, orthonormal_over
from engine.errors import InputError
from engine.mesh import FloatArray
from engine.progress import Progress

SAMPLE = 256
"""Frames that the iteration starts from."""
EXTRA = 30
"""Axes beyond the wanted ones at the start: the wanted ones converge faster, at little more per product."""
BEYOND = 5
"""Axes beyond the wanted ones that are followed to the end: what comes next belongs on a scree plot."""
RANDOM = 4
"""Random directions at the start, so that what no sampled frame does is found as well."""
TOLERANCE = {4: 1e-5, 8: 1e-9}
"""Largest residual |C e - lambda e| / lambda of a wanted axis, by the bytes of a number. The axes are better than this:
what is returned is C e / lambda."""
SETTLED = 1e-4
"""A residual below this that a pass no longer halves has come down to rounding."""
KNOWN = 3e-3
"""Residual up to which a further eigenvalue counts as known: its error is of the order of the square."""
PASSES = 300
PIECE = 8192
NOTHING = 64 * float(np.finfo(np.float64).eps)
NOTHING_SQUARED = {4: 1e-7, 8: NOTHING}
"""Share of the largest eigenvalue below which a product with the covariance holds rounding only."""


class _Space:
    """Orthonormal vectors over the metric, their products with the covariance, and the best axes that they hold."""

    def __init__(self, frames: FrameChunks, columns: Columns, room: int, progress: Progress) -> None:
        self.frames, self.columns, self.progress = frames, columns, progress
        width = len(frames.reference[columns])
        self.room = min(room, width)
        self._vectors = np.empty((self.room, width))
        self._products = np.empty((self.room, frames.columns))
        self._inner = np.zeros((self.room, self.room))
        self.size = self.passes = 0
        self.drift: FloatArray = np.zeros(frames.columns)
        self.total = 0.0
        self.values: FloatArray = np.zeros(0)
        self._turn: FloatArray = np.zeros((0, 0))

    @property
    def vectors(self) -> FloatArray:
        return self._vectors[: self.size]

    @property
    def products(self) -> FloatArray:
        return self._products[: self.size]

    def add(self, block: FloatArray) -> None:
        """Multiply orthonormal rows over the metric by the covariance, and find the best axes with them."""
        old, self.size = self.size, self.size + len(block)
        self._vectors[old : self.size] = block
        self._multiply(self._vectors[old : self.size], self._products[old : self.size])
        inner = self.vectors @ self._products[old : self.size, self.columns].T
        self._inner[: self.size, old : self.size] = inner
        self._inner[old : self.size, : self.size] = inner.T
        within = self._inner[: self.size, : self.size]
        values, turn = np.linalg.eigh((within + within.T) / 2)
        self.values, self._turn = values[::-1], turn[:, ::-1].T

    def turned_products(self, count: int) -> FloatArray:
        """Return the covariance times the first axes (count, 3 N)."""
        found: FloatArray = self._turn[:count] @ self.products
        return found

    def residuals(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return the residuals of the first axes over the metric, and their lengths over the eigenvalues."""
        rows = np.empty((count, self._vectors.shape[1]))
        scaled = self.values[:count, None] * self._turn[:count]
        for at in pieces(rows.shape[1]):
            columns = at if isinstance(self.columns, slice) else self.columns[at]
            rows[:, at] = self._turn[:count] @ self.products[:, columns] - scaled @ self.vectors[:, at]
        return rows, np.sqrt(np.einsum("ij,ij->i", rows, rows)) / self.values[:count]

    def keep(self, count: int) -> None:
        """Forget all but the first axes."""
        for held in (self._vectors, self._products):
            for at in pieces(held.shape[1]):
                held[:count, at] = self._turn[:count] @ held[: self.size, at]
        self._inner[:count, :count] = np.diag(self.values[:count])
        self.size, self.values, self._turn = count, self.values[:count], np.eye(count)

    def _multiply(self, block: FloatArray, product: FloatArray) -> None:
        frames, first = self.frames, not self.passes
        wide = np.zeros((len(block), frames.columns), frames.dtype)
        wide[:, self.columns] = block
        product[:] = 0
        sums, squares = np.zeros(frames.columns), np.zeros(frames.columns)
        done = 0
        for rows in frames.chunks(checked=first):
            scores = (rows @ wide.T).T
            for at in pieces(frames.columns):
                product[:, at] += scores @ rows[:, at]
            if first:
                sums += rows.sum(axis=0)
                squares += np.einsum("ij,ij->j", rows, rows)
            done += len(rows)
            self.progress(1 - 0.8 ** (self.passes + done / len(frames)), "principal axes")
        if first:
            self.drift = sums / len(frames)
            self.total = float((squares / len(frames) - self.drift**2)[self.columns].sum())
        self.passes += 1
        product /= len(frames)
        # The rows lie about a reference near the mean; what it is off by is taken out here.
        offset = block @ self.drift[self.columns]
        for row, off in zip(product, offset, strict=True):
            row -= off * self.drift


def decompose_iterated(
    frames: FrameChunks, columns: Columns, wanted: float | int, memory: int, progress: Progress
) -> Decomposition:
    """Return the leading axes of dense or streamed frames, as many as are wanted and what else is known.

    Parameters
    ----------
    frames : FrameChunks
        The training frames.
    columns : (3 V,) int or slice
        Columns of the metric.
    wanted : float or int
        Coverage or count.
    memory : int
        Most bytes for working arrays, the chunks of ``frames`` included.
    progress : Progress
        Told after every chunk.

    Raises
    ------
    InputError
        When ``memory`` does not hold the wanted axes, or positions are not finite.
    """
    # Beside a chunk stand what a reader made it of, and that in double precision.
    rows = max(0, memory - 3 * frames.bytes) // (8 * frames.columns)
    # The space takes two rows a vector; a block and what it is made of take three.
    most, room = rows // 7, 2 * rows // 7
    if most < 2 or (isinstance(wanted, int) and wanted > most):
        raise _too_little(memory, most, frames, wanted)
    start = _start(frames, columns, wanted, most, rows // 4)
    space = _Space(frames, columns, min(room, len(frames) + EXTRA + RANDOM), progress)
    space.add(start[: space.room])
    del start
    unseen = space.products[-RANDOM:, columns]
    quiet = NOTHING * float(np.linalg.norm(frames.reference[columns]))
    known, last = 0, np.inf
    while space.total > quiet**2:
        rank = int((space.values > NOTHING_SQUARED[frames.dtype.itemsize] * space.values[0]).sum())
        count = min(wanted, rank) if isinstance(wanted, int) else axes_for(space.values[:rank], space.total, wanted)
        if count > most:
            raise _too_little(memory, most, frames, wanted)
        follow = min(rank, count + BEYOND, most)
        block = np.zeros((0, 0))
        block, size = space.residuals(follow)
        known = count + int(np.argmax(np.append(size[count:], np.inf) > KNOWN))
        worst = float(size[:count].max())
        settled = worst <= TOLERANCE[frames.dtype.itemsize] or last / 2 < worst < SETTLED
        last = worst
        if (count < rank and space.passes > 1 and settled) or space.passes == PASSES:
            break
        block = block[size > TOLERANCE[frames.dtype.itemsize]]
        if space.passes == 1:
            # An axis that no sampled frame moves along is in no residual yet, only in what became of random directions.
            block = np.vstack([block, unseen])
        if space.size + len(block) > space.room:
            space.keep(min(space.size, count + EXTRA, space.room - len(block)))
        block = orthonormal(block, space.vectors)
        if not len(block):
            break
        space.add(block)

    def axes(count: int) -> FloatArray:
        # One more product with the covariance: nearer than the vector itself, and there on all vertices.
        made = space.turned_products(count)
        made /= space.values[:count, None]
        return orthonormal_over(made, columns).reshape(count, -1, 3)

    mean = (frames.reference + space.drift - frames.motion.neutral.ravel()).reshape(-1, 3)
    return Decomposition(mean, space.values[:known], space.total, axes)


def orthonormal(block: FloatArray, against: FloatArray) -> FloatArray:
    """Return orthonormal rows that span what ``block`` adds to orthonormal rows ``against``; fewer where it is less.

    The rows of ``block`` are written over.
    """
    block /= np.maximum(np.sqrt(np.einsum("ij,ij->i", block, block)), np.finfo(np.float64).tiny)[:, None]
    for _ in range(2):
        shares = block @ against.T
        for at in pieces(block.shape[1]):
            block[:, at] -= shares @ against[:, at]
        size, turn = np.linalg.eigh(block @ block.T)
        # What is left of a row after the projection may be its rounding only.
        kept = size > 1e-12
        made = (turn[:, kept] / np.sqrt(size[kept])).T
        for at in pieces(block.shape[1]):
            block[: len(made), at] = made @ block[:, at]
        block = block[: len(made)]
    return block


def pieces(width: int) -> Iterator[slice]:
    """Yield slices of columns: what is computed by them needs no second array of the whole width."""
    for first in range(0, width, PIECE):
        yield slice(first, min(first + PIECE, width))


def _start(frames: FrameChunks, columns: Columns, wanted: float | int, most: int, sample: int) -> FloatArray:
    """Return orthonormal rows over the metric to start from: axes of a sample of the frames, and random directions."""
    rows = frames.sample(min(SAMPLE, max(sample, 2)))[:, columns]
    size, turn = np.linalg.eigh(rows @ rows.T)
    size, turn = size[::-1], turn[:, ::-1]
    there = int((size > 1e-12 * max(float(size[0]), np.finfo(np.float64).tiny)).sum())
    count = wanted if isinstance(wanted, int) else axes_for(size[:there], float(size.sum()), wanted) if there else 0
    aim = max(min(count + EXTRA, most - RANDOM), 1)
    found = (turn[:, : min(there, aim)] / np.sqrt(size[: min(there, aim)])).T @ rows
    more = min(max(RANDOM, aim - len(found)), most - len(found), rows.shape[1] - len(found))
    random = np.random.default_rng(0).normal(size=(max(more, 0), rows.shape[1]))
    return np.vstack([found, orthonormal(random, found)])


def _too_little(memory: int, most: int, frames: FrameChunks, wanted: float | int) -> InputError:
    problem = f"{memory >> 20} MB hold at most {most} axes of {frames.columns // 3} vertices"
    needs = f"{wanted} are wanted" if isinstance(wanted, int) else f"a coverage of {wanted:g} takes more"
    return InputError("memory", f"{problem}, {needs}", "allow more memory, or ask for fewer axes")
