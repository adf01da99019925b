"""Principal axes of a performance: its mean, the axes it moves along, and how much each of them explains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from engine.basis.spectrum import Decomposition, axes_for, fix_signs
from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, frozen
from engine.motion import MeshMotion
from engine.progress import Progress, silent
from engine.shapes import ExpressionBasis


@dataclass(frozen=True)
class PrincipalBasis:
    """Mean and principal axes of the displacements of a performance (Kim & Ko 2007, section 4).

    Attributes
    ----------
    neutral : (N, 3) float
        Neutral face, mm.
    mean : (N, 3) float
        Mean displacement over the training frames, mm.
    axes : (m, N, 3) float
        Orthonormal over ``vertices`` (unit length there, no unit), most variance first. Off them an axis moves as the
        frames that made it did: the same linear combination of centred frames. The component of the largest magnitude
        is positive.
    eigenvalues : (r,) float
        Variance along every axis that is known, descending, mm^2: eigenvalues of (1/L) D D^T over ``vertices``. At
        least m of them; all of the motion's rank where that was computed whole.
    total_variance : float
        Sum of all eigenvalues of the motion, known or not, mm^2.
    coverage : float
        Share of the total variance that the m axes explain, 0..1.
    vertices : (V,) int or None
        Sorted vertices of the inner product; None for all.
    train : (int, int)
        First frame and the one after the last that the axes come from, counted from 0.
    frames : int
        How many these are.
    """

    neutral: FloatArray
    mean: FloatArray
    axes: FloatArray
    eigenvalues: FloatArray
    total_variance: float
    coverage: float
    vertices: IntArray | None
    train: tuple[int, int]
    frames: int

    def __post_init__(self) -> None:
        for name in ("neutral", "mean", "axes", "eigenvalues"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.float64))
        if self.vertices is not None:
            object.__setattr__(self, "vertices", frozen(self.vertices, np.int64))

    @property
    def count(self) -> int:
        """Number m of axes."""
        return len(self.axes)

    @property
    def cumulative(self) -> FloatArray:
        """(r,) share of the total variance that the first 1, 2, ... axes explain, 0..1."""
        shares: FloatArray = np.minimum(np.cumsum(self.eigenvalues) / self.total_variance, 1.0)
        return shares

    def basis(self) -> ExpressionBasis:
        """Return the axes as shapes about the mean: ``v = neutral + mean + sum_j w_j axis_j``, w in mm."""
        names = tuple(f"axis {j + 1}" for j in range(self.count))
        return ExpressionBasis(self.neutral, names, self.axes, mean=self.mean)

    def coordinates(self, displacements: Any) -> FloatArray:
        """Return where displacements (..., N, 3) from the neutral face lie on the axes, (..., m) in mm.

        ``e_j . (d - mean)`` over ``vertices`` (Kim & Ko 2007, eq. 3).

        Raises
        ------
        InputError
            When they have another number of vertices.
        """
        given = np.asarray(displacements, dtype=np.float64)
        if given.shape[-2:] != self.neutral.shape:
            problem = f"have shape {given.shape} for {len(self.neutral)} vertices"
            raise InputError("displacements", problem, "give (..., vertices, 3) of the same topology")
        at: IntArray | slice = slice(None) if self.vertices is None else self.vertices
        centred = (given - self.mean)[..., at, :]
        axes = self.axes[:, at].reshape(self.count, -1)
        found: FloatArray = centred.reshape(*given.shape[:-2], -1) @ axes.T
        return found


def principal_basis(
    motion: MeshMotion,
    coverage: float = 0.995,
    count: int | None = None,
    *,
    vertices: IntArray | None = None,
    train: tuple[int, int] | None = None,
    memory_mb: float = 512,
    progress: Progress = silent,
) -> PrincipalBasis:
    """Return the principal axes of a performance's displacements (Kim & Ko 2007, section 4).

    Factored and driven motion is analysed exactly in the space of its markers or shapes, by the QR factorisation of
    what spreads them over the vertices; a dense or streamed motion exactly while it is small, else by subspace
    iteration in chunks of frames until the wanted axes have converged (ours). All give the same answer.

    Parameters
    ----------
    motion : MeshMotion
        The performance.
    coverage : float
        Share of the total variance to explain, in (0, 1]; the fewest axes that do are kept. Used without ``count``.
    count : int, optional
        Number of axes to keep instead.
    vertices : (V,) int, optional
        Vertices of the inner product; None for all.
    train : (int, int), optional
        First frame and the one after the last to learn from, counted from 0; None for all.
    memory_mb : float
        Most that a dense or streamed motion may take for working arrays beside the result, MB.
    progress : Progress
        Told after every chunk of frames; may raise `Cancelled`.

    Raises
    ------
    InputError
        On fewer than two frames, frames outside the motion, a coverage outside (0, 1], more axes than the frames span,
        numbers that are not finite, a motion that does not move, or too little memory for what was asked.
    """
    wanted = _wanted(coverage, count)
    metric = _metric(vertices, len(motion.neutral))
    start, stop = _train(train, len(motion))
    if not (np.isfinite(memory_mb) and memory_mb > 0):
        raise InputError("memory", f"is {memory_mb:g} MB", "give a number above 0")
    found = _decompose(motion.slice(start, stop), metric, wanted, int(memory_mb * 2**20), progress)
    if not len(found.eigenvalues):
        problem = f"frames {start + 1} to {stop} do not differ on the vertices that count"
        raise InputError("motion", problem, "choose a range in which the face moves")
    kept = axes_for(found.eigenvalues, found.total_variance, wanted)
    axes = found.axes(kept)
    fix_signs(axes, metric)
    axes.flags.writeable = False
    explained = min(float(found.eigenvalues[:kept].sum()) / found.total_variance, 1.0)
    progress(1.0, "principal axes")
    return PrincipalBasis(
        motion.neutral,
        found.mean,
        axes,
        found.eigenvalues,
        found.total_variance,
        explained,
        metric,
        (start, stop),
        stop - start,
    )


def _decompose(
    motion: MeshMotion, vertices: IntArray | None, wanted: float | int, memory: int, progress: Progress
) -> Decomposition:
    if motion.kind in ("factored", "driven"):
        from engine.basis.principal_factored import decompose_factored

        return decompose_factored(motion, vertices, memory, progress)
    from engine.basis.principal_dense import decompose_dense

    return decompose_dense(motion, vertices, wanted, memory, progress)


def _wanted(coverage: float, count: int | None) -> float | int:
    if count is not None:
        if isinstance(count, bool) or int(count) != count or count < 1:
            raise InputError("count", f"is {count}", "give a whole number of axes, 1 or more")
        return int(count)
    if not (np.isfinite(coverage) and 0 < coverage <= 1):
        raise InputError("coverage", f"is {coverage:g}", "give a share above 0 and at most 1, for instance 0.995")
    return float(coverage)


def _metric(vertices: Any, count: int) -> IntArray | None:
    if vertices is None:
        return None
    given = np.asarray(vertices)
    if given.ndim != 1 or not len(given) or given.dtype.kind not in "iu":
        problem = f"have shape {given.shape} and type {given.dtype}"
        raise InputError("vertices", problem, "give the numbers of at least one vertex")
    if given.min() < 0 or given.max() >= count:
        problem = f"run from {given.min()} to {given.max()}, the mesh has {count}"
        raise InputError("vertices", problem, "number them from 0")
    metric: IntArray = np.unique(given).astype(np.int64)
    return metric


def _train(train: tuple[int, int] | None, length: int) -> tuple[int, int]:
    start, stop = (0, length) if train is None else (int(train[0]), int(train[1]))
    if not 0 <= start < stop <= length:
        problem = f"frames {start + 1} to {stop} do not lie in 1 to {length}"
        raise InputError("training range", problem, "choose frames of the motion")
    if length < 2:
        raise InputError("motion", "has one frame", "a performance needs two")
    if stop - start < 2:
        raise InputError("training range", "has one frame", "give at least two that differ")
    return start, stop
