"""One fitted scan as reports and plates need it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from engine.scan.fit import FaceFit
from engine.scan.quality import FitQuality
from engine.scan.range_image import RangeImage


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
    """

    name: str
    word: str
    held: str
    scan: RangeImage
    landmarks: Mapping[str, tuple[float, float]]
    scheme: str
    fit: FaceFit
    quality: FitQuality

    def __post_init__(self) -> None:
        object.__setattr__(self, "landmarks", MappingProxyType({n: (float(x), float(y)) for n, (x, y) in
                                                                self.landmarks.items()}))  # fmt: skip

    @property
    def title(self) -> str:
        """The name with what is held, such as ``car (ar)``."""
        return f"{self.name} ({self.held})" if self.held else self.name
