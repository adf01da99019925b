"""``quasiface scan ...``: reads arguments, runs the job, prints figures. No Qt."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from engine.errors import InputError
from studio.output import Json, print_result, remark
from studio.scan.fiducial_options import FiducialOptions
from studio.scan.options import FitOptions
from studio.scan.view_options import ViewOptions

if TYPE_CHECKING:
    from engine.scan.range_image import RangeImage

# Readers and the job are imported where they are used: help does not wait for numpy and image libraries.
_OPTIONS = FitOptions()
_READING = FiducialOptions()
_VIEW = ViewOptions()


def info(
    scan: Path,
    /,
    *,
    unit: str | None = None,
    placing: Annotated[ViewOptions, Parameter(name="*")] = _VIEW,
    as_json: Json = False,
) -> int:
    """Say what a scan holds: size, missing pixels, spikes, unit and bounds.

    Parameters
    ----------
    scan : Path
        An organised .ply or .pcd, .npz, .abs, point text (.xyz), a .json beside its depth image, or a mesh: .obj, .glb,
        a .ply with faces.
    unit : str
        What the file's numbers mean: mm, cm, m; for a mesh also the millimetres of one, as "85.3 mm".
    """
    from studio.scan.view_cli import view_figures
    from studio.scan.view_options import read_placed

    file = read_placed(scan, unit, placing)
    for warning in file.warnings:
        remark(f"{scan}: {warning}")
    values = scan_figures(file.scan)
    values |= {"unit": file.unit, "assumed": file.assumed, "format": file.format}
    values["view"] = None if file.view is None else view_figures(file.view)
    print_result(values, as_json)
    return 0


def scan_figures(scan: RangeImage) -> dict[str, Any]:
    """Return width, height, missing_fraction, spikes and bounds_mm (lowest and highest x, y, z) of a scan."""
    import numpy as np

    from engine.scan.repair import find_spikes

    points = scan.points[scan.valid]
    return {
        "width": scan.width,
        "height": scan.height,
        "missing_fraction": scan.missing_fraction,
        "spikes": int(np.count_nonzero(find_spikes(scan, _OPTIONS.spike_mm))),
        "bounds_mm": [points.min(axis=0).tolist(), points.max(axis=0).tolist()],
        "colour": scan.colour is not None,
    }


def fit(
    scan: Path,
    /,
    *,
    fiducials: Path,
    out: Path,
    scheme: str = "closed",
    template: Path | None = None,
    unit: str | None = None,
    skip: Annotated[list[str] | None, Parameter(negative="")] = None,
    limits: Path | None = None,
    placing: Annotated[ViewOptions, Parameter(name="*")] = _VIEW,
    options: Annotated[FitOptions, Parameter(name="*")] = _OPTIONS,
    reading: Annotated[FiducialOptions, Parameter(name="*")] = _READING,
    as_json: Json = False,
) -> int:
    """Fit the face template to a scan and write it as GLB or OBJ.

    Parameters
    ----------
    scan : Path
        An organised .ply or .pcd, .npz, .abs, point text (.xyz), a .json beside its depth image, or a mesh: .obj, .glb,
        a .ply with faces.
    fiducials : Path
        Where the scheme's points are: our .json, or .pts, .ljson, .csv by a mapping.
    out : Path
        The face: .glb (metres) or .obj (mm, with .mtl and _texture.png beside it).
    scheme : str
        Which points there are: closed, open, or the .toml file of a scheme.
    template : Path
        Another template than the one shipped.
    unit : str
        What the file's numbers mean: mm, cm, m; for a mesh also the millimetres of one, as "85.3 mm".
    skip : list of str
        Fiducials to do without; may be given several times.
    limits : Path
        What the figures are judged by (TOML); by default the limits that come along.
    """
    from engine.files.limits import read_limits
    from engine.scan.limits import Limits
    from engine.scan.regions import regions_of
    from studio.scan.fiducial_files import fiducials_for_fit
    from studio.scan.job import (
        FitInputs,
        check_overwrites,
        export_face,
        face_files,
        run,
        template_for,
    )
    from studio.scan.judged_figures import judged, measured
    from studio.scan.scheme_cli import scheme_files, scheme_from
    from studio.scan.view_options import read_placed

    face_files(out, textured=True)
    bounds = Limits() if limits is None else read_limits(limits)
    definition = scheme_from(scheme)
    file = read_placed(scan, unit, placing)
    sources = [*file.source_files, fiducials, *scheme_files(scheme)]
    sources += [path for path in (template, limits) if path is not None]
    check_overwrites(face_files(out, file.scan.colour is not None), sources)
    assumed = regions_of(template_for(template, definition)).assumed
    placed, skipped, told = fiducials_for_fit(
        fiducials, definition, file.scan, reading, file.view, file.unit, skip or ()
    )
    culprits = {"fiducial": fiducials, "range image": scan, "thin-plate source": template or "the template"}
    try:
        face = run(FitInputs(file.scan, placed, definition, template), options)
    except InputError as error:
        culprit = next((path for word, path in culprits.items() if error.subject.startswith(word)), None)
        if culprit is None:
            raise
        raise InputError(f"{culprit}, {error.subject}", error.problem, error.remedy) from error
    written = export_face(face, file.scan, out, sources=sources)
    for warning in file.warnings:
        remark(f"{scan}: {warning}")
    for text in told:
        remark(f"{fiducials}: {text}")
    if assumed:
        remark(f"{template or 'template'}: states no regions; they are told {assumed}")
    values = {"skipped_fiducials": list(skipped), "unit": file.unit, "assumed": file.assumed, "files": written}
    found = judged(measured(face, template), bounds)
    if not as_json:
        del found["regions"]  # a table of its own, which people have in the report
    print_result(found | values, as_json)
    return 0
