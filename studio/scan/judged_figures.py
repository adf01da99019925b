"""The figures of a fit with those of its regions, and what they mean against limits: for fit, batch and record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from engine.scan.limits import Limits

_REGION = ("name", "vertices", "median_mm", "p95_mm", "max_mm", "filled_fraction")
_VERDICTS = ("verdict", "worst_region")


def measured(fit: FaceFit, template: Path | None = None) -> dict[str, Any]:
    """Return the figures of a fit and, under ``regions``, of its regions; without verdicts.

    Raises
    ------
    InputError
        When the fit was made with another template than that of ``template``.
    """
    from engine.scan.quality import measure_regions
    from engine.scan.regions import regions_of
    from studio.scan.job import figures, template_of

    values = {name: value for name, value in figures(fit).items() if name not in _VERDICTS}
    regions = measure_regions(fit, regions_of(template_of(template)))
    return values | {"regions": [{name: getattr(region, name) for name in _REGION} for region in regions]}


def judged(values: Mapping[str, Any], limits: Limits) -> dict[str, Any]:
    """Return figures of ``measured`` with a verdict on every region, the worst region and the worst verdict of all.

    Raises
    ------
    KeyError, TypeError, ValueError
        On values that are no such figures, as a file may hold them.
    """
    from engine.scan.limits import FIGURES, Verdict, worst
    from engine.scan.quality import FitQuality, RegionQuality, overall, verdicts

    quality = FitQuality(**{entry.name: _number(values[entry.name]) for entry in fields(FitQuality)})
    regions = []
    for row in values["regions"]:
        figures = {name: _number(row[name]) for name in _REGION[1:]}
        region = RegionQuality(str(row["name"]), **figures, limits=limits.region(row["name"]), verdict=Verdict.OK)
        verdict = worst([region.judge(figure) for figure in FIGURES])
        regions.append(RegionQuality(region.name, **figures, limits=region.limits, verdict=verdict))
    last = max(regions, key=lambda region: region.rank, default=None)
    return {name: value for name, value in values.items() if name != "regions"} | {
        "verdict": str(overall(verdicts(quality, limits), regions)),
        "worst_region": None if last is None else last.name,
        "regions": [region_figures(region) for region in regions],
    }


def region_figures(region: Any) -> dict[str, Any]:
    """Return the figures of one region under the names that scripts rely on."""
    return {name: getattr(region, name) for name in _REGION} | {"verdict": str(region.verdict)}


def _number(value: Any) -> Any:
    """Return a number as it is; JSON's null stands for one that is not finite."""
    if value is None:
        return float("nan")
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError(f"{value!r} is no figure")
    return value
