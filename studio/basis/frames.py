"""One frame of the performance and how the three bases reproduce it, ready to be shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from engine.mesh import FloatArray, IntArray
from studio.basis.context import BasisContext
from studio.basis.follower import BasisFollower

if TYPE_CHECKING:
    from engine.basis.compare import Comparison
    from engine.shapes import ExpressionBasis
    from studio.basis.motions import PreparedMotion


@dataclass(frozen=True)
class FramePicture:
    """Positions (N, 3) in mm of one frame, and markers (K, 3); None where there is nothing to show.

    ``rms_mm`` tells the error by hand, quasi-eigen and PCA shapes.
    """

    index: int
    original: FloatArray
    by_hand: FloatArray | None = None
    by_quasi: FloatArray | None = None
    by_pca: FloatArray | None = None
    rms_mm: tuple[float | None, ...] = ()
    markers: tuple[FloatArray | None, ...] = (None,)


class FramePictures:
    """Makes frames from what the follower has.

    Attributes
    ----------
    pca : bool
        Whether the reconstruction by PCA axes is wanted.
    """

    def __init__(self, context: BasisContext, follower: BasisFollower) -> None:
        self._context, self._follower = context, follower
        self.pca = False

    def picture(self, index: int) -> FramePicture | None:
        """Return a frame, counted from 0; None while there is no motion on the rig that is shown."""
        prepared, rig = self._follower.prepared, self._context.rig
        if prepared is None or rig is None or len(prepared.motion.neutral) != len(rig.mesh.vertices):
            return None
        if not 0 <= index < len(prepared.motion):
            return None
        original = prepared.motion.frame(index)
        comparison, used = self._reconstruction()
        if comparison is None or used is None:
            return FramePicture(index, original, markers=(_captured(prepared, index),))
        bounds = self._context.setup.options.bounds
        keys = {"hand": bounds, "quasi_eigen": bounds, "pca": "free"}
        bases = {**comparison.bases, "quasi_eigen": used}
        made: list[FloatArray | None] = []
        for key, bound in keys.items():
            wanted = key != "pca" or self.pca
            made.append(_placed(bases[key], comparison.weights[key][bound][index]) if wanted else None)
        rms = tuple(float(comparison.errors[key][bound].rms_frames[index]) for key, bound in keys.items())
        markers = _captured(prepared, index), *(_rebuilt(prepared, rig.mesh.faces, placed) for placed in made)
        return FramePicture(index, original, made[0], made[1], made[2], rms, markers)

    def _reconstruction(self) -> tuple[Comparison | None, ExpressionBasis | None]:
        """Return figures and basis in use, where they are of this motion."""
        analysis, blend = self._follower.analysis, self._follower.blend
        if analysis is None or not self._follower.shows_motion:
            return None, None
        if blend is not None:
            return blend.comparison, blend.basis
        return analysis.result.comparison, analysis.result.quasi.basis


def _placed(basis: ExpressionBasis, weights: FloatArray) -> FloatArray:
    placed: FloatArray = basis.evaluate(weights)
    return placed


def _captured(prepared: PreparedMotion, index: int) -> FloatArray | None:
    return None if prepared.bound is None else prepared.bound.captured[index]


def _rebuilt(prepared: PreparedMotion, faces: IntArray, placed: FloatArray | None) -> FloatArray | None:
    """Return where a reconstruction has the markers: each keeps its place beside the surface that it has at rest."""
    bound = prepared.bound
    if bound is None or placed is None:
        return None
    moved = placed - prepared.motion.neutral
    found: FloatArray = bound.binding.rest + bound.binding.on(moved, faces)
    return found
