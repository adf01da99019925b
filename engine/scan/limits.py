"""What counts as good: limits for a whole face and for its regions. Needs no numpy: windows and files load it early.

The default bounds of the regions were measured: the largest figure of seven clean scans of the virtual scanner (the
bundled sample and a stranger, level 2, noise 0.15 mm), taken one and a half times and rounded, is where a warning
begins; twice that (filled vertices: three times) is a failure. A clean scan thus stays well below every warning.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from math import isfinite
from types import MappingProxyType

from engine.errors import InputError


class Verdict(StrEnum):
    """What a figure means against its limit."""

    OK = "ok"
    WARN = "warn"
    FAIL = "fail"


def worst(verdicts: list[Verdict]) -> Verdict:
    """Return the worst of several verdicts; ``ok`` of none."""
    return max(verdicts, key=tuple(Verdict).index, default=Verdict.OK)


@dataclass(frozen=True)
class Bounds:
    """A figure above ``warn`` is a warning, above ``fail`` a failure.

    Raises
    ------
    InputError
        Unless 0 <= warn <= fail, both finite.
    """

    warn: float
    fail: float

    def __post_init__(self) -> None:
        for name in ("warn", "fail"):
            value = getattr(self, name)
            if not isfinite(value) or not 0 <= value <= LARGEST:
                raise InputError(name, f"is {value:g}", f"give 0 to {LARGEST:g}")
        if self.fail < self.warn:
            raise InputError("fail", f"{self.fail:g} is below warn {self.warn:g}", "let it be as large or larger")

    def judge(self, value: float) -> Verdict:
        """Return the verdict on a figure; what is not a number fails."""
        if not isfinite(value) or value > self.fail:
            return Verdict.FAIL
        return Verdict.OK if value <= self.warn else Verdict.WARN


LARGEST = 1000.0
"""No limit lies beyond this, mm."""


@dataclass(frozen=True)
class RegionLimits:
    """Bounds for one region: distances to the scan in mm, and the share of filled vertices, 0..1."""

    median_mm: Bounds = Bounds(0.07, 0.14)
    p95_mm: Bounds = Bounds(0.20, 0.40)
    max_mm: Bounds = Bounds(0.60, 1.20)
    filled_fraction: Bounds = Bounds(0.10, 0.30)


FIGURES = tuple(entry.name for entry in fields(RegionLimits))
"""Names of a region's figures that have bounds: ``median_mm``, ``p95_mm``, ``max_mm``, ``filled_fraction``."""


def _bounds(median: float, p95: float, largest: float, filled: float) -> RegionLimits:
    """Return bounds that warn at these figures and fail at twice, filled vertices at three times as much."""
    middle, high, top = (Bounds(warn, round(2 * warn, 3)) for warn in (median, p95, largest))
    return RegionLimits(middle, high, top, Bounds(filled, round(min(1.0, 3 * filled), 3)))


REGIONS: Mapping[str, RegionLimits] = MappingProxyType(
    {
        "brows": _bounds(0.06, 0.15, 0.40, 0.25),
        "lids": _bounds(0.06, 0.25, 0.90, 0.10),
        "eyes": _bounds(0.11, 0.35, 1.00, 0.25),
        "nose": _bounds(0.08, 0.20, 0.65, 0.10),
        "lips": _bounds(0.09, 0.30, 0.95, 0.10),
        "mouth": _bounds(0.06, 0.22, 0.80, 0.10),
        "cheeks": _bounds(0.05, 0.14, 0.40, 0.05),
        "jaw": _bounds(0.05, 0.14, 0.40, 0.05),
        "forehead": _bounds(0.05, 0.14, 0.40, 0.05),
    }
)
"""The regions of the template shipped, with their default bounds."""


@dataclass(frozen=True)
class Limits:
    """What counts as good.

    Of a whole face, a figure up to ``tolerance`` times its limit is a warning, beyond it a failure. Regions have bounds
    of their own; one that is not named has those of ``RegionLimits()``.
    """

    median_mm: float = 0.07
    p99_mm: float = 0.30
    max_mm: float = 1.50
    filled_fraction: float = 0.10
    folded_faces: int = 0
    noise_mm: float = 0.20
    tolerance: float = 2.0
    regions: Mapping[str, RegionLimits] = field(default_factory=lambda: REGIONS)

    def __post_init__(self) -> None:
        object.__setattr__(self, "regions", MappingProxyType(dict(self.regions)))
        for name in WHOLE:
            value, largest = getattr(self, name), 1.0 if name == "filled_fraction" else LARGEST
            if not isfinite(value) or not 0 <= value <= largest:
                raise InputError(name, f"is {value:g}", f"give 0 to {largest:g}")
        if not isfinite(self.tolerance) or not 1 <= self.tolerance <= LARGEST:
            raise InputError("tolerance", f"is {self.tolerance:g}", "give 1 or more: failure comes after the warning")

    def region(self, name: str) -> RegionLimits:
        """Return the bounds of a region."""
        return self.regions.get(name, RegionLimits())

    def with_region(self, name: str, bounds: RegionLimits) -> Limits:
        """Return the same limits with other bounds for one region."""
        return replace(self, regions={**self.regions, name: bounds})

    def __reduce__(self) -> tuple[type[Limits], tuple[object, ...]]:
        # A mapping that cannot be written to cannot be sent to another process either.
        return Limits, (*(getattr(self, name) for name in WHOLE), self.tolerance, dict(self.regions))

    def __hash__(self) -> int:
        return hash((tuple(getattr(self, name) for name in WHOLE), self.tolerance, tuple(self.regions.items())))


WHOLE = ("median_mm", "p99_mm", "max_mm", "filled_fraction", "folded_faces", "noise_mm")
"""Names of a whole face's figures that have a limit."""
