"""Quasi-eigen faces: hand-sculpted shapes projected onto what a performance does (Kim & Ko 2007, section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.basis.principal import PrincipalBasis
from engine.basis.project_checks import Facts, plain_warnings
from engine.basis.reduce import STILL, restricted
from engine.basis.weights import SHAPE_PRECISION
from engine.errors import InputError
from engine.mesh import FloatArray, frozen
from engine.shapes import ExpressionBasis, check_topology

UNTOUCHED = 0.1
"""An axis is missing when all shapes together reach less than this many of its standard deviations."""
AUGMENTED = 2.0
"""How many standard deviations from the mean an axis stands that was added as a shape."""
STILL_MM = 1e-6
"""RMS displacement in mm below which a shape does not move the metric's vertices."""


@dataclass(frozen=True)
class QuasiEigen:
    """A hand-sculpted basis projected onto the principal axes of a performance.

    All figures are over the metric's vertices; axes are counted from 0.

    Attributes
    ----------
    basis : ExpressionBasis
        The quasi-eigen faces under the hand shapes' names. Linear (Kim & Ko 2007): displacements from the neutral face,
        ``mean`` None. Affine (ours): displacements about ``mean`` = mu.
    projection : (n, m) float
        W, eq. 3, mm.
    residual_mm : (n,) float
        RMS distance between a hand shape and its quasi-eigen face, mm.
    residual_fraction : (n,) float
        The same as a share of the hand shape; NaN for a shape that does not move.
    cosine : (n,) float
        Cosine between both as displacements from the neutral face (ours); NaN for a shape that does not move.
    missing : tuple of int
        Axes that no shape touches: ``sum_i |w_ij| < epsilon sqrt(lambda_j)`` (section 4; in standard deviations: ours).
    rank : int
        Rank of W (ours), to the precision that files keep shapes in: finds what ``missing`` cannot, a shape that says
        what another says.
    singular_values : (min(n, m),) float
        Of ``W Lambda^-1/2``, descending (ours).
    span_coverage : float
        Share of the training variance that free weights of this basis reproduce (ours); the axes' coverage at best. For
        the linear basis a lower bound: what it reproduces of the mean beside the axes is not counted.
    affine : bool
    warnings : tuple of str
        What an artist should know, in plain words.
    """

    basis: ExpressionBasis
    projection: FloatArray
    residual_mm: FloatArray
    residual_fraction: FloatArray
    cosine: FloatArray
    missing: tuple[int, ...]
    rank: int
    singular_values: FloatArray
    span_coverage: float
    affine: bool
    warnings: tuple[str, ...]


def project(
    hand: ExpressionBasis, principal: PrincipalBasis, affine: bool = False, *, epsilon: float = UNTOUCHED
) -> QuasiEigen:
    """Return the quasi-eigen faces of hand-sculpted shapes (Kim & Ko 2007, eq. 3 and 4).

    ``w_ij = e_j . (e_i - mu)`` over the metric's vertices of ``principal``; ``e_i^QE = mu + sum_j w_ij e_j`` on all.
    The linear basis is the paper's, for sliders; the affine one stores ``e_i^QE - mu`` about the mean mu and is the
    span of the principal axes exactly where rank W = m (ours).

    Parameters
    ----------
    hand : ExpressionBasis
        Shapes from the neutral face; a basis about a mean is taken as its shapes plus that mean.
    principal : PrincipalBasis
        Mean and axes of the performance on the same topology.
    affine : bool
    epsilon : float
        Standard deviations of an axis that all shapes together must reach for it not to be missing.

    Raises
    ------
    InputError
        On another topology.
    """
    check_topology("hand basis", len(hand.neutral), len(principal.neutral), "the performance")
    shapes = hand.displacements if hand.mean is None else hand.displacements + hand.mean
    at = principal.vertices
    flat, axes, mean = restricted(shapes, at), restricted(principal.axes, at), restricted(principal.mean, at)
    projection = (flat - mean) @ axes.T
    moved = np.tensordot(projection, principal.axes, axes=1)
    projected = principal.mean + moved
    if affine:
        basis = ExpressionBasis(hand.neutral, hand.names, moved, mean=principal.mean)
    else:
        basis = ExpressionBasis(hand.neutral, hand.names, projected)

    found = restricted(projected, at)
    count = flat.shape[1] // 3
    size, reached = np.linalg.norm(flat, axis=1), np.linalg.norm(found, axis=1)
    residual = np.linalg.norm(flat - found, axis=1)
    still = size <= STILL_MM * np.sqrt(count)
    nothing = np.full(len(hand), np.nan)
    fraction = np.divide(residual, size, out=nothing.copy(), where=~still)
    both = size * reached
    cosine = np.divide(np.einsum("nd,nd->n", flat, found), both, out=nothing.copy(), where=~still & (both > 0))
    cosine[~still & (both == 0)] = 0.0
    variances = axis_variances(principal)
    whitened = projection / np.sqrt(variances)
    singular = _singular(whitened)
    rank = numerical_rank(_singular(_one_length(whitened, np.linalg.norm(flat - mean, axis=1))))
    missing = tuple(int(j) for j in np.flatnonzero(np.abs(whitened).sum(axis=0) < epsilon))
    facts = Facts(
        hand=hand,
        shapes=flat,
        still=still,
        cosine=cosine,
        rank=rank,
        axes=principal.count,
        missing=missing,
        affine=affine,
        neutral_apart_mm=float(np.sqrt(np.mean(np.sum((hand.neutral - principal.neutral) ** 2, axis=1)))),
    )
    return QuasiEigen(
        basis=basis,
        projection=frozen(projection, np.float64),
        residual_mm=frozen(residual / np.sqrt(count), np.float64),
        residual_fraction=frozen(fraction, np.float64),
        cosine=frozen(cosine, np.float64),
        missing=missing,
        rank=rank,
        singular_values=frozen(singular, np.float64),
        span_coverage=_span_coverage(principal, projection, np.hypot(size, np.linalg.norm(mean)), affine),
        affine=affine,
        warnings=plain_warnings(facts),
    )


def axis_variances(principal: PrincipalBasis) -> FloatArray:
    """Return the eigenvalue (m,) of each of the m axes, mm^2, at least 1e-12 of the largest."""
    variances = principal.eigenvalues[: principal.count]
    return np.maximum(variances, max(1e-12 * float(variances.max(initial=0.0)), 1e-300))


def numerical_rank(singular: FloatArray) -> int:
    """Return how many of descending singular values stand clear of the rounding of files (`SHAPE_PRECISION`)."""
    if not len(singular) or not singular[0]:
        return 0
    return int((singular > SHAPE_PRECISION * singular[0]).sum())


def _singular(rows: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.svd(rows, compute_uv=False), dtype=np.float64)


def _one_length(rows: FloatArray, length: FloatArray) -> FloatArray:
    """Return rows (n, m) per length (n,) of the shapes they tell of, so that none is rounding beside another."""
    shows = (length > STILL * length.max(initial=0.0))[:, None]
    return np.divide(rows, length[:, None], out=np.zeros_like(rows), where=shows)


def _span_coverage(principal: PrincipalBasis, projection: FloatArray, length: FloatArray, affine: bool) -> float:
    """Return the share of the training variance that free weights reproduce.

    In m + 1 coordinates: those on the axes, and one along the part of mu beside them, which only a linear basis needs.
    """
    from scipy.linalg import qr

    if not principal.total_variance > 0:
        return float("nan")
    mean, axes = restricted(principal.mean, principal.vertices), restricted(principal.axes, principal.vertices)
    along = mean @ axes.T
    offset = np.append(along, np.linalg.norm(mean - along @ axes))
    span = np.pad(projection, ((0, 0), (0, 1)))
    if not affine:
        span = span + offset
    scale = np.sqrt(np.append(axis_variances(principal), max(float(mean @ mean), 1e-300)))
    _, sizes, right = np.linalg.svd(_one_length(span / scale, length), full_matrices=False)
    kept = right[: numerical_rank(sizes)] * scale
    columns = qr(kept.T, mode="economic")[0] if len(kept) else np.zeros((len(scale), 0))
    variances = principal.eigenvalues[: principal.count]
    held = float(variances @ np.sum(columns[:-1] ** 2, axis=1))
    lost = 0.0 if affine else float(np.sum((offset - columns @ (columns.T @ offset)) ** 2))
    return float(np.clip((held - lost) / principal.total_variance, 0.0, 1.0))


def augment(hand: ExpressionBasis, principal: PrincipalBasis, axes: Sequence[int]) -> ExpressionBasis:
    """Return hand shapes with principal axes added as shapes named ``axis 1`` on (Kim & Ko 2007, section 4).

    An added shape is the mean plus two standard deviations along the axis (ours): it lies in the performance, so
    projecting leaves it as it is, and it is large enough to be looked at and made recognisable.

    Raises
    ------
    InputError
        When an axis is not there or named twice, or on another topology.
    """
    check_topology("hand basis", len(hand.neutral), len(principal.neutral), "the performance")
    wanted = [int(axis) for axis in axes]
    if any(not 0 <= axis < principal.count for axis in wanted) or len(set(wanted)) != len(wanted):
        problem = f"{', '.join(str(axis + 1) for axis in wanted)} of {principal.count}"
        raise InputError("axes", problem, "name axes that are there, each once")
    if not wanted:
        return hand
    deviations = np.sqrt(axis_variances(principal)[wanted])
    added = principal.mean + AUGMENTED * deviations[:, None, None] * principal.axes[wanted]
    names = list(hand.names)
    for axis in wanted:
        name = plain = f"axis {axis + 1}"
        again = 2
        while name in names:
            name, again = f"{plain} ({again})", again + 1
        names.append(name)
    shapes = hand.displacements if hand.mean is None else hand.displacements + hand.mean
    return ExpressionBasis(hand.neutral, tuple(names), np.concatenate([shapes, added]))


def blend(hand: ExpressionBasis, quasi: ExpressionBasis, amounts: FloatArray) -> ExpressionBasis:
    """Return shapes between hand (amount 0) and quasi-eigen (amount 1), each by its own amount (n,) (ours).

    An affine quasi-eigen basis hands over its mean by the mean amount, so that both ends are the bases themselves.

    Raises
    ------
    InputError
        Unless both bases have the same shapes and there is one amount in 0..1 a shape.
    """
    check_topology("quasi-eigen basis", len(quasi.neutral), len(hand.neutral), "the hand basis")
    if quasi.names != hand.names:
        raise InputError("quasi-eigen basis", "has other shapes than the hand basis", "project the hand basis again")
    amounts = check_amounts(amounts, len(hand))
    mean = blended_mean(hand.mean, quasi.mean, amounts)
    from_neutral = [
        basis.displacements if basis.mean is None else basis.displacements + basis.mean for basis in (hand, quasi)
    ]
    share = amounts[:, None, None]
    shapes = (1 - share) * from_neutral[0] + share * from_neutral[1]
    return ExpressionBasis(hand.neutral, hand.names, shapes if mean is None else shapes - mean, mean=mean)


def check_amounts(amounts: FloatArray, count: int) -> FloatArray:
    """Return one amount in 0..1 a shape, or raise InputError."""
    amounts = np.asarray(amounts, dtype=np.float64)
    if amounts.shape != (count,) or not (np.isfinite(amounts) & (amounts >= 0) & (amounts <= 1)).all():
        raise InputError("amounts", f"have shape {amounts.shape} or leave 0..1", f"give {count} numbers from 0 to 1")
    return amounts


def blended_mean(hand: FloatArray | None, quasi: FloatArray | None, amounts: FloatArray) -> FloatArray | None:
    """Return the mean of blended bases: each basis' own by its share of the mean amount; None where neither has one."""
    if hand is None and quasi is None:
        return None
    share = float(amounts.mean())
    first = 0.0 if hand is None else (1 - share) * hand
    second = 0.0 if quasi is None else share * quasi
    return np.asarray(first + second, dtype=np.float64)
