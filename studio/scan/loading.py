"""A scan's file becomes an item of a project: read, looked over, with the fiducials that belong to it. No Qt."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from engine.files.landmarks_json import read_fiducials
from engine.landmarks import LandmarkSet
from engine.progress import Progress
from engine.scan.range_image import RangeImage
from studio.project.document import ScanItem, SourceInfo, content_key, new_id
from studio.scan import edits
from studio.scan.job import scheme_of
from studio.scan.options import FitOptions
from studio.scan.sample import SampleScan

NAME_LIMIT = 60


@dataclass(frozen=True)
class LoadedScan:
    """A scan that was read, not yet in the project."""

    item: ScanItem
    image: RangeImage
    remarks: tuple[str, ...]


def load_scan(path: Path, progress: Progress, wanted: SampleScan | None = None, unit: str | None = None) -> LoadedScan:
    """Read a range image from a file and say what is in it.

    Parameters
    ----------
    path : Path
        JSON with images, PLY or NPZ.
    progress : callable
        Takes reports; may raise ``Cancelled``.
    wanted : SampleScan, optional
        Name, word, scheme and fiducials that belong to it.
    unit : {"mm", "cm", "m"}, optional
        What its numbers mean; left out, as the file says, or else mm.

    Raises
    ------
    InputError
        When it cannot be read as a scan.
    """
    from engine.files.scan import read_scan
    from engine.scan.repair import find_spikes

    progress(0.05, f"reading {path.name}")
    file = read_scan(path, unit)
    progress(0.6, "looking for spikes")
    options = FitOptions()
    spikes = int(find_spikes(file.scan, options.spike_mm).sum())
    progress(0.8, "checking its content")
    scan = file.scan
    source = SourceInfo(str(path), file.unit, file.assumed, scan.width, scan.height, scan.missing_fraction, spikes)
    landmarks = LandmarkSet({})
    if wanted is not None and wanted.fiducials is not None:
        positions = read_fiducials(wanted.fiducials).positions
        scheme = scheme_of(wanted.scheme)
        size = scan.width, scan.height
        landmarks = edits.imported(landmarks, scheme, positions, size, str(wanted.fiducials))
    plain = "".join("_" if c in '/\\:*?"<>|' or not c.isprintable() else c for c in path.stem)[:NAME_LIMIT]
    name = wanted.name if wanted is not None else plain
    item = ScanItem(
        new_id(),
        name.strip(". ") or "scan",
        content_key(scan),
        word=wanted.word if wanted is not None else "",
        held=wanted.held if wanted is not None else "",
        source=source,
        scheme=wanted.scheme if wanted is not None else "closed",
        landmarks=landmarks,
        options=options,
    )
    return LoadedScan(item, scan, file.warnings)
