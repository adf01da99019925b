"""How good a fit is, in figures a supervisor can hold against limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.errors import InputError
from engine.geometry.normals import smallest_angles
from engine.scan.fit import FaceFit
from engine.scan.limits import FIGURES, Limits, RegionLimits, Verdict, worst
from engine.scan.regions import FaceRegions

__all__ = [
    "Check",
    "FitQuality",
    "Limits",
    "RegionQuality",
    "Verdict",
    "measure",
    "measure_regions",
    "overall",
    "verdicts",
]


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
class Check:
    """One line of the quality table; ``limit`` and ``verdict`` are None where nothing is judged."""

    name: str
    value: float
    unit: str
    limit: float | None = None
    verdict: Verdict | None = None


@dataclass(frozen=True)
class RegionQuality:
    """Figures of one region of a fitted face against its limits.

    ``vertices`` counts all of them; distances in mm are over the measured ones and NaN where there are none.
    ``verdict`` is the worst of the figures' verdicts. A region of filled vertices alone has no distances, and is judged
    by its share of them.
    """

    name: str
    vertices: int
    median_mm: float
    p95_mm: float
    max_mm: float
    filled_fraction: float
    limits: RegionLimits
    verdict: Verdict

    def judge(self, figure: str) -> Verdict:
        """Return the verdict on one figure, a name of ``limits.FIGURES``; a distance that is not there is no fault."""
        value = float(getattr(self, figure))
        if np.isnan(value):
            return Verdict.OK
        verdict: Verdict = getattr(self.limits, figure).judge(value)
        return verdict

    @property
    def figure(self) -> str:
        """The figure that lies highest against its limit, a name of ``limits.FIGURES``."""
        return max(FIGURES, key=lambda name: (list(Verdict).index(self.judge(name)), self._share(name)))

    @property
    def severity(self) -> float:
        """How high the worst figure lies: 1 at its warning limit; what regions are ranked by."""
        return self._share(self.figure)

    @property
    def rank(self) -> tuple[int, float]:
        """What regions are ordered by: verdict first, then how high the worst figure lies."""
        return list(Verdict).index(self.verdict), self.severity

    def _share(self, figure: str) -> float:
        value, warn = float(getattr(self, figure)), float(getattr(self.limits, figure).warn)
        if np.isnan(value) or value == 0:
            return 0.0
        return value / warn if warn > 0 else float("inf")


def measure_regions(fit: FaceFit, regions: FaceRegions, limits: Limits | None = None) -> tuple[RegionQuality, ...]:
    """Return the figures of every region of a fitted face, in the order of ``regions.names``.

    Raises
    ------
    InputError
        When the face was made from another template than the regions.
    """
    limits = limits or Limits()
    of_vertex = regions.vertices(fit.levels)
    if len(of_vertex) != len(fit.deviation_mm):
        problem = f"have {len(of_vertex)} vertices and the face {len(fit.deviation_mm)}"
        raise InputError("regions", problem, "take those of the template it was fitted with")
    result = []
    for index, name in enumerate(regions.names):
        mine = of_vertex == index
        if not mine.any():
            continue
        distance = fit.deviation_mm[mine & ~np.isnan(fit.deviation_mm)]
        median, p95, largest = np.percentile(distance, [50, 95, 100]) if len(distance) else np.full(3, np.nan)
        found = RegionQuality(
            name=name,
            vertices=int(mine.sum()),
            median_mm=float(median),
            p95_mm=float(p95),
            max_mm=float(largest),
            filled_fraction=float(fit.filled[mine].mean()),
            limits=limits.region(name),
            verdict=Verdict.OK,
        )
        result.append(replace(found, verdict=worst([found.judge(figure) for figure in FIGURES])))
    return tuple(result)


def overall(checks: Sequence[Check], regions: Sequence[RegionQuality] = ()) -> Verdict:
    """Return the worst verdict of a face and its regions."""
    return worst([check.verdict for check in checks if check.verdict is not None] + [r.verdict for r in regions])


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
