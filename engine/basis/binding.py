"""Where markers sit on a mesh, and a clip that is bound to it: the values that `engine.basis.markers` makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.basis.head import HeadMotion
from engine.geometry.rigid import RigidTransform
from engine.mesh import FloatArray, IntArray, TriangleMesh, frozen


@dataclass(frozen=True)
class MarkerBinding:
    """Where on a mesh each marker sits.

    Parameters
    ----------
    labels : sequence of str
        K face markers.
    faces : (K,) int
        The triangle under each.
    barycentric : (K, 3) float
        Where in it; rows sum to 1.
    rest : (K, 3) float
        The marker's own place at rest, mm, in the rig's frame; it may stand off the surface.
    distance_mm : (K,) float
        How far from the surface that is.
    """

    labels: tuple[str, ...]
    faces: IntArray
    barycentric: FloatArray
    rest: FloatArray
    distance_mm: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "labels", tuple(self.labels))
        object.__setattr__(self, "faces", frozen(self.faces, np.int64))
        for name in ("barycentric", "rest", "distance_mm"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.float64))

    def __len__(self) -> int:
        return len(self.labels)

    def points(self, mesh: TriangleMesh) -> FloatArray:
        """Return the places (K, 3) on the surface of ``mesh``, mm."""
        return self.on(mesh.vertices, mesh.faces)

    def on(self, values: FloatArray, faces: IntArray) -> FloatArray:
        """Return values (K, ...) at the markers of what is given per vertex (N, ...): positions, displacements."""
        found: FloatArray = np.einsum("kc,kc...->k...", self.barycentric, np.asarray(values)[faces[self.faces]])
        return found


@dataclass(frozen=True)
class BoundMarkers:
    """A clip on a rig: the head's motion removed, gaps filled and counted.

    Parameters
    ----------
    binding : MarkerBinding
        The K face markers that are used.
    displacements : (L, K, 3) float
        From rest, mm, in the rig's frame; finite.
    fps : float
        Frames a second.
    captured : (L, K, 3) float
        Positions in the rig's frame after the head's motion was removed, mm; NaN where a marker was not seen.
    placement : RigidTransform
        From the clip's frame into the rig's.
    head : HeadMotion, optional
        The pose of the head in these frames, in the rig's frame: carries the resting head to where it was.
    head_labels : tuple of str
        The markers it was found from.
    rest_frame : int
        The frame of the clip taken as the neutral face.
    frames : (L,) int
        Which frames of the clip these are: those that show too little to be filled are left out.
    filled : int
        Positions that were filled in.
    filled_short, filled_long : int
        Of these: between neighbouring frames, and from the other markers.
    left_out : tuple of str
        Markers that are not used.
    head_filled : int
        Frames whose head pose was interpolated.
    warnings : tuple of str
        Far markers, long gaps, what was left out.
    """

    binding: MarkerBinding
    displacements: FloatArray
    fps: float
    captured: FloatArray
    placement: RigidTransform
    frames: IntArray
    head: HeadMotion | None = None
    head_labels: tuple[str, ...] = ()
    rest_frame: int = 0
    filled: int = 0
    filled_short: int = 0
    filled_long: int = 0
    left_out: tuple[str, ...] = ()
    head_filled: int = 0
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "displacements", frozen(self.displacements, np.float64))
        object.__setattr__(self, "captured", frozen(self.captured, np.float64))
        object.__setattr__(self, "frames", frozen(self.frames, np.int64))

    def __len__(self) -> int:
        return len(self.displacements)


@dataclass(frozen=True)
class MarkerPair:
    """One line of a pairs file: a marker, and the vertex or the place (x, y, z), mm, on the neutral face."""

    label: str
    target: int | tuple[float, float, float]


Pairs = Sequence[MarkerPair]
