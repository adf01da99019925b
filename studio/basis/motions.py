"""A performance as it was read becomes the motion of a rig: markers are bound, curves drive, meshes are compared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from engine.errors import InputError, some
from engine.progress import Progress, silent
from studio.basis.options import MotionOptions

if TYPE_CHECKING:
    from engine.basis.markers import BoundMarkers
    from engine.files.motion_file import DenseClip, MotionFile
    from engine.motion import MarkerClip, MeshMotion, WeightCurves
    from engine.shapes import Rig

NEUTRAL_TOLERANCE_MM = 1e-3
"""Two neutral faces that differ by less are the same."""

FEWEST_HEAD_MARKERS = 3
"""Fewer do not say how a head turns."""


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
    data: MarkerClip | WeightCurves | DenseClip,
    rig: Rig,
    options: MotionOptions,
    driver: Rig | None = None,
    progress: Progress = silent,
) -> PreparedMotion:
    """Return the motion of ``rig`` that a recording means.

    Parameters
    ----------
    data : MarkerClip or WeightCurves or DenseClip
        As it was read, mm, +Y up, +Z out of the face.
    rig : Rig
        Whose vertices move: the hand-sculpted one.
    options : MotionOptions
        Head markers, pairs and rest frame of markers.
    driver : Rig, optional
        The rig that curves drive and that markers lie on, where it is another one of the same topology. Its
        displacements are added to the neutral face of ``rig``.

    Raises
    ------
    InputError
        When the recording does not fit the rig, or the two rigs are of different topologies.
    """
    from engine.motion import MarkerClip, MeshMotion, WeightCurves, driven_by
    from engine.shapes import check_topology

    source = rig if driver is None else driver
    check_topology("the driving rig", len(source.basis.neutral), len(rig.basis.neutral), "the hand-sculpted one")
    if isinstance(data, WeightCurves):
        motion, unused, resting = driven_by(source.basis, data)
        notes = _left_over(unused, resting)
        if source is not rig and motion.basis is not None and motion.weights is not None:
            notes = (*notes, *_moved_apart(source, rig))
            motion = MeshMotion.driven(replace(motion.basis, neutral=rig.basis.neutral), motion.weights, motion.fps)
        return PreparedMotion(motion, None, notes)
    if not isinstance(data, MarkerClip):
        return PreparedMotion(data.motion(rig.basis.neutral))
    from engine.basis.markers import MarkerPair, bind_markers, marker_motion

    pairs = None if options.pairs is None else [MarkerPair(label, at) for label, at in options.pairs.items()]
    head = options.head if options.head is not None else _found_head(data, options)
    bound = bind_markers(source.mesh, data, pairs=pairs, head=head, rest_frame=options.rest_frame, progress=progress)
    progress(0.8, "spreading the markers over the face")
    motion = marker_motion(source.mesh, bound)
    if source is not rig and motion.phi is not None and motion.markers is not None:
        motion = MeshMotion.factored(motion.phi, motion.markers, rig.basis.neutral, motion.fps)
    found = (f"{len(head)} head markers found: {some(head)}",) if head and options.head is None else ()
    return PreparedMotion(motion, bound, (*found, *bound.warnings))


def _found_head(clip: MarkerClip, options: MotionOptions) -> tuple[str, ...]:
    """Return the markers that seem to sit on the head; none that a pair puts on the face."""
    from engine.basis.head import propose_head

    paired = options.pairs or {}
    found = tuple(label for label in propose_head(clip) if label not in paired)
    return found if len(found) >= FEWEST_HEAD_MARKERS else ()


def _moved_apart(driver: Rig, rig: Rig) -> tuple[str, ...]:
    import numpy as np

    apart = float(np.abs(driver.basis.neutral - rig.basis.neutral).max())
    if apart < NEUTRAL_TOLERANCE_MM:
        return ()
    return (f"the neutral faces differ by up to {apart:.2f} mm: what the driving rig does is added to the other",)


def _left_over(unused: tuple[str, ...], resting: tuple[str, ...]) -> tuple[str, ...]:
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
