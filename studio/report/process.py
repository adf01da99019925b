"""Writes a report in a process of its own, so that no window stutters while pages are drawn. No Qt."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from engine.errors import InputError
from engine.progress import Progress
from engine.scan.limits import Limits
from studio.report.job import ReportResult, ReportScan
from studio.report.options import ReportOptions

_POLL = 0.1


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
    """Do what ``studio.report.job.run`` does, in another process.

    Raises
    ------
    InputError
        As there.
    Cancelled
        From ``progress``; the process is then stopped and no file is changed.
    RuntimeError
        When the process failed by a fault of the program, or was stopped by the system.
    """
    context = get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(there, tuple(scans), limits, options, out, title, date), daemon=True)
    progress(0.0, "starting")
    process.start()
    there.close()
    last = (0.0, "starting")
    try:
        while True:
            progress(*last)  # also while nothing comes: it may have been cancelled
            if not here.poll(_POLL):
                continue
            kind, value = here.recv()
            if kind == "progress":
                last = value
            elif kind == "done":
                result: ReportResult = value
                return result
            elif kind == "input":
                raise InputError(*value)
            else:
                raise RuntimeError(value)
    except EOFError:
        raise RuntimeError("the process that wrote the report was stopped by the system") from None
    finally:
        here.close()
        process.terminate()
        process.join()


def _work(
    there: Connection,
    scans: tuple[ReportScan, ...],
    limits: Limits,
    options: ReportOptions,
    out: Path,
    title: str,
    date: datetime.date | None,
) -> None:
    from studio.report.job import run

    def told(kind: str, value: Any) -> None:
        there.send((kind, value))

    try:
        result = run(scans, limits, options, out, lambda f, text: told("progress", (f, text)), title=title, date=date)
        told("done", result.without_entries())
    except InputError as error:
        told("input", (error.subject, error.problem, error.remedy))
    except Exception as error:
        told("fault", f"{type(error).__name__}: {error}")
