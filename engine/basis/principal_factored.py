"""Principal axes of factored and driven motion, exact in the few dimensions it moves in.

Such a motion is ``d(t) = A g(t)``: A spreads markers or holds shapes, g are marker displacements or weights. With
``A = Q R`` over the vertices of the metric, d and ``y = R g`` have the same inner products (Kim & Ko 2007, section 4;
the factorisation is ours). ``A^T A`` would square the condition and is never formed, nor is ``y^T y``: triangles of QR
factorisations are stacked over chunks of frames instead.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from engine.basis.spectrum import Decomposition, columns_of, orthonormal_over, rank_of, stacked
from engine.mesh import FloatArray, IntArray
from engine.motion import MeshMotion
from engine.progress import Progress

CHUNK_FRAMES = 8192


def decompose_factored(motion: MeshMotion, vertices: IntArray | None, memory: int, progress: Progress) -> Decomposition:
    """Return the whole spectrum of a factored or driven motion, and its axes on demand.

    Parameters
    ----------
    motion : MeshMotion
        Factored or driven; the training frames only.
    vertices : (V,) int or None
        Vertices of the metric.
    memory : int
        Bytes for a chunk of frames.
    progress : Progress
        Told after every chunk.
    """
    spread, metric, frames, base = _parts(motion, vertices)
    progress(0.0, "factorising")
    triangle = np.asarray(np.linalg.qr(metric, mode="r"))
    middle = frames.mean(axis=0)
    dimensions, sides = len(triangle), frames.shape[2]
    step = int(np.clip(memory // (64 * max(frames[0].size, dimensions * sides)), 1, CHUNK_FRAMES))

    def chunks() -> Iterator[tuple[FloatArray, FloatArray]]:
        """Yield centred frames (c, sides, K) and their orthonormal coordinates (c, sides * dimensions)."""
        for start in range(0, len(frames), step):
            centred = np.ascontiguousarray((frames[start : start + step] - middle).transpose(0, 2, 1))
            moved = centred.reshape(-1, centred.shape[2]) @ triangle.T
            yield centred, moved.reshape(len(centred), -1)

    combined = np.zeros((0, dimensions * sides))
    total, done = 0.0, 0
    for _, moved in chunks():
        total += float(np.vdot(moved, moved))
        combined = stacked(combined, moved)
        done += len(moved)
        progress(0.8 * done / len(frames), "principal axes")
    _, singular, rows = np.linalg.svd(combined, full_matrices=False)
    offset = float(np.linalg.norm(triangle @ middle))
    rank = rank_of(singular, len(frames), offset)
    mean = (spread @ middle).reshape(motion.neutral.shape)

    def axes(count: int) -> FloatArray:
        # Everywhere, off the metric too, an axis is the combination of centred frames that has its coordinates.
        made, done = np.zeros((count, sides * spread.shape[1])), 0
        for centred, moved in chunks():
            made += (moved @ rows[:count].T / singular[:count] ** 2).T @ centred.reshape(len(centred), -1)
            done += len(moved)
            progress(0.8 + 0.2 * done / len(frames), "principal axes")
        shapes = _shapes(made.reshape(count, sides, -1), spread).reshape(count, -1)
        return orthonormal_over(shapes, columns_of(vertices)).reshape(count, -1, 3)

    eigenvalues = singular[:rank] ** 2 / len(frames)
    return Decomposition(mean if base is None else mean + base, eigenvalues, total / len(frames), axes)


def _parts(
    motion: MeshMotion, vertices: IntArray | None
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray | None]:
    """Return A (rows, K), its rows of the metric, frames (L, K, sides) and the displacement that stays."""
    if motion.phi is not None and motion.markers is not None:
        return motion.phi, motion.phi if vertices is None else motion.phi[vertices], motion.markers, None
    assert motion.basis is not None and motion.weights is not None
    shapes = motion.basis.displacements
    spread = shapes.reshape(len(shapes), -1).T
    metric = spread if vertices is None else shapes[:, vertices].reshape(len(shapes), -1).T
    return spread, metric, motion.weights[:, :, None], motion.basis.mean


def _shapes(directions: FloatArray, spread: FloatArray) -> FloatArray:
    """Return shapes (m, V, 3) of coordinates (m, sides, K) under columns (rows, K): rows are V or 3 V."""
    count, sides, columns = directions.shape
    moved = directions.reshape(-1, columns) @ spread.T
    if sides == 1:
        return moved.reshape(count, -1, 3)
    shaped: FloatArray = np.ascontiguousarray(moved.reshape(count, 3, -1).transpose(0, 2, 1))
    return shaped
