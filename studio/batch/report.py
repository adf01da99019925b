"""The report of a batch: checked before the work, written from its fits, and never the loss of its figures. No Qt."""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import InputError
from engine.scan.limits import Limits
from studio.batch.job import ItemResult, ScanItem
from studio.batch.sources import project_sources, resolved, written_files
from studio.report.options import ReportOptions

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from studio.project.document import Project


@dataclass(frozen=True)
class BatchReport:
    """What became of a report: ``values`` to be printed, and the exit ``code`` that its failure asks for."""

    values: dict[str, Any] = field(default_factory=dict)
    code: int = 0


def check_report(project: Project, out: Path, items: Sequence[ScanItem], kept: Iterable[Path] = ()) -> None:
    """Raise an InputError where a report cannot be written, or would replace what the batch reads or writes."""
    from studio.report.job import check_out, sheet_path

    check_out(out)
    sources = resolved([*project_sources(project), *kept])
    faces = resolved(file for item in items if item.out is not None for file in written_files(item.out))
    for path in (out, sheet_path(out)):
        if path.resolve() in sources:
            raise InputError(str(path), "would be replaced, but the batch reads it", "choose another name")
        if path.resolve() in faces:
            raise InputError(str(path), "is also written as a face", "choose another name")


def write_report(
    project: Project,
    out: Path,
    limits: Limits,
    items: Sequence[ScanItem],
    results: Sequence[ItemResult],
    fits: Mapping[int, FaceFit],
) -> BatchReport:
    """Write the report of a project that was fitted; a failure is told in the result, so that figures are not lost.

    Parameters
    ----------
    items, results : sequences
        What was fitted and what became of it, in the same order; a scan whose item failed is named with the reason.
    fits : mapping of int to FaceFit
        The fits that were made, by the number of their item.
    """
    from studio.report.job import run, scans_of
    from studio.scan.job import input_key

    by_name = {scan.name: scan.id for scan in project.scans}
    for number, fit in fits.items():
        scan_id = by_name[items[number].name]
        project.put_fit(scan_id, input_key(project.scan(scan_id)), fit)
    errors = {result.name: result.error for result in results if result.error}
    scans = [replace(one, needs=errors.get(one.item.name, one.needs)) for one in scans_of(project)]
    options = ReportOptions(fit_missing=False)
    try:
        made = run(scans, limits, options, out, title=project.name, date=datetime.date.today())
    except (InputError, OSError) as error:
        return BatchReport({"report": [], "report_error": str(error)}, 2)
    except Exception as error:
        text = f"failed by a fault of the program: {type(error).__name__}: {error}"
        return BatchReport({"report": [], "report_error": text}, 1)
    return BatchReport({"report": made.files})
