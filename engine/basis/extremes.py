"""Maxima and percentiles of the reproduction error: what needs every vertex of every frame (ours)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from threading import Lock
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.basis.error import check_weights
from engine.basis.error_chunks import LargeErrors, SmallErrors
from engine.basis.reduce import metric_vertices
from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, frozen
from engine.motion import MeshMotion
from engine.progress import Progress, silent
from engine.shapes import ExpressionBasis, check_topology

T = TypeVar("T")
THREADS = 2
BINS = 1 << 16
"""Bins of the histogram that the pooled percentile comes from."""


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
    errors: SmallErrors | LargeErrors
    if motion.kind in ("factored", "driven"):
        errors = SmallErrors(basis, motion, weights, metric_vertices(vertices, len(motion.neutral)))
    else:
        errors = LargeErrors(basis, motion, weights, metric_vertices(vertices, len(motion.neutral)))
    length, points = len(motion), errors.points
    tops, places, ranks = np.zeros(length), np.zeros(length, dtype=np.int64), np.zeros(length)
    vertex_tops, vertex_places = np.zeros(points), np.zeros(points, dtype=np.int64)
    spectrum = Histogram()

    def look(distances: Callable[[], NDArray[Any]]) -> tuple[IntArray, FloatArray, IntArray, FloatArray, FloatArray]:
        sizes = distances()
        across, down = sizes.argmax(axis=1), sizes.argmax(axis=0)
        largest = sizes[np.arange(len(sizes)), across]
        highest = sizes[down, np.arange(points)]
        spectrum.add(sizes, float(largest.max()))
        return across, largest, down, highest, rank_values(sizes, percentile)

    for start, (across, largest, down, highest, middle) in in_turn(look, errors.chunks()):
        progress(start / length, f"Measuring frame {start + 1} of {length}")
        at = slice(start, start + len(across))
        places[at], tops[at], ranks[at] = across, largest, middle
        larger = highest > vertex_tops
        vertex_tops[larger], vertex_places[larger] = highest[larger], start + down[larger]
    if isinstance(errors, SmallErrors):
        tops = errors.exact(np.arange(length), places)
        vertex_tops = errors.exact(vertex_places, np.arange(points))
    per_vertex = np.full(len(motion.neutral), np.nan)
    per_vertex[slice(None) if errors.vertices is None else errors.vertices] = vertex_tops
    progress(1.0, "Measuring the error")
    frame = int(np.argmax(tops))
    place = int(places[frame])
    return Extremes(
        max_mm=float(tops[frame]),
        percentile=float(percentile),
        percentile_mm=spectrum.percentile(percentile),
        bin_mm=spectrum.width,
        max_frames=frozen(tops, np.float64),
        percentile_frames=frozen(ranks, np.float64),
        max_vertices=frozen(per_vertex, np.float64),
        max_frame=frame,
        max_vertex=place if errors.vertices is None else int(errors.vertices[place]),
    )


def in_turn(look: Callable[[Any], T], chunks: Iterator[tuple[int, Any]]) -> Iterator[tuple[int, T]]:
    """Yield ``(start, look(chunk))`` in order, computed by a few threads that are never far ahead."""
    with ThreadPoolExecutor(THREADS) as pool:
        waiting: deque[tuple[int, Future[T]]] = deque()
        for start, chunk in chunks:
            waiting.append((start, pool.submit(look, chunk)))
            if len(waiting) > THREADS:
                first, found = waiting.popleft()
                yield first, found.result()
        for first, found in waiting:
            yield first, found.result()


def rank_values(sizes: NDArray[Any], percentile: float) -> FloatArray:
    """Return the percentile of every row (c, V) by linear interpolation between ranks; the rows are reordered."""
    at = percentile / 100 * (sizes.shape[1] - 1)
    low = int(at)
    high = min(low + 1, sizes.shape[1] - 1)
    sizes.partition((low, high), axis=1)
    first, second = sizes[:, low].astype(np.float64), sizes[:, high].astype(np.float64)
    return np.asarray(first + (at - low) * (second - first), dtype=np.float64)


class Histogram:
    """Counts of numbers >= 0 in equal bins that grow wider by doubling when a larger number comes (ours)."""

    def __init__(self) -> None:
        self.width = 0.0
        self.counts = np.zeros(BINS, dtype=np.int64)
        self.top = 0.0
        self._lock = Lock()

    def add(self, values: NDArray[Any], top: float) -> None:
        """Count values (c, V), the largest of which is ``top``; may be called from any thread."""
        with self._lock:
            self._add(np.ascontiguousarray(values, dtype=np.float32), top)

    def _add(self, values: NDArray[Any], top: float) -> None:
        import cv2

        if top <= 0 and not self.width:
            self.counts[0] += values.size
            return
        self.top = max(self.top, top)
        # Powers of two: the width at the end hangs on the largest number alone, not on the order of the threads.
        self.width = self.width or 2.0 ** np.floor(np.log2(top / BINS))
        while top >= 0.999 * self.width * BINS:
            self.counts = np.append(self.counts.reshape(-1, 2).sum(axis=1), np.zeros(BINS // 2, dtype=np.int64))
            self.width *= 2
        found = cv2.calcHist([values], [0], None, [BINS], [0.0, self.width * BINS])
        self.counts += np.rint(found.ravel()).astype(np.int64)

    def percentile(self, percentile: float) -> float:
        """Return a percentile of all numbers, to within one bin."""
        total = np.cumsum(self.counts)
        rank = percentile / 100 * (total[-1] - 1)
        at = int(np.searchsorted(total, rank, side="right"))
        at = min(at, BINS - 1)
        inside = (rank - (total[at] - self.counts[at]) + 0.5) / max(int(self.counts[at]), 1)
        return float(min(self.width * (at + inside), self.top))
