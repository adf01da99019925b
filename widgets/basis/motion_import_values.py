"""What the import of a performance shows, and what the user chooses there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from engine.basis.markers import BoundMarkers
from engine.files.motion_file import DenseClip
from engine.mesh import FloatArray, TriangleMesh
from engine.motion import MarkerClip, WeightCurves

Role = Literal["face", "head", "unused"]

FAR_MM = 15.0
"""A marker further from the face than this is looked at twice."""


@dataclass(frozen=True)
class MotionChoice:
    """How a performance is to be read and bound; None is what the file says, or what is found out.

    Parameters
    ----------
    unit : str, optional
        ``mm``, ``cm``, ``m`` or millimetres (``"85.3 mm"``).
    up, forward : str, optional
        The file's axes that point up and out of the face.
    fps : float, optional
        Frames a second.
    head : tuple of str, optional
        Head markers; proposed where None.
    rest_frame : int, optional
        From 0.
    scale : bool
        Whether the performer is fitted to the rig's size as well.
    """

    unit: str | None = None
    up: str | None = None
    forward: str | None = None
    fps: float | None = None
    head: tuple[str, ...] | None = None
    rest_frame: int | None = None
    scale: bool = False


@dataclass(frozen=True)
class MotionImportFacts:
    """A performance as it was read under a choice.

    Parameters
    ----------
    name : str
        File name.
    data : MarkerClip or WeightCurves or DenseClip
        mm, in our frame.
    unit, up, forward : str
        What the file's numbers were taken for; empty for curves.
    guessed : tuple of str
        Which of ``unit``, ``up``, ``forward``, ``fps`` nobody stated.
    assumed : str
        In words.
    head : tuple of str
        Markers taken for the head's.
    bound : BoundMarkers, optional
        How the clip lies on the face; None before that is known, and without markers.
    mesh : TriangleMesh, optional
        The face.
    pairs : int
        Markers with a place of their own; 0 without a pairs file.
    warnings : tuple of str
        What the user should look at.
    problem : str
        Why it cannot be taken as it is.
    """

    name: str
    data: MarkerClip | WeightCurves | DenseClip
    unit: str = "mm"
    up: str = "y"
    forward: str = "z"
    guessed: tuple[str, ...] = ()
    assumed: str = ""
    head: tuple[str, ...] = ()
    bound: BoundMarkers | None = None
    mesh: TriangleMesh | None = None
    pairs: int = 0
    warnings: tuple[str, ...] = ()
    problem: str = ""


@dataclass(frozen=True)
class TrackRow:
    """A marker or a curve as it is listed: ``seen`` 0..1, ``distance_mm`` to the face or NaN, ``role``."""

    label: str
    seen: float
    distance_mm: float
    role: Role


def rows_of(facts: MotionImportFacts, head: tuple[str, ...]) -> tuple[TrackRow, ...]:
    """Return the rows of a clip's markers; none for curves and meshes."""
    if not isinstance(facts.data, MarkerClip):
        return ()
    share = facts.data.seen.mean(axis=0)
    away: dict[str, float] = {}
    if facts.bound is not None:
        binding = facts.bound.binding
        away = dict(zip(binding.labels, binding.distance_mm.tolist(), strict=True))
    out = set() if facts.bound is None else set(facts.bound.left_out)
    return tuple(
        TrackRow(
            label,
            float(seen),
            away.get(label, float("nan")),
            "head" if label in head else "unused" if label in out else "face",
        )
        for label, seen in zip(facts.data.labels, share, strict=True)
    )


def points_at(facts: MotionImportFacts, choice: MotionChoice, frame: int, most: int = 1500) -> FloatArray:
    """Return the points (n, 3) of a frame in the rig's frame, mm, as they will lie under a choice; NaN in gaps.

    Unit and axes that differ from the facts' are applied at once; the place on the face is then only that of their
    middle, until the performance has been read again.
    """
    import numpy as np

    from engine.files.mesh_unit import mm_per_unit
    from engine.files.motion_axes import axes_rotation

    if isinstance(facts.data, WeightCurves):
        return np.zeros((0, 3))
    rest = min(choice.rest_frame or 0, len(facts.data) - 1)
    if isinstance(facts.data, MarkerClip):
        points, first = facts.data.positions[frame], facts.data.positions[rest]
    else:
        step = max(1, facts.data.count // most)
        points, first = (facts.data.read(k, k + 1)[0, ::step] for k in (frame, rest))
    up, forward = choice.up or facts.up, choice.forward or facts.forward
    factor = mm_per_unit(choice.unit) / mm_per_unit(facts.unit) if choice.unit else 1.0
    same = (up, forward) == (facts.up, facts.forward) and factor == 1
    if not same:
        if up[-1] == forward[-1]:
            return np.zeros((0, 3))
        turn = axes_rotation(up, forward) @ axes_rotation(facts.up, facts.forward).T
        points, first = (factor * part @ turn.T for part in (points, first))
    bound = facts.bound
    if same and bound is not None:
        placed = bound.placement.apply(points)
        place = int(np.abs(bound.frames - frame).argmin())
        if bound.head is not None:
            return np.asarray((placed - bound.head.translations[place]) @ bound.head.rotations[place])
        return placed
    if facts.mesh is None or (same and not isinstance(facts.data, MarkerClip)):
        return np.asarray(points)
    return np.asarray(points + _face_middle(facts.mesh) - _middle(first))


def _middle(points: FloatArray) -> FloatArray:
    """Return the median (3,) of the points that are seen; the origin where none is."""
    import numpy as np

    seen = points[np.isfinite(points).all(axis=1)]
    return np.median(seen, axis=0) if len(seen) else np.zeros(3)


def _face_middle(mesh: TriangleMesh) -> FloatArray:
    """Return about where a face's markers have their middle: the front half, two thirds up."""
    import numpy as np

    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    height = low[1] + 0.55 * (high[1] - low[1])
    return np.array([(low[0] + high[0]) / 2, height, low[2] + 0.85 * (high[2] - low[2])])
