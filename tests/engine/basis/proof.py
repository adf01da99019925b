"""The performance and the two hand-made bases of the sample, through the whole pipeline: what the proof measures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

import resources
from engine.basis.error import ReproductionError, reproduction_error
from engine.basis.markers import BoundMarkers, bind_markers, marker_motion
from engine.basis.principal import PrincipalBasis, principal_basis
from engine.basis.quasi_eigen import QuasiEigen, project
from engine.basis.weights import solve_weights
from engine.files.marker_pairs import read_marker_pairs
from engine.files.motion import read_motion
from engine.files.rig import read_rig
from engine.mesh import FloatArray
from engine.motion import MarkerClip, MeshMotion
from engine.shapes import ExpressionBasis, Rig

BOUNDS = (-1.0, 2.0)
SMOOTH_MM = 25.0
"""How far the random fields of the control reach; the animator's own deviations are not much smoother."""
HAND_A, HAND_B = "animator_24.npz", "mpfb_34.npz"


@lru_cache(maxsize=2)
def rig(name: str) -> Rig:
    return read_rig(resources.sample_path("performance", name)).rig


@lru_cache(maxsize=1)
def clip() -> MarkerClip:
    data = read_motion(resources.sample_path("performance", "speech_emotion.c3d")).data
    assert isinstance(data, MarkerClip)
    return data


@lru_cache(maxsize=1)
def bound() -> BoundMarkers:
    pairs = read_marker_pairs(resources.sample_path("performance", "MARKERS.json"))
    head = [label for label in clip().labels if label.startswith("head_")]
    return bind_markers(rig(HAND_A).mesh, clip(), pairs=pairs, head=head)


@lru_cache(maxsize=1)
def motion() -> MeshMotion:
    return marker_motion(rig(HAND_A).mesh, bound())


@lru_cache(maxsize=1)
def axes() -> PrincipalBasis:
    return principal_basis(motion(), 0.995, vertices=rig(HAND_A).skin)


@lru_cache(maxsize=1)
def alpha_pca() -> float:
    return _error(axes().basis(), None)[0].alpha_mean


@dataclass(frozen=True, eq=False)
class Figures:
    """What a set of shapes makes of the performance; solved when first asked for."""

    hand: ExpressionBasis

    @cached_property
    def quasi(self) -> QuasiEigen:
        return project(self.hand, axes())

    @cached_property
    def by_hand(self) -> tuple[ReproductionError, FloatArray]:
        return _error(self.hand, BOUNDS)

    @cached_property
    def by_quasi(self) -> tuple[ReproductionError, FloatArray]:
        return _error(self.quasi.basis, BOUNDS)

    @cached_property
    def free(self) -> tuple[ReproductionError, FloatArray]:
        return _error(self.quasi.basis, None)

    @property
    def gain(self) -> float:
        return self.by_hand[0].alpha_mean / self.by_quasi[0].alpha_mean

    @property
    def loss(self) -> float:
        return self.by_quasi[0].alpha_mean / alpha_pca()

    @property
    def cosine(self) -> float:
        return float(np.nanmedian(self.quasi.cosine))

    @property
    def p99(self) -> float:
        return float(np.percentile(np.abs(self.by_quasi[1]), 99))

    @property
    def p99_free(self) -> float:
        return float(np.percentile(np.abs(self.free[1]), 99))

    def worst(self, count: int) -> list[tuple[str, float]]:
        """The shapes that changed most, with their cosines."""
        order = np.argsort(np.nan_to_num(self.quasi.cosine, nan=-1.0))[:count]
        return [(self.hand.names[k], float(self.quasi.cosine[k])) for k in order]


@lru_cache(maxsize=2)
def figures(name: str) -> Figures:
    return Figures(rig(name).basis)


@lru_cache(maxsize=4)
def control(seed: int) -> Figures:
    """As many random smooth shapes as the animator's, each as large as one of them."""
    own, skin = rig(HAND_A).basis, rig(HAND_A).skin
    rng = np.random.default_rng(seed)
    shapes = np.zeros_like(own.displacements)
    for shape, theirs in zip(shapes, own.displacements, strict=True):
        waves = rng.standard_normal((96, 3)) / SMOOTH_MM
        field = np.cos(own.neutral @ waves.T + rng.uniform(0, 2 * np.pi, 96)) @ rng.standard_normal((96, 3))
        shape[:] = field * np.sqrt((theirs[skin] ** 2).sum() / (field[skin] ** 2).sum())
    return Figures(ExpressionBasis(own.neutral, own.names, shapes))


def _error(basis: ExpressionBasis, bounds: tuple[float, float] | None) -> tuple[ReproductionError, FloatArray]:
    skin = rig(HAND_A).skin
    weights = solve_weights(basis, motion(), bounds, vertices=skin)
    return reproduction_error(basis, motion(), weights, vertices=skin), weights


def report() -> list[str]:
    """The figures of the proof in lines, for ``make bench``."""
    lines = [f"{axes().count} axes cover {axes().coverage:.4f}; PCA alone {alpha_pca():.3f} %"]
    for title, found in (
        ("the animator's 24", figures(HAND_A)),
        ("another artist's 34", figures(HAND_B)),
        ("24 random smooth shapes", control(1)),
    ):
        lines.append(
            f"{title}: alpha hand {found.by_hand[0].alpha_mean:.3f} %, quasi-eigen {found.by_quasi[0].alpha_mean:.3f} %"
            f" (hand / quasi-eigen {found.gain:.2f}, quasi-eigen / PCA {found.loss:.3f}), median cosine"
            f" {found.cosine:.3f}, 99 % of |w| within {found.p99:.2f}, free {found.p99_free:.2f}"
        )
        lines.append("  most changed: " + ", ".join(f"{name} {cosine:.2f}" for name, cosine in found.worst(5)))
    return lines


if __name__ == "__main__":
    print("\n".join(report()))
