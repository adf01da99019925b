"""A performance from a file of any format that the studio reads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from engine.errors import InputError
from engine.files.c3d import read_c3d
from engine.files.dense_checks import MAX_DENSE_BYTES
from engine.files.glb_animation import read_glb_animation
from engine.files.live_link import looks_like_live_link, read_live_link
from engine.files.marker_csv import names_markers, read_marker_csv
from engine.files.mesh_unit import mm_per_unit
from engine.files.motion_axes import axis_name
from engine.files.motion_file import MotionFile
from engine.files.motion_npz import read_motion_npz
from engine.files.pc2 import read_pc2
from engine.files.source import checked_file
from engine.files.trc import read_trc
from engine.files.weights_csv import looks_like_weights, read_weights
from engine.motion import MarkerClip, WeightCurves, check_fps
from engine.name_text import clean_names, told

MOTION_SUFFIXES = (".c3d", ".trc", ".csv", ".tsv", ".pc2", ".npz", ".glb")


def read_motion(
    path: str | Path,
    *,
    unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    fps: float | None = None,
) -> MotionFile:
    """Read a performance: markers, weight curves, or the positions of every vertex.

    Parameters
    ----------
    path : str or Path
        ``.c3d``, ``.trc`` or ``.csv`` with markers; ``.csv`` of Live Link Face or of our own weights; ``.glb`` with a
        weights animation; ``.pc2`` or ``.npz`` with vertices.
    unit : {"mm", "cm", "m"} or "85.3 mm", optional
        What the file's numbers mean; the file's own word, else what makes it as large as a face.
    up, forward : {"x", "-x", "y", "-y", "z", "-z"}, optional
        The file's axes that point up and out of the face; found from the points where left out.
    fps : float, optional
        Frames a second; the file's own, else 30.

    Returns
    -------
    MotionFile
        In mm, +Y up, +Z out of the face, with what was assumed and counted.

    Raises
    ------
    InputError
        When the file cannot be read as a performance, for whatever reason.
    """
    path = checked_file(path, MAX_DENSE_BYTES)
    if unit is not None:
        mm_per_unit(unit)
    up, forward = (None if axis is None else axis_name(axis) for axis in (up, forward))
    if fps is not None:
        check_fps(fps)
    suffix = path.suffix.lower()
    try:
        if suffix in (".csv", ".tsv", ".txt"):
            return _named(_table(path, unit, up, forward, fps))
        if suffix in _READERS:
            return _named(_READERS[suffix](path, unit=unit, up=up, forward=forward, fps=fps))
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "check the file and the disk") from error
    raise InputError(str(path), "is not a performance that can be read", f"give a {', '.join(MOTION_SUFFIXES)} file")


def _named(file: MotionFile) -> MotionFile:
    """Return a performance whose names any project can hold; how many were changed is in its warnings."""
    data = file.data
    if isinstance(data, MarkerClip):
        labels, changed = clean_names(data.labels)
        data = replace(data, labels=labels) if changed else data
    elif isinstance(data, WeightCurves):
        names, changed = clean_names(data.names)
        data = replace(data, names=names) if changed else data
    else:
        return file
    if not changed:
        return file
    what = "marker" if isinstance(data, MarkerClip) else "curve"
    return replace(file, data=data, warnings=(*file.warnings, *told(changed, what)))


def _table(path: Path, unit: str | None, up: str | None, forward: str | None, fps: float | None) -> MotionFile:
    with path.open("rb") as handle:
        start = handle.read(_HEADER_BYTES).decode("utf-8-sig", "replace").splitlines()
    header = start[0].strip() if start else ""
    if looks_like_live_link(header):
        return read_live_link(path, fps)
    if looks_like_weights(header) and not names_markers(start[:1]):
        return read_weights(path, fps)
    return read_marker_csv(path, unit=unit, up=up, forward=forward, fps=fps)


_HEADER_BYTES = 1 << 20
_READERS: dict[str, Callable[..., MotionFile]] = {
    ".c3d": read_c3d,
    ".trc": read_trc,
    ".pc2": read_pc2,
    ".npz": read_motion_npz,
    ".glb": read_glb_animation,
}
