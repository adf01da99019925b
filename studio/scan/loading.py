"""A scan's file becomes an item of a project: read, looked over, with the fiducials that belong to it. No Qt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from engine.errors import InputError
from engine.landmarks import LandmarkSet
from engine.progress import Progress
from engine.scan.range_image import RangeImage
from studio.project.document import ScanItem, SourceInfo
from studio.project.keys import content_key, new_id
from studio.scan import edits
from studio.scan.dropped import ScanToRead
from studio.scan.fiducial_files import fiducials_from
from studio.scan.job import scheme_of, template_of
from studio.scan.options import FitOptions

if TYPE_CHECKING:
    from engine.files.scan_file import ScanFile
    from engine.scan.mesh_view import MeshView

NAME_LIMIT = 60


@dataclass(frozen=True)
class LoadedScan:
    """A scan that was read, not yet in the project."""

    item: ScanItem
    image: RangeImage
    remarks: tuple[str, ...]


def load_scan(
    wanted: ScanToRead, progress: Progress, unit: str | None = None, view: MeshView | None = None
) -> LoadedScan:
    """Read a scan from a file and say what is in it.

    Parameters
    ----------
    wanted : ScanToRead
        The file, and the name, word, scheme and fiducials that belong to it.
    progress : callable
        Takes reports; may raise ``Cancelled``.
    unit : {"mm", "cm", "m"}, optional
        What its numbers mean; left out, as the file says, or else mm.
    view : MeshView, optional
        Where the camera stands before a mesh; left out, it is placed automatically.

    Raises
    ------
    InputError
        When it cannot be read as a scan. Fiducials that cannot be used are left out with a remark.
    """
    from engine.files.scan import read_scan
    from engine.scan.repair import find_spikes

    path = wanted.path
    progress(0.05, f"reading {path.name}")
    file = read_scan(path, unit, view)
    progress(0.6, "looking for spikes")
    options = FitOptions()
    spikes = int(find_spikes(file.scan, options.spike_mm).sum())
    progress(0.8, "checking its content")
    scan = file.scan
    source = SourceInfo(
        str(path), file.unit, file.assumed, scan.width, scan.height, scan.missing_fraction, spikes, file.view
    )
    scheme, landmarks, remarks = _belonging(wanted, file)
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
    told = (file.assumed,) if file.view is not None and source.unit_open and unit is None else ()
    return LoadedScan(item, scan, (*told, *file.warnings, *remarks))


def _belonging(wanted: ScanToRead, file: ScanFile) -> tuple[str, LandmarkSet, tuple[str, ...]]:
    """Return scheme, fiducials and remarks; left to the fiducials, the scheme is that of the mouth they show."""
    if wanted.fiducials is None:
        return wanted.scheme or "closed", LandmarkSet({}), ()
    scan, path = file.scan, wanted.fiducials
    try:
        size, scheme = (scan.width, scan.height), wanted.scheme or "open"
        positions, remarks = fiducials_from(path, scheme, size, scan, view=file.view, unit=file.unit)
        scheme = wanted.scheme or _scheme_for(scan, positions, named=path.suffix.lower() == ".json")
        landmarks = edits.imported(LandmarkSet({}), scheme_of(scheme), positions, size, str(path))
        landmarks = edits.with_proposals(LandmarkSet({}), landmarks, scheme_of(scheme), size, _propose(scheme))
    except InputError as error:
        return wanted.scheme or "closed", LandmarkSet({}), (f"fiducials left out: {error}",)
    return scheme, landmarks, tuple(remark for remark in remarks if "outside" in remark)


def _propose(scheme: str) -> edits.Propose:
    from engine.scan.warp import propose_fiducials

    return lambda known: propose_fiducials(template_of(), scheme, known)


def _scheme_for(scan: RangeImage, positions: Mapping[str, tuple[float, float]], named: bool) -> str:
    """Return open where there are points of the inner lips, and, unless they were named so, the mouth is open."""
    from engine.scan.mouth import INNER_FRACTIONS, find_opening

    inner = any(name in positions for name in INNER_FRACTIONS)
    return "open" if inner and (named or find_opening(scan, positions) is not None) else "closed"


def _plain_name(path: Path) -> str:
    stem = path.name.split(".")[0] or path.stem
    plain = "".join("_" if c in '/\\:*?"<>|' or not c.isprintable() else c for c in stem)[:NAME_LIMIT]
    return plain.strip(". ") or "scan"
