"""Small coordinates in which every squared error of a motion is exact (ours)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from engine.basis.reduced import Columns, Reduced, squares
from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, frozen
from engine.motion import MeshMotion
from engine.progress import Progress, silent
from engine.shapes import check_topology

DEPENDENT = 1e-13
"""Share of the largest direction of a set of vectors below which a direction is rounding."""
STILL = 1e-10
"""Share of the largest vector below which a vector is rounding and shows nothing."""


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

    Householder QR of the vectors brought to one length, then the singular values of its small factor: the Gram matrix,
    which squares the condition, is never formed.
    """
    from scipy.linalg import qr

    units = one_length(vectors)
    if not len(units):
        return np.zeros((vectors.shape[1], 0))
    columns, factor = qr(units.T, mode="economic", check_finite=False, overwrite_a=True)
    left, sizes, _ = np.linalg.svd(factor)
    return np.asarray(columns @ left[:, : int((sizes > DEPENDENT * sizes[0]).sum())], dtype=np.float64)


def one_length(vectors: FloatArray) -> FloatArray:
    """Return the vectors (s, D) that show something, each of length 1; others are below 1e-10 of the largest."""
    size = np.sqrt(squares(vectors))
    shows = size > STILL * size.max(initial=0.0)
    return np.asarray(vectors[shows] / size[shows, None], dtype=np.float64)


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
    progress(0.0, "Reducing the motion")
    if motion.kind in ("factored", "driven"):
        if motion.kind == "factored":
            spread, span, held, numbers, matrix, mean = _factored(motion, shapes, vertices)
        else:
            spread, span, held, numbers, matrix, mean = _driven(motion, shapes, vertices)
        _, sizes, turned = np.linalg.svd(one_length(held), full_matrices=True)
        p = int((sizes > DEPENDENT * sizes.max(initial=0.0)).sum())
        chosen = numbers if frames is None else numbers[frames]
        coordinates = chosen @ (matrix @ turned.T) + mean @ turned.T
        columns = Columns(spread, span, np.ascontiguousarray(turned.T))
        along = coordinates @ (turned @ _inner(spread, span, centred[None])[0])
        inside, rest = np.ascontiguousarray(coordinates[:, :p]), np.ascontiguousarray(coordinates[:, p:])
        outside, held = squares(rest), held @ turned[:p].T
    else:
        flat = restricted(shapes, vertices)
        span = orthonormal_span(flat)
        columns, rest, held = Columns(None, span, None), None, flat @ span
        inside, outside, along = _streamed(motion, span, centred, vertices, frames, progress)
    progress(1.0, "Reducing the motion")
    return Reduced(
        vertices,
        motion.fps,
        frozen(inside, np.float64),
        frozen(outside, np.float64),
        None if rest is None else frozen(rest, np.float64),
        frozen(held, np.float64),
        frozen(along, np.float64),
        float(centred @ centred),
        frozen(origin, np.float64),
        columns,
    )


Parts = tuple[FloatArray | None, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Q, the columns beside Q (x) I3, the shapes' coordinates; the frames' are numbers (L, a) @ (a, r) + (r,)."""


def _factored(motion: MeshMotion, shapes: FloatArray, vertices: IntArray | None) -> Parts:
    from scipy.linalg import qr

    assert motion.phi is not None and motion.markers is not None
    found, factor = qr(motion.phi if vertices is None else motion.phi[vertices], mode="economic", check_finite=False)
    spread = np.asarray(found, dtype=np.float64)
    count, k = spread.shape
    left = np.ascontiguousarray((shapes if vertices is None else shapes[:, vertices]).transpose(1, 0, 2))
    size = np.sqrt(np.einsum("vsc,vsc->s", left, left))
    flat = left.reshape(count, -1)
    inner = np.zeros((k, flat.shape[1]))
    for _ in range(2):  # once leaves rounding of the whole in the remainder, twice does not
        step = spread.T @ flat
        flat = flat - spread @ step
        inner += step
    left = flat.reshape(left.shape)
    beside = np.flatnonzero(np.sqrt(np.einsum("vsc,vsc->s", left, left)) > 10 * DEPENDENT * size)
    rest = np.ascontiguousarray(left[:, beside].transpose(1, 0, 2)).reshape(len(beside), 3 * count)
    span = orthonormal_span(rest)
    held = inner.reshape(k, -1, 3).transpose(1, 0, 2).reshape(len(shapes), -1)
    own = np.zeros((len(shapes), span.shape[1]))
    own[beside] = rest @ span
    numbers = motion.markers.reshape(len(motion), -1)
    matrix = np.zeros((numbers.shape[1], 3 * k + span.shape[1]))
    matrix[:, : 3 * k] = np.kron(np.asarray(factor).T, np.eye(3))
    return spread, span, np.concatenate([held, own], axis=1), numbers, matrix, np.zeros(matrix.shape[1])


def _driven(motion: MeshMotion, shapes: FloatArray, vertices: IntArray | None) -> Parts:
    assert motion.basis is not None and motion.weights is not None
    rig, flat = restricted(motion.basis.displacements, vertices), restricted(shapes, vertices)
    if motion.basis.mean is None:
        span = orthonormal_span(np.concatenate([rig, flat]))
        return None, span, flat @ span, motion.weights, rig @ span, np.zeros(span.shape[1])
    mean = restricted(motion.basis.mean, vertices)
    span = orthonormal_span(np.concatenate([rig, mean[None], flat]))
    return None, span, flat @ span, motion.weights, rig @ span, mean @ span


def _inner(spread: FloatArray | None, span: FloatArray, flat: FloatArray) -> FloatArray:
    """Return the coordinates (s, 3k + j) of vectors (s, 3V)."""
    if spread is None:
        return np.asarray(flat @ span)
    triples = flat.reshape(len(flat), -1, 3)
    inner = np.tensordot(triples, spread, axes=(1, 0)).transpose(0, 2, 1).reshape(len(flat), -1)
    return np.concatenate([inner, flat @ span], axis=1)


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
        outside[at] = squares(rest)
    return coordinates, outside, along
