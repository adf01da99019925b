"""A PDF report of fitted scans: an overview to judge by, then a page for every scan."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import matplotlib as mpl
from matplotlib.backends.backend_pdf import PdfPages

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.progress import Progress, part, silent
from engine.scan.quality import Limits
from engine.scan.regions import FaceRegions, regions_of
from studio.report.drawing import settings
from studio.report.entry import Absent, ReportEntry
from studio.report.overview import overview_pages
from studio.report.scan_page import STILL, FacePictures, face_pictures, scan_page
from widgets.scene.heatmap import HeatRange
from widgets.scene.stills import Stills

DPI = 200
"""Of pictures on a page."""


def write_report(
    path: str | Path,
    entries: Sequence[ReportEntry],
    *,
    title: str = "Scans fitted to the template",
    limits: Limits | None = None,
    heat: HeatRange | None = None,
    absent: Sequence[Absent] = (),
    regions: FaceRegions | None = None,
    date: datetime.date | None = None,
    sheet: str | Path | None = None,
    progress: Progress = silent,
) -> Path:
    """Write a PDF report and return its path.

    The overview has every scan in a line, with its worst region, its figures and a verdict for each region, and all
    faces side by side. Every scan then has a page: picture, range image and regions; the face textured and shaded from
    three sides; its distance to the scan with a colour bar; the regions against their limits; what it was made from.
    Text is text, pictures are embedded, and every verdict is a word and a sign, so that it reads in grey.

    Parameters
    ----------
    path : path
        The PDF; written whole or not at all.
    entries : sequence of ReportEntry
    title : str
        Headline of the first page.
    limits : Limits, optional
        What the figures are judged by.
    heat : HeatRange, optional
        Range of the distance pictures in mm, the same for all of them.
    absent : sequence of Absent
        Scans that are named with the reason why they have no page.
    regions : FaceRegions, optional
        Those of the template that the faces were fitted with; by default of the template shipped.
    date : date, optional
        Stands at the foot of every page.
    sheet : path, optional
        A PNG beside it with all faces and their verdicts, for lists and chats.
    progress : callable
        ``progress(fraction, text)``.

    Raises
    ------
    InputError
        Without entries, or where a file cannot be written.
    """
    if not entries:
        raise InputError("report", "there is no fitted scan", "fit one first")
    heat, limits, path = heat or HeatRange(), limits or Limits(), Path(path)
    if regions is None:
        from studio.scan.job import template_of

        regions = regions_of(template_of())
    pictures = _pictures(entries, heat, part(progress, 0.0, 0.4))
    _make_folder(path)
    with mpl.rc_context(settings()):
        line = _line(entries, date)
        first = overview_pages(entries, absent, pictures, title, line, limits, heat)
        count = len(first) + len(entries)
        foot = f"{program()}, {date.isoformat()}" if date is not None else program()
        meta = {"Title": title, "Creator": program(), "CreationDate": None}
        with atomic_write(path) as handle, PdfPages(handle, metadata=meta) as pdf:
            for number in range(count):
                scan = number - len(first)
                page = first[number] if scan < 0 else scan_page(entries[scan], pictures[scan], regions, limits, heat)
                page.foot(foot if scan < 0 else f"{foot}, {title}", number + 1, count)
                pdf.savefig(page.figure, dpi=DPI)
                progress(0.4 + 0.55 * (number + 1) / count, f"writing page {number + 1} of {count}")
        if sheet is not None:
            from studio.report.contact_sheet import write_contact_sheet

            write_contact_sheet(sheet, entries, pictures, limits, heat)
    progress(1.0, "wrote the report")
    return path


def program() -> str:
    """Return the program's name and version."""
    try:
        return f"Quasiface Studio {version('quasiface-studio')}"
    except PackageNotFoundError:
        return "Quasiface Studio"


def _pictures(entries: Sequence[ReportEntry], heat: HeatRange, progress: Progress) -> list[FacePictures]:
    taken = []
    with Stills(*STILL) as stills:
        for number, entry in enumerate(entries):
            progress(number / len(entries), f"picturing {entry.name}")
            taken.append(face_pictures(stills, entry, heat))
    return taken


def _make_folder(path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(str(path), f"cannot be written ({error.strerror})", "choose another place") from None


def _line(entries: Sequence[ReportEntry], date: datetime.date | None) -> str:
    schemes = sorted({entry.scheme for entry in entries})
    levels = sorted({entry.fit.levels for entry in entries})
    when = f"{date.isoformat()}    " if date is not None else ""
    count = f"{len(entries)} scan{'s' if len(entries) > 1 else ''}"
    return f"{when}{count}, scheme {', '.join(schemes)}, level {', '.join(map(str, levels))}    lengths in mm"
