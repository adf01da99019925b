"""How good a fit is, in figures a supervisor can hold against limits."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from engine.geometry.normals import smallest_angles
from engine.scan.fit import FaceFit


class Verdict(StrEnum):
    """What a figure means against its limit."""

    OK = "ok"
    WARN = "warn"
    FAIL = "fail"


@dataclass(frozen=True)
class FitQuality:
    """Figures of one fit; distances to the scan in mm over the vertices that were measured."""

    median_mm: float
    p95_mm: float
    p99_mm: float
    max_mm: float
    filled_vertices: int
    filled_fraction: float
    folded_faces: int
    vertices: int
    faces: int
    fiducial_residual_px: float
    min_angle_deg: float
    noise_mm: float


@dataclass(frozen=True)
class Limits:
    """What counts as good; a figure up to ``tolerance`` times its limit is a warning, beyond it a failure."""

    median_mm: float = 0.07
    p99_mm: float = 0.30
    max_mm: float = 1.50
    filled_fraction: float = 0.10
    folded_faces: int = 0
    noise_mm: float = 0.20
    tolerance: float = 2.0


@dataclass(frozen=True)
class Check:
    """One line of the quality table; ``limit`` and ``verdict`` are None where nothing is judged."""

    name: str
    value: float
    unit: str
    limit: float | None = None
    verdict: Verdict | None = None


def measure(fit: FaceFit) -> FitQuality:
    """Return the figures of ``fit``; distances are NaN when no vertex was measured."""
    distance = fit.deviation_mm[~np.isnan(fit.deviation_mm)]
    median, p95, p99, largest = np.percentile(distance, [50, 95, 99, 100]) if len(distance) else np.full(4, np.nan)
    return FitQuality(
        median_mm=float(median),
        p95_mm=float(p95),
        p99_mm=float(p99),
        max_mm=float(largest),
        filled_vertices=int(fit.filled.sum()),
        filled_fraction=float(fit.filled.mean()),
        folded_faces=len(fit.folded_faces),
        vertices=len(fit.mesh.vertices),
        faces=len(fit.mesh.faces),
        fiducial_residual_px=fit.fiducial_residual_px,
        min_angle_deg=float(np.degrees(smallest_angles(fit.mesh.vertices, fit.mesh.faces).min())),
        noise_mm=fit.repair.noise_mm,
    )


def verdicts(quality: FitQuality, limits: Limits | None = None) -> list[Check]:
    """Return the quality table: first the distances to the scan, then the mesh."""
    limits = limits or Limits()
    return [
        _judge("median", quality.median_mm, "mm", limits.median_mm, limits.tolerance),
        Check("95th percentile", quality.p95_mm, "mm"),
        _judge("99th percentile", quality.p99_mm, "mm", limits.p99_mm, limits.tolerance),
        _judge("largest", quality.max_mm, "mm", limits.max_mm, limits.tolerance),
        _judge("scan noise", quality.noise_mm, "mm", limits.noise_mm, limits.tolerance),
        Check("vertices", quality.vertices, "count"),
        _judge("filled vertices", 100 * quality.filled_fraction, "%", 100 * limits.filled_fraction, limits.tolerance),
        _judge("folded triangles", quality.folded_faces, "count", limits.folded_faces, limits.tolerance),
        Check("smallest angle", quality.min_angle_deg, "degrees"),
    ]


def _judge(name: str, value: float, unit: str, limit: float, tolerance: float) -> Check:
    if not np.isfinite(value) or value > tolerance * limit:
        verdict = Verdict.FAIL
    else:
        verdict = Verdict.OK if value <= limit else Verdict.WARN
    return Check(name, float(value), unit, float(limit), verdict)
