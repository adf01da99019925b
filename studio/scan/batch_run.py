"""The fitting of many scans: a task each, and a report at the end, whether or not a dialog watches."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from engine.errors import InputError
from engine.progress import Progress
from studio.batch.job import ItemResult, ScanItem, attempt
from studio.batch.project import project_items
from studio.project.document import Change
from studio.scan.commands import SetOptions
from studio.scan.job import input_key
from studio.scan.options import FitOptions
from studio.tasks import Task, TaskState

if TYPE_CHECKING:
    from collections.abc import Callable

    from engine.scan.fit import FaceFit
    from studio.session import Session


@dataclass(frozen=True)
class BatchRequest:
    """What is to be fitted and written.

    Parameters
    ----------
    scans : tuple of str
        Ids.
    level : int or None
        Subdivision for all of them; None leaves each its own.
    folder : Path or None
        Where the faces go; None writes none.
    ending, pattern : str
        Format and names of the faces.
    report : Path or None
        Written once all are fitted.
    """

    scans: tuple[str, ...]
    level: int | None = None
    folder: Path | None = None
    ending: str = "glb"
    pattern: str = "{name}"
    report: Path | None = None


class BatchRun(QObject):
    """Fits scans of the open project as tasks; dialogs come and go, the run stays.

    Parameters
    ----------
    session : Session
        Project, undo stack and tasks.
    write_report : callable
        Starts writing a report to a path.

    Signals
    -------
    moved(str)
        The task of a scan (id) came forward or ended.
    ended(str)
        No scan is being fitted any more; what became of them, in words.
    """

    moved = Signal(str)
    ended = Signal(str)

    def __init__(self, session: Session, write_report: Callable[[Path], object], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._session, self._write_report = session, write_report
        self._tasks: dict[str, Task] = {}
        self._results: dict[str, ItemResult] = {}
        self._report: Path | None = None
        self._begun = False
        session.tasks.changed.connect(self._on_task)
        session.changed.connect(self._on_change)
        session.replaced.connect(self._forget)

    @property
    def running(self) -> bool:
        """Whether scans are being fitted."""
        return any(task.active for task in self._tasks.values())

    @property
    def fraction(self) -> float:
        """How far all of it is, 0..1."""
        shares = [task.fraction if task.active else 1.0 for task in self._tasks.values()]
        return sum(shares) / max(len(shares), 1)

    def task(self, scan_id: str) -> Task | None:
        """Return the task that a scan has, or had since it last changed."""
        return self._tasks.get(scan_id)

    def result(self, scan_id: str) -> ItemResult | None:
        """Return what became of a scan, as long as it is as it was then."""
        return self._results.get(scan_id)

    def start(self, request: BatchRequest) -> None:
        """Begin; does nothing while it runs.

        Raises
        ------
        InputError
            When the names of the faces are wrong, or no scan is ready; nothing has changed then.
        """
        if self.running:
            return
        project = self._session.project
        files = request.folder, request.ending, request.pattern
        ready = {item.name for item in project_items(project, *files)[0]}
        chosen = [i for i in request.scans if i in project and project.scan(i).name in ready]
        if not chosen:
            raise InputError("batch", "no scan that is ticked is ready", "finish the fiducials of one")
        self._set_level(chosen, request.level)
        by_name = {item.name: item for item in project_items(project, *files)[0]}  # anew: with that level
        self._results.clear()
        self._tasks.clear()
        self._report, self._begun = request.report, True
        for scan_id in chosen:
            scan = project.scan(scan_id)
            self._tasks[scan_id] = self._submit(scan_id, input_key(scan), by_name[scan.name])

    def stop(self) -> None:
        """Stop what has not been done yet; what is written stays."""
        for task in [task for task in self._tasks.values() if task.active]:
            self._session.tasks.cancel(task)

    def _set_level(self, chosen: list[str], level: int | None) -> None:
        project, stack = self._session.project, self._session.stack
        others = [i for i in chosen if level is not None and project.scan(i).options.levels != level]
        if not others:
            return
        stack.beginMacro(f"Use level {level} on {len(others)} scans")
        try:
            for scan_id in others:
                options: FitOptions = project.scan(scan_id).options.model_copy(update={"levels": level})
                stack.push(SetOptions(project, scan_id, options))
        finally:
            stack.endMacro()

    def _submit(self, scan_id: str, key: str, item: ScanItem) -> Task:
        project, limits = self._session.project, self._session.project.limits

        def work(progress: Progress) -> tuple[ItemResult, FaceFit | None]:
            return attempt(item, limits, progress)

        def done(outcome: tuple[ItemResult, FaceFit | None]) -> None:
            self._results[scan_id], fit = outcome
            if fit is not None and item.fit is None:
                project.put_fit(scan_id, key, fit)
            self._ended(scan_id)

        def failed(_error: BaseException) -> None:
            """It has been noted with its task, as for what is no fault of the input."""

        title = f"Fitting “{item.name}”"
        return self._session.tasks.submit(title, work, done, failed=failed, key=f"batch {scan_id}")

    def _on_task(self, task: Any) -> None:
        scan_id = next((i for i, other in self._tasks.items() if other is task), None)
        if scan_id is None:
            return
        if task.state is TaskState.FAILED:
            self._results[scan_id] = ItemResult(task.title, "failed", error=task.error)
        if task.state in (TaskState.FAILED, TaskState.CANCELLED):
            self._ended(scan_id)
        else:
            self.moved.emit(scan_id)

    def _ended(self, scan_id: str) -> None:
        self.moved.emit(scan_id)
        if self.running or not self._begun:
            return
        self._begun = False
        failed = sum(bool(result.error) for result in self._results.values())
        stopped = sum(task.state is TaskState.CANCELLED for task in self._tasks.values())
        done = len(self._results) - failed
        told = f"{done} fitted"
        told += f", {failed} failed: see the table" if failed else ""
        told += f", {stopped} stopped" if stopped else ""
        report, self._report = self._report, None
        self.ended.emit(told)
        if report is not None and done and not stopped:
            self._write_report(report)

    def _on_change(self, change: Change) -> None:
        if change.kind in ("landmarks", "options", "scheme", "source") and not self._begun:
            self._results.pop(change.id, None)
            self._tasks.pop(change.id, None)

    def _forget(self) -> None:
        self._results.clear()
        self._tasks.clear()
        self._report, self._begun = None, False
