"""``quasiface batch``: reads arguments, runs the items, prints figures. No Qt."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn

from cyclopts import Parameter
from cyclopts.validators import Number

from studio.output import Json, print_result, print_table, remark

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
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
    format: Literal["glb", "obj"] | None = None,
    pattern: str | None = None,
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
        What the faces of a project are written as; glb where it is left out.
    pattern : str
        Names of a project's faces: {name}, {number}, {word}, {held}; "{name}" where it is left out.
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
        if resume:
            _refuse("resume", "is for jobs files", "leave it out: fits that a project keeps are not made again")
        kept = () if limits is None else (limits,)
        return _project(jobs, workers, out, format or "glb", pattern or "{name}", judged, report, as_json, kept)
    for name, value in {"out": out, "report": report, "format": format, "pattern": pattern}.items():
        if value is not None:
            problem = "is for projects; a jobs file names the file of every item"
            _refuse(name, problem, f"leave it out, or give a project instead of {jobs.name}")
    asked = read_jobs(jobs, keep=() if limits is None else (limits,))
    if judged is None:
        judged = read_limits(asked.limits) if asked.limits is not None else Limits()
    return _run(asked.items, judged, workers, BatchRecord(jobs), resume, as_json)


def _refuse(name: str, problem: str, remedy: str) -> NoReturn:
    from engine.errors import InputError

    raise InputError(f"--{name}", problem, remedy)


def _workers(asked: int, items: int) -> int:
    """Return how many workers there will be, and say so where they are fewer than asked."""
    from studio.batch.runner import workers_for

    count = workers_for(asked, items)
    if count < min(asked, items):
        remark(f"{count} of {asked} workers: free memory has no room for more")
    elif count < asked:
        remark(f"{count} of {asked} workers: there {'is 1 item' if items == 1 else f'are {items} items'} to do")
    return count


def _run(
    items: Sequence[FileItem],
    limits: Limits,
    workers: int,
    record: BatchRecord,
    resume: bool,
    as_json: bool,
) -> int:
    from studio.batch.runner import run_items

    results: dict[int, ItemResult] = {}
    todo: list[int] = []
    for number, item in enumerate(items):
        done = record.finished(item, limits) if resume else None
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

    count = _workers(workers, len(todo))
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
    kept: Sequence[Path],
) -> int:
    from studio.batch.project import project_items
    from studio.batch.report import check_report, write_report
    from studio.batch.runner import run_items
    from studio.project import store

    if out is None:
        _refuse("out", "is missing", "name the folder that the faces of a project go to")
    project = store.load(path)
    judged = limits or project.limits
    items, left_out = project_items(project, out, ending, pattern, kept)
    if report is not None:
        check_report(project, report, items, kept)
    told = _Teller(len(items), 0)
    count = _workers(workers, len(items))
    fits: dict[int, FaceFit] = {}
    results = run_items(
        items,
        judged,
        workers=count,
        told=lambda _number, result: told(result),
        keep=None if report is None else fits.__setitem__,
    )
    results += left_out
    if report is None:
        return _print(results, count, as_json)
    made = write_report(project, report, judged, items, results, fits)
    return max(_print(results, count, as_json, made.values), made.code, key=(0, 2, 1).index)


_RESERVED = ("name", "state", "error", "files", "seconds")
"""What an item's row says beside its figures."""


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
            row |= {"files": result.files, "seconds": round(result.seconds, 3)}
            row |= {name: value for name, value in result.figures.items() if name not in _RESERVED}
        rows.append(row)
    done = sum(not result.error for result in results)
    if as_json:
        summary = {"stage": "scan", "done": done, "failed": len(rows) - done, "workers": workers}
        print_result(summary | {"items": rows} | (more or {}), True)
    else:
        columns = ("name", "state", "verdict", "worst_region", "median_mm", "p99_mm", "filled_fraction", "seconds")
        print_table(columns, [[row.get(name) for name in columns] for row in rows])
        if more and more.get("report_error"):
            remark(f"no report: {more['report_error']}")
    if done == len(rows):
        return 0
    return 1 if any(result.own_fault for result in results) else 2
