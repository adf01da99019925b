"""A performance as it was read becomes the motion of a rig: markers are bound, curves drive, meshes are compared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from engine.errors import InputError, some
from engine.progress import Progress, silent
from studio.basis.options import BasisOptions, MotionOptions

if TYPE_CHECKING:
    from engine.basis.markers import BoundMarkers
    from engine.files.motion_file import DenseClip, MotionFile
    from engine.mesh import FloatArray, IntArray
    from engine.motion import MarkerClip, MeshMotion, WeightCurves
    from engine.shapes import Rig

NEUTRAL_TOLERANCE_MM = 1e-3
"""Two neutral faces that differ by less are the same."""

FEWEST_HEAD_MARKERS = 3
"""Fewer do not say how a head turns."""

FAR_FROM_REST_MM = 1.0
"""A mesh clip whose every frame is further (RMS) from the neutral face may rest on another one."""

OTHER_SIZE = 0.05
"""Share of a face's size; what lies further apart is of another unit or pose."""

_SAMPLED = 50


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
    left_out : int
        Frames of the recording that show too little and are not in the motion.
    rest_mm : float
        RMS distance of a mesh clip's frame that is nearest to the neutral face; 0 for markers and curves.
    """

    motion: MeshMotion
    bound: BoundMarkers | None = None
    notes: tuple[str, ...] = ()
    left_out: int = 0
    rest_mm: float = 0.0

    @property
    def frames(self) -> IntArray:
        """(L,) which frames of the recording these are, from 0."""
        return np.arange(len(self.motion)) if self.bound is None else self.bound.frames

    def kept(self, options: BasisOptions) -> BasisOptions:
        """Return the options with the training range in frames of the motion, where it counts those of the recording.

        Raises
        ------
        InputError
            When the range ends after the recording, or fewer than two frames of it are in the motion.
        """
        if options.train is None or not self.left_out:
            return options
        first, last = options.train[0] + 1, options.train[1]
        total = len(self.motion) + self.left_out
        if last > total:
            raise InputError(f"training range {first}:{last}", f"the performance has {total} frames", "choose others")
        start, stop = (int(at) for at in np.searchsorted(self.frames, options.train))
        if stop - start < 2:
            raise InputError(
                f"training range {first}:{last}", "shows too few markers in all but one frame", "choose others"
            )
        return options.model_copy(update={"train": (start, stop)})

    def recorded(self, train: tuple[int, int]) -> tuple[int, int]:
        """Return a range of frames of the motion, start and stop from 0, in frames of the recording."""
        return int(self.frames[train[0]]), int(self.frames[train[1] - 1]) + 1


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
        The rig that curves drive, that markers lie on and that a mesh clip was recorded on, where it is another one
        of the same topology. Its displacements are added to the neutral face of ``rig``.

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
        return _of_mesh(data, rig, source)
    from engine.basis.markers import MarkerPair, bind_markers, marker_motion

    pairs = None if options.pairs is None else [MarkerPair(label, at) for label, at in options.pairs.items()]
    told: tuple[str, ...] = ()
    head = options.head if options.head is not None else _found_head(data, options)
    if options.head == ():
        data, told = _without_head(data, options)
    elif options.head is None and head:
        told = (f"{_counted(len(head), 'head marker')} found: {some(head)}",)
    bound = bind_markers(
        source.mesh,
        data,
        pairs=pairs,
        head=head,
        rest_frame=options.rest_frame,
        scale=options.scale,
        progress=progress,
    )
    progress(0.8, "spreading the markers over the face")
    motion = marker_motion(source.mesh, bound)
    if source is not rig and motion.phi is not None and motion.markers is not None:
        motion = MeshMotion.factored(motion.phi, motion.markers, rig.basis.neutral, motion.fps)
    return PreparedMotion(motion, bound, (*told, *bound.warnings), len(data) - len(bound))


def _of_mesh(data: DenseClip, rig: Rig, source: Rig) -> PreparedMotion:
    """Return the motion of ``rig`` that the mesh of ``source`` makes."""
    from engine.motion import MeshMotion

    motion = data.motion(source.basis.neutral)
    apart = _nearest_to_rest(motion)
    notes: tuple[str, ...] = ()
    if apart > FAR_FROM_REST_MM:
        notes = (
            f"the frame nearest to the neutral face is {apart:.1f} mm (RMS) from it: was it recorded on another rig?",
        )
    if source is rig:
        return PreparedMotion(motion, None, notes, rest_mm=apart)
    between = rig.basis.neutral - source.basis.neutral

    def read(start: int, stop: int) -> FloatArray:
        return data.read(start, stop) + between

    moved = MeshMotion.streamed(read, len(data), rig.basis.neutral, data.fps)
    return PreparedMotion(moved, None, (*notes, *_moved_apart(source, rig)), rest_mm=apart)


def _nearest_to_rest(motion: MeshMotion) -> float:
    frames = np.unique(np.linspace(0, len(motion) - 1, _SAMPLED).astype(np.int64)).tolist()
    return min(_rms(motion.displacements(frame, frame + 1)[0]) for frame in frames)


def _rms(moved: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))


def check_sizes(
    path: Path, file: MotionFile, prepared: PreparedMotion, rig: Rig, options: MotionOptions, driver: Rig | None = None
) -> None:
    """Raise InputError where what was read without a stated unit is no face, or none that fits the rig.

    Raises
    ------
    InputError
        Naming the option that says how large it is.
    """
    from engine.files.motion_axes import LARGEST_FACE_MM, SMALLEST_FACE_MM, typical_positions
    from engine.files.scan_file import MM_PER_UNIT
    from engine.motion import MarkerClip

    size = float(np.ptp(rig.basis.neutral, axis=0).max())
    if driver is not None:
        own, other = (basis.neutral - basis.neutral.mean(axis=0) for basis in (rig.basis, driver.basis))
        apart = _rms(other - own)
        if apart > OTHER_SIZE * size:
            problem = (
                f"its neutral face is {apart:.3g} mm (RMS) from the hand-sculpted one, which is {size:.3g} mm large"
            )
            raise InputError("--rig", problem, "save both rigs in one unit and pose")
    if options.unit is not None or options.scale:
        return
    if isinstance(file.data, MarkerClip):
        cloud = typical_positions(file.data.positions)
        span = float(np.ptp(cloud, axis=0).max()) if len(cloud) > 1 else 0.0
        fitted = "unit" in file.guessed and file.unit not in MM_PER_UNIT
        # Markers of a mouth alone span less than a face, those of a whole body are none.
        if fitted or not SMALLEST_FACE_MM / 2 <= span <= 2 * LARGEST_FACE_MM:
            problem = "in mm, cm or m its markers are as large as no face"
            if not fitted:
                problem = f"its markers span {span:.3g} mm, which is no face"
            raise InputError(str(path), problem, "say its unit with --unit, or fit its size to the rig with --scale")
    elif prepared.rest_mm > OTHER_SIZE * size:
        problem = f"its frame nearest to the neutral face is {prepared.rest_mm:.3g} mm (RMS) from it"
        raise InputError(str(path), problem, "say its unit with --unit and its axes, or name its rig with --rig")


def _without_head(clip: MarkerClip, options: MotionOptions) -> tuple[MarkerClip, tuple[str, ...]]:
    """Return a clip whose head's motion stays in without the markers that sit on the head, and what was left out."""
    from engine.motion import MarkerClip

    found = _found_head(clip, options)
    if not found or len(clip.labels) - len(found) < FEWEST_HEAD_MARKERS:
        return clip, ()
    kept = [k for k, label in enumerate(clip.labels) if label not in found]
    face = MarkerClip(tuple(clip.labels[k] for k in kept), clip.positions[:, kept], clip.fps)
    return face, (f"{_counted(len(found), 'head marker')} left out: {some(found)}",)


def _found_head(clip: MarkerClip, options: MotionOptions) -> tuple[str, ...]:
    """Return the markers that seem to sit on the head; none that a pair puts on the face."""
    from engine.basis.head import propose_head

    paired = options.pairs or {}
    found = tuple(label for label in propose_head(clip) if label not in paired)
    return found if len(found) >= FEWEST_HEAD_MARKERS else ()


def _moved_apart(driver: Rig, rig: Rig) -> tuple[str, ...]:
    apart = float(np.abs(driver.basis.neutral - rig.basis.neutral).max())
    if apart < NEUTRAL_TOLERANCE_MM:
        return ()
    return (f"the neutral faces differ by up to {apart:.2f} mm: what the driving rig does is added to the other",)


def _left_over(unused: tuple[str, ...], resting: tuple[str, ...]) -> tuple[str, ...]:
    notes = []
    if unused:
        drive = "drives" if len(unused) == 1 else "drive"
        notes.append(f"{_counted(len(unused), 'curve')} {drive} nothing: {some(unused)}")
    if resting:
        rest = "rests" if len(resting) == 1 else "rest"
        notes.append(f"{_counted(len(resting), 'shape')} of the rig {rest}: {some(resting)}")
    return tuple(notes)


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def frame_range(text: str) -> tuple[int, int]:
    """Return the training range of ``A:B`` (first and last frame, counted from 1) as start and stop from 0.

    Raises
    ------
    InputError
        When it is no such range.
    """
    first, colon, last = text.partition(":")
    numbers = bool(colon) and first.strip().isdecimal() and last.strip().isdecimal()
    if numbers and 1 <= int(first) == int(last):
        raise InputError(f"--train {text!r}", "needs at least two frames", "give first:last, counted from 1, as 1:6000")
    if not (numbers and 1 <= int(first) < int(last)):
        raise InputError(f"--train {text!r}", "is no range of frames", "give first:last, counted from 1, as 1:6000")
    return int(first) - 1, int(last)
