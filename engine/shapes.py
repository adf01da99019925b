"""Expression bases: a neutral face and the named displacements that move it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from engine.errors import InputError, some
from engine.mesh import FloatArray, IntArray, TriangleMesh, frozen

SKIN = "skin"
"""Name of the part that every error figure is measured on."""


@dataclass(frozen=True)
class ExpressionBasis:
    """A neutral face and what may be added to it: ``v = neutral + mean + sum_i w_i displacements_i``.

    Parameters
    ----------
    neutral : (N, 3) float
        Positions in mm.
    names : sequence of str
        One per shape, none empty, none twice.
    displacements : (n, N, 3) float
        Displacements in mm: from the neutral face (Kim & Ko 2007, section 3), or about ``mean`` where there is one.
    mean : (N, 3) float, optional
        Mean displacement in mm of an affine basis (ours).

    Raises
    ------
    InputError
        Without any shape; on names that are empty or double, arrays that do not fit, or numbers that are not finite.
    """

    neutral: FloatArray
    names: tuple[str, ...]
    displacements: FloatArray
    mean: FloatArray | None = None

    def __post_init__(self) -> None:
        neutral, displacements = frozen(self.neutral, np.float64), frozen(self.displacements, np.float64)
        names = tuple(str(name) for name in self.names)
        if neutral.ndim != 2 or neutral.shape[1] != 3:
            raise InputError("neutral", f"has shape {neutral.shape}", "give one row of 3 numbers a vertex")
        if displacements.ndim != 3 or displacements.shape[1:] != neutral.shape:
            problem = f"have shape {displacements.shape} for a neutral face of {len(neutral)} vertices"
            raise InputError("displacements", problem, "give (shapes, vertices, 3) on the same topology")
        if not len(displacements):
            raise InputError("basis", "has no shapes", "give at least one beside the neutral face")
        check_names(names, len(displacements))
        if not np.isfinite(neutral).all():
            raise InputError("neutral", "holds positions that are not finite", "export it again")
        bad = [name for name, shape in zip(names, displacements, strict=True) if not np.isfinite(shape).all()]
        if bad:
            raise InputError(f"shape {some(bad)}", "holds numbers that are not finite", "export it again")
        object.__setattr__(self, "neutral", neutral)
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "displacements", displacements)
        if self.mean is not None:
            mean = frozen(self.mean, np.float64)
            if mean.shape != neutral.shape or not np.isfinite(mean).all():
                problem = f"has shape {mean.shape} or numbers that are not finite"
                raise InputError("mean", problem, "give one finite displacement a vertex")
            object.__setattr__(self, "mean", mean)

    def __len__(self) -> int:
        return len(self.names)

    def evaluate(self, weights: Any) -> FloatArray:
        """Return positions (N, 3) in mm for weights (n,), or (L, N, 3) for (L, n) (Kim & Ko 2007, eq. 1)."""
        weights = np.asarray(weights, dtype=np.float64)
        if weights.shape[-1:] != (len(self),):
            raise InputError("weights", f"have shape {weights.shape}", f"give one for each of the {len(self)} shapes")
        base = self.neutral if self.mean is None else self.neutral + self.mean
        flat = self.displacements.reshape(len(self), -1)
        moved: FloatArray = base + (weights @ flat).reshape(*weights.shape[:-1], *base.shape)
        return moved

    def shape(self, name: str) -> FloatArray:
        """Return the displacements (N, 3) of a shape, mm.

        Raises
        ------
        InputError
            When there is none of that name.
        """
        if name not in self.names:
            raise InputError(f"shape {name!r}", "is not in the basis", f"it has {some(self.names)}")
        found: FloatArray = self.displacements[self.names.index(name)]
        return found


@dataclass(frozen=True)
class Rig:
    """A mesh together with the shapes that move it; the mesh's vertices are the basis' neutral face.

    Parameters
    ----------
    mesh : TriangleMesh
        Faces, texture chart and parts; its vertices are the neutral face, mm.
    basis : ExpressionBasis
        The shapes on the same vertices.
    """

    mesh: TriangleMesh
    basis: ExpressionBasis

    def __post_init__(self) -> None:
        if self.mesh.vertices.shape != self.basis.neutral.shape:
            problem = f"has {len(self.basis.neutral)} vertices, its mesh {len(self.mesh.vertices)}"
            raise InputError("basis", problem, "use shapes of the same topology")

    @property
    def skin(self) -> IntArray:
        """Sorted vertices that errors are measured on: those of the part ``skin``, or all that a face uses."""
        return skin_vertices(self.mesh)

    @property
    def skin_name(self) -> str:
        """What that set is called on reports."""
        return SKIN if SKIN in self.mesh.parts else "all vertices"

    def with_basis(self, basis: ExpressionBasis) -> Rig:
        """Return the same mesh with other shapes (and the neutral face of theirs)."""
        return Rig(self.mesh.with_vertices(basis.neutral), basis)


def skin_vertices(mesh: TriangleMesh) -> IntArray:
    """Return the sorted vertices of the part ``skin``; of all faces where no part is called so."""
    faces = mesh.faces[mesh.parts[SKIN]] if SKIN in mesh.parts else mesh.faces
    found: IntArray = np.unique(faces)
    return found


def check_names(names: tuple[str, ...], count: int) -> None:
    """Raise InputError unless there are ``count`` names, none empty and none twice."""
    if len(names) != count:
        raise InputError("names", f"are {len(names)} for {count} shapes", "give one name a shape")
    if any(not name.strip() for name in names):
        raise InputError("names", f"shape {[not n.strip() for n in names].index(True) + 1} has none", "name it")
    double = sorted({name for name in names if names.count(name) > 1})
    if double:
        raise InputError("names", f"{some(double)} stands for several shapes", "give every shape a name of its own")


def check_topology(subject: str, vertices: int, wanted: int, of: str) -> None:
    """Raise InputError when ``subject`` has another number of vertices than ``of``, with both counts."""
    if vertices != wanted:
        problem = f"has {vertices} vertices, {of} has {wanted}"
        raise InputError(subject, problem, "both must be of one topology; export them from one mesh")
