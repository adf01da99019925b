"""All that the report of a basis shows, taken out of inputs and result, small enough to be sent to another process."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.files.source import kind_of
from engine.mesh import FloatArray, IntArray, TriangleMesh
from studio.basis.job import BASES, Check, checks
from studio.basis.options import BOUNDS, BasisOptions
from widgets.scene.basis_content import counted

if TYPE_CHECKING:
    from engine.basis.quasi_eigen import QuasiEigen
    from engine.motion import MeshMotion
    from studio.basis.job import BasisInputs, BasisResult

WORST = 4
"""Frames that are pictured."""
_BLOCK = 1 << 20


@dataclass(frozen=True, eq=False)
class FrameShot:
    """One frame: its number from 0, the original's positions (N, 3) and the reconstructions', mm, and their RMS, mm."""

    frame: int
    original: FloatArray
    by_hand: FloatArray
    by_quasi: FloatArray
    rms_mm: tuple[float, float]

    @property
    def built(self) -> tuple[FloatArray, FloatArray]:
        """What hand and quasi-eigen shapes make of it."""
        return self.by_hand, self.by_quasi


@dataclass(frozen=True, eq=False)
class BasisEntry:
    """A basis as the report shows it.

    Attributes
    ----------
    mesh : TriangleMesh
        The neutral face, mm; ``skin`` are the vertices that everything is measured on, ``skin_name`` what they are
        called, ``origin`` the point that alpha is about.
    names, hand : shapes of the hand-sculpted basis, displacements (n, N, 3) mm
    quasi : QuasiEigen
    eigenvalues, total_variance, coverage, axes : of the principal axes
    trained : (int, int)
        First frame and the one after the last, from 0.
    fps, frames : of the whole performance
    alpha, pooled, rms : by basis and bounds key, %, % and mm
    curves : by basis key
        Alpha (L,) % and RMS (L,) mm of every frame: hand and quasi-eigen in the bounds shown, PCA free.
    heat : by basis key
        RMS (N,) mm of every vertex, likewise.
    shots : tuple of FrameShot
        The worst frames by the quasi-eigen basis.
    facts : tuple of (str, str)
        Files with their SHA-256, options.
    """

    mesh: TriangleMesh
    skin: IntArray
    skin_name: str
    origin: FloatArray
    names: tuple[str, ...]
    hand: FloatArray
    quasi: QuasiEigen
    eigenvalues: FloatArray
    total_variance: float
    coverage: float
    axes: int
    trained: tuple[int, int]
    fps: float
    frames: int
    bounds: str
    alpha: Mapping[str, Mapping[str, float]]
    pooled: Mapping[str, Mapping[str, float]]
    rms: Mapping[str, Mapping[str, float]]
    p99: Mapping[str, Mapping[str, float]]
    curves: Mapping[str, tuple[FloatArray, FloatArray]]
    heat: Mapping[str, FloatArray]
    worst: IntArray
    shots: tuple[FrameShot, ...]
    checks: tuple[Check, ...]
    facts: tuple[tuple[str, str], ...]
    title: str = "Quasi-eigen basis"
    texture: NDArray[np.uint8] | None = None

    def shape(self, index: int) -> FloatArray:
        """Return a quasi-eigen shape as displacements (N, 3) from the neutral face, mm."""
        basis = self.quasi.basis
        moved: FloatArray = basis.displacements[index]
        return moved if basis.mean is None else moved + basis.mean


def entry_of(
    inputs: BasisInputs,
    options: BasisOptions,
    result: BasisResult,
    *,
    files: Mapping[str, Path] | None = None,
    texture: NDArray[np.uint8] | None = None,
    title: str = "Quasi-eigen basis",
) -> BasisEntry:
    """Return what the report shows.

    Parameters
    ----------
    files : mapping of str to Path, optional
        The input files by their role; each is told with its SHA-256.

    Raises
    ------
    InputError
        When a file cannot be read.
    """
    comparison, principal = result.comparison, result.principal
    shown = {"hand": options.bounds, "quasi_eigen": options.bounds, "pca": "free"}
    errors = {basis: comparison.errors[basis][key] for basis, key in shown.items()}
    worst = errors["quasi_eigen"].worst_frames(8)
    worst = worst if len(worst) else np.zeros(1, dtype=np.int64)  # without any error the first frame stands for all
    table: dict[str, dict[str, dict[str, float]]] = {name: {} for name in ("alpha_mean", "alpha_pooled", "rms_mm")}
    for name, rows in table.items():
        for basis in BASES:
            rows[basis] = {key: float(getattr(comparison.errors[basis][key], name)) for key in BOUNDS}
    return BasisEntry(
        mesh=inputs.hand.mesh,
        skin=inputs.hand.skin,
        skin_name=result.skin_name,
        origin=errors["hand"].origin,
        names=inputs.hand.basis.names,
        hand=inputs.hand.basis.displacements,
        quasi=result.quasi,
        eigenvalues=principal.eigenvalues,
        total_variance=principal.total_variance,
        coverage=principal.coverage,
        axes=principal.count,
        trained=principal.train,
        fps=inputs.motion.fps,
        frames=len(inputs.motion),
        bounds=options.bounds,
        alpha=table["alpha_mean"],
        pooled=table["alpha_pooled"],
        rms=table["rms_mm"],
        p99=comparison.p99,
        curves={basis: (error.alpha_frames, error.rms_frames) for basis, error in errors.items()},
        heat={basis: error.rms_vertices for basis, error in errors.items()},
        worst=worst,
        shots=tuple(_shot(inputs.motion, result, options.bounds, int(frame)) for frame in worst[:WORST]),
        checks=checks(result, options.bounds),
        facts=(*_files(files or {}), *_choices(options, principal.count, principal.train)),
        title=title,
        texture=texture,
    )


def _shot(motion: MeshMotion, result: BasisResult, bounds: str, frame: int) -> FrameShot:
    comparison = result.comparison
    built, rms = [], []
    for basis in ("hand", "quasi_eigen"):
        shapes = comparison.bases[basis]
        moved = np.tensordot(comparison.weights[basis][bounds][frame], shapes.displacements, axes=1)
        built.append(motion.neutral + moved + (0.0 if shapes.mean is None else shapes.mean))
        rms.append(float(comparison.errors[basis][bounds].rms_frames[frame]))
    return FrameShot(frame, motion.frame(frame), built[0], built[1], (rms[0], rms[1]))


def _files(files: Mapping[str, Path]) -> tuple[tuple[str, str], ...]:
    rows: list[tuple[str, str]] = []
    for role, path in files.items():
        found = _digest(path) if kind_of(path) is not None else "the file is no longer there"
        rows += [(role, path.name), ("SHA-256", found)]
    return tuple(rows)


def _choices(options: BasisOptions, axes: int, trained: tuple[int, int]) -> tuple[tuple[str, str], ...]:
    """Return the options as people say them, with the axes and frames that came of them."""
    by = f"by coverage {options.coverage:g} ({axes})" if options.count is None else f"{axes}, by number"
    low, _, high = options.bounds.partition("..")
    rows = [
        ("Kind", "affine, the mean of the motion kept apart" if options.affine else "linear"),
        ("Axes", by),
        ("Trained on", f"{counted(trained[0] + 1)}\u2013{counted(trained[1])}"),
        ("Weights", f"in {low} to {high}".replace("-", "\u2212") if high else "free"),
    ]
    if options.ridge:
        rows.append(("Ridge", f"{options.ridge:g}"))
    return tuple(rows)


def _digest(path: Path) -> str:
    digest = hashlib.sha256()
    if kind_of(path) == "folder":
        for file in sorted(path.glob("*.obj")):
            digest.update(file.name.encode() + _digest(file).encode())
        return digest.hexdigest()
    with path.open("rb") as handle:
        while block := handle.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()
