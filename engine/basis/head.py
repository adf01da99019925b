"""The head's own motion: found from markers that move rigidly together, and removed from all others."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from engine.errors import InputError, some
from engine.geometry.rigid import RigidTransform
from engine.mesh import BoolArray, FloatArray, IntArray, frozen
from engine.motion import MarkerClip

_HEAD_LABEL = re.compile(r"(?:^|[^a-z])(?:head|hat|cap|helmet|hd|[lr][fb]hd)(?:[^a-z]|$)", re.IGNORECASE)
_SAMPLED = 600
_STRAY_MM = 1.0
_STEADY, _SPAN = 0.35, 0.33


@dataclass(frozen=True)
class HeadMotion:
    """The pose of a head in every frame: it carries the reference head to where it was.

    Parameters
    ----------
    rotations : (L, 3, 3) float
        Proper rotations.
    translations : (L, 3) float
        mm.
    filled : (L,) bool
        Frames with fewer than 3 usable markers, whose pose is interpolated.
    strays : int
        Marker positions that did not move with the others and had no say.
    residual_mm : float
        RMS distance of the markers from where the pose puts them.
    """

    rotations: FloatArray
    translations: FloatArray
    filled: BoolArray
    strays: int
    residual_mm: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotations", frozen(self.rotations, np.float64))
        object.__setattr__(self, "translations", frozen(self.translations, np.float64))
        object.__setattr__(self, "filled", frozen(self.filled, bool))

    def __len__(self) -> int:
        return len(self.rotations)

    def remove(self, positions: FloatArray) -> FloatArray:
        """Return positions (L, K, 3), mm, with the head held still in its reference pose; NaN stays NaN."""
        still: FloatArray = np.einsum("lki,lij->lkj", positions - self.translations[:, None], self.rotations)
        return still

    def at(self, frames: IntArray) -> HeadMotion:
        """Return the poses of some frames."""
        strays, residual = self.strays, self.residual_mm
        return HeadMotion(self.rotations[frames], self.translations[frames], self.filled[frames], strays, residual)

    def seen_from(self, placement: RigidTransform) -> HeadMotion:
        """Return the same motion in the frame that ``placement`` leads to; its scale goes along."""
        turn, shift = placement.rotation, placement.translation
        rotations = turn @ self.rotations @ turn.T
        moved = placement.scale * self.translations @ turn.T
        translations = moved + shift - np.einsum("lij,j->li", rotations, shift)
        return HeadMotion(rotations, translations, self.filled, self.strays, placement.scale * self.residual_mm)

    def transforms(self) -> tuple[RigidTransform, ...]:
        """Return the pose of every frame."""
        return tuple(RigidTransform(r, t) for r, t in zip(self.rotations, self.translations, strict=True))


def propose_head(clip: MarkerClip, tolerance_mm: float | None = None) -> tuple[str, ...]:
    """Return labels of markers that seem to sit on the head: by their names, else those that move rigidly together.

    Names such as ``head1``, ``LFHD`` or ``cap_2`` count where there are at least three. Otherwise (ours) markers are
    grouped so that the distance of no two in a group varies by more than the tolerance; the largest group wins, the
    higher one of two alike. Empty where no group has three markers that do not lie on a line, span a third of all, and
    are much steadier than the face: calm cheeks are no skull.

    Parameters
    ----------
    clip : MarkerClip
        mm, +Y up.
    tolerance_mm : float, optional
        Standard deviation of a distance over the clip; from the steadiest pairs where left out.
    """
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    named = tuple(label for label in clip.labels if _HEAD_LABEL.search(label.replace("_", " ")))
    if len(named) >= 3 and len(named) < len(clip.labels):
        return named
    count = len(clip.labels)
    if count < 4:
        return ()
    chosen = np.unique(np.linspace(0, len(clip) - 1, min(_SAMPLED, len(clip))).astype(np.int64))
    unsteady = _unsteadiness(clip.positions[chosen])
    pairs = unsteady[np.triu_indices(count, 1)]
    pairs = pairs[np.isfinite(pairs)]
    if not len(pairs):
        return ()
    if tolerance_mm is None:
        tolerance_mm = max(2.5 * float(np.sort(pairs)[min(2, len(pairs) - 1)]), 0.05)
    distance = np.where(np.isfinite(unsteady), unsteady, 10 * tolerance_mm + pairs.max())
    np.fill_diagonal(distance, 0.0)
    group = fcluster(linkage(squareform(distance, checks=False), "complete"), tolerance_mm, "distance")
    height = [np.nanmedian(up) if np.isfinite(up).any() else 0.0 for up in clip.positions[..., 1].T]
    middles = np.array([np.nanmedian(t, axis=0) for t in clip.positions[chosen].transpose(1, 0, 2) if _shown(t)])
    whole = float(np.ptp(middles, axis=0).max()) if len(middles) else 0.0
    best: tuple[float, float] = (0.0, 0.0)
    found: IntArray = np.zeros(0, dtype=np.int64)
    for name in np.unique(group):
        members = np.flatnonzero(group == name)
        typical = np.nanmedian(clip.positions[chosen][:, members], axis=0) if len(members) >= 3 else np.zeros((0, 3))
        if len(members) < 3 or len(members) == count or _on_a_line(typical):
            continue
        inside = unsteady[np.ix_(members, members)]
        if np.nanmax(inside) > _STEADY * np.median(pairs) or np.ptp(typical, axis=0).max() < _SPAN * whole:
            continue
        score = (float(len(members)), float(np.mean([height[k] for k in members])))
        if score > best or not len(found):
            best, found = score, members
    return tuple(clip.labels[k] for k in found)


def head_motion(clip: MarkerClip, labels: Sequence[str], reference_frame: int | None = None) -> HeadMotion:
    """Return the head's pose in every frame from its markers, about their places in the reference frame.

    A marker that is missing or that strays from where the others put it has no say in a frame; with fewer than 3 left,
    the pose is interpolated between its neighbours (and counted).

    Parameters
    ----------
    clip : MarkerClip
        mm.
    labels : sequence of str
        At least 3 markers on the head, not on a line.
    reference_frame : int, optional
        The frame whose pose is the identity; the first that shows the most of them where left out.

    Raises
    ------
    InputError
        On unknown labels, fewer than 3, markers on a line, or when no frame shows 3 of them.
    """
    unknown = [label for label in labels if label not in clip.labels]
    if unknown:
        raise InputError(f"head marker {some(unknown)}", "is not in the clip", f"it has {some(clip.labels)}")
    if len(set(labels)) < 3:
        raise InputError("head markers", f"are {len(set(labels))}", "choose at least 3 that do not lie on a line")
    columns = [clip.labels.index(label) for label in dict.fromkeys(labels)]
    positions = clip.positions[:, columns]
    seen = clip.seen[:, columns]
    if seen.sum(axis=1).max() < 3:
        raise InputError("head markers", "are never seen three at a time", "choose others, or none")
    first = int(seen.sum(axis=1).argmax()) if reference_frame is None else reference_frame
    if seen[first].sum() < 3:
        raise InputError(f"frame {first + 1}", "shows fewer than 3 head markers", "choose another rest frame")
    shape = _shape(positions, seen, first)
    if _on_a_line(shape[np.isfinite(shape).all(axis=1)]):
        raise InputError("head markers", "lie on one line", "choose markers that do not")
    seen = seen & np.isfinite(shape).all(axis=1)
    rotations, translations, used, strays, residual = _poses(np.nan_to_num(shape), positions, seen)
    good = used >= 3
    if not good.any():
        raise InputError("head markers", "fit no rigid motion in any frame", "choose markers that move together")
    rotations, translations = _interpolated(rotations, translations, good)
    # The identity belongs to the reference frame: the shape is a mean over frames and lies a little beside it.
    base, shift = rotations[first], translations[first]
    rotations = rotations @ base.T
    translations = translations - np.einsum("lij,j->li", rotations, shift)
    return HeadMotion(rotations, translations, ~good, strays, residual)


def _unsteadiness(positions: FloatArray) -> FloatArray:
    """Standard deviation (K, K) of the distance of every two markers; NaN for pairs seldom seen together."""
    count = positions.shape[1]
    found = np.full((count, count), np.nan)
    least = max(3, len(positions) // 20)
    for k in range(count):
        away = np.linalg.norm(positions - positions[:, k : k + 1], axis=2)
        often = np.isfinite(away).sum(axis=0) >= least
        if often.any():
            found[k, often] = np.nanstd(away[:, often], axis=0)
    return found


def _shape(positions: FloatArray, seen: BoolArray, first: int) -> FloatArray:
    """Mean places (H, 3) of the markers in the pose of frame ``first``; NaN for one that cannot be joined to them."""
    shape: FloatArray = np.array(positions[first], dtype=np.float64)
    chosen = np.unique(np.linspace(0, len(positions) - 1, min(_SAMPLED, len(positions))).astype(np.int64))
    for _ in range(4):
        known = np.isfinite(shape).all(axis=1)
        if known.sum() < 3:
            break
        use = seen[chosen] & known
        rotations, translations, used, _, _ = _poses(np.nan_to_num(shape), positions[chosen], use)
        good = used >= 3
        back = np.einsum("lhi,lij->lhj", positions[chosen][good] - translations[good][:, None], rotations[good])
        some_seen = seen[chosen][good].any(axis=0)
        fresh: FloatArray = np.full_like(shape, np.nan)
        if some_seen.any():
            fresh[some_seen] = np.nanmedian(back[:, some_seen], axis=0)
        shape = np.where(np.isfinite(fresh), fresh, shape)
    return shape


def _poses(
    shape: FloatArray, positions: FloatArray, seen: BoolArray
) -> tuple[FloatArray, FloatArray, IntArray, int, float]:
    """Pose of every frame, how many markers it rests on, how many strayed, and the RMS residual, mm."""
    places = np.where(seen[..., None], positions, 0.0)
    use = seen.astype(np.float64)
    rotations, translations = _kabsch(shape, places, use)
    away = _residual(shape, places, rotations, translations)
    typical = np.sqrt(np.sum(use * away**2, axis=1) / np.maximum(use.sum(axis=1), 1))
    usual = float(np.median(typical[use.sum(axis=1) >= 3])) if (use.sum(axis=1) >= 3).any() else 0.0
    # One marker that strays pulls the pose along and all look wrong: leave out the worst, one at a time.
    limit = max(_STRAY_MM, 5 * usual)
    strays = 0
    for _ in range(max(0, shape.shape[0] - 3)):
        off = np.where(use > 0, away, 0.0)
        bad = np.flatnonzero((off.max(axis=1) > limit) & (use.sum(axis=1) > 3))
        if not len(bad):
            break
        use[bad] = _without_worst(shape, places[bad], use[bad])
        strays += len(bad)
        rotations[bad], translations[bad] = _kabsch(shape, places[bad], use[bad])
        away[bad] = _residual(shape, places[bad], rotations[bad], translations[bad])
    used = use.sum(axis=1).astype(np.int64)
    # Where even three do not agree with the shape, the frame tells nothing.
    used[np.where(use > 0, away, 0.0).max(axis=1) > limit] = 0
    good = used >= 3
    residual = float(np.sqrt((use[good] * away[good] ** 2).sum() / use[good].sum())) if good.any() else 0.0
    return rotations, translations, used, strays, residual


def _without_worst(shape: FloatArray, places: FloatArray, use: FloatArray) -> FloatArray:
    """Leave out, in each frame, the marker whose absence makes the others agree best."""
    best = np.full(len(use), np.inf)
    chosen = use.copy()
    for marker in range(use.shape[1]):
        trial = use.copy()
        trial[:, marker] = 0.0
        rotations, translations = _kabsch(shape, places, trial)
        away = _residual(shape, places, rotations, translations)
        cost = np.where(use[:, marker] > 0, (trial * away**2).sum(axis=1), np.inf)
        better = cost < best
        best[better], chosen[better] = cost[better], trial[better]
    return chosen


def _kabsch(shape: FloatArray, places: FloatArray, use: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation (L, 3, 3) and translation (L, 3) of every frame; the identity where fewer than 3 markers have a say."""
    total = np.maximum(use.sum(axis=1), 1.0)[:, None]
    middle = use @ shape / total
    goal = np.einsum("lh,lhi->li", use, places) / total
    covariance = np.einsum("lh,lhi,lhj->lij", use, places - goal[:, None], shape[None] - middle[:, None])
    u, _, vt = np.linalg.svd(covariance)
    signs = np.ones((len(use), 3))
    signs[:, 2] = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    rotations = (u * signs[:, None]) @ vt
    rotations[use.sum(axis=1) < 3] = np.eye(3)
    translations = goal - np.einsum("lij,lj->li", rotations, middle)
    return rotations, translations


def _residual(shape: FloatArray, places: FloatArray, rotations: FloatArray, translations: FloatArray) -> FloatArray:
    carried = np.einsum("lij,hj->lhi", rotations, shape) + translations[:, None]
    away: FloatArray = np.linalg.norm(carried - places, axis=2)
    return away


def _interpolated(rotations: FloatArray, translations: FloatArray, good: BoolArray) -> tuple[FloatArray, FloatArray]:
    if good.all():
        return rotations, translations
    known = np.flatnonzero(good)
    wanted = np.clip(np.arange(len(good)), known[0], known[-1]).astype(np.float64)
    turned = Rotation.from_matrix(rotations[known])
    smooth = Slerp(known, turned)(wanted) if len(known) > 1 else turned[np.zeros(len(good), dtype=np.int64)]
    shifted = np.stack([np.interp(wanted, known, translations[known, axis]) for axis in range(3)], axis=1)
    matrices = np.where(good[:, None, None], rotations, smooth.as_matrix())
    return matrices, np.where(good[:, None], translations, shifted)


def _shown(track: FloatArray) -> bool:
    return bool(np.isfinite(track).all(axis=1).any())


def _on_a_line(points: FloatArray) -> bool:
    if len(points) < 3:
        return True
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(values[1] <= 0.02 * max(values[0], 1e-9))
