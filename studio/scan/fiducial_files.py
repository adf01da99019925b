"""Fiducials from and to files of other tools, without a window: read, mapped, brought to a scan's pixels, and told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from engine.errors import InputError, some
from studio.scan.fiducial_options import FiducialOptions
from studio.scan.job import scheme_of

if TYPE_CHECKING:
    from engine.files.landmark_file import LandmarkFile
    from engine.landmark_mapping import LandmarkMapping
    from engine.landmarks import LandmarkScheme
    from engine.mesh import BoolArray, FloatArray
    from engine.scan.landmark_pixels import Place
    from engine.scan.mesh_view import MeshView
    from engine.scan.range_image import RangeImage

Positions = dict[str, tuple[float, float]]
Size = tuple[int, int]
MIRRORED = "left and right look swapped: check the mapping, and whether the picture is mirrored"

LEAST = 4
"""From this many fiducials on a fit can be tried."""


@dataclass(frozen=True)
class FoundFiducials:
    """What a file gives for a scan.

    Parameters
    ----------
    file : LandmarkFile
        The file as it was read.
    mapping : LandmarkMapping
        Which of its points are which fiducials, and in ``why`` why it was chosen; empty where it was asked for.
    pixels : (n, 2) float
        The file's points in the scan's picture; NaN where they have no place there.
    hidden : (n,) bool
        Points in space that the surface in view covers.
    positions : mapping of str to (x, y)
        The fiducials found, in the scheme's order, also those outside the picture.
    places : mapping of str to Place
        Where each of them falls.
    unmapped, absent : tuple of str, mapping of str to str
        Fiducials that the mapping does not know, and those whose point (named) is not there.
    remarks : tuple of str
        What was assumed, and what the user should look at.
    mirrored : bool
        Whether left and right look swapped.
    """

    file: LandmarkFile
    mapping: LandmarkMapping
    why: str
    pixels: FloatArray
    hidden: BoolArray
    positions: Mapping[str, tuple[float, float]]
    places: Mapping[str, Place]
    unmapped: tuple[str, ...]
    absent: Mapping[str, str]
    remarks: tuple[str, ...] = ()
    mirrored: bool = False

    @property
    def usable(self) -> Positions:
        """The fiducials that lie on the picture, holes included."""
        return {name: place for name, place in self.positions.items() if self.places[name] != "outside"}

    def named(self, place: str) -> tuple[str, ...]:
        """Return the fiducials that fall on such a place."""
        return tuple(name for name, where in self.places.items() if where == place)


@lru_cache(maxsize=1)
def shipped_mappings() -> tuple[LandmarkMapping, ...]:
    """Return the mappings that are shipped."""
    import resources
    from engine.files.mapping import read_mapping

    return tuple(read_mapping(path) for path in resources.mapping_paths())


def mapping_for(
    wanted: str | LandmarkMapping, labels: Sequence[str], names: Sequence[str]
) -> tuple[LandmarkMapping, str]:
    """Return the mapping of a name, a file, or (empty) the one that fits a file's points, and why it was chosen.

    Raises
    ------
    InputError
        When there is no such mapping.
    """
    from engine.files.mapping import read_mapping
    from engine.landmark_mapping import BY_NAME, by_name, choose_mapping

    if not isinstance(wanted, str):
        return wanted, ""
    if not wanted:
        return choose_mapping(shipped_mappings(), labels, names)
    if wanted.replace("_", " ").replace("-", " ").lower() == BY_NAME:
        return by_name(labels, names), ""
    known = {mapping.name: mapping for mapping in shipped_mappings()}
    if wanted in known:
        return known[wanted], ""
    if Path(wanted).suffix.lower() in (".toml", ".json"):
        return read_mapping(Path(wanted)), ""
    choices = ", ".join((*known, repr(BY_NAME)))
    raise InputError(f"mapping {wanted[:60]!r}", "is not known", f"use one of {choices}, or a .toml or .json file")


def find_fiducials(
    file: LandmarkFile,
    subject: str,
    scheme: str | LandmarkScheme,
    scan: RangeImage,
    options: FiducialOptions | None = None,
    mapping: LandmarkMapping | None = None,
    view: MeshView | None = None,
    unit: str = "mm",
) -> FoundFiducials:
    """Bring a file's points to a scan's pixels and name them.

    Parameters
    ----------
    file : LandmarkFile
        As read with the options' group and origin.
    subject : str
        The file's name, for messages.
    scheme : str or LandmarkScheme
        The fiducials that are wanted.
    scan : RangeImage
        The scan they are for.
    options : FiducialOptions, optional
        Mapping, scaling, and the size of the picture they were placed on.
    mapping : LandmarkMapping, optional
        In the place of the options' mapping.
    view : MeshView, optional
        How the scan's mesh was looked at; points in space are then in the mesh's frame, else in the scan's.
    unit : str
        The unit of points in space.

    Raises
    ------
    InputError
        When the points belong to a picture of another size and scaling was not asked for, or to none.
    """
    from engine.landmark_mapping import apply_mapping
    from engine.scan.landmark_pixels import looks_mirrored, places

    options = options or FiducialOptions()
    definition = scheme_of(scheme)
    pixels, hidden = _pixels(file, subject, scan, options, view, unit)
    chosen, why = mapping_for(mapping or options.mapping, file.labels, definition.names)
    mapped = apply_mapping(chosen, pixels, file.labels, definition.names)
    positions: Positions = {name: (place[0], place[1]) for name, place in mapped.positions.items()}
    where = places(positions, scan)
    found = FoundFiducials(file, chosen, why, pixels, hidden, positions, where, mapped.unmapped, mapped.absent)
    told = list(file.remarks)
    told.append(f"mapping {chosen.title or chosen.name}" + (f", chosen by {why}" if why else ""))
    told += summary(found)
    mirrored = looks_mirrored(positions, definition)
    if mirrored:
        told.append(MIRRORED)
    return replace(found, remarks=tuple(told), mirrored=mirrored)


def summary(found: FoundFiducials) -> list[str]:
    """Return how many fiducials were found, and which were not and why, one line each."""
    total = len(found.positions) + len(found.unmapped) + len(found.absent)
    lines = [f"{len(found.usable)} of {total} fiducials found"]
    hidden = [str(k) for k in range(len(found.hidden)) if found.hidden[k]]
    for names, what in (
        (found.unmapped, "not in the mapping"),
        (tuple(found.absent), "without a point in the file or in sight"),
        (found.named("outside"), "outside the picture, left unset"),
        (found.named("on a hole"), "on missing pixels"),
    ):
        if names:
            lines.append(f"{len(names)} {what}: {some(names)}")
    if hidden:
        what = "1 point of the file is" if len(hidden) == 1 else f"{len(hidden)} points of the file are"
        lines.append(f"{what} hidden by the surface in view")
    return lines


def fiducials_from(
    path: str | Path,
    scheme: str | LandmarkScheme,
    image_size: Size,
    scan: RangeImage,
    mapping: LandmarkMapping | str | None = None,
    *,
    options: FiducialOptions | None = None,
    view: MeshView | None = None,
    unit: str = "mm",
) -> tuple[Positions, tuple[str, ...]]:
    """Return the fiducials that a file of any format gives for a scan, in pixels, and what is to be told.

    Parameters
    ----------
    path : str or Path
        ``.json``, ``.pts``, ``.ljson`` or a table.
    scheme : str or LandmarkScheme
        The fiducials that are wanted.
    image_size : (int, int)
        Width and height of the scan's picture.
    scan : RangeImage
        The scan itself.
    mapping : LandmarkMapping or str, optional
        Which points are which fiducials; left out, the one that fits.
    options : FiducialOptions, optional
        Group, origin and scaling.
    view, unit
        As in `find_fiducials`.

    Raises
    ------
    InputError
        When the file cannot be read, belongs to a picture of another size, or has none of the fiducials.
    """
    from engine.files.landmarks import read_landmarks

    options = options or FiducialOptions()
    if tuple(image_size) != (scan.width, scan.height):
        raise InputError("image size", "is not that of the scan", "give the scan's own")
    if isinstance(mapping, str):
        options, mapping = options.model_copy(update={"mapping": mapping}), None
    file = read_landmarks(path, options.group, options.origin)
    found = find_fiducials(file, str(path), scheme, scan, options, mapping, view, unit)
    if not found.usable:
        raise no_fiducials(found, str(path), scheme_of(scheme).name)
    return found.usable, found.remarks


def no_fiducials(found: FoundFiducials, subject: str, scheme: str) -> InputError:
    """Return the error of a file that has not one fiducial of a scheme on the picture."""
    if found.positions:
        problem = f"all {len(found.positions)} fiducials lie outside the picture"
        return InputError(subject, problem, "give the file of this scan")
    return InputError(subject, f"has no point of scheme {scheme}", "choose the mapping or the scheme it was made for")


def fiducials_for_fit(
    path: Path,
    scheme: str | LandmarkScheme,
    scan: RangeImage,
    options: FiducialOptions,
    view: MeshView | None = None,
    unit: str = "mm",
    skip: Sequence[str] = (),
) -> tuple[Positions, tuple[str, ...], tuple[str, ...]]:
    """Return (positions, skipped, remarks) for a fit: ``skip`` and what the file's layout cannot give are left out.

    Raises
    ------
    InputError
        When a file by names lacks one of the scheme, a point lies outside the picture, too few are left, or ``skip``
        names one that the scheme does not have.
    """
    from engine.files.landmarks import read_landmarks
    from engine.files.landmarks_json import Fiducials, check_fiducials
    from engine.landmark_mapping import BY_NAME

    definition = scheme_of(scheme)
    unknown = [name for name in skip if name not in definition]
    if unknown:
        raise InputError("skip", f"{some(unknown)} is not in scheme {definition.name}", "check the name")
    wanted = [name for name in definition.names if name not in skip]
    left_out = tuple(name for name in definition.names if name in skip)
    file = read_landmarks(path, options.group, options.origin)
    ours = file.format == "json" and not options.mapping and not options.scale
    known = not file.labels or not set(file.labels).isdisjoint(definition.names)
    if ours and known and file.image_size is not None:
        given = zip(file.labels, file.points.tolist(), strict=True)
        placed: Positions = {name: (x, y) for name, (x, y) in given if name not in skip}
        check_fiducials(Fiducials(placed, file.image_size), wanted, (scan.width, scan.height), str(path))
        return placed, left_out, ()
    found = find_fiducials(file, str(path), definition, scan, options, None, view, unit)
    lacking = tuple(name for name in (*found.unmapped, *found.absent) if name not in skip)
    positions = {name: place for name, place in found.positions.items() if name not in skip}
    if not positions:
        raise no_fiducials(found, str(path), definition.name)
    if found.mapping.name == BY_NAME and lacking:
        problem = f"{some(lacking)} {'is' if len(lacking) == 1 else 'are'} missing"
        raise InputError(str(path), problem, "give --mapping, the other scheme or the points, or --skip them")
    outside = [name for name in found.named("outside") if name not in skip]
    if outside:
        problem = f"{some(outside)} outside the picture of {scan.width} x {scan.height}"
        raise InputError(str(path), problem, "give the file of this scan, or --image-size and --scale")
    if len(positions) < LEAST:
        raise InputError(str(path), f"only {len(positions)} fiducials are there", f"give at least {LEAST}")
    return positions, (*left_out, *lacking), found.remarks


def _pixels(
    file: LandmarkFile, subject: str, scan: RangeImage, options: FiducialOptions, view: MeshView | None, unit: str
) -> tuple[FloatArray, BoolArray]:
    """Return a file's points as pixels (n, 2) of a scan, and which (n,) are hidden."""
    import numpy as np

    from engine.scan.landmark_pixels import project_points, scale_pixels

    if file.dimension == 3:
        points = in_scan_frame(file.points, view, unit)
        try:
            projected = project_points(points, scan)
        except InputError as error:
            raise InputError(f"{subject}, {error.subject}", error.problem, error.remedy) from None
        return projected.pixels, projected.hidden
    made_on, used_on = made_on_size(file, options, subject), (scan.width, scan.height)
    pixels = file.points
    if made_on is not None and made_on != used_on:
        if not options.scale:
            theirs, ours = " x ".join(map(str, made_on)), " x ".join(map(str, used_on))
            problem = f"was made for a picture of {theirs}, this one has {ours}"
            raise InputError(subject, problem, "choose the file of this scan, or scale the points")
        try:
            pixels = scale_pixels(pixels, made_on, used_on)
        except InputError as error:
            raise InputError(f"{subject}, {error.subject}", error.problem, error.remedy) from None
    return pixels, np.zeros(len(pixels), dtype=np.bool_)


def made_on_size(file: LandmarkFile, options: FiducialOptions, subject: str) -> Size | None:
    """Return the size of the picture that a file's points were placed on, as the file or the caller says.

    Raises
    ------
    InputError
        When the two contradict each other.
    """
    if file.image_size is not None and options.image_size not in (None, file.image_size):
        theirs = " x ".join(map(str, file.image_size))
        raise InputError(f"{subject}, image_size", f"is {theirs}, another was given", "leave the given one out")
    return file.image_size or options.image_size


def in_scan_frame(points: FloatArray, view: MeshView | None, unit: str) -> FloatArray:
    """Return points (n, 3) of a mesh in the frame of the scan that a view made of it, mm."""
    from engine.files.mesh_unit import mm_per_unit

    factor = mm_per_unit(unit)
    return points * factor if view is None else view.into_camera(points, factor)
