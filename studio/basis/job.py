"""A hand-sculpted rig and a performance become a quasi-eigen basis with figures: the job every caller runs. No Qt."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import InputError
from engine.progress import Progress, part, silent
from studio.basis.options import BOUNDS, BasisOptions, MotionOptions

if TYPE_CHECKING:
    from engine.basis.compare import Comparison
    from engine.basis.principal import PrincipalBasis
    from engine.basis.quasi_eigen import QuasiEigen
    from engine.motion import MeshMotion
    from engine.shapes import Rig

BASES = {"hand": "hand", "quasi_eigen": "quasi-eigen", "pca": "PCA"}
"""The three bases by key, as they are called on screen."""

LEAST_GAIN, MOST_LOSS, MOST_WEIGHT, LEAST_COSINE = 3.5, 1.3, 3.0, 0.85
"""What a quasi-eigen basis is judged by: hand / quasi-eigen, quasi-eigen / PCA, 99th percentile of |w|, cosine."""


@dataclass(frozen=True)
class BasisInputs:
    """What a basis is made of.

    Attributes
    ----------
    hand : Rig
        The hand-sculpted shapes.
    motion : MeshMotion
        The performance on the same vertices.
    """

    hand: Rig
    motion: MeshMotion


@dataclass(frozen=True)
class BasisResult:
    """What came out.

    Attributes
    ----------
    principal : PrincipalBasis
        Mean and axes of the training range.
    quasi : QuasiEigen
        The projected shapes, W, and how near each is to its hand shape.
    comparison : Comparison
        Weights and errors of the three bases under the three bounds, over the whole performance.
    seconds, peak_mb : float
        Time of the computation, and the most memory the process has had so far (NaN where it cannot be told).
    skin_name : str
        Name of the vertices that everything is measured on.
    """

    principal: PrincipalBasis
    quasi: QuasiEigen
    comparison: Comparison
    seconds: float
    peak_mb: float
    skin_name: str


def run(inputs: BasisInputs, options: BasisOptions, progress: Progress = silent) -> BasisResult:
    """Find the axes, project the shapes on them, and reconstruct the performance by all three bases.

    Raises
    ------
    InputError
        When rig and performance are of different topologies, or the options ask for what is not there.
    """
    from engine.basis.compare import compare
    from engine.basis.quasi_eigen import project

    started = time.perf_counter()
    hand, motion = inputs.hand, inputs.motion
    principal = find_axes(inputs, options, part(progress, 0.0, 0.5))
    progress(0.5, "projecting the shapes")
    quasi = project(hand.basis, principal, options.affine)
    comparison = compare(
        hand.basis,
        quasi,
        principal,
        motion,
        vertices=hand.skin,
        ridge=options.ridge,
        progress=part(progress, 0.5, 1.0),
    )
    seconds = time.perf_counter() - started
    return BasisResult(principal, quasi, comparison, seconds, peak_mb(), hand.skin_name)


def find_axes(inputs: BasisInputs, options: BasisOptions, progress: Progress = silent) -> PrincipalBasis:
    """Return the principal axes of the training range over the skin.

    Raises
    ------
    InputError
        When the topologies differ, or the range or the number of axes is not there.
    """
    from engine.basis.principal import principal_basis
    from engine.shapes import check_topology

    check_topology("motion", len(inputs.motion.neutral), len(inputs.hand.basis.neutral), "the rig")
    progress(0.0, "finding the principal axes")
    return principal_basis(
        inputs.motion,
        options.coverage,
        options.count,
        vertices=inputs.hand.skin,
        train=options.train,
        memory_mb=options.memory_mb,
        progress=progress,
    )


def figures(result: BasisResult) -> dict[str, Any]:
    """Return every figure under the names that scripts rely on."""
    principal, quasi, errors = result.principal, result.quasi, result.comparison.errors
    shapes = [
        {"name": name, "residual_mm": mm, "residual_fraction": fraction, "cosine": cosine}
        for name, mm, fraction, cosine in zip(
            quasi.basis.names, quasi.residual_mm, quasi.residual_fraction, quasi.cosine, strict=True
        )
    ]

    def table(mean: str, pooled: str) -> dict[str, dict[str, dict[str, float]]]:
        return {
            basis: {
                key: {"mean": getattr(error, mean), "pooled": getattr(error, pooled)} for key, error in rows.items()
            }
            for basis, rows in errors.items()
        }

    return {
        "axes": principal.count,
        "coverage": principal.coverage,
        "missing_axes": [axis + 1 for axis in quasi.missing],
        "rank": quasi.rank,
        "span_coverage": quasi.span_coverage,
        "shapes": shapes,
        "median_cosine": median_cosine(quasi),
        "alpha": table("alpha_mean", "alpha_pooled"),
        "alpha_motion": table("motion_mean", "motion_pooled"),
        "rms_mm": {basis: {key: error.rms_mm for key, error in rows.items()} for basis, rows in errors.items()},
        "weights_p99": result.comparison.p99,
        "measured_on": result.skin_name,
        "origin_mm": list(next(iter(errors["hand"].values())).origin),
        "frames": len(next(iter(errors["hand"].values())).alpha_frames),
        "trained_on": [principal.train[0] + 1, principal.train[1]],
        "warnings": list(quasi.warnings),
        "seconds": result.seconds,
        "peak_mb": result.peak_mb,
    }


@dataclass(frozen=True)
class Check:
    """One figure with its limit: ``sign`` says on which side of the limit it passes."""

    name: str
    value: float
    sign: str
    limit: float

    @property
    def passes(self) -> bool:
        """Whether the figure keeps its limit."""
        return self.value >= self.limit if self.sign == "≥" else self.value <= self.limit


def checks(result: BasisResult, bounds: str = "-1..2") -> tuple[Check, ...]:
    """Return what a quasi-eigen basis is judged by: hand and quasi-eigen in the same bounds, PCA free (METHODS B.7)."""
    errors, quasi = result.comparison.errors, result.quasi
    hand, own, best = (errors[b][k].alpha_mean for b, k in (("hand", bounds), ("quasi_eigen", bounds), ("pca", "free")))
    return (
        Check("hand / quasi-eigen", _ratio(hand, own), "≥", LEAST_GAIN),
        Check("quasi-eigen / PCA", _ratio(own, best), "≤", MOST_LOSS),
        Check("weights, 99th pct |w|", result.comparison.p99["quasi_eigen"][bounds], "≤", MOST_WEIGHT),
        Check("median cosine", median_cosine(quasi), "≥", LEAST_COSINE),
        Check("rank of W", float(quasi.rank), "≥", float(result.principal.count)),
    )


def median_cosine(quasi: QuasiEigen) -> float:
    """Return the median cosine between the hand shapes that move and their quasi-eigen shapes."""
    import numpy as np

    moving = quasi.cosine[np.isfinite(quasi.cosine)]
    return float(np.median(moving)) if len(moving) else float("nan")


def _ratio(above: float, below: float) -> float:
    return above / below if below > 0 else float("inf")


def as_command(
    hand: str,
    motion: str,
    options: BasisOptions,
    reading: MotionOptions,
    out: str,
    rig: str | None = None,
    pairs: str | None = None,
) -> str:
    """Return the command line that makes the same basis of the same files; ``pairs`` is the file they stand in."""
    words = ["quasiface", "basis", "project", "--hand", hand, "--motion", motion]
    if rig is not None:
        words += ["--rig", rig]
    words += ["--count", str(options.count)] if options.count else ["--coverage", repr(options.coverage)]
    if options.train is not None:
        words += ["--train", f"{options.train[0] + 1}:{options.train[1]}"]
    if options.affine:
        words.append("--affine")
    if options.ridge:
        words += ["--ridge", repr(options.ridge)]
    if options.memory_mb != BasisOptions.model_fields["memory_mb"].default:
        words += ["--memory-mb", repr(options.memory_mb)]
    for name in ("unit", "up", "forward"):
        if getattr(reading, name) is not None:
            words.append(f"--{name}={getattr(reading, name)}")  # an axis such as -z is no option
    if reading.fps is not None:
        words += ["--fps", repr(reading.fps)]
    if reading.rest_frame is not None:
        words += ["--rest-frame", str(reading.rest_frame + 1)]
    if reading.scale:
        words.append("--scale")
    for label in reading.head or ():
        words += ["--head", label]
    if reading.head == ():
        words.append("--keep-head")
    if pairs is not None:
        words += ["--pairs", pairs]
    return shlex.join([*words, "--out", out])


def peak_mb() -> float:
    """Return the most memory the process has had so far, MB; NaN where the system does not say."""
    try:
        import resource
    except ImportError:  # Windows
        return float("nan")
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / (1 << 20) if sys.platform == "darwin" else size / 1024


def bounds_of(low: float | None, high: float | None, free: bool) -> tuple[float, float] | None:
    """Return the bounds that a command asked for.

    Raises
    ------
    InputError
        When the lower bound is not below the upper one, or both bounds and ``free`` are asked for.
    """
    if free and low is not None:
        raise InputError("--free", "is given together with --bounds", "give one of them")
    if free:
        return None
    if low is None or high is None:
        return BOUNDS["-1..2"]
    if not low < high:
        raise InputError("--bounds", f"{low:g} {high:g}: the first is not below the second", "give the lower one first")
    return low, high


RIG_ENDINGS = (".glb", ".npz", "")
"""Endings of what a basis is written to; without one it is a folder of OBJs."""


def check_out(path: Path, sources: Iterable[Path], endings: tuple[str, ...] | None = None) -> None:
    """Raise InputError where a result cannot be written, or would be written over what it is made of.

    Parameters
    ----------
    path : Path
        A file or a folder.
    sources : iterable of Path
        Files and folders it is made of.
    endings : tuple of str, optional
        Of the file, with the dot; one that is empty stands for a folder.
    """
    from engine.files.atomic import check_writable

    place, made_of = path.resolve(), {source.resolve() for source in sources}
    if place in made_of:
        raise InputError(str(path), "is one of the inputs", "choose another name with --out")
    ending = path.suffix.lower()
    folder = ending not in (".glb", ".npz", ".csv", ".pdf") and (not ending or path.is_dir())
    if endings is not None and ending not in endings and not ("" in endings and folder):
        known = ", ".join(known for known in endings if known)
        raise InputError(str(path), "has no known ending", f"choose {known}{' or a folder' * ('' in endings)}")
    if not folder:
        check_writable(path)
        return
    if any(place in source.parents for source in made_of):
        raise InputError(str(path), "holds one of the inputs", "choose another folder with --out")
    if path.exists() and not path.is_dir():
        raise InputError(str(path), "is a file", "choose a folder, or end the name in .glb or .npz")
    if not place.parent.is_dir():
        raise InputError(str(path), "its folder does not exist", "make the folder first or choose another")
    if path.is_dir() and any(path.iterdir()) and not (path / "shapes.json").is_file():
        raise InputError(str(path), "holds files that are no basis of ours", "choose an empty or a new folder")
