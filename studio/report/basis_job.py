"""A basis becomes a PDF report: the job that window and command line run alike. No Qt."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import InputError
from engine.files.atomic import check_writable
from engine.progress import Progress, silent

if TYPE_CHECKING:
    from studio.basis.job import BasisInputs, BasisResult
    from studio.basis.options import BasisOptions
    from studio.report.basis_entry import BasisEntry


def check_report(out: Path) -> None:
    """Raise an InputError where a report clearly cannot be written to ``out``: its ending, its folder."""
    if out.suffix.lower() != ".pdf":
        raise InputError(str(out), "has no ending of a report", "end it in .pdf")
    check_writable(out)


def write_basis_report(
    out: Path,
    inputs: BasisInputs,
    options: BasisOptions,
    result: BasisResult,
    *,
    files: Mapping[str, Path] | None = None,
    progress: Progress = silent,
    **more: Any,
) -> tuple[Path, ...]:
    """Write the report of a result and return the files written; ``more`` goes to ``basis_entry.entry_of``.

    Raises
    ------
    InputError
        When the report cannot be written, or an input file cannot be read.
    """
    from studio.report.basis_entry import entry_of

    check_report(out)
    return write_pages(progress, entry_of(inputs, options, result, files=files, **more), out)


def write_apart(entry: BasisEntry, out: Path, progress: Progress) -> tuple[Path, ...]:
    """Write the pages in a process of its own, for the window; a report that is cancelled changes no file.

    Raises
    ------
    InputError, Cancelled, RuntimeError
        As ``studio.report.apart.apart`` does.
    """
    from studio.report.apart import apart

    check_report(out)
    files: tuple[Path, ...] = apart(write_pages, (entry, out, datetime.date.today()), progress)
    return files


def write_pages(
    progress: Progress, entry: BasisEntry, out: Path, date: datetime.date | None = None
) -> tuple[Path, ...]:
    """Draw and write every page; the PDF is written whole or not at all.

    Raises
    ------
    InputError
        When it cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_pdf import PdfPages

    from engine.files.atomic import atomic_write
    from studio.report.basis_pages import pages_of
    from studio.report.drawing import settings
    from studio.report.pages import DPI, program

    with mpl.rc_context(settings()):
        pages = pages_of(entry, progress)
        foot = f"{program()}, {date.isoformat()}" if date is not None else program()
        meta = {"Title": entry.title, "Creator": program(), "CreationDate": None}
        with atomic_write(out) as handle, PdfPages(handle, metadata=meta) as pdf:
            for number, page in enumerate(pages, 1):
                page.foot(f"{foot}, {entry.title}", number, len(pages))
                pdf.savefig(page.figure, dpi=DPI)
                progress(0.7 + 0.3 * number / len(pages), f"writing page {number} of {len(pages)}")
    return (out,)
