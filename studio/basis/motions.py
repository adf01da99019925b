"""A performance as it was read becomes the motion of a rig: markers are bound, curves drive, meshes are compared."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from engine.errors import InputError
from engine.progress import Progress, silent
from studio.basis.options import MotionOptions

if TYPE_CHECKING:
    from engine.basis.markers import BoundMarkers
    from engine.files.motion import MotionFile
    from engine.files.motion_file import DenseClip
    from engine.motion import MarkerClip, MeshMotion, WeightCurves
    from engine.shapes import Rig


@dataclass(frozen=True)
class PreparedMotion:
    """The motion of a rig, and what became of the recording on the way.

    Attributes
    ----------
    motion : MeshMotion
        On the rig's vertices, mm.
    bound : BoundMarkers, optional
        Where the markers sit on the face and how they move; None for curves and meshes.
    notes : tuple of str
        What was repaired, left out or is doubtful, with counts.
    """

    motion: MeshMotion
    bound: BoundMarkers | None = None
    notes: tuple[str, ...] = ()


def read_performance(path: Path, options: MotionOptions) -> MotionFile:
    """Read a performance with the unit, axes and frame rate that were chosen.

    Raises
    ------
    InputError
        When it cannot be read.
    """
    from engine.files.motion import read_motion

    return read_motion(path, unit=options.unit, up=options.up, forward=options.forward, fps=options.fps)


def prepare(
    data: MarkerClip | WeightCurves | DenseClip, rig: Rig, options: MotionOptions, progress: Progress = silent
) -> PreparedMotion:
    """Return the motion of ``rig`` that a recording means.

    Parameters
    ----------
    data : MarkerClip or WeightCurves or DenseClip
        As it was read, mm, +Y up, +Z out of the face.
    rig : Rig
        The rig that markers lie on, that curves drive, or whose topology the mesh has.
    options : MotionOptions
        Head markers, pairs and rest frame of markers.

    Raises
    ------
    InputError
        When the recording does not fit the rig.
    """
    from engine.motion import MarkerClip, WeightCurves, driven_by

    if isinstance(data, WeightCurves):
        motion, unused, resting = driven_by(rig.basis, data)
        return PreparedMotion(motion, None, _left_over(unused, resting))
    if not isinstance(data, MarkerClip):
        return PreparedMotion(data.motion(rig.basis.neutral))
    from engine.basis.markers import bind_markers, marker_motion

    bound = bind_markers(rig.mesh, data, pairs=options.pairs, head=options.head, rest_frame=options.rest_frame)
    progress(0.5, "spreading the markers over the face")
    return PreparedMotion(marker_motion(rig.mesh, bound), bound, bound.warnings)


def _left_over(unused: tuple[str, ...], resting: tuple[str, ...]) -> tuple[str, ...]:
    from engine.errors import some

    notes = []
    if unused:
        notes.append(f"{len(unused)} curves drive nothing: {some(unused)}")
    if resting:
        notes.append(f"{len(resting)} shapes of the rig rest: {some(resting)}")
    return tuple(notes)


def frame_range(text: str) -> tuple[int, int]:
    """Return the training range of ``A:B`` (first and last frame, counted from 1) as start and stop from 0.

    Raises
    ------
    InputError
        When it is no such range.
    """
    first, colon, last = text.partition(":")
    if not (colon and first.strip().isdecimal() and last.strip().isdecimal() and 1 <= int(first) < int(last)):
        raise InputError(f"--train {text!r}", "is no range of frames", "give first:last, counted from 1, as 1:6000")
    return int(first) - 1, int(last)
