"""Principal axes of dense and streamed motion, in chunks of frames."""

from __future__ import annotations

import numpy as np

from engine.basis.spectrum import Decomposition, rank_of
from engine.mesh import FloatArray, IntArray
from engine.motion import MeshMotion
from engine.progress import Progress


def decompose_dense(
    motion: MeshMotion, vertices: IntArray | None, wanted: float | int, memory: int, progress: Progress
) -> Decomposition:
    """Return the spectrum and axes of a dense or streamed motion."""
    frames = np.concatenate([moved for _, moved in motion.chunks()]).reshape(len(motion), -1)
    mean = frames.mean(axis=0)
    centred = (frames - mean).reshape(len(frames), -1, 3)
    at: IntArray | slice = slice(None) if vertices is None else vertices
    metric = centred[:, at].reshape(len(frames), -1)
    shares, singular, _ = np.linalg.svd(metric, full_matrices=False)
    offset = float(np.linalg.norm(mean + motion.neutral.ravel()))
    rank = rank_of(singular, len(frames), offset)

    def axes(count: int) -> FloatArray:
        made: FloatArray = np.tensordot((shares[:, :count] / singular[:count]).T, centred, axes=1)
        return made

    eigenvalues = singular[:rank] ** 2 / len(frames)
    return Decomposition(mean.reshape(-1, 3), eigenvalues, float((metric**2).sum()) / len(frames), axes)
