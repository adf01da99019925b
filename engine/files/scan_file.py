"""What every scan reader returns, and what is checked and said about every scan."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from engine.errors import InputError
from engine.mesh import BoolArray, FloatArray
from engine.scan.range_image import Camera, ColourImage, RangeImage

if TYPE_CHECKING:
    from engine.scan.mesh_view import MeshView

MM_PER_UNIT: dict[str, float] = {"mm": 1.0, "cm": 10.0, "m": 1000.0}

SMALLEST_MM, LARGEST_MM = 20.0, 5000.0
"""Extents outside which a scan of a face has most likely been read in the wrong unit."""

FARTHEST_MM = 1e6
"""A coordinate beyond this, a kilometre, is no measurement, and squares of it would swamp the face's own."""

_CAMERA_TOLERANCE_PX = 0.5


@dataclass(frozen=True)
class ScanFile:
    """A scan as it was read, and what was taken for granted.

    Parameters
    ----------
    scan : RangeImage
        Points in mm.
    unit : str
        The unit the file's numbers were taken in: ``mm``, ``cm`` or ``m``; of a mesh also a number of millimetres.
    assumed : str
        In words, where the unit (and a camera that had to be guessed) came from.
    source_files : tuple of Path
        All files that were read, the one the user named first.
    format : str
        ``depth``, ``disparity``, ``ply``, ``npz``, ``pcd``, ``abs`` or ``xyz``; ``obj``, ``ply`` or ``glb`` of a mesh.
    warnings : tuple of str
        What the user should look at: an unlikely size, left out colours, coarse depth.
    view : MeshView, optional
        Where the camera stood before a mesh; None for what a scanner delivered.
    """

    scan: RangeImage
    unit: str
    assumed: str
    source_files: tuple[Path, ...]
    format: str
    warnings: tuple[str, ...] = ()
    view: MeshView | None = None


def choose_unit(
    requested: str | None, named: str | None, subject: str, usual: str = "mm"
) -> tuple[str, str, tuple[str, ...]]:
    """Return (unit, what was assumed, warnings) from the caller's wish, the file's own word and what is usual.

    The caller's wish wins over the file. InputError for a unit other than ``mm``, ``cm``, ``m``.
    """
    if requested is not None and requested not in MM_PER_UNIT:
        raise InputError("unit", f"{str(requested)[:40]!r} is not known", "choose mm, cm or m")
    if named is not None and named not in MM_PER_UNIT:
        raise InputError(f"{subject}, unit", f"{named[:40]!r} is not known", "it must be mm, cm or m")
    if requested is not None:
        clash = named is not None and named != requested
        warning = (f"read in {requested} as asked, although the file names {named}",) if clash else ()
        return requested, f"{requested}, as asked", warning
    if named is not None:
        return named, f"{named}, as in the file", ()
    return usual, f"{usual} assumed: the file names no unit", ()


def likely_unit(points: FloatArray, *units: str) -> str:
    """Return the first of ``units`` in which points (n, 3), unscaled, have a size that a face can have; else the last.

    Points that are not finite do not count.
    """
    finite: BoolArray = np.asarray(np.isfinite(points).all(axis=1))
    extent = _extent(points, finite) if finite.any() else 0.0
    likely = (unit for unit in units if SMALLEST_MM <= extent * MM_PER_UNIT[unit] <= LARGEST_MM)
    return next(likely, units[-1])


def make_scan(
    subject: str, points: FloatArray, colour: ColourImage | None, camera: Camera | None, unit: str | None = None
) -> tuple[RangeImage, tuple[str, ...]]:
    """Return the range image, and warnings about its size, orientation and camera.

    Parameters
    ----------
    subject : str
        The file's name, for messages.
    points : (H, W, 3) float
        In mm, NaN where missing; made read-only.
    colour : (H, W, 3) uint8, optional
        Made read-only.
    camera : Camera, optional
        Left out, with a warning, when it does not project the points to their pixels.
    unit : str, optional
        The unit that the file's numbers were taken in, where there was a choice.

    Raises
    ------
    InputError
        Naming the file, where ``RangeImage`` refuses or a coordinate is beyond `FARTHEST_MM`.
    """
    for array in (points, colour):
        if array is not None:
            array.flags.writeable = False
    try:
        scan = RangeImage(points, colour, camera)
    except InputError as error:
        raise InputError(f"{subject}, {error.subject}", error.problem, error.remedy) from error
    # Two reductions and no copy: the largest scan has 48 million coordinates.
    farthest = float(max(np.fmax.reduce(scan.points, axis=None), -np.fmin.reduce(scan.points, axis=None)))
    if farthest > FARTHEST_MM:
        problem = f"a coordinate of {farthest:.3g} mm, more than {FARTHEST_MM:.0e} mm"
        remedy = "check unit_mm and the camera" if unit is None else f"check whether it is in {unit}"
        raise InputError(f"{subject}, points", problem, remedy)
    warnings = size_warnings(scan, unit)
    if camera is not None and reprojection_px(scan) > _CAMERA_TOLERANCE_PX:
        scan = RangeImage(scan.points, scan.colour, None)
        warnings += ("its camera does not project the points to their pixels: left out",)
    if rows_run_upwards(scan.points):
        warnings += ("the picture stands on its head: Y grows from row to row",)
    return scan, warnings


def size_warnings(scan: RangeImage, unit: str | None) -> tuple[str, ...]:
    """Return a warning, with the unit that would fit, where the scan is too small or large for a face."""
    extent = _extent(scan.points.reshape(-1, 3), scan.valid.ravel())
    if SMALLEST_MM <= extent <= LARGEST_MM:
        return ()
    fitting = [
        other
        for other, factor in MM_PER_UNIT.items()
        if unit is not None and 2 * SMALLEST_MM <= extent * factor / MM_PER_UNIT[unit] <= LARGEST_MM / 2
    ]
    advice = f"its unit is rather {' or '.join(fitting)} than {unit}" if fitting else "check its unit"
    return (f"the scan is {extent:.3g} mm across, unlikely for a face: {advice}",)


def rows_run_upwards(points: FloatArray) -> bool:
    """Whether Y mostly grows with the row (H, W, 3): the picture is upside down."""
    step = max(1, points.shape[0] // 64), max(1, points.shape[1] // 64)
    heights = points[:: step[0], :: step[1], 1]
    change = np.diff(heights, axis=0)
    change = change[np.isfinite(change) & (change != 0)]
    return bool(change.size and np.mean(change > 0) > 0.75)


def reprojection_px(scan: RangeImage) -> float:
    """Return the median distance in pixels between a point's projection and its own pixel; inf without a camera."""
    if scan.camera is None:
        return float("inf")
    rows, columns = np.nonzero(scan.valid)
    step = max(1, len(rows) // 20_000)
    rows, columns = rows[::step], columns[::step]
    with np.errstate(all="ignore"):
        distance = np.linalg.norm(
            scan.camera.project(scan.points[rows, columns]) - np.column_stack([columns, rows]), axis=1
        )
    return float(np.median(np.where(np.isfinite(distance), distance, np.inf)))


def _extent(points: FloatArray, valid: BoolArray) -> float:
    """Largest side of the box that holds the valid ones of points (n, 3) but for 2 % at either end (spikes)."""
    places = np.flatnonzero(valid)
    places = places[:: max(1, len(places) // 50_000)]
    low, high = np.percentile(points[places], [2, 98], axis=0)
    with np.errstate(over="ignore"):
        return float((high - low).max())
