"""What to sculpt next: where a basis fails its performance, and which shapes lose their look (ours)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.basis.error import AT_REST_MM, check_weights, spaced_peaks
from engine.basis.live import even_frames
from engine.basis.muscles import ChecklistEntry, muscle_checklist
from engine.basis.project_checks import LOOKS_LIKE_ITSELF
from engine.basis.quasi_eigen import QuasiEigen
from engine.basis.reduce import metric_vertices, moved, reduce_motion, restricted
from engine.basis.weights import split, stacked
from engine.errors import some
from engine.mesh import FloatArray, IntArray, frozen
from engine.motion import MeshMotion
from engine.progress import Progress, part, silent
from engine.shapes import ExpressionBasis, check_topology

SAMPLE = 240
"""Evenly spaced frames that the worst explained directions are found on; all frames are then measured along them."""
MOVING = 0.5
"""Share of a direction's largest motion from which a vertex belongs to its region."""
WORTH_MM = 1e-6
"""RMS error in mm below which nothing is left to explain."""


@dataclass(frozen=True)
class UncoveredAxis:
    """A direction of the performance that the basis explains badly.

    Attributes
    ----------
    direction : (N, 3) float
        Displacement in mm that the frame which shows it best lacks along it: what a shape for it would look like.
    share : float
        Share of the squared error that is left.
    rms_mm : float
        RMS over all frames and the metric's vertices of the error along it, mm.
    region : str
        Where it moves most, seen from the subject: ``upper left``, ``lower middle`` and so on.
    frames : tuple of int
        Frames that show it best, best first, counted from 0.
    nearest : tuple of (str, float)
        The shapes that come nearest, with their cosine, nearest first.
    vertices : (R,) int
        The vertices of the metric that move at least half as far in it as the one that moves most.
    """

    direction: FloatArray
    share: float
    rms_mm: float
    region: str
    frames: tuple[int, ...]
    nearest: tuple[tuple[str, float], ...]
    vertices: IntArray


@dataclass(frozen=True)
class Drift:
    """A shape whose quasi-eigen face no longer looks like it.

    Attributes
    ----------
    name : str
    cosine : float
        Between the hand shape and its quasi-eigen face.
    amount : float
        The largest amount of quasi-eigen, 0..1, at which the cosine stays at 0.85 or above.
    """

    name: str
    cosine: float
    amount: float


@dataclass(frozen=True)
class Advice:
    """What an artist may do next.

    Attributes
    ----------
    uncovered : tuple of UncoveredAxis
        Worst explained directions of the performance, worst first.
    drifting : tuple of Drift
        Shapes that lose their look, worst first.
    checklist : tuple of ChecklistEntry
        The muscles, and the shapes found for them.
    sentences : tuple of str
        The same in plain words, most useful first.
    """

    uncovered: tuple[UncoveredAxis, ...]
    drifting: tuple[Drift, ...]
    checklist: tuple[ChecklistEntry, ...]
    sentences: tuple[str, ...]


def keep_amount(hand: FloatArray, quasi: FloatArray, cosine: float = LOOKS_LIKE_ITSELF) -> float:
    """Return the largest amount 0..1 at which ``(1 - a) hand + a quasi`` keeps a cosine to ``hand`` (D,) (ours)."""
    size = float(np.linalg.norm(hand))
    if not size:
        return 1.0
    along = float(hand @ quasi) / size
    beside = float(np.linalg.norm(quasi - along / size * hand))
    # The tangent of the angle, a beside / ((1 - a) size + a along), may reach that of acos(cosine) and no more.
    tangent = float(np.sqrt(1 - cosine**2)) / cosine
    rate = beside + tangent * (size - along)
    return 1.0 if rate <= tangent * size else float(tangent * size / rate)


def advise(
    hand: ExpressionBasis,
    quasi: QuasiEigen,
    motion: MeshMotion,
    weights: FloatArray,
    *,
    vertices: IntArray | None = None,
    count: int = 3,
    progress: Progress = silent,
) -> Advice:
    """Return what to sculpt next, and how much of its hand shape each face must keep (ours).

    The errors that the quasi-eigen basis leaves under ``weights`` (L, n) are decomposed; their largest directions are
    what new shapes would have to show.

    Parameters
    ----------
    vertices : (V,) int, optional
        The metric's vertices; all where left out.
    count : int
        At most so many directions.

    Raises
    ------
    InputError
        On another topology, weights that do not fit, or numbers that are not finite.
    Cancelled
        Raised by ``progress``.
    """
    check_topology("hand basis", len(hand.neutral), len(motion.neutral), "the motion")
    check_topology("quasi-eigen basis", len(quasi.basis.neutral), len(motion.neutral), "the motion")
    weights = check_weights(quasi.basis, weights, len(motion))
    at = metric_vertices(vertices, len(motion.neutral))
    shapes = hand.displacements if hand.mean is None else hand.displacements + hand.mean
    flat = restricted(shapes, at)
    uncovered = _uncovered(hand.names, flat, quasi.basis, motion, weights, at, count, progress)
    projected = quasi.basis.displacements if quasi.basis.mean is None else quasi.basis.displacements + quasi.basis.mean
    drifting = tuple(
        Drift(hand.names[i], float(quasi.cosine[i]), keep_amount(flat[i], restricted(projected[i], at)))
        for i in np.argsort(quasi.cosine)
        if quasi.cosine[i] < LOOKS_LIKE_ITSELF
    )
    checklist = muscle_checklist(hand.names)
    return Advice(uncovered, drifting, checklist, _sentences(quasi, uncovered, drifting, checklist))


def _uncovered(
    names: tuple[str, ...],
    flat: FloatArray,
    basis: ExpressionBasis,
    motion: MeshMotion,
    weights: FloatArray,
    at: IntArray | None,
    count: int,
    progress: Progress,
) -> tuple[UncoveredAxis, ...]:
    """Return the largest directions of the error: found on some frames, measured on all."""
    chosen = even_frames(len(motion), SAMPLE)
    errors = _errors(basis, motion, weights, chosen)
    measured = restricted(errors, at)
    gram = measured @ measured.T
    values, vectors = np.linalg.eigh(gram)
    points = measured.shape[1] // 3
    least = len(chosen) * points * WORTH_MM**2
    kept = [k for k in np.argsort(values)[::-1][: max(count, 0)] if values[k] > max(least, 1e-12 * values.max())]
    if not kept:
        return ()
    directions = np.tensordot((vectors[:, kept] / np.sqrt(values[kept])).T, errors, axes=1)
    reduced = reduce_motion(
        motion, np.concatenate([stacked(basis), directions]), vertices=at, progress=part(progress, 0.1, 1)
    )
    held, mean = split(basis, reduced.shapes)
    left = reduced.frames - mean - weights @ held
    total = float(np.einsum("lr,lr->", left, left) + reduced.outside.sum())
    energy = np.linalg.norm(measured.reshape(len(chosen), -1, 3), axis=2).max(axis=0)
    neutral = motion.neutral if at is None else motion.neutral[at]
    size = np.linalg.norm(flat, axis=1)
    found = []
    for k, direction in enumerate(directions):
        along = left @ reduced.shapes[len(reduced.shapes) - len(directions) + k]
        frames = spaced_peaks(np.abs(along), 3, max(1, round(0.5 * motion.fps)))
        direction = direction * along[frames[0]]
        moving = np.linalg.norm(direction if at is None else direction[at], axis=1)
        region = np.flatnonzero(moving >= MOVING * moving.max())
        vector = restricted(direction, at)
        cosines = np.divide(flat @ vector, size * np.linalg.norm(vector), out=np.zeros(len(size)), where=size > 0)
        nearest = [(names[i], float(cosines[i])) for i in np.argsort(-np.abs(cosines))[:3]]
        found.append(
            UncoveredAxis(
                direction=frozen(direction, np.float64),
                share=float(along @ along) / total,
                rms_mm=float(np.sqrt(along @ along / len(along) / points)),
                region=place(neutral, energy, moving),
                frames=tuple(int(frame) for frame in frames),
                nearest=tuple(nearest),
                vertices=frozen(region if at is None else at[region], np.int64),
            )
        )
    return tuple(sorted(found, key=lambda axis: -axis.share))


def _errors(basis: ExpressionBasis, motion: MeshMotion, weights: FloatArray, chosen: IntArray) -> FloatArray:
    """Return the errors (M, N, 3) of some frames on all vertices, mm."""
    found = np.zeros((len(chosen), *motion.neutral.shape))
    flat = found.reshape(len(chosen), -1)
    for start, vectors in moved(motion, None, chosen):
        flat[start : start + len(vectors)] = vectors
    flat -= weights[chosen] @ basis.displacements.reshape(len(basis), -1)
    if basis.mean is not None:
        flat -= basis.mean.ravel()
    return found


def place(neutral: FloatArray, energy: FloatArray, moving: FloatArray) -> str:
    """Return where a direction moves, in words seen from the subject: within the part of the face that moves at all.

    Parameters
    ----------
    neutral : (V, 3) float
        +Y up, left is +X, mm.
    energy : (V,) float
        How far every vertex moves in what is compared, mm.
    moving : (V,) float
        How far it moves in the direction, mm.
    """
    alive = neutral[energy >= 0.1 * energy.max()] if energy.max() > AT_REST_MM else neutral
    low, high = alive.min(axis=0), alive.max(axis=0)
    share = moving**2 / np.sum(moving**2)
    centre = share @ neutral
    height = "upper" if centre[1] > (low[1] + high[1]) / 2 else "lower"
    across = (centre[0] - (low[0] + high[0]) / 2) / max(high[0] - low[0], 1e-300)
    side = "left" if across > 0.12 else "right" if across < -0.12 else "middle"
    return f"{height} {side}"


def _sentences(
    quasi: QuasiEigen,
    uncovered: tuple[UncoveredAxis, ...],
    drifting: tuple[Drift, ...],
    checklist: tuple[ChecklistEntry, ...],
) -> tuple[str, ...]:
    said: list[str] = []
    for axis in uncovered:
        name, cosine = axis.nearest[0]
        frames = some([str(frame + 1) for frame in axis.frames])
        said.append(
            f"Sculpt or change a shape in the {axis.region} of the face: {100 * axis.share:.0f} % of the remaining"
            f" error ({axis.rms_mm:.2f} mm RMS) lies along one motion there, as in frame {frames};"
            f" {name} comes nearest (cosine {cosine:.2f})."
        )
    for axis_number in quasi.missing:
        said.append(f"No shape touches axis {axis_number + 1}: add it as a shape and make it recognisable.")
    for drift in drifting:
        said.append(
            f"{drift.name} no longer looks like itself (cosine {drift.cosine:.2f}): stop its slider at"
            f" {np.floor(100 * drift.amount) / 100:.2f} to keep {LOOKS_LIKE_ITSELF}, or sculpt it closer to what the"
            " performer does."
        )
    lacking = [entry.element.muscle for entry in checklist if not entry.found]
    if lacking and len(lacking) < len(checklist):
        said.append(f"No shape is named for {some(lacking)}: the checklist says what each of them does.")
    return tuple(said)
