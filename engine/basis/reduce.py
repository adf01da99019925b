"""Small coordinates in which every squared error of a motion is exact (ours)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, frozen
from engine.motion import MeshMotion
from engine.progress import Progress, silent
from engine.shapes import check_topology

DEPENDENT = 1e-13
"""Share of the largest direction of a set of vectors below which a direction is rounding."""


@dataclass(frozen=True)
class Reduced:
    """A motion and some shapes in one orthonormal frame of the displacements over the metric's vertices (ours).

    A displacement over V vertices is a vector of 3V numbers. The columns of the frame are orthonormal there, so inner
    products, norms and distances of coordinates are those of the displacements, to rounding.

    Attributes
    ----------
    vertices : (V,) int or None
        The metric's vertices; None = all.
    fps : float
        Frames a second of the motion.
    frames : (L, r) float
        Coordinates of every frame's displacement, mm.
    outside : (L,) float
        Squared length of what the frame does not hold of a frame's displacement, mm^2; 0 for factored and driven
        motion, which the frame holds whole.
    shapes : (s, r) float
        Coordinates of the shapes, which the frame holds whole, mm.
    along_neutral : (L,) float
        Inner product of every displacement with the neutral face about ``origin``, mm^2.
    neutral_squared : float
        Squared length of the neutral face about ``origin``, mm^2.
    origin : (3,) float
        Centroid of the neutral face over the metric's vertices, mm: the origin of eq. 6 here.
    spread : (V, k) float or None
        Orthonormal columns Q of a factored motion; the first 3k columns of the frame are Q (x) I3.
    span : (3V, p) float
        The other columns of the frame.
    """

    vertices: IntArray | None
    fps: float
    frames: FloatArray
    outside: FloatArray
    shapes: FloatArray
    along_neutral: FloatArray
    neutral_squared: float
    origin: FloatArray
    spread: FloatArray | None
    span: FloatArray

    def __len__(self) -> int:
        return len(self.frames)

    @property
    def count(self) -> int:
        """Number of vertices of the metric."""
        return len(self.span) // 3

    @property
    def whole(self) -> bool:
        """Whether the frame holds every displacement of the motion whole."""
        return not self.outside.any()

    @property
    def moved_squared(self) -> FloatArray:
        """|d*|^2 of every frame (L,), mm^2."""
        found: FloatArray = np.einsum("lr,lr->l", self.frames, self.frames) + self.outside
        return found

    @property
    def placed_squared(self) -> FloatArray:
        """|v*|^2 of every frame (L,) about ``origin``, mm^2: the denominator of eq. 6, squared."""
        found: FloatArray = self.neutral_squared + 2 * self.along_neutral + self.moved_squared
        return np.maximum(found, 0)

    def at(self, frames: Any) -> Reduced:
        """Return the same coordinates for some of the frames."""
        return Reduced(
            self.vertices,
            self.fps,
            frozen(self.frames[frames], np.float64),
            frozen(self.outside[frames], np.float64),
            self.shapes,
            frozen(self.along_neutral[frames], np.float64),
            self.neutral_squared,
            self.origin,
            self.spread,
            self.span,
        )

    def vertex_mean_square(self, errors: FloatArray) -> FloatArray:
        """Return the mean over frames of every vertex' squared length (V,), mm^2, for vectors given as (L, r).

        Only what the frame holds is counted. Uses the second moment of the coordinates, never the vectors themselves.
        """
        moment = errors.T @ errors / len(errors)
        k = 0 if self.spread is None else self.spread.shape[1]
        total = np.zeros(self.count)
        span = self.span.reshape(self.count, 3, -1)
        for axis in range(3):
            inner, across = moment[axis : 3 * k : 3, axis : 3 * k : 3], moment[axis : 3 * k : 3, 3 * k :]
            if self.spread is not None:
                total += np.einsum("vk,vk->v", self.spread @ inner, self.spread)
                total += 2 * np.einsum("vp,vp->v", self.spread @ across, span[:, axis])
            total += np.einsum("vp,vp->v", span[:, axis] @ moment[3 * k :, 3 * k :], span[:, axis])
        return np.maximum(total, 0)


def metric_vertices(vertices: Any, count: int) -> IntArray | None:
    """Return the metric's vertices as given, checked against a mesh of ``count`` vertices; None stays None.

    Raises
    ------
    InputError
        When there is none, one is not of the mesh, or one is named twice.
    """
    if vertices is None:
        return None
    found: IntArray = np.asarray(vertices)
    if found.ndim != 1 or not len(found) or not np.issubdtype(found.dtype, np.integer):
        problem = f"have shape {found.shape} and type {found.dtype}"
        raise InputError("vertices of the metric", problem, "give the numbers of some vertices")
    if found.min() < 0 or found.max() >= count:
        raise InputError("vertices of the metric", f"one is outside 0..{count - 1}", "choose vertices of the mesh")
    if len(np.unique(found)) != len(found):
        raise InputError("vertices of the metric", "one is named twice", "name each vertex once")
    return frozen(found, np.int64)


def restricted(shapes: FloatArray, vertices: IntArray | None) -> FloatArray:
    """Return displacements (..., N, 3) as vectors (..., 3V) over the metric's vertices."""
    kept = shapes if vertices is None else shapes[..., vertices, :]
    return kept.reshape(*kept.shape[:-2], -1)


def orthonormal_span(vectors: FloatArray) -> FloatArray:
    """Return orthonormal columns (D, p) that span vectors (s, D); directions that are rounding are left out.

    Householder QR, then the singular values of its small factor: the Gram matrix, which squares the condition, is
    never formed.
    """
    from scipy.linalg import qr

    if not len(vectors) or not vectors.any():
        return np.zeros((vectors.shape[1], 0))
    columns, factor = qr(vectors.T, mode="economic", check_finite=False)
    left, sizes, _ = np.linalg.svd(factor)
    return np.asarray(columns @ left[:, : int((sizes > DEPENDENT * sizes[0]).sum())], dtype=np.float64)


def reduce_motion(
    motion: MeshMotion,
    shapes: FloatArray,
    *,
    vertices: IntArray | None = None,
    frames: IntArray | None = None,
    progress: Progress = silent,
) -> Reduced:
    """Return a motion and shapes in small coordinates over the metric's vertices (ours).

    Factored motion, d = (Phi (x) I3) m: QR of Phi over those vertices, plus the part of the shapes outside its space.
    Driven motion: the span of its rig's shapes and the shapes. Dense and streamed motion: the span of the shapes; one
    pass over the frames gives their coordinates and the length of what is left, computed from the remainder itself.

    Parameters
    ----------
    motion : MeshMotion
    shapes : (s, N, 3) float
        Displacements whose combinations will be compared with the motion, mm.
    vertices : (V,) int, optional
        The metric's vertices; all where left out.
    frames : (M,) int, optional
        Only these frames; all where left out.

    Raises
    ------
    InputError
        On another topology, or a motion with numbers that are not finite.
    Cancelled
        Raised by ``progress``.
    """
    shapes = np.asarray(shapes, dtype=np.float64)
    check_topology("shapes", shapes.shape[1], len(motion.neutral), "the motion")
    vertices = metric_vertices(vertices, len(motion.neutral))
    neutral = motion.neutral if vertices is None else motion.neutral[vertices]
    origin = neutral.mean(axis=0)
    centred = (neutral - origin).ravel()
    flat = restricted(shapes, vertices)
    spread: FloatArray | None = None
    outside: FloatArray | None = None
    progress(0.0, "Reducing the motion")
    if motion.phi is not None and motion.markers is not None:
        markers = motion.markers if frames is None else motion.markers[frames]
        spread, span, coordinates, held = _factored(motion.phi, markers, flat, vertices)
        along = coordinates @ _inner(spread, span, centred[None])[0]
    elif motion.basis is not None and motion.weights is not None:
        weights = motion.weights if frames is None else motion.weights[frames]
        rig = restricted(motion.basis.displacements, vertices)
        mean = np.zeros((0, rig.shape[1])) if motion.basis.mean is None else restricted(motion.basis.mean, vertices)
        mean = mean.reshape(-1, rig.shape[1])
        span = orthonormal_span(np.concatenate([rig, mean, flat]))
        coordinates, held = weights @ (rig @ span) + (mean @ span).sum(axis=0), flat @ span
        along = coordinates @ (span.T @ centred)
    else:
        span = orthonormal_span(flat)
        held = flat @ span
        coordinates, outside, along = _streamed(motion, span, centred, vertices, frames, progress)
    progress(1.0, "Reducing the motion")
    return Reduced(
        vertices,
        motion.fps,
        frozen(coordinates, np.float64),
        frozen(np.zeros(len(coordinates)) if outside is None else outside, np.float64),
        frozen(held, np.float64),
        frozen(along, np.float64),
        float(centred @ centred),
        frozen(origin, np.float64),
        spread,
        span,
    )


def _factored(
    phi: FloatArray, markers: FloatArray, flat: FloatArray, vertices: IntArray | None
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return Q, the columns beside Q (x) I3, the frames' and the shapes' coordinates."""
    from scipy.linalg import qr

    columns, factor = qr(phi if vertices is None else phi[vertices], mode="economic", check_finite=False)
    spread = np.asarray(columns, dtype=np.float64)
    marks = len(markers)
    rotated = (factor @ markers.transpose(1, 0, 2).reshape(phi.shape[1], -1)).reshape(-1, marks, 3)
    inner = rotated.transpose(1, 0, 2).reshape(marks, -1)
    rest = flat
    for _ in range(2):  # once leaves rounding of the whole in the remainder, twice does not
        rest = _remainder(spread, rest)
    size = np.linalg.norm(flat, axis=1)
    rest = rest[np.linalg.norm(rest, axis=1) > DEPENDENT * 10 * max(size.max(initial=0.0), 1e-300)]
    span = orthonormal_span(rest)
    if span.shape[1]:
        span = orthonormal_span(_remainder(spread, span.T))
    coordinates: FloatArray = np.concatenate([inner, np.zeros((marks, span.shape[1]))], axis=1)
    return spread, span, coordinates, _inner(spread, span, flat)


def _inner(spread: FloatArray, span: FloatArray, flat: FloatArray) -> FloatArray:
    """Return the coordinates (s, 3k + p) of vectors (s, 3V)."""
    triples = flat.reshape(len(flat), -1, 3)
    inner = np.tensordot(triples, spread, axes=(1, 0)).transpose(0, 2, 1).reshape(len(flat), -1)
    return np.concatenate([inner, flat @ span], axis=1)


def _remainder(spread: FloatArray, flat: FloatArray) -> FloatArray:
    """Return what Q (x) I3 does not hold of vectors (s, 3V)."""
    count = len(flat)
    triples = flat.reshape(count, -1, 3).transpose(1, 0, 2).reshape(len(spread), -1)
    left = triples - spread @ (spread.T @ triples)
    return np.ascontiguousarray(left.reshape(-1, count, 3).transpose(1, 0, 2)).reshape(count, -1)


def moved(
    motion: MeshMotion, vertices: IntArray | None, frames: IntArray | None = None, largest: int = 32 << 20
) -> Iterator[tuple[int, FloatArray]]:
    """Yield ``(start, vectors (c, 3V))`` of the displacements over the metric's vertices, all finite.

    ``start`` counts the frames asked for.

    Raises
    ------
    InputError
        At the first frame with numbers that are not finite.
    """
    count = len(motion.neutral) if vertices is None else len(vertices)
    step = max(1, largest // (24 * count))
    total = len(motion) if frames is None else len(frames)
    for start in range(0, total, step):
        stop = min(start + step, total)
        if frames is None:
            found = motion.displacements(start, stop, vertices)
        else:
            found = np.concatenate([motion.displacements(int(k), int(k) + 1, vertices) for k in frames[start:stop]])
        flat = found.reshape(stop - start, -1)
        finite = np.isfinite(flat.sum(axis=1))
        if not finite.all():
            at = start + int(np.flatnonzero(~finite)[0])
            at = at if frames is None else int(frames[at])
            raise InputError(f"motion, frame {at + 1}", "holds numbers that are not finite", "export it again")
        yield start, flat


def _streamed(
    motion: MeshMotion,
    span: FloatArray,
    centred: FloatArray,
    vertices: IntArray | None,
    frames: IntArray | None,
    progress: Progress,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return coordinates, squared length outside and inner product with the neutral face of every frame."""
    total = len(motion) if frames is None else len(frames)
    coordinates, outside, along = np.zeros((total, span.shape[1])), np.zeros(total), np.zeros(total)
    for start, flat in moved(motion, vertices, frames):
        progress(start / total, f"Reducing frame {start + 1} of {total}")
        at = slice(start, start + len(flat))
        coordinates[at], along[at] = flat @ span, flat @ centred
        rest = flat - coordinates[at] @ span.T
        outside[at] = np.einsum("ld,ld->l", rest, rest)
    return coordinates, outside, along
