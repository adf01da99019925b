"""Writes a report of scans in a process of its own. No Qt."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from pathlib import Path

from engine.progress import Progress
from engine.scan.limits import Limits
from studio.report.apart import apart
from studio.report.job import ReportResult, ReportScan
from studio.report.options import ReportOptions


def run_apart(
    scans: Sequence[ReportScan],
    limits: Limits,
    options: ReportOptions,
    out: Path,
    progress: Progress,
    *,
    title: str,
    date: datetime.date | None = None,
) -> ReportResult:
    """Do what ``studio.report.job.run`` does, in another process; a report that is cancelled changes no file.

    Raises
    ------
    InputError, Cancelled, RuntimeError
        As ``studio.report.apart.apart`` does.
    """
    result: ReportResult = apart(_work, (tuple(scans), limits, options, out, title, date), progress)
    return result


def _work(
    progress: Progress,
    scans: tuple[ReportScan, ...],
    limits: Limits,
    options: ReportOptions,
    out: Path,
    title: str,
    date: datetime.date | None,
) -> ReportResult:
    from studio.report.job import run

    return run(scans, limits, options, out, progress, title=title, date=date).without_entries()
