"""``quasiface basis ...``: reads arguments, runs the job, prints figures. No Qt."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter
from cyclopts.validators import Number

from studio.basis.arguments import AxesArguments, ReadingArguments
from studio.output import Json, print_result, print_table, progress_lines, remark

if TYPE_CHECKING:
    from engine.files.rig import RigFile
    from engine.motion import MeshMotion
    from engine.shapes import Rig
    from studio.basis.options import MotionOptions

# Readers and the job are imported where they are used: help does not wait for numpy.
_AXES = AxesArguments()
_READING = ReadingArguments()
Ridge = Annotated[float, Parameter(validator=Number(gte=0))]
Switch = Annotated[bool, Parameter(negative="")]
Axes = Annotated[AxesArguments, Parameter(name="*")]
Reading = Annotated[ReadingArguments, Parameter(name="*")]


def pca(
    *,
    motion: Path,
    out: Path,
    rig: Path | None = None,
    axes: Axes = _AXES,
    reading: Reading = _READING,
    as_json: Json = False,
) -> int:
    """Find the principal axes of a performance and write them as a basis about its mean.

    Parameters
    ----------
    motion : Path
        Markers (.c3d, .trc, .csv), weight curves (.csv), a mesh cache (.pc2, .npz), or a .glb with a weights animation.
    out : Path
        The axes: .glb, .npz, or a folder for .obj files.
    rig : Path
        The rig that markers lie on or curves drive: .glb, .npz, or a folder of .obj files; a .glb motion is its own.
    """
    from engine.files.rig_out import write_rig
    from studio.basis.job import BasisInputs, check_out, find_axes

    options = axes.options()
    base = _rig(_base(rig, motion))
    check_out(out, (*base.source_files, motion))
    moved = _moved(motion, base.rig, base, reading.options())
    principal = find_axes(BasisInputs(base.rig, moved), options, progress_lines())
    written = write_rig(out, base.rig.with_basis(principal.basis()), name="pca", texture=base.texture)
    values = {
        "axes": principal.count,
        "coverage": principal.coverage,
        "eigenvalues_mm2": principal.eigenvalues[: principal.count],
        "total_variance_mm2": principal.total_variance,
        "frames": len(moved),
        "trained_on": [principal.train[0] + 1, principal.train[1]],
        "measured_on": base.rig.skin_name,
        "files": list(written),
    }
    print_result(values, as_json)
    return 0


def project(
    *,
    hand: Path,
    motion: Path,
    out: Path,
    rig: Path | None = None,
    affine: Switch = False,
    ridge: Ridge = 0.0,
    report: Path | None = None,
    axes: Axes = _AXES,
    reading: Reading = _READING,
    as_json: Json = False,
) -> int:
    """Project hand-sculpted shapes onto what a performance does, and say how well each basis reproduces it.

    Parameters
    ----------
    hand : Path
        The hand-sculpted rig: .glb with morph targets, .npz, or a folder of .obj files.
    motion : Path
        Markers (.c3d, .trc, .csv), weight curves (.csv), a mesh cache (.pc2, .npz), or a .glb with a weights animation.
    out : Path
        The quasi-eigen basis: .glb, .npz, or a folder for .obj files.
    rig : Path
        The rig that curves drive or markers lie on, where it is not the hand-sculpted one.
    affine : bool
        Write the basis about the mean of the motion.
    ridge : float
        Weight of small weights in every fit.
    report : Path
        A report with figures, pictures and curves (.pdf).
    """
    from engine.files.rig_out import write_rig
    from studio.basis.job import BasisInputs, check_out, figures, run

    options = axes.options(affine=affine, ridge=ridge)
    sculpted = _rig(hand)
    driver = _rig(rig) if rig is not None else sculpted
    sources = (*sculpted.source_files, *driver.source_files, motion)
    for path in (out, report):
        if path is not None:
            check_out(path, sources)
    inputs = BasisInputs(sculpted.rig, _moved(motion, sculpted.rig, driver, reading.options()))
    result = run(inputs, options, progress_lines())
    made = sculpted.rig.with_basis(result.quasi.basis)
    written = list(write_rig(out, made, name="quasi-eigen", texture=sculpted.texture))
    if report is not None:
        from studio.report.basis_job import write_basis_report

        files = {"hand": hand, "motion": motion} | ({} if rig is None else {"rig": rig})
        written += write_basis_report(report, inputs, options, result, files=files)
    for warning in result.quasi.warnings:
        remark(warning)
    found = figures(result) | {"files": written}
    if as_json:
        print_result(found, True)
    else:
        _print(found)
    return 0


def solve(
    *,
    basis: Path,
    motion: Path,
    out: Path,
    rig: Path | None = None,
    bounds: tuple[float, float] | None = None,
    free: Switch = False,
    ridge: Ridge = 0.0,
    reading: Reading = _READING,
    as_json: Json = False,
) -> int:
    """Find the weights with which a basis reproduces a performance, and write them as curves.

    Parameters
    ----------
    basis : Path
        The basis: .glb with morph targets, .npz, or a folder of .obj files.
    motion : Path
        Markers (.c3d, .trc, .csv), weight curves (.csv), a mesh cache (.pc2, .npz), or a .glb with a weights animation.
    out : Path
        The curves (.csv): frame, time_s, a column a shape.
    rig : Path
        The rig that curves drive or markers lie on, where it is not the basis.
    bounds : tuple of float
        Lowest and highest weight; -1 2 where left out.
    free : bool
        Weights without bounds.
    ridge : float
        Weight of small weights.
    """
    import numpy as np
    from engine.files.weights_csv import write_weights

    from engine.basis.error import reproduction_error
    from engine.basis.weights import solve_weights
    from engine.motion import WeightCurves
    from studio.basis.job import bounds_of, check_out

    low, high = bounds if bounds is not None else (None, None)
    limits = bounds_of(low, high, free)
    base = _rig(basis)
    driver = _rig(rig) if rig is not None else base
    check_out(out, (*base.source_files, *driver.source_files, motion))
    moved = _moved(motion, base.rig, driver, reading.options())
    weights = solve_weights(base.rig.basis, moved, limits, ridge, vertices=base.rig.skin, progress=progress_lines())
    error = reproduction_error(base.rig.basis, moved, weights, vertices=base.rig.skin)
    write_weights(out, WeightCurves(base.rig.basis.names, weights, moved.fps))
    values = {
        "frames": len(moved),
        "shapes": len(base.rig.basis),
        "bounds": None if limits is None else list(limits),
        "alpha": {"mean": error.alpha_mean, "pooled": error.alpha_pooled},
        "alpha_motion": {"mean": error.motion_mean, "pooled": error.motion_pooled},
        "rms_mm": error.rms_mm,
        "weights_p99": float(np.percentile(np.abs(weights), 99)),
        "weights_max": float(np.abs(weights).max()),
        "measured_on": base.rig.skin_name,
        "files": [out],
    }
    print_result(values, as_json)
    return 0


def _base(rig: Path | None, motion: Path) -> Path:
    """Return the file of the rig that a performance moves: the one that was named, or that of a .glb itself."""
    from engine.errors import InputError

    if rig is None and motion.suffix.lower() != ".glb":
        raise InputError("--rig", "is missing", f"name the rig that {motion.name} moves")
    return rig or motion


def _rig(path: Path) -> RigFile:
    from engine.files.rig import read_rig

    file = read_rig(path)
    for warning in file.warnings:
        remark(f"{path}: {warning}")
    return file


def _moved(path: Path, rig: Rig, driver: RigFile, reading: MotionOptions) -> MeshMotion:
    """Return the motion of ``rig``'s vertices, and say what was found on the way."""
    from studio.basis.motions import prepare, read_performance

    file = read_performance(path, reading)
    for text in file.warnings:
        remark(f"{path}: {text}")
    prepared = prepare(file.data, rig, reading, None if driver.rig is rig else driver.rig)
    for note in prepared.notes:
        remark(f"{path}: {note}")
    return prepared.motion


def _print(found: dict[str, Any]) -> None:
    rows = [(s["name"], s["residual_mm"], 100 * s["residual_fraction"], s["cosine"]) for s in found["shapes"]]
    print_table(("shape", "residual_mm", "residual_%", "cosine"), rows)
    print()
    keys = ("0..1", "-1..2", "free")
    alphas = [(basis, *(row[key]["mean"] for key in keys)) for basis, row in found["alpha"].items()]
    print_table(("alpha % (mean)", *keys), alphas)
    print()
    shown = ("axes", "coverage", "missing_axes", "rank", "span_coverage", "median_cosine", "measured_on", "frames",
             "seconds", "peak_mb", "files")  # fmt: skip
    print_result({name: found[name] for name in shown}, False)
