"""``quasiface fiducials ...``: landmarks of other tools become fiducials, and fiducials theirs. No Qt."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from engine.errors import InputError, some
from studio.output import Json, print_result, remark
from studio.scan.fiducial_options import AS_IT_IS, FiducialOptions
from studio.scan.scheme_cli import scheme_from
from studio.scan.view_options import ViewOptions

if TYPE_CHECKING:
    from engine.files.landmark_file import LandmarkFile
    from engine.landmarks import LandmarkScheme
    from engine.mesh import FloatArray

_OPTIONS = FiducialOptions()
_VIEW = ViewOptions()


def info(landmarks: Path, /, *, group: str | None = None, origin: float | None = None, as_json: Json = False) -> int:
    """Say what a file of landmarks holds, and which mapping fits it.

    Parameters
    ----------
    landmarks : Path
        .json, .pts, .ljson, or a table .csv.
    group : str
        Which group of an .ljson, or row of a table.
    origin : float
        What the file calls the centre of the top left pixel: 0, 0.5 or 1.
    """
    import numpy as np

    from engine.files.landmarks import read_landmarks
    from studio.scan.fiducial_files import mapping_for
    from studio.scan.job import scheme_of

    file = read_landmarks(landmarks, group, origin)
    for text in file.remarks:
        remark(f"{landmarks}: {text}")
    placed = file.points[np.isfinite(file.points).all(axis=1)]
    mapping, why = mapping_for("", file.labels, scheme_of("open").names)
    values = {
        "format": file.format,
        "points": len(file.points),
        "present": file.present,
        "dimension": file.dimension,
        "labels": list(file.labels),
        "group": file.group,
        "groups": len(file.groups),
        "image_size": file.image_size,
        "origin": file.origin,
        "bounds": [placed.min(axis=0).tolist(), placed.max(axis=0).tolist()] if len(placed) else None,
        "mapping": mapping.name,
        "mapping_why": why,
        "fiducials": sum(name in mapping.entries for name in scheme_of("open").names),
    }
    print_result(values if as_json else values | {"labels": _short(file.labels)}, as_json)
    return 0


def convert(
    landmarks: Path,
    /,
    *,
    out: Path,
    scheme: str = "closed",
    scan: Path | None = None,
    unit: str | None = None,
    placing: Annotated[ViewOptions, Parameter(name="*")] = _VIEW,
    out_origin: float | None = None,
    options: Annotated[FiducialOptions, Parameter(name="*")] = _OPTIONS,
    as_json: Json = False,
) -> int:
    """Turn landmarks of another tool into fiducials, or fiducials into its points.

    A file of fiducials goes out under the points of --mapping; every other file comes in by it. With --mapping none
    all points are kept as they are, and only the format changes.

    Parameters
    ----------
    landmarks : Path
        .json, .pts, .ljson, or a table .csv.
    out : Path
        .json (needs a picture's size), .pts, .ljson or .csv.
    scheme : str
        Which fiducials there are: closed, open, or a scheme's .toml file.
    scan : Path
        The scan they are for: gives the picture's size, and pixels to points in space.
    unit : str
        What the numbers of the scan's file mean.
    out_origin : float
        What the written file is to call the centre of the top left pixel: 0, 0.5 or 1; 1 for .pts if left out.
    """
    from engine.files.landmarks import format_of, read_landmarks, write_landmarks
    from studio.scan.job import check_overwrites

    format_of(out)
    named = [Path(text) for text in (scheme, options.mapping) if Path(text).suffix]
    check_overwrites((out,), (landmarks, *((scan,) if scan is not None else ()), *named))
    definition = scheme_from(scheme)
    file = read_landmarks(landmarks, options.group, options.origin)
    if options.mapping == AS_IT_IS:
        result = _kept(file, options, landmarks)
    elif set(file.labels) <= set(definition.names) and options.mapping:
        result = _exported(file, definition, options, landmarks)
    else:
        result = _imported(file, definition, options, landmarks, scan, unit, placing)
    points, labels, size, values, remarks = result
    for text in remarks:
        remark(f"{landmarks}: {text}")
    write_landmarks(out, points, labels, size, out_origin)
    print_result(values | {"points": len(points), "format": format_of(out), "files": [out]}, as_json)
    return 0


_Result = tuple["FloatArray", tuple[str, ...], tuple[int, int] | None, dict[str, Any], tuple[str, ...]]


def _kept(file: LandmarkFile, options: FiducialOptions, subject: Path) -> _Result:
    from studio.scan.fiducial_files import made_on_size

    size = made_on_size(file, options, str(subject))
    return file.points, file.labels, size, {"mapping": AS_IT_IS}, file.remarks


def _exported(file: LandmarkFile, scheme: LandmarkScheme, options: FiducialOptions, subject: Path) -> _Result:
    from engine.landmark_mapping import invert_mapping
    from studio.scan.fiducial_files import made_on_size, mapping_for

    mapping, _ = mapping_for(options.mapping, file.labels, scheme.names)
    positions = {name: (x, y) for name, (x, y) in zip(file.labels, file.points.tolist(), strict=True)}
    done = invert_mapping(mapping, positions)
    remarks = list(file.remarks)
    if done.lost:
        remarks.append(f"{len(done.lost)} fiducials have no place in {mapping.title}: {some(done.lost)}")
    if done.holes:
        remarks.append(f"{done.holes} of {len(done.labels)} points of {mapping.title} are empty")
    values = {"mapping": mapping.name, "lost": list(done.lost), "holes": done.holes}
    return done.points, done.labels, made_on_size(file, options, str(subject)), values, tuple(remarks)


def _imported(
    file: LandmarkFile,
    scheme: LandmarkScheme,
    options: FiducialOptions,
    subject: Path,
    scan: Path | None,
    unit: str | None,
    placing: ViewOptions,
) -> _Result:
    import numpy as np

    from studio.scan.fiducial_files import (
        find_fiducials,
        made_on_size,
        mapping_for,
        no_fiducials,
    )

    if scan is not None:
        from studio.scan.view_options import read_placed

        read = read_placed(scan, unit, placing)
        found = find_fiducials(file, str(subject), scheme, read.scan, options, None, read.view, read.unit)
        if not found.usable:
            raise no_fiducials(found, str(subject), scheme.name)
        values = {
            "mapping": found.mapping.name,
            "fiducials": len(found.usable),
            "unmapped": list(found.unmapped),
            "absent": list(found.absent),
            "outside": list(found.named("outside")),
            "on_holes": list(found.named("on a hole")),
            "hidden_points": int(found.hidden.sum()),
        }
        points = np.array(list(found.usable.values()))
        return points, tuple(found.usable), (read.scan.width, read.scan.height), values, found.remarks
    from engine.landmark_mapping import apply_mapping

    if options.scale:
        raise InputError("--scale", "needs the scan that the points are for", "give --scan as well")
    mapping, why = mapping_for(options.mapping, file.labels, scheme.names)
    mapped = apply_mapping(mapping, file.points, file.labels, scheme.names)
    if not mapped.positions:
        problem = f"has no point of scheme {scheme.name} by mapping {mapping.title}"
        raise InputError(str(subject), problem, "choose another --mapping")
    told = [*file.remarks, f"mapping {mapping.title}" + (f", chosen by {why}" if why else "")]
    for names, what in ((mapped.unmapped, "not in the mapping"), (tuple(mapped.absent), "without a point in the file")):
        if names:
            told.append(f"{len(names)} {what}: {some(names)}")
    values = {
        "mapping": mapping.name,
        "fiducials": len(mapped.positions),
        "unmapped": list(mapped.unmapped),
        "absent": list(mapped.absent),
    }
    points = np.array(list(mapped.positions.values()))
    return points, tuple(mapped.positions), made_on_size(file, options, str(subject)), values, tuple(told)


def _short(labels: tuple[str, ...]) -> str:
    return ", ".join(labels[:6]) + (f" ... {labels[-1]}" if len(labels) > 6 else "")
