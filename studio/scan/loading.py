"""A scan's file becomes an item of a project: read, looked over, with the fiducials that belong to it. No Qt."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from engine.errors import InputError
from engine.files.landmarks_json import read_fiducials
from engine.landmarks import LandmarkSet
from engine.progress import Progress
from engine.scan.range_image import RangeImage
from studio.project.document import ScanItem, SourceInfo
from studio.project.keys import content_key, new_id
from studio.scan import edits
from studio.scan.dropped import ScanToRead
from studio.scan.job import scheme_of
from studio.scan.options import FitOptions

NAME_LIMIT = 60


@dataclass(frozen=True)
class LoadedScan:
    """A scan that was read, not yet in the project."""

    item: ScanItem
    image: RangeImage
    remarks: tuple[str, ...]


def load_scan(wanted: ScanToRead, progress: Progress, unit: str | None = None) -> LoadedScan:
    """Read a scan from a file and say what is in it.

    Parameters
    ----------
    wanted : ScanToRead
        The file, and the name, word, scheme and fiducials that belong to it.
    progress : callable
        Takes reports; may raise ``Cancelled``.
    unit : {"mm", "cm", "m"}, optional
        What its numbers mean; left out, as the file says, or else mm.

    Raises
    ------
    InputError
        When it cannot be read as a scan. Fiducials that cannot be used are left out with a remark.
    """
    from engine.files.scan import read_scan
    from engine.scan.repair import find_spikes

    path = wanted.path
    progress(0.05, f"reading {path.name}")
    file = read_scan(path, unit)
    progress(0.6, "looking for spikes")
    options = FitOptions()
    spikes = int(find_spikes(file.scan, options.spike_mm).sum())
    progress(0.8, "checking its content")
    scan = file.scan
    source = SourceInfo(str(path), file.unit, file.assumed, scan.width, scan.height, scan.missing_fraction, spikes)
    scheme, landmarks, remarks = _belonging(wanted, scan)
    item = ScanItem(
        new_id(),
        wanted.name or _plain_name(path),
        content_key(scan),
        word=wanted.word,
        held=wanted.held,
        source=source,
        scheme=scheme,
        landmarks=landmarks,
        options=options,
    )
    return LoadedScan(item, scan, (*file.warnings, *remarks))


def _belonging(wanted: ScanToRead, scan: RangeImage) -> tuple[str, LandmarkSet, tuple[str, ...]]:
    """Return scheme, fiducials and remarks: open where the fiducials have points of the inner lips."""
    if wanted.fiducials is None:
        return wanted.scheme or "closed", LandmarkSet({}), ()
    try:
        positions = read_fiducials(wanted.fiducials).positions
        inner = set(scheme_of("open").names) - set(scheme_of("closed").names)
        scheme = wanted.scheme or ("open" if inner & positions.keys() else "closed")
        size = scan.width, scan.height
        landmarks = edits.imported(LandmarkSet({}), scheme_of(scheme), positions, size, str(wanted.fiducials))
    except InputError as error:
        return wanted.scheme or "closed", LandmarkSet({}), (f"fiducials left out: {error}",)
    return scheme, landmarks, (f"{len(landmarks.points)} fiducials from {wanted.fiducials.name}",)


def _plain_name(path: Path) -> str:
    stem = path.name.split(".")[0] or path.stem
    plain = "".join("_" if c in '/\\:*?"<>|' or not c.isprintable() else c for c in stem)[:NAME_LIMIT]
    return plain.strip(". ") or "scan"
