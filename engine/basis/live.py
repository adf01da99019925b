"""The error of a basis between hand and quasi-eigen while its sliders are dragged (ours)."""

from __future__ import annotations

import numpy as np

from engine.basis.error import pooled
from engine.basis.quasi_eigen import QuasiEigen, blended_mean, check_amounts
from engine.basis.reduce import reduce_motion
from engine.basis.reduced import Reduced, squares
from engine.basis.weights import Bounds, check_bounds, check_ridge, solve_reduced, split, stacked
from engine.errors import InputError
from engine.mesh import FloatArray, IntArray
from engine.motion import MeshMotion
from engine.progress import Progress, silent
from engine.shapes import ExpressionBasis, check_topology


class LiveAlpha:
    """Alpha (Kim & Ko 2007, eq. 6) of blended shapes on evenly spaced frames, ready for many questions (ours).

    Parameters
    ----------
    hand, quasi : ExpressionBasis
        Both ends of the sliders; ``quasi`` may be a QuasiEigen.
    motion : MeshMotion
    bounds : as in `solve_weights`
    vertices : (V,) int, optional
        The metric's vertices; all where left out.
    frames : int or None
        How many evenly spaced frames; None for all of them, which is exact.
    ridge : float
        As in `solve_weights`.

    Raises
    ------
    InputError
        On another topology, other shapes, or bounds or a ridge that cannot be.
    Cancelled
        Raised by ``progress``.
    """

    frames: IntArray
    """(M,) the frames it looks at, counted from 0."""

    def __init__(
        self,
        hand: ExpressionBasis,
        quasi: QuasiEigen | ExpressionBasis,
        motion: MeshMotion,
        bounds: Bounds = None,
        vertices: IntArray | None = None,
        frames: int | None = 500,
        *,
        ridge: float = 0.0,
        progress: Progress = silent,
    ) -> None:
        quasi = quasi.basis if isinstance(quasi, QuasiEigen) else quasi
        check_topology("hand basis", len(hand.neutral), len(motion.neutral), "the motion")
        check_topology("quasi-eigen basis", len(quasi.neutral), len(motion.neutral), "the motion")
        if quasi.names != hand.names:
            raise InputError(
                "quasi-eigen basis", "has other shapes than the hand basis", "project the hand basis again"
            )
        if frames is not None and frames < 1:
            raise InputError("frames", f"are {frames}", "look at one or more")
        self._bounds, self._ridge, self._count = check_bounds(bounds), check_ridge(ridge), len(hand)
        length = len(motion)
        self.frames = even_frames(length, frames)
        chosen = None if len(self.frames) == length else self.frames
        both = np.concatenate([stacked(hand), stacked(quasi)])
        self._reduced: Reduced = reduce_motion(motion, both, vertices=vertices, frames=chosen, progress=progress)
        start = len(stacked(hand))
        (self._hand, first), (self._quasi, second) = (
            split(hand, self._reduced.shapes[:start]),
            split(quasi, self._reduced.shapes[start:]),
        )
        self._hand, self._quasi = self._hand + first, self._quasi + second  # both from the neutral face
        self._means = (None if hand.mean is None else first, None if quasi.mean is None else second)

    def alpha(self, amounts: FloatArray) -> tuple[float, float]:
        """Return alpha in percent, (mean over frames, pooled), for amounts (n,) from 0 = hand to 1 = quasi-eigen."""
        weights, shapes, mean = self._solve(amounts)
        errors = self._reduced.frames - mean - weights @ shapes
        squared = squares(errors) + self._reduced.outside
        placed = self._reduced.placed_squared
        ratio = np.sqrt(np.divide(squared, placed, out=np.zeros_like(squared), where=placed > 0))
        return 100 * float(ratio.mean()), pooled(squared, placed)

    def weights(self, amounts: FloatArray) -> FloatArray:
        """Return the weights (M, n) of the blended shapes on `frames`."""
        return self._solve(amounts)[0]

    def _solve(self, amounts: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        amounts = check_amounts(amounts, self._count)
        blended = blended_mean(*self._means, amounts)
        mean = np.zeros(self._hand.shape[1]) if blended is None else blended
        shapes = (1 - amounts)[:, None] * self._hand + amounts[:, None] * self._quasi - mean
        found = solve_reduced(self._reduced.frames - mean, shapes, self._bounds, self._ridge)
        return found, shapes, mean


def even_frames(length: int, count: int | None) -> IntArray:
    """Return ``count`` evenly spaced frames of ``length``, ends included; all of them for None or a larger count."""
    if count is None or count >= length:
        return np.arange(length)
    return np.unique(np.round(np.linspace(0, length - 1, count)).astype(np.int64))
