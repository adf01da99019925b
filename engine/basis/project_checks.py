"""What a projection says about the shapes it was given, in plain words (ours)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.errors import some
from engine.mesh import BoolArray, FloatArray
from engine.shapes import ExpressionBasis

LOOKS_LIKE_ITSELF = 0.85
"""Cosine to its hand shape below which a quasi-eigen face no longer looks like it."""
SAME = 1 - 1e-9
"""Cosine from which two shapes are one."""
NEUTRALS_APART_MM = 0.1
"""RMS distance of two neutral faces from which they are said to differ, mm."""


@dataclass(frozen=True)
class Facts:
    """What the warnings are drawn from; ``shapes`` (n, 3V) over the metric's vertices."""

    hand: ExpressionBasis
    shapes: FloatArray
    still: BoolArray
    cosine: FloatArray
    rank: int
    axes: int
    missing: tuple[int, ...]
    affine: bool
    neutral_apart_mm: float


def plain_warnings(facts: Facts) -> tuple[str, ...]:
    """Return the warnings about a projection, gravest first."""
    names, count = facts.hand.names, len(facts.hand)
    plural = "shape" if count == 1 else "shapes"
    said: list[str] = []
    if facts.neutral_apart_mm > NEUTRALS_APART_MM:
        said.append(
            f"The shapes rest on another neutral face than the performance ({facts.neutral_apart_mm:.2f} mm RMS apart);"
            " only their displacements are compared."
        )
    still = [name for name, at_rest in zip(names, facts.still, strict=True) if at_rest]
    if still:
        said.append(f"{_shapes(still)} not move the measured part of the face: {some(still)}.")
    for first, second in duplicates(facts.shapes, facts.still):
        said.append(f"{names[second]} is the same shape as {names[first]}: it adds nothing that can be reproduced.")
    drifted = [names[i] for i in np.argsort(facts.cosine) if facts.cosine[i] < LOOKS_LIKE_ITSELF]
    if drifted:
        worst = float(np.nanmin(facts.cosine))
        verb = "no longer looks like itself" if len(drifted) == 1 else "no longer look like themselves"
        said.append(
            f"{len(drifted)} of {count} {plural} {verb} (cosine below {LOOKS_LIKE_ITSELF}, lowest {worst:.2f}): "
            f"{some(drifted)}."
        )
    needed = facts.axes if facts.affine else facts.axes + 1
    if count < needed:
        kind = "axes" if facts.affine else "axes and the mean"
        said.append(f"{count} {plural} cannot span {facts.axes} {kind}: sculpt at least {needed - count} more.")
    if facts.missing:
        listed = some([str(axis + 1) for axis in facts.missing])
        said.append(f"No shape touches axis {listed}: add it as a shape and make it recognisable.")
    reachable = min(count, facts.axes)
    if facts.rank < reachable:
        lost = reachable - facts.rank
        said.append(
            f"The projection has rank {facts.rank} of {reachable}: {lost} {'shape says' if lost == 1 else 'shapes say'}"
            " what others say already."
        )
    return tuple(said)


def _shapes(names: list[str]) -> str:
    return "A shape does" if len(names) == 1 else f"{len(names)} shapes do"


def duplicates(shapes: FloatArray, still: BoolArray) -> list[tuple[int, int]]:
    """Return pairs (first, second) of shapes (n, 3V) that differ by a factor above 0 at most, each second once."""
    size = np.linalg.norm(shapes, axis=1)
    unit = shapes / np.where(still | (size == 0), 1.0, size)[:, None]
    unit[still] = 0
    cosine = unit @ unit.T
    pairs = []
    for second in range(len(shapes)):
        same = np.flatnonzero(cosine[second, :second] >= SAME)
        if len(same):
            pairs.append((int(same[0]), second))
    return pairs
