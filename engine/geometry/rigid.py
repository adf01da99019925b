"""Rigid and similarity transforms between points that correspond."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.errors import InputError
from engine.mesh import FloatArray, frozen

_FLAT = 1e-9


@dataclass(frozen=True)
class RigidTransform:
    """``x -> scale rotation x + translation``.

    Parameters
    ----------
    rotation : (3, 3) float
        Proper: its determinant is 1.
    translation : (3,) float
        mm.
    scale : float
        1 of a rigid motion.
    """

    rotation: FloatArray
    translation: FloatArray
    scale: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation", frozen(self.rotation, np.float64))
        object.__setattr__(self, "translation", frozen(self.translation, np.float64))

    @classmethod
    def identity(cls) -> RigidTransform:
        """Return the transform that changes nothing."""
        return cls(np.eye(3), np.zeros(3))

    def apply(self, points: FloatArray) -> FloatArray:
        """Return points (..., 3) carried along."""
        carried: FloatArray = self.scale * (np.asarray(points) @ self.rotation.T) + self.translation
        return carried

    def turn(self, vectors: FloatArray) -> FloatArray:
        """Return displacements (..., 3) carried along: rotated and scaled, not shifted."""
        carried: FloatArray = self.scale * (np.asarray(vectors) @ self.rotation.T)
        return carried

    def inverse(self) -> RigidTransform:
        """Return the transform that undoes this one."""
        back = self.rotation.T
        return RigidTransform(back, -(back @ self.translation) / self.scale, 1.0 / self.scale)

    def after(self, first: RigidTransform) -> RigidTransform:
        """Return the transform that does ``first`` and then this one."""
        return RigidTransform(self.rotation @ first.rotation, self.apply(first.translation), self.scale * first.scale)


def align(
    source: FloatArray, target: FloatArray, weights: FloatArray | None = None, scale: bool = False
) -> RigidTransform:
    """Return the transform that brings ``source`` onto ``target`` with the least weighted squared distance.

    Parameters
    ----------
    source, target : (n, 3) float
        Points that correspond, finite.
    weights : (n,) float, optional
        Non-negative; 1 each where left out.
    scale : bool
        Whether a uniform scale is found too.

    Raises
    ------
    InputError
        For fewer than 3 points of positive weight, points on a line (the turn about it is free), or arrays that do
        not fit or are not finite.

    References
    ----------
    Kabsch 1976; Umeyama 1991.
    """
    source, target = np.asarray(source, dtype=np.float64), np.asarray(target, dtype=np.float64)
    if source.ndim != 2 or source.shape[1] != 3 or source.shape != target.shape:
        problem = f"have shapes {source.shape} and {target.shape}"
        raise InputError("points", problem, "give as many rows of 3 numbers on both sides")
    share = np.ones(len(source)) if weights is None else np.asarray(weights, dtype=np.float64)
    if share.shape != (len(source),) or not np.isfinite(share).all() or (share < 0).any():
        raise InputError("weights", "are not one non-negative number a point", "correct them")
    if not (np.isfinite(source).all() and np.isfinite(target).all()):
        raise InputError("points", "hold numbers that are not finite", "leave out the points that are missing")
    if np.count_nonzero(share) < 3:
        raise InputError("points", f"are {np.count_nonzero(share)}", "give at least 3 pairs to align")
    share = share / share.sum()
    middle, goal = share @ source, share @ target
    first, second = source - middle, target - goal
    for name, cloud in (("source", first), ("target", second)):
        spread = np.linalg.svd(np.sqrt(share)[:, None] * cloud, compute_uv=False)
        size = max(float(np.abs(cloud).max()), 1e-300)
        if spread[1] <= _FLAT * max(spread[0], size):
            raise InputError(f"{name} points", "lie on one line or in one place", "choose points that do not")
    covariance = (share[:, None] * second).T @ first
    u, values, vt = np.linalg.svd(covariance)
    signs = np.array([1.0, 1.0, float(np.sign(np.linalg.det(u) * np.linalg.det(vt)))])
    rotation = (u * signs) @ vt
    factor = float((values * signs).sum() / (share @ (first**2).sum(axis=1))) if scale else 1.0
    if factor <= 0:
        raise InputError("points", "fit no rotation: one side is the other's mirror image", "check their order")
    return RigidTransform(rotation, goal - factor * (rotation @ middle), factor)
