"""The shapes of a rig as a table that can be worked on: renamed, mirrored, split, combined."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from engine.errors import InputError, some
from engine.mesh import FloatArray
from engine.mirror_map import MirrorMap, mid_plane, mirror_map, mirrored
from engine.name_text import LONGEST_NAME, is_name
from engine.shapes import ExpressionBasis, Rig


class ShapeTable:
    """The shapes of a rig by name, in their order; ``rig`` gives back a frozen one.

    Parameters
    ----------
    rig : Rig
        Is not changed.
    pairs : MirrorMap, optional
        The other side of its vertices; found when it is needed where it is left out.
    """

    def __init__(self, rig: Rig, pairs: MirrorMap | None = None) -> None:
        self._rig = rig
        self._pairs = pairs
        self._middle = None if pairs is None else pairs.middle
        self._shapes = dict(zip(rig.basis.names, rig.basis.displacements, strict=True))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the shapes, in their order."""
        return tuple(self._shapes)

    def rig(self) -> Rig:
        """Return the rig with the shapes as they are now."""
        basis = self._rig.basis
        if self.names == basis.names and all(
            shape is old or np.shares_memory(shape, old)
            for shape, old in zip(self._shapes.values(), basis.displacements, strict=True)
        ):
            return self._rig
        displacements = np.stack(list(self._shapes.values()))
        displacements.flags.writeable = False
        return Rig(self._rig.mesh, ExpressionBasis(basis.neutral, self.names, displacements, basis.mean))

    def rename(self, name: str, to: str) -> None:
        """Give a shape another name."""
        self._get(name)
        if to != name:
            self._free(to)
        self._shapes = {to if old == name else old: shape for old, shape in self._shapes.items()}

    def reorder(self, names: Sequence[str]) -> None:
        """Put the shapes in the order of ``names``, which are all of them."""
        double = [name for name, count in Counter(names).items() if count > 1]
        if double:
            raise InputError(f"shape {double[0]!r}", "is named twice in the new order", "name every shape once")
        for name in names:
            self._get(name)
        left = [name for name in self._shapes if name not in set(names)]
        if left:
            raise InputError(f"shape {left[0]!r}", "is not in the new order", "name every shape once")
        self._shapes = {name: self._shapes[name] for name in names}

    def remove(self, names: Sequence[str]) -> None:
        """Take shapes out; at least one stays."""
        for name in names:
            self._get(name)
        if len(set(names)) == len(self._shapes):
            raise InputError(f"shapes {some(names)}", "are all there are", "keep at least one")
        self._shapes = {name: shape for name, shape in self._shapes.items() if name not in set(names)}

    def mirror(self, name: str, to: str, replace: bool = False) -> None:
        """Put the mirror image of a shape under the name ``to``: in its own place, in that of ``to``, or behind it."""
        shape = self._get(name)
        if to != name and not replace:
            self._free(to)
        if self._pairs is None:
            self._pairs = mirror_map(self._rig.mesh)
            self._middle = self._pairs.middle
        mean = self._rig.basis.mean
        # About a mean the face that is seen is both together.
        made = mirrored(shape, self._pairs) if mean is None else mirrored(shape + mean, self._pairs) - mean
        if to in self._shapes:
            self._shapes[to] = made
        else:
            self._put(name, {name: shape, to: made})

    def split(self, name: str, left: str, right: str, border_mm: float, keep: bool = False) -> None:
        """Part a shape across the mid plane, with a border of so many mm in which it fades; the halves add up to it."""
        shape = self._get(name)
        if left == right:
            raise InputError(f"shape {left!r}", "is the name of both halves", "give each a name of its own")
        for half in (left, right):
            if half != name or keep:
                self._free(half)
        if self._middle is None:
            self._middle = mid_plane(self._rig.mesh)
        halves = halved(shape, left_share(self._rig.basis.neutral[:, 0] - self._middle, border_mm))
        self._put(name, ({name: shape} if keep else {}) | dict(zip((left, right), halves, strict=True)))

    def combine(self, terms: Sequence[tuple[str, float]], to: str, keep: bool = True) -> None:
        """Put the weighted sum of shapes behind the last of them, or in their place."""
        names = [name for name, _ in terms]
        made = np.zeros_like(self._rig.basis.neutral)
        for name, weight in terms:
            made = made + weight * self._get(name)
        if keep or to not in names:
            self._free(to)
        last = max(names, key=list(self._shapes).index)
        self._put(last, {last: self._shapes[last], to: made} if keep else {to: made})
        if not keep:
            gone = set(names) - {to}
            self._shapes = {name: shape for name, shape in self._shapes.items() if name not in gone}

    def _get(self, name: str) -> FloatArray:
        if name not in self._shapes:
            raise InputError(f"shape {name!r}", "is not in the rig", f"it has {some(self._shapes)}")
        shape: FloatArray = self._shapes[name]
        return shape

    def _free(self, name: str) -> None:
        if not is_name(name):
            raise InputError(f"shape {name[:40]!r}", "cannot be called so", f"use 1 to {LONGEST_NAME} letters")
        if name in self._shapes:
            raise InputError(f"shape {name!r}", "is in the rig already", "choose another name")

    def _put(self, name: str, shapes: dict[str, FloatArray]) -> None:
        """Put shapes into the place of one."""
        found: dict[str, FloatArray] = {}
        for old, shape in self._shapes.items():
            if old == name:
                found |= shapes
            elif old not in shapes:
                found[old] = shape
        self._shapes = found


def left_share(x: FloatArray, border_mm: float) -> FloatArray:
    """Return how much (N,) of a motion at ``x`` mm from the mid plane is of the left: a smooth step over the border."""
    if border_mm > 0:
        t = np.asarray(np.clip(0.5 + x / border_mm, 0.0, 1.0), dtype=np.float64)
    else:
        t = 0.5 + 0.5 * np.sign(x)
    return t * t * (3 - 2 * t)


def halved(shape: FloatArray, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two parts of displacements (N, 3) that add up to them to the last bit; ``share`` (N,) is the first's."""
    most = np.where(share >= 0.5, share, 1 - share)[:, None] * shape
    # The larger part is at least half of the whole, so that this difference and the sum are exact (Sterbenz).
    rest = shape - most
    first = (share >= 0.5)[:, None]
    return np.where(first, most, rest), np.where(first, rest, most)
