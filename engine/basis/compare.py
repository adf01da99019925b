"""Hand, quasi-eigen and principal bases side by side, under the same bounds (ours; Kim & Ko 2007, section 5.5)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from engine.basis.error import ReproductionError, reduced_error, vertex_squares
from engine.basis.principal import PrincipalBasis
from engine.basis.quasi_eigen import QuasiEigen, axis_variances
from engine.basis.reduce import reduce_motion
from engine.basis.weights import BOUNDS, check_bounds, check_ridge, solve_reduced, split, stacked
from engine.mesh import FloatArray, IntArray, frozen
from engine.motion import MeshMotion
from engine.progress import Progress, part, silent
from engine.shapes import ExpressionBasis, check_topology

BasisKey = Literal["hand", "quasi_eigen", "pca"]
KEYS: tuple[BasisKey, ...] = ("hand", "quasi_eigen", "pca")


@dataclass(frozen=True)
class Comparison:
    """Three bases under three bounds, over one performance.

    Attributes
    ----------
    bases : mapping of basis key to ExpressionBasis
        ``hand``, ``quasi_eigen``, ``pca``; the axes of ``pca`` are scaled: one unit is one standard deviation.
    weights : mapping of basis key to mapping of bounds key to (L, n) float
        Keys of bounds: ``0..1``, ``-1..2``, ``free``.
    errors : the same of ReproductionError
    p99 : the same of float
        99th percentile of the size of the weights over all frames and shapes.
    largest : the same of float
        The largest size of a weight.
    """

    bases: Mapping[str, ExpressionBasis]
    weights: Mapping[str, Mapping[str, FloatArray]]
    errors: Mapping[str, Mapping[str, ReproductionError]]
    p99: Mapping[str, Mapping[str, float]]
    largest: Mapping[str, Mapping[str, float]]


def deviation_basis(principal: PrincipalBasis) -> ExpressionBasis:
    """Return the axes as shapes about the mean, each one standard deviation long, so that weights count them (ours)."""
    plain = principal.basis()
    deviations = np.sqrt(axis_variances(principal))
    return ExpressionBasis(plain.neutral, plain.names, plain.displacements * deviations[:, None, None], plain.mean)


def compare(
    hand: ExpressionBasis,
    quasi: QuasiEigen | ExpressionBasis,
    principal: PrincipalBasis,
    motion: MeshMotion,
    *,
    vertices: IntArray | None = None,
    ridge: float = 0.0,
    progress: Progress = silent,
) -> Comparison:
    """Return how closely three bases reproduce a motion under three bounds (Kim & Ko 2007, section 5.5; bounds: ours).

    The motion is reduced once for all of them. Under bounds the principal axes count in standard deviations.

    Parameters
    ----------
    vertices : (V,) int, optional
        The metric's vertices; all where left out.
    ridge : float
        As in `solve_weights`; the same for all.

    Raises
    ------
    InputError
        On bases or a motion of another topology, or numbers that are not finite.
    Cancelled
        Raised by ``progress``.
    """
    quasi_basis = quasi.basis if isinstance(quasi, QuasiEigen) else quasi
    ridge = check_ridge(ridge)
    bases: dict[str, ExpressionBasis] = dict(zip(KEYS, (hand, quasi_basis, deviation_basis(principal)), strict=True))
    return _compared(bases, motion, vertices, ridge, progress)


def compare_again(
    before: Comparison,
    quasi: QuasiEigen | ExpressionBasis,
    motion: MeshMotion,
    *,
    vertices: IntArray | None = None,
    ridge: float = 0.0,
    progress: Progress = silent,
) -> Comparison:
    """Return a comparison with another quasi-eigen basis; hand and principal bases keep their figures (ours).

    Parameters
    ----------
    before : Comparison
        Of the same motion, vertices and ridge.

    Raises
    ------
    InputError
        On a basis of another topology.
    Cancelled
        Raised by ``progress``.
    """
    basis = quasi.basis if isinstance(quasi, QuasiEigen) else quasi
    new = _compared({"quasi_eigen": basis}, motion, vertices, check_ridge(ridge), progress)
    return Comparison(
        bases={**before.bases, **new.bases},
        weights={**before.weights, **new.weights},
        errors={**before.errors, **new.errors},
        p99={**before.p99, **new.p99},
        largest={**before.largest, **new.largest},
    )


def _compared(
    bases: Mapping[str, ExpressionBasis],
    motion: MeshMotion,
    vertices: IntArray | None,
    ridge: float,
    progress: Progress,
) -> Comparison:
    for key, basis in bases.items():
        check_topology(f"{key} basis", len(basis.neutral), len(motion.neutral), "the motion")
    rows = [stacked(basis) for basis in bases.values()]
    starts = np.cumsum([0, *(len(row) for row in rows)])
    reduced = reduce_motion(motion, np.concatenate(rows), vertices=vertices, progress=part(progress, 0, 0.3))
    del rows
    coordinates = {
        key: split(bases[key], reduced.shapes[start:stop])
        for key, start, stop in zip(bases, starts[:-1], starts[1:], strict=True)
    }
    weights: dict[str, dict[str, FloatArray]] = {key: {} for key in bases}
    jobs = [(key, name) for key in bases for name in BOUNDS]
    for step, (key, name) in enumerate(jobs):
        shapes, mean = coordinates[key]
        own = part(progress, 0.3 + 0.4 * step / len(jobs), 0.3 + 0.4 * (step + 1) / len(jobs))
        solved = solve_reduced(reduced.frames - mean, shapes, check_bounds(BOUNDS[name]), ridge, progress=own)
        weights[key][name] = frozen(solved, np.float64)
    per_vertex: dict[str, FloatArray] = {}
    if reduced.rest is None:
        known = {f"{key} {name}": (bases[key], weights[key][name]) for key, name in jobs}
        per_vertex = vertex_squares(motion, known, reduced.vertices, part(progress, 0.7, 1))
    errors: dict[str, dict[str, ReproductionError]] = {key: {} for key in bases}
    for step, (key, name) in enumerate(jobs):
        progress(0.7 + 0.3 * step / len(jobs) if reduced.rest is not None else 1.0, "Measuring the error")
        shapes, mean = coordinates[key]
        own_squares = per_vertex.get(f"{key} {name}")
        errors[key][name] = reduced_error(reduced, shapes, mean, weights[key][name], len(motion.neutral), own_squares)
    sizes = {key: {name: np.abs(found) for name, found in weights[key].items()} for key in bases}
    progress(1.0, "Measuring the error")
    return Comparison(
        bases=bases,
        weights=weights,
        errors=errors,
        p99={key: {name: float(np.percentile(size, 99)) for name, size in sizes[key].items()} for key in bases},
        largest={key: {name: float(size.max()) for name, size in sizes[key].items()} for key in bases},
    )
