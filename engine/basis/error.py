"""How closely a basis reproduces a performance (Kim & Ko 2007, section 5.5)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from engine.basis.reduce import moved, reduce_motion, restricted
from engine.basis.reduced import Reduced, squares
from engine.basis.weights import split, stacked
from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, frozen
from engine.motion import MeshMotion
from engine.progress import Progress, part, silent
from engine.shapes import ExpressionBasis, check_topology

AT_REST_MM = 1e-9
"""RMS displacement in mm below which a frame is the neutral face and has no error in percent of its motion."""


ROUNDING_MM = 1e-9
"""RMS error in mm up to which a frame is reproduced exactly."""


@dataclass(frozen=True)
class ReproductionError:
    """How far a reconstruction is from the performance, over the metric's vertices.

    Attributes
    ----------
    alpha_mean, alpha_pooled : float
        Kim & Ko 2007, eq. 6, in percent: mean over frames of ``100 |v* - v| / |v*|``, and
        ``100 sqrt(sum |v* - v|^2 / sum |v*|^2)``. Positions are taken about ``origin``.
    motion_mean, motion_pooled : float
        The same in percent of the displacement ``|d*|``, free of any origin (ours). The mean leaves out frames at rest.
    rms_mm : float
        Root mean square distance over all frames and vertices, mm.
    alpha_frames : (L,) float
        Percent, of every frame.
    motion_frames : (L,) float
        Percent of the displacement, of every frame; NaN at rest.
    rms_frames : (L,) float
        mm, of every frame.
    rms_vertices : (N,) float
        mm, of every vertex; NaN off the metric.
    origin : (3,) float
        Centroid of the neutral face over the metric's vertices, mm.
    resting : int
        Number of frames at rest.
    fps : float
        Frames a second.
    """

    alpha_mean: float
    alpha_pooled: float
    motion_mean: float
    motion_pooled: float
    rms_mm: float
    alpha_frames: FloatArray
    motion_frames: FloatArray
    rms_frames: FloatArray
    rms_vertices: FloatArray
    origin: FloatArray
    resting: int
    fps: float

    def worst_frames(self, count: int = 8, apart: int | None = None) -> IntArray:
        """Return the frames of largest RMS error, worst first, at least ``apart`` frames from each other.

        Frames without error but rounding are none of them: there may be fewer than asked for, or none.

        Parameters
        ----------
        count : int
            At most so many.
        apart : int, optional
            Half a second where left out, so that one event is named once (ours).
        """
        apart = round(0.5 * self.fps) if apart is None else apart
        return spaced_peaks(self.rms_frames, count, max(1, apart), floor=ROUNDING_MM)


def spaced_peaks(values: FloatArray, count: int, apart: int, floor: float = -0.5) -> IntArray:
    """Return where the largest of ``values`` (L,), all >= 0, lie: largest first, at least ``apart`` from each other.

    Those up to ``floor`` are none.
    """
    left = np.array(values, dtype=np.float64)
    found: list[int] = []
    while len(found) < count:
        worst = int(np.argmax(left))
        if left[worst] <= floor:
            break
        found.append(worst)
        left[max(0, worst - apart + 1) : worst + apart] = -1
    return np.array(found, dtype=np.int64)


def reproduction_error(
    basis: ExpressionBasis,
    motion: MeshMotion,
    weights: FloatArray,
    *,
    vertices: IntArray | None = None,
    progress: Progress = silent,
) -> ReproductionError:
    """Return how far a basis under weights (L, n) is from a motion (Kim & Ko 2007, eq. 6; origin and others: ours).

    Displacements are compared, and the denominator's positions are the motion's.

    Parameters
    ----------
    vertices : (V,) int, optional
        The metric's vertices; all where left out.

    Raises
    ------
    InputError
        On another topology, weights that do not fit, or numbers that are not finite.
    Cancelled
        Raised by ``progress``.
    """
    check_topology("basis", len(basis.neutral), len(motion.neutral), "the motion")
    weights = check_weights(basis, weights, len(motion))
    reduced = reduce_motion(motion, stacked(basis), vertices=vertices, progress=part(progress, 0, 0.6))
    shapes, mean = split(basis, reduced.shapes)
    known = {"basis": (basis, weights)}
    per_vertex = None
    if reduced.rest is None:
        per_vertex = vertex_squares(motion, known, reduced.vertices, part(progress, 0.6, 1))["basis"]
    found = reduced_error(reduced, shapes, mean, weights, len(motion.neutral), per_vertex)
    progress(1.0, "Measuring the error")
    return found


def check_weights(basis: ExpressionBasis, weights: FloatArray, length: int) -> FloatArray:
    """Return weights (L, n) as they are when they fit a basis and a motion, else raise InputError."""
    weights = np.asarray(weights, dtype=np.float64)
    if weights.shape != (length, len(basis)):
        problem = f"have shape {weights.shape} for {length} frames and {len(basis)} shapes"
        raise InputError("weights", problem, "solve them for this motion and basis")
    if not np.isfinite(weights).all():
        raise InputError("weights", "hold numbers that are not finite", "solve them again")
    return weights


def reduced_error(
    reduced: Reduced,
    shapes: FloatArray,
    mean: FloatArray,
    weights: FloatArray,
    vertices: int,
    vertex_mean_square: FloatArray | None = None,
) -> ReproductionError:
    """Return the error of weights (L, n) on shapes (n, r) about a mean (r,), all in reduced coordinates.

    Parameters
    ----------
    vertices : int
        Number of vertices of the whole mesh.
    vertex_mean_square : (V,) float, optional
        Mean squared error of every vertex of the metric, mm^2, of a dense or streamed motion.
    """
    errors = reduced.frames - mean - weights @ shapes
    squared = squares(errors) + reduced.outside
    placed, moving = reduced.placed_squared, reduced.moved_squared
    alpha = 100 * np.sqrt(np.divide(squared, placed, out=np.zeros_like(squared), where=placed > 0))
    resting = np.sqrt(moving / reduced.count) <= AT_REST_MM
    ratio = 100 * np.sqrt(np.divide(squared, moving, out=np.full_like(squared, np.nan), where=~resting))
    if vertex_mean_square is None:
        vertex_mean_square = reduced.vertex_mean_square(errors)
    per_vertex = np.full(vertices, np.nan)
    per_vertex[slice(None) if reduced.vertices is None else reduced.vertices] = np.sqrt(vertex_mean_square)
    return ReproductionError(
        alpha_mean=float(alpha.mean()),
        alpha_pooled=pooled(squared, placed),
        motion_mean=float(ratio[~resting].mean()) if not resting.all() else float("nan"),
        motion_pooled=pooled(squared, moving) if not resting.all() else float("nan"),
        rms_mm=float(np.sqrt(squared.mean() / reduced.count)),
        alpha_frames=frozen(alpha, np.float64),
        motion_frames=frozen(ratio, np.float64),
        rms_frames=frozen(np.sqrt(squared / reduced.count), np.float64),
        rms_vertices=frozen(per_vertex, np.float64),
        origin=reduced.origin,
        resting=int(resting.sum()),
        fps=reduced.fps,
    )


def pooled(squared: FloatArray, of: FloatArray) -> float:
    """Return ``100 sqrt(sum squared / sum of)``, percent."""
    total = float(of.sum())
    return 100 * float(np.sqrt(squared.sum() / total)) if total > 0 else float("nan")


def vertex_squares(
    motion: MeshMotion,
    solved: Mapping[str, tuple[ExpressionBasis, FloatArray]],
    vertices: IntArray | None,
    progress: Progress = silent,
) -> dict[str, FloatArray]:
    """Return the mean squared error (V,) of every vertex, mm^2, of several bases under weights, in one pass."""
    total = {name: np.zeros(len(motion.neutral) if vertices is None else len(vertices)) for name in solved}
    flat = {name: restricted(basis.displacements, vertices) for name, (basis, _) in solved.items()}
    for start, found in moved(motion, vertices):
        progress(start / len(motion), f"Measuring frame {start + 1} of {len(motion)}")
        for name, (basis, weights) in solved.items():
            errors = found - weights[start : start + len(found)] @ flat[name]
            if basis.mean is not None:
                errors -= restricted(basis.mean, vertices)
            triples = errors.reshape(len(errors), -1, 3)
            total[name] += np.einsum("lvc,lvc->v", triples, triples)
    return {name: found / len(motion) for name, found in total.items()}
