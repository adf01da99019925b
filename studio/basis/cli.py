"""``quasiface basis ...``: reads arguments, runs the job, prints figures. No Qt."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec

from cyclopts import Parameter
from cyclopts.validators import Number

from studio.basis.arguments import AxesArguments, ReadingArguments
from studio.output import Json, print_result, print_table, progress_lines, remark

if TYPE_CHECKING:
    from engine.files.motion_file import MotionFile
    from engine.files.rig import RigFile
    from engine.progress import Progress
    from studio.basis.motions import PreparedMotion
    from studio.basis.options import MotionOptions

# Readers and the job are imported where they are used: help does not wait for numpy.
_AXES = AxesArguments()
_READING = ReadingArguments()
Ridge = Annotated[float, Parameter(validator=Number(gte=0))]
Switch = Annotated[bool, Parameter(negative="")]
Axes = Annotated[AxesArguments, Parameter(name="*")]
Reading = Annotated[ReadingArguments, Parameter(name="*")]
P = ParamSpec("P")


def _stoppable(command: Callable[P, int]) -> Callable[P, int]:
    """Return a command that says what was written when the user stops it."""

    @wraps(command)
    def run(*arguments: P.args, **named: P.kwargs) -> int:
        try:
            return command(*arguments, **named)
        except KeyboardInterrupt as stopped:
            remark(f"cancelled; {str(stopped) or 'nothing was written'}")
            raise

    return run


@_stoppable
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
    from studio.basis.job import RIG_ENDINGS, BasisInputs, check_out, find_axes

    options, laid = axes.options(), reading.options()
    named = _named(motion, rig, reading.pairs)
    check_out(out, named, RIG_ENDINGS)
    base = _rig(_base(rig, motion))
    check_out(out, (*base.source_files, *named))
    file, prepared = _moved(motion, base, base, laid)
    options = prepared.kept(options)
    with _naming(motion, *_distinct(rig)):
        principal = find_axes(BasisInputs(base.rig, prepared.motion), options, _progress())
    with _writing(out):
        written = write_rig(out, base.rig.with_basis(principal.basis()), name="pca", texture=base.texture)
    _tell(base, file, prepared)
    values = {
        "axes": principal.count,
        "coverage": principal.coverage,
        "eigenvalues_mm2": principal.eigenvalues[: principal.count],
        "total_variance_mm2": principal.total_variance,
        "frames": len(prepared.motion),
        "trained_on": _trained_on(prepared, principal.train),
        "measured_on": base.rig.skin_name,
        **_read_as(file, prepared),
        "rig_unit": base.unit,
        "files": list(written),
    }
    _print_values(values, as_json)
    return 0


@_stoppable
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
    from studio.basis.job import RIG_ENDINGS, BasisInputs, check_out, figures, run

    options, laid = axes.options(affine=affine, ridge=ridge), reading.options()
    named = _named(hand, motion, rig, reading.pairs)
    check_out(out, named, RIG_ENDINGS)
    if report is not None:
        check_out(report, (out, *named), (".pdf",))
    sculpted = _rig(hand)
    driver = _rig(rig) if rig is not None else sculpted
    for path in (out, report):
        if path is not None:
            check_out(path, (*sculpted.source_files, *driver.source_files, *named))
    file, prepared = _moved(motion, sculpted, driver, laid)
    options = prepared.kept(options)
    inputs = BasisInputs(sculpted.rig, prepared.motion)
    with _naming(motion, *_distinct(hand, rig)):
        result = run(inputs, options, _progress())
    written: list[Path] = []
    if report is not None:
        from studio.report.basis_job import write_basis_report

        files = {"hand": hand, "motion": motion} | ({} if rig is None else {"rig": rig})
        with _writing(report):
            written += write_basis_report(report, inputs, options, result, files=files)
    with _writing(out, *written):
        made = sculpted.rig.with_basis(result.quasi.basis)
        written = [*write_rig(out, made, name="quasi-eigen", texture=sculpted.texture), *written]
    _tell(sculpted, file, prepared, driver)
    for warning in result.quasi.warnings:
        remark(warning)
    found = figures(result) | {"trained_on": _trained_on(prepared, result.principal.train)}
    found |= {**_read_as(file, prepared), "hand_unit": sculpted.unit, "files": written}
    if as_json:
        print_result(found, True)
    else:
        _print(found)
    return 0


@_stoppable
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

    from engine.basis.error import reproduction_error
    from engine.basis.weights import solve_weights
    from engine.files.weights_csv import write_weights
    from engine.motion import WeightCurves
    from studio.basis.job import bounds_of, check_out

    laid = reading.options()
    low, high = bounds if bounds is not None else (None, None)
    limits = bounds_of(low, high, free)
    named = _named(basis, motion, rig, reading.pairs)
    check_out(out, named, (".csv",))
    base = _rig(basis)
    driver = _rig(rig) if rig is not None else base
    check_out(out, (*base.source_files, *driver.source_files, *named))
    file, prepared = _moved(motion, base, driver, laid)
    moved, at = prepared.motion, base.rig.skin
    with _naming(motion, *_distinct(basis, rig)):
        weights = solve_weights(base.rig.basis, moved, limits, ridge, vertices=at, progress=_progress())
        error = reproduction_error(base.rig.basis, moved, weights, vertices=at)
    with _writing(out):
        write_weights(out, WeightCurves(base.rig.basis.names, weights, moved.fps), prepared.frames)
    _tell(base, file, prepared, driver)
    values: dict[str, Any] = {
        "frames": len(moved),
        "shapes": len(base.rig.basis),
        "bounds": None if limits is None else list(limits),
        "alpha": {"mean": error.alpha_mean, "pooled": error.alpha_pooled},
        "alpha_motion": {"mean": error.motion_mean, "pooled": error.motion_pooled},
        "rms_mm": error.rms_mm,
        "weights_p99": float(np.percentile(np.abs(weights), 99)),
        "weights_max": float(np.abs(weights).max()),
        "measured_on": base.rig.skin_name,
        **_read_as(file, prepared),
        "rig_unit": base.unit,
        "files": [out],
    }
    if as_json:
        print_result(values, True)
        return 0
    rows = [(title, *(values[name][kind] for kind in ("mean", "pooled"))) for title, name in
            (("of the face", "alpha"), ("of the motion", "alpha_motion"))]  # fmt: skip
    print_table(("alpha %", "mean", "pooled"), rows)
    print()
    shown = {name: value for name, value in values.items() if name not in ("alpha", "alpha_motion")}
    _print_values(shown | {"bounds": "free" if limits is None else f"{limits[0]:g} to {limits[1]:g}"}, False)
    return 0


def _base(rig: Path | None, motion: Path) -> Path:
    """Return the file of the rig that a performance moves: the one that was named, or that of a .glb itself."""
    from engine.errors import InputError

    if rig is None and motion.suffix.lower() != ".glb":
        raise InputError("--rig", "is missing", f"name the rig that {motion.name} moves")
    return rig or motion


def _named(*paths: Path | None) -> tuple[Path, ...]:
    return tuple(path for path in paths if path is not None)


def _distinct(*paths: Path | None) -> tuple[Path, ...]:
    return tuple(dict.fromkeys(_named(*paths)))


def _rig(path: Path) -> RigFile:
    from engine.files.rig import read_rig

    with _naming(path):
        return read_rig(path)


def _moved(path: Path, base: RigFile, driver: RigFile, reading: MotionOptions) -> tuple[MotionFile, PreparedMotion]:
    """Return a performance as it was read, and the motion of the vertices of ``base`` that it means."""
    from studio.basis.motions import check_sizes, prepare, read_performance

    with _naming(path):
        file = read_performance(path, reading)
    other = None if driver is base else driver.rig
    with _naming(path, driver.source_files[0]):
        prepared = prepare(file.data, base.rig, reading, other, _progress())
        check_sizes(path, file, prepared, base.rig, reading, other)
    return file, prepared


def _progress() -> Progress:
    """Return lines for people who wait at a terminal; a script reads one line on stderr where something is wrong."""
    from engine.progress import silent

    return progress_lines() if sys.stderr.isatty() else silent


@contextmanager
def _naming(*paths: Path) -> Iterator[None]:
    """Let errors say of which files they speak."""
    from engine.errors import InputError

    try:
        yield
    except InputError as error:
        if error.subject.startswith("--") or any(str(path) in error.subject for path in paths):
            raise
        names = " with ".join(map(str, paths))
        subject = names if error.subject == "motion" else f"{names}, {error.subject}"
        raise InputError(subject, error.problem, error.remedy) from error


@contextmanager
def _writing(path: Path, *before: Path) -> Iterator[None]:
    """Let who stops a command know what is there already."""
    try:
        yield
    except KeyboardInterrupt:
        parts = [f"{path} may be incomplete"] if not path.suffix else []
        parts += [f"{', '.join(map(str, before))} was written"] if before else []
        raise KeyboardInterrupt("; ".join(parts)) from None


def _tell(base: RigFile, file: MotionFile, prepared: PreparedMotion, driver: RigFile | None = None) -> None:
    """Say what was assumed, repaired and left out; only once all is written, so that a failure is told in one line."""
    for rig in (base, *(() if driver is None or driver is base else (driver,))):
        for text in (rig.assumed, *rig.warnings):
            remark(f"{rig.source_files[0]}: {text}")
    for text in (file.assumed, *file.warnings, *prepared.notes):
        remark(f"{file.source_files[0]}: {text}")


def _read_as(file: MotionFile, prepared: PreparedMotion) -> Mapping[str, Any]:
    return {
        "unit": file.unit or None,
        "up": file.up or None,
        "forward": file.forward or None,
        "fps": file.fps,
        "assumed": file.assumed,
        "left_out_frames": prepared.left_out,
        "notes": [*file.warnings, *prepared.notes],
    }


def _trained_on(prepared: PreparedMotion, train: tuple[int, int]) -> list[int]:
    """Return the first and the last frame of the recording that the axes were found from, counted from 1."""
    start, stop = prepared.recorded(train)
    return [start + 1, stop]


def _print_values(values: Mapping[str, Any], as_json: bool) -> None:
    """Print figures; for people without the sentences that stand on stderr."""
    told = () if as_json else ("assumed", "notes")
    print_result({name: value for name, value in values.items() if name not in told}, as_json)


def _print(found: dict[str, Any]) -> None:
    rows = [(s["name"], s["residual_mm"], 100 * s["residual_fraction"], s["cosine"]) for s in found["shapes"]]
    print_table(("shape", "residual_mm", "residual_%", "cosine"), rows)
    print()
    keys = ("0..1", "-1..2", "free")
    for kind in ("mean", "pooled"):
        alphas = [(basis, *(row[key][kind] for key in keys)) for basis, row in found["alpha"].items()]
        print_table((f"alpha % ({kind})", *keys), alphas)
        print()
    if found["alpha"]["quasi_eigen"]["free"]["pooled"] < found["alpha"]["pca"]["free"]["pooled"]:
        print("Free quasi-eigen shapes may lie below PCA: their span holds the mean as one more direction.")
        print()
    shown = ("axes", "coverage", "missing_axes", "rank", "span_coverage", "median_cosine", "measured_on", "frames",
             "left_out_frames", "trained_on", "unit", "up", "forward", "fps", "hand_unit", "seconds", "peak_mb",
             "files")  # fmt: skip
    print_result({name: found[name] for name in shown}, False)
