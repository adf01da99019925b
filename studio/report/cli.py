"""``quasiface report``: reads arguments, runs the job, prints figures. No Qt."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from studio.output import Json, print_result, print_table, progress_lines, remark
from studio.report.options import ReportOptions

_OPTIONS = ReportOptions()


def report(
    project: Path,
    /,
    *,
    out: Path,
    limits: Path | None = None,
    options: Annotated[ReportOptions, Parameter(name="*")] = _OPTIONS,
    as_json: Json = False,
) -> int:
    """Write a PDF report of a project's scans: an overview, and a page for every scan.

    Parameters
    ----------
    project : Path
        A project file (.qface); it is not changed.
    out : Path
        The report (.pdf).
    limits : Path
        What the figures are judged by (TOML); by default the limits kept in the project.
    """
    import datetime

    from engine.errors import InputError
    from engine.files.limits import read_limits
    from studio.project import store
    from studio.report.job import figures, run, scans_of, sheet_path

    judged = read_limits(limits) if limits is not None else None
    opened = store.load(project)
    sources = {path.resolve() for path in (project, limits) if path is not None}
    for path in (out, *((sheet_path(out),) if options.contact_sheet else ())):
        if path.resolve() in sources:
            raise InputError(str(path), "would be replaced, but the report is made from it", "choose another name")
    judged = judged or opened.limits
    result = run(
        scans_of(opened), judged, options, out, progress_lines(), title=opened.name, date=datetime.date.today()
    )
    found = figures(result, judged)
    if as_json:
        print_result({"project": project, **found}, True)
        return 0
    columns = ("name", "verdict", "worst_region")
    print_table(("scan", "verdict", "worst region"), [[row[name] for name in columns] for row in found["scans"]])
    for scan in result.absent:
        remark(f"{scan.name}: {scan.reason}; it has no page")
    print_result({"files": result.files}, False)
    return 0
