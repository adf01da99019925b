"""``quasiface batch``: reads arguments, runs the items, prints figures. No Qt."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from studio.output import Json, print_result, print_table, remark

if TYPE_CHECKING:
    from engine.scan.limits import Limits
    from studio.batch.job import ItemResult
    from studio.batch.options import FileItem
    from studio.batch.record import BatchRecord

Workers = Annotated[int, Parameter(validator=Number(gte=1, lte=64))]


def batch(
    jobs: Path,
    /,
    *,
    workers: Workers = 1,
    resume: bool = False,
    out: Path | None = None,
    format: Literal["glb", "obj"] = "glb",
    pattern: str = "{name}",
    limits: Path | None = None,
    report: Path | None = None,
    as_json: Json = False,
) -> int:
    """Fit many scans: those of a jobs file (.toml), or all of a project (.qface).

    Parameters
    ----------
    jobs : Path
        A jobs file with stage = "scan", [options] and [[item]], or a project.
    workers : int
        How many processes work at a time; fewer where memory is short.
    resume : bool
        Leave out items of a jobs file that are done: same inputs, files as they were written.
    out : Path
        Folder for the faces of a project.
    format : str
        What the faces of a project are written as.
    pattern : str
        Names of a project's faces: {name}, {number}, {word}, {held}.
    limits : Path
        What the figures are judged by (TOML); else what the jobs file names or the project keeps.
    report : Path
        A report of a project's scans (.pdf).
    """
    from engine.files.limits import read_limits
    from engine.scan.limits import Limits
    from studio.batch.options import read_jobs
    from studio.batch.record import BatchRecord

    judged = read_limits(limits) if limits is not None else None
    if jobs.suffix.lower() == ".qface":
        return _project(jobs, workers, out, format, pattern, judged, report, as_json)
    _refuse(jobs, out=out, report=report)
    asked = read_jobs(jobs, keep=() if limits is None else (limits,))
    if judged is None:
        judged = read_limits(asked.limits) if asked.limits is not None else Limits()
    return _run(asked.items, judged, workers, BatchRecord(jobs), resume, as_json)


def _refuse(jobs: Path, **given: Path | None) -> None:
    from engine.errors import InputError

    for name, value in given.items():
        if value is not None:
            problem = "is for projects; a jobs file names the file of every item"
            raise InputError(f"--{name}", problem, f"leave it out, or give a project instead of {jobs.name}")


def _run(
    items: Sequence[FileItem],
    limits: Limits,
    workers: int,
    record: BatchRecord,
    resume: bool,
    as_json: bool,
) -> int:
    from studio.batch.runner import run_items, workers_for

    results: dict[int, ItemResult] = {}
    todo: list[int] = []
    for number, item in enumerate(items):
        done = record.finished(item) if resume else None
        if done is None:
            todo.append(number)
        else:
            results[number] = done
    told = _Teller(len(items), len(results))

    def take(place: int, result: ItemResult) -> None:
        number = todo[place]
        results[number] = result
        told(result)
        if result.state == "done":
            record.add(items[number], result)

    count = workers_for(workers, len(todo))
    try:
        run_items([items[number] for number in todo], limits, workers=count, told=take)
    finally:
        if any(result.state == "done" for result in results.values()):
            record.save()
    return _print([results[number] for number in range(len(items))], count, as_json)


def _project(
    path: Path,
    workers: int,
    out: Path | None,
    ending: str,
    pattern: str,
    limits: Limits | None,
    report: Path | None,
    as_json: bool,
) -> int:
    import datetime

    from engine.errors import InputError
    from studio.batch.project import project_items
    from studio.batch.runner import run_items, workers_for
    from studio.project import store

    if out is None:
        raise InputError("--out", "is missing", "name the folder that the faces of a project go to")
    project = store.load(path)
    judged = limits or project.limits
    items, left_out = project_items(project, out, ending, pattern)
    told = _Teller(len(items), 0)
    count = workers_for(workers, len(items))
    results: list[ItemResult] = run_items(items, judged, workers=count, told=lambda _number, result: told(result))
    files: dict[str, Any] = {}
    if report is not None:
        from studio.report.job import run, scans_of
        from studio.report.options import ReportOptions

        made = run(scans_of(project), judged, ReportOptions(), report, title=project.name, date=datetime.date.today())
        files["report"] = made.files
    return _print([*results, *left_out], count, as_json, files)


class _Teller:
    """Says on stderr what became of every item, as it comes."""

    def __init__(self, count: int, done: int) -> None:
        self._count, self._done = count, done

    def __call__(self, result: ItemResult) -> None:
        """Print one line."""
        self._done += 1
        said = result.error or f"{result.figures['verdict']}, median {result.figures['median_mm']:.3f} mm"
        remark(f"{self._done}/{self._count}  {result.name}: {said}")


def _print(results: Sequence[ItemResult], workers: int, as_json: bool, more: dict[str, Any] | None = None) -> int:
    rows: list[dict[str, Any]] = []
    for result in results:
        row: dict[str, Any] = {"name": result.name, "state": result.state}
        if result.error:
            row["error"] = result.error
        else:
            row |= {"files": result.files, "seconds": round(result.seconds, 3), **result.figures}
        rows.append(row)
    done = sum("error" not in row for row in rows)
    if as_json:
        summary = {"stage": "scan", "done": done, "failed": len(rows) - done, "workers": workers}
        print_result(summary | {"items": rows} | (more or {}), True)
    else:
        columns = ("name", "state", "verdict", "worst_region", "median_mm", "p99_mm", "filled_fraction", "seconds")
        print_table(columns, [[row.get(name) for name in columns] for row in rows])
    if done == len(rows):
        return 0
    return 1 if any(result.own_fault for result in results) else 2
