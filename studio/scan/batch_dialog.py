"""The dialog of a batch: a task for every scan, so that the window and its task list stay usable meanwhile."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QDialog, QFileDialog, QVBoxLayout, QWidget

from engine.errors import InputError
from engine.progress import Progress
from studio import dialogs
from studio.batch.job import ItemResult, ScanItem, attempt
from studio.batch.project import face_names, project_items
from studio.project.document import Change, needs
from studio.scan.commands import SetOptions
from studio.scan.job import input_key
from studio.scan.options import FitOptions
from studio.tasks import Task, TaskState, describe
from widgets import theme
from widgets.scan.batch_panel import BatchPanel, BatchRow

if TYPE_CHECKING:
    from collections.abc import Callable

    from engine.scan.fit import FaceFit
    from studio.session import Session

WIDTH, HEIGHT = 680, 620
REPORT_FILTER = "Report (*.pdf)"


class BatchDialog(QDialog):
    """Fits the scans of a project one by one, beside the window.

    Parameters
    ----------
    session : Session
        Project, undo stack and tasks.
    write_report : callable
        Starts writing a report to a path.
    """

    def __init__(self, session: Session, write_report: Callable[[Path], object], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("batch")
        self.setWindowTitle("Fit all scans")
        self.setWindowModality(Qt.WindowModality.NonModal)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._session, self._write_report = session, write_report
        self._tasks: dict[str, Task] = {}
        self._results: dict[str, ItemResult] = {}
        self._report: Path | None = None
        self.panel = BatchPanel(self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        self.panel.changed.connect(self._refresh)
        self.panel.folder_requested.connect(self._ask_folder)
        self.panel.report_requested.connect(self._ask_report)
        self.panel.started.connect(self.start)
        self.panel.cancelled.connect(self.stop)
        self.panel.closed.connect(self.reject)
        session.tasks.changed.connect(self._on_task)
        session.changed.connect(self._on_change)
        session.replaced.connect(self.reject)
        theme.signals.changed.connect(self._list)
        self._list()
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))

    @property
    def running(self) -> bool:
        """Whether scans are being fitted."""
        return any(task.active for task in self._tasks.values())

    # -- what is shown ------------------------------------------------------------------------------------------------

    def _list(self) -> None:
        self.panel.set_rows([self._row(item.id) for item in self._session.project.scans])
        self._refresh()

    def _row(self, scan_id: str) -> BatchRow:
        project = self._session.project
        item = project.scan(scan_id)
        state, needed, result = project.state(scan_id), needs(item), self._results.get(scan_id)
        row = BatchRow(scan_id, item.name, needed or state.reason or "fit fresh", not needed)
        task = self._tasks.get(scan_id)
        if task is not None and task.active:
            waits = task.state is TaskState.WAITING
            return replace(row, text="waiting" if waits else f"{100 * task.fraction:.0f} %  {task.text}")
        if task is not None and task.state is TaskState.CANCELLED:
            return replace(row, text="stopped")
        if result is None:
            return row
        if result.error:
            return replace(row, text=result.error)
        worst = result.figures.get("worst_region")
        wrote = f", wrote {result.files[0].name}" if result.files else ""
        text = f"median {result.figures['median_mm']:.3f} mm, worst {worst}{wrote}"
        return replace(row, text=text, verdict=str(result.figures["verdict"]))

    def _refresh(self) -> None:
        if self.running:
            return
        chosen, folder, problem = self.panel.chosen(), self._folder(), ""
        if folder is not None:
            try:
                names = face_names(self._session.project.scans, self.panel.pattern.text())
            except InputError as error:
                problem = str(error)
            else:
                there = [folder / f"{names[i]}.{self.panel.format.currentText()}" for i in chosen]
                count = sum(path.exists() for path in there)
                self.panel.show_note(f"{count} faces in the folder are replaced" if count else "")
        if not chosen:
            problem = "Tick a scan whose fiducials are ready."
        report = self._report_path()
        if report is not None and report.suffix.lower() != ".pdf":
            problem = f"{report}: has no ending of a report; end it in .pdf"
        if problem or folder is None:
            self.panel.show_note(problem, trouble=bool(problem))
        self.panel.command.set_command(*self._command(folder, report))

    def _command(self, folder: Path | None, report: Path | None) -> tuple[list[str], str]:
        project = self._session.project
        if project.path is None or self._session.is_dirty:
            return [], "save the project first: the command reads its file"
        if folder is None:
            return [], "choose a folder for the faces"
        words = ["quasiface", "batch", str(project.path), "--out", str(folder)]
        if self.panel.format.currentText() != "glb":
            words += ["--format", self.panel.format.currentText()]
        if self.panel.pattern.text() != "{name}":
            words += ["--pattern", self.panel.pattern.text()]
        return words + (["--report", str(report)] if report is not None else []), ""

    def _folder(self) -> Path | None:
        text = self.panel.folder.text().strip()
        return Path(text).expanduser() if text else None

    def _report_path(self) -> Path | None:
        text = self.panel.report.text().strip()
        return Path(text).expanduser() if text else None

    def _ask_folder(self) -> None:
        start = self.panel.folder.text() or str(self._session.settings["files/folder"])
        chosen = QFileDialog.getExistingDirectory(self, "Folder for the faces", start)
        if chosen:
            self.panel.folder.setText(chosen)

    def _ask_report(self) -> None:
        name = f"{self._session.project.name}.pdf"
        path = dialogs.save_file(self, self._session.settings, "Write report", name, REPORT_FILTER)
        if path is not None:
            self.panel.report.setText(str(path))

    # -- running ------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Fit the scans that are ticked, and write their faces."""
        chosen, project = self.panel.chosen(), self._session.project
        self._set_level(chosen)
        try:
            items, _ = project_items(
                project, self._folder(), self.panel.format.currentText(), self.panel.pattern.text()
            )
        except InputError as error:
            self.panel.show_note(str(error), trouble=True)
            return
        by_name = {item.name: item for item in items}
        self._results.clear()
        self._report = self._report_path()
        for scan_id in chosen:
            scan = project.scan(scan_id)
            if scan.name in by_name:
                self._tasks[scan_id] = self._submit(scan_id, input_key(scan), by_name[scan.name])
        self.panel.set_running(True)
        self._show_all()

    def _set_level(self, chosen: tuple[str, ...]) -> None:
        level, project, stack = self.panel.level.currentData(), self._session.project, self._session.stack
        if level is None or level < 0:
            return
        others = [i for i in chosen if project.scan(i).options.levels != level]
        if others:
            stack.beginMacro(f"Use level {level} on {len(others)} scans")
            for scan_id in others:
                options: FitOptions = project.scan(scan_id).options.model_copy(update={"levels": level})
                stack.push(SetOptions(project, scan_id, options))
            stack.endMacro()

    def _submit(self, scan_id: str, key: str, item: ScanItem) -> Task:
        project, limits = self._session.project, self._session.project.limits

        def work(progress: Progress) -> tuple[ItemResult, FaceFit | None]:
            return attempt(item, limits, progress)

        def done(outcome: tuple[ItemResult, FaceFit | None]) -> None:
            result, fit = outcome
            self._results[scan_id] = result
            if fit is not None and item.fit is None:
                project.put_fit(scan_id, key, fit)
            self._ended(scan_id)

        def failed(error: BaseException) -> None:
            self._results[scan_id] = ItemResult(item.name, "failed", error=describe(error))
            self._ended(scan_id)

        title = f"Fitting “{item.name}”"
        return self._session.tasks.submit(title, work, done, failed=failed, key=f"batch {scan_id}")

    def stop(self) -> None:
        """Stop what has not been done yet; what is written stays."""
        self._report = None
        for task in [task for task in self._tasks.values() if task.active]:
            self._session.tasks.cancel(task)
        self._finish()

    def _ended(self, scan_id: str) -> None:
        if scan_id in self._session.project:
            self.panel.set_row(self._row(scan_id))
        self._finish()

    def _finish(self) -> None:
        if self.running or not self._tasks:
            return
        self._show_all()
        self._tasks.clear()
        self.panel.set_running(False)
        failed = sum(bool(result.error) for result in self._results.values())
        done = len(self._results) - failed
        self._refresh()
        self.panel.show_note(f"{done} fitted" + (f", {failed} failed: see the table" if failed else ""))
        if self._report is not None and done:
            self._write_report(self._report)
        self._report = None

    def _show_all(self) -> None:
        for item in self._session.project.scans:
            self.panel.set_row(self._row(item.id))
        count = max(len(self._tasks), 1)
        self.panel.set_progress(sum(task.fraction if task.active else 1.0 for task in self._tasks.values()) / count)

    def _on_task(self, task: Any) -> None:
        scan_id = next((i for i, other in self._tasks.items() if other is task), None)
        if scan_id is None or scan_id not in self._session.project:
            return
        self.panel.set_row(self._row(scan_id))
        count = len(self._tasks)
        self.panel.set_progress(sum(t.fraction if t.active else 1.0 for t in self._tasks.values()) / count)
        if task.state is TaskState.CANCELLED:
            self._finish()

    def _on_change(self, change: Change) -> None:
        if self._tasks:
            return
        if change.kind in ("added", "removed", "project"):
            self._list()
        elif change.id in self._session.project:
            self._results.pop(change.id, None) if change.kind in ("landmarks", "options", "scheme") else None
            self.panel.set_row(self._row(change.id))
            self._refresh()

    def done(self, code: int) -> None:
        """Let go of the session when the dialog ends; scans that are being fitted go on as tasks."""
        self._session.tasks.changed.disconnect(self._on_task)
        self._session.changed.disconnect(self._on_change)
        self._session.replaced.disconnect(self.reject)
        super().done(code)

    def closeEvent(self, event: QCloseEvent) -> None:
        """End like with Esc."""
        self.reject()
        event.accept()
