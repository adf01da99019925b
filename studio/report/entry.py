"""One fitted scan as reports and plates need it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from engine.scan.fit import FaceFit
from engine.scan.quality import FitQuality, RegionQuality
from engine.scan.range_image import RangeImage


@dataclass(frozen=True)
class Origin:
    """Where a face comes from, as a report writes it: pairs of a name and a value.

    ``inputs`` say what the scan was read from, ``options`` how it was fitted, ``proof`` which fit it is.
    """

    inputs: tuple[tuple[str, str], ...] = ()
    options: tuple[tuple[str, str], ...] = ()
    proof: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, eq=False)
class ReportEntry:
    """A scan, its fiducials and the face they led to.

    Parameters
    ----------
    name : str
        The scan's name.
    word, held : str
        The word that was spoken and the letters held; empty for the base.
    scan : RangeImage
    landmarks : mapping of str to (x, y)
        Fiducials in pixels.
    scheme : str
        ``closed`` or ``open``.
    fit : FaceFit
    quality : FitQuality
    regions : tuple of RegionQuality
        Figures of the regions with their limits.
    origin : Origin
        Files, options and keys.
    note : str
        What has to be known before the figures are read, such as that the fit is stale; empty for nothing.
    """

    name: str
    word: str
    held: str
    scan: RangeImage
    landmarks: Mapping[str, tuple[float, float]]
    scheme: str
    fit: FaceFit
    quality: FitQuality
    regions: tuple[RegionQuality, ...] = ()
    origin: Origin = field(default_factory=Origin)
    note: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "landmarks", MappingProxyType({n: (float(x), float(y)) for n, (x, y) in
                                                                self.landmarks.items()}))  # fmt: skip

    @property
    def title(self) -> str:
        """The name with what is held, such as ``car (ar)``."""
        return f"{self.name} ({self.held})" if self.held else self.name


@dataclass(frozen=True)
class Absent:
    """A scan that is not in the report's pages, and why."""

    name: str
    reason: str
