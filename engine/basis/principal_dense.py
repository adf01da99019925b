"""Principal axes of dense and streamed motion: exact while the frames or the mesh are few, else by iteration."""

from __future__ import annotations

import numpy as np

from engine.basis.frame_chunks import FrameChunks
from engine.basis.principal_iterated import decompose_iterated
from engine.basis.spectrum import Columns, Decomposition, axes_for, columns_of, orthonormal_over, rank_of, stacked
from engine.errors import InputError
from engine.mesh import FloatArray, IntArray
from engine.motion import MeshMotion
from engine.progress import Progress

EXACT = 256
"""Up to so many frames, or coordinates of the metric, an exact factorisation costs no more than an iteration."""
FINE = 1e-5
"""What a coverage leaves over, below which products in single precision are not tried."""
SINGLE = 1e-6
"""Products in single precision tell a variance apart from nothing down to this share of the largest."""


def decompose_dense(
    motion: MeshMotion, vertices: IntArray | None, wanted: float | int, memory: int, progress: Progress
) -> Decomposition:
    """Return mean, variances and axes of a dense or streamed motion.

    Parameters
    ----------
    motion : MeshMotion
        The training frames only.
    vertices : (V,) int or None
        Vertices of the metric.
    wanted : float or int
        Coverage or count; all axes at a coverage of 1.
    memory : int
        Most bytes for working arrays.
    progress : Progress
        Told after every chunk.

    Raises
    ------
    InputError
        On positions that are not finite, or when ``memory`` is too small for what is wanted.
    """
    columns = columns_of(vertices)
    width = motion.neutral.size if vertices is None else 3 * len(vertices)
    small = min(len(motion), width)
    whole = wanted > small // 3 if isinstance(wanted, int) else wanted == 1.0
    if whole or small <= EXACT:
        needed = 48 * small**2 + 64 * motion.neutral.size
        if needed > memory and whole:
            problem = f"{memory >> 20} MB do not hold what the axes of {len(motion)} frames need"
            raise InputError("memory", problem, f"allow {(needed >> 20) + 1} MB, or ask for a smaller coverage")
        if needed <= memory:
            frames = FrameChunks(motion, (memory - 48 * small**2) // 4)
            way = _many_frames if width <= len(motion) else _few_frames
            return way(frames, columns, progress)
    # A reader's own chunk stands beside the one made of it.
    single = FrameChunks(motion, memory // 8, double=not isinstance(wanted, int) and wanted > 1 - FINE)
    found = decompose_iterated(single, columns, wanted, memory, progress)
    if single.dtype == np.float32 and _too_fine(found.eigenvalues, found.total_variance, wanted):
        found = decompose_iterated(FrameChunks(motion, memory // 8), columns, wanted, memory, progress)
    return found


def _too_fine(eigenvalues: FloatArray, total: float, wanted: float | int) -> bool:
    """Return whether products in single precision cannot tell all wanted variances apart from nothing."""
    if not len(eigenvalues):
        return False
    if isinstance(wanted, int) and wanted > len(eigenvalues):
        return True
    return bool(eigenvalues[axes_for(eigenvalues, total, wanted) - 1] < SINGLE * eigenvalues[0])


def _many_frames(frames: FrameChunks, columns: Columns, progress: Progress) -> Decomposition:
    """More frames than coordinates: X = Q R over chunks of frames, and the singular values of R."""
    drift, size = np.zeros(frames.columns), 0.0
    frames.sample(EXACT)
    for rows in frames.chunks(checked=True):
        drift += rows.sum(axis=0) / len(frames)
        progress(0.3 * (size := size + len(rows) / len(frames)), "mean")
    frames.reference = frames.reference + drift
    triangle, total, done = np.zeros((0, len(drift[columns]))), 0.0, 0.0
    for rows in frames.chunks():
        metric = rows[:, columns]
        total += float(np.vdot(metric, metric)) / len(frames)
        triangle = stacked(triangle, metric)
        progress(0.3 + 0.4 * (done := done + len(rows) / len(frames)), "principal axes")
    _, singular, turned = np.linalg.svd(triangle, full_matrices=False)
    rank = rank_of(singular, len(frames), float(np.linalg.norm(frames.reference[columns])))

    def axes(count: int) -> FloatArray:
        made = np.zeros((count, frames.columns))
        for rows in frames.chunks():
            made += (turned[:count] @ rows[:, columns].T / singular[:count, None] ** 2) @ rows
        made[:, columns] = turned[:count]
        return made.reshape(count, -1, 3)

    mean = (frames.reference - frames.motion.neutral.ravel()).reshape(-1, 3)
    return Decomposition(mean, singular[:rank] ** 2 / len(frames), total, axes)


def _few_frames(frames: FrameChunks, columns: Columns, progress: Progress) -> Decomposition:
    """Fewer frames than coordinates: X^T = Q R over blocks of vertices, and the singular values of R."""
    counts = np.zeros(frames.columns, dtype=bool)
    counts[columns] = True
    triangle, mean, total = np.zeros((0, len(frames))), np.empty(frames.columns), 0.0
    for first, block in frames.blocks():
        at = slice(3 * first, 3 * first + block.shape[1])
        mean[at] = block.mean(axis=0)
        metric = (block - mean[at])[:, counts[at]]
        total += float(np.vdot(metric, metric)) / len(frames)
        triangle = stacked(triangle, metric.T)
        progress(0.7 * at.stop / frames.columns, "principal axes")
    _, singular, shares = np.linalg.svd(triangle, full_matrices=False)
    offset = float(np.linalg.norm((mean + frames.motion.neutral.ravel())[columns]))
    rank = rank_of(singular, len(frames), offset)

    def axes(count: int) -> FloatArray:
        made = np.empty((count, frames.columns))
        for first, block in frames.blocks():
            at = slice(3 * first, 3 * first + block.shape[1])
            made[:, at] = shares[:count] / singular[:count, None] @ (block - mean[at])
            progress(0.7 + 0.3 * at.stop / frames.columns, "principal axes")
        return orthonormal_over(made, columns).reshape(count, -1, 3)

    return Decomposition(mean.reshape(-1, 3), singular[:rank] ** 2 / len(frames), total, axes)
