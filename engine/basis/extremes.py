"""Maxima and percentiles of the reproduction error: what needs every vertex of every frame (ours)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.basis.error import check_weights
from engine.basis.reduce import metric_vertices, moved, restricted
from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, frozen
from engine.motion import MeshMotion
from engine.progress import Progress, silent
from engine.shapes import ExpressionBasis, check_topology


@dataclass(frozen=True)
class Extremes:
    """The largest errors of a reconstruction, over the metric's vertices.

    Attributes
    ----------
    max_mm : float
        Largest distance of a vertex in any frame, mm; it is in frame ``max_frame`` at vertex ``max_vertex``.
    percentile : float
        Which percentile the others are, 0..100.
    percentile_mm : float
        Over all frames and vertices together, mm, to within ``bin_mm``.
    bin_mm : float
        Width of the histogram's bins, mm.
    max_frames, percentile_frames : (L,) float
        Of every frame, over its vertices, mm (linear interpolation between ranks).
    max_vertices : (N,) float
        Of every vertex over the frames, mm; NaN off the metric.
    max_frame, max_vertex : int
    """

    max_mm: float
    percentile: float
    percentile_mm: float
    bin_mm: float
    max_frames: FloatArray
    percentile_frames: FloatArray
    max_vertices: FloatArray
    max_frame: int
    max_vertex: int


def error_extremes(
    basis: ExpressionBasis,
    motion: MeshMotion,
    weights: FloatArray,
    *,
    vertices: IntArray | None = None,
    percentile: float = 95.0,
    progress: Progress = silent,
) -> Extremes:
    """Return maxima and percentiles of the error of a basis under weights (L, n), streamed over the frames (ours).

    Parameters
    ----------
    vertices : (V,) int, optional
        The metric's vertices; all where left out.
    percentile : float
        0..100.

    Raises
    ------
    InputError
        On another topology, weights that do not fit, a percentile outside 0..100, or numbers that are not finite.
    Cancelled
        Raised by ``progress``.
    """
    check_topology("basis", len(basis.neutral), len(motion.neutral), "the motion")
    weights = check_weights(basis, weights, len(motion))
    if not 0 <= percentile <= 100:
        raise InputError("percentile", f"is {percentile:g}", "give a number from 0 to 100")
    at = metric_vertices(vertices, len(motion.neutral))
    flat = restricted(basis.displacements, at)
    count = flat.shape[1] // 3
    frames_max, frames_percentile = np.zeros(len(motion)), np.zeros(len(motion))
    vertices_max = np.zeros(count)
    everything = []
    for start, found in moved(motion, at):
        progress(start / len(motion), f"Measuring frame {start + 1} of {len(motion)}")
        errors = found - weights[start : start + len(found)] @ flat
        if basis.mean is not None:
            errors -= restricted(basis.mean, at)
        sizes = np.linalg.norm(errors.reshape(len(errors), -1, 3), axis=2)
        frames_max[start : start + len(found)] = sizes.max(axis=1)
        frames_percentile[start : start + len(found)] = np.percentile(sizes, percentile, axis=1)
        np.maximum(vertices_max, sizes.max(axis=0), out=vertices_max)
        everything.append(sizes.ravel())
    per_vertex = np.full(len(motion.neutral), np.nan)
    per_vertex[slice(None) if at is None else at] = vertices_max
    progress(1.0, "Measuring the error")
    worst = int(np.argmax(vertices_max))
    return Extremes(
        max_mm=float(frames_max.max()),
        percentile=float(percentile),
        percentile_mm=float(np.percentile(np.concatenate(everything), percentile)),
        bin_mm=0.0,
        max_frames=frozen(frames_max, np.float64),
        percentile_frames=frozen(frames_percentile, np.float64),
        max_vertices=frozen(per_vertex, np.float64),
        max_frame=int(np.argmax(frames_max)),
        max_vertex=worst if at is None else int(at[worst]),
    )
