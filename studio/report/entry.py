"""What a report and the plates are made from: one scan with its face and figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from engine.scan.fit import FaceFit
from engine.scan.quality import FitQuality
from engine.scan.range_image import RangeImage


@dataclass(frozen=True, eq=False)
class ReportEntry:
    """One scan and what was made of it.

    Parameters
    ----------
    name : str
        What the scan is called.
    word, held : str
        The word that was spoken and its letters that were held; both empty for the base face.
    scan : RangeImage
        As it was read, mm.
    landmarks : mapping of str to (x, y)
        The fiducials that were used, pixels.
    scheme : str
        ``closed`` or ``open``.
    fit : FaceFit
        The face.
    quality : FitQuality
        Its figures.
    """

    name: str
    word: str
    held: str
    scan: RangeImage
    landmarks: Mapping[str, tuple[float, float]]
    scheme: str
    fit: FaceFit
    quality: FitQuality
