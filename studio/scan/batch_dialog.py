"""The dialog of a batch: what is fitted and written is chosen in it, and followed while it is open."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from engine.errors import InputError
from studio.batch.project import face_names
from studio.project.document import Change, needs
from studio.scan.batch_run import BatchRequest, BatchRun
from studio.tasks import TaskState
from widgets import theme
from widgets.scan.batch_panel import BatchPanel, BatchRow

if TYPE_CHECKING:
    from studio.session import Session

WIDTH, HEIGHT = 680, 620


class BatchDialog(QDialog):
    """Starts and shows a run beside the window; the run goes on when the dialog is closed.

    Parameters
    ----------
    run : BatchRun
        What fits the scans.
    session : Session
        Whose project it is.
    """

    def __init__(self, run: BatchRun, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("batch")
        self.setWindowTitle("Fit all scans")
        self.setWindowModality(Qt.WindowModality.NonModal)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.run, self._session = run, session
        self.panel = BatchPanel(self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        files = Path(str(session.settings["files/folder"]))
        self.panel.folder.proposed = str(files)
        self.panel.report.proposed = str(files / f"{session.project.name}.pdf")
        self.panel.changed.connect(self._refresh)
        self.panel.started.connect(self.start)
        self.panel.cancelled.connect(run.stop)
        self.panel.closed.connect(self.reject)
        run.moved.connect(self._on_moved)
        run.ended.connect(self._on_ended)
        session.changed.connect(self._on_change)
        session.replaced.connect(self.reject)
        theme.signals.changed.connect(self._list)
        self._list()
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))

    @property
    def running(self) -> bool:
        """Whether scans are being fitted."""
        return self.run.running

    def start(self) -> None:
        """Fit the scans that are ticked, and write their faces."""
        level, panel = self.panel.level.currentData(), self.panel
        request = BatchRequest(
            panel.chosen(),
            None if level is None or level < 0 else level,
            panel.folder.folder(),
            panel.format.currentText(),
            panel.pattern.text(),
            panel.report.path(".pdf"),
        )
        try:
            self.run.start(request)
        except InputError as error:
            panel.show_note(str(error), trouble=True)
            return
        self._list()

    # -- what is shown ------------------------------------------------------------------------------------------------

    def _list(self) -> None:
        self.panel.set_rows([self._row(item.id) for item in self._session.project.scans])
        self.panel.set_running(self.running)
        self.panel.set_progress(self.run.fraction)
        self._refresh()

    def _row(self, scan_id: str) -> BatchRow:
        project = self._session.project
        item = project.scan(scan_id)
        state, needed, result = project.state(scan_id), needs(item), self.run.result(scan_id)
        row = BatchRow(scan_id, item.name, needed or state.reason or "fit fresh", not needed)
        task = self.run.task(scan_id)
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
        chosen, folder, report = self.panel.chosen(), self.panel.folder.folder(), self.panel.report.path(".pdf")
        told, problem = "", ""
        try:
            told = self._replaced(chosen, folder, report)
        except InputError as error:
            problem = str(error)
        if not chosen:
            problem = "Tick a scan whose fiducials are ready."
        self.panel.show_note(problem or told, trouble=bool(problem))
        self.panel.command.set_command(*self._command(folder, report))

    def _replaced(self, chosen: tuple[str, ...], folder: Path | None, report: Path | None) -> str:
        """Return what a run would replace, in words; InputError where names cannot be."""
        told = []
        if folder is not None:
            names = face_names(self._session.project.scans, self.panel.pattern.text())
            files = [folder / f"{names[i]}.{self.panel.format.currentText()}" for i in chosen]
            count = sum(_exists(path, "Faces to") for path in files)
            told = [f"{count} faces in the folder"] if count else []
        if report is not None and _exists(report, "Report"):
            told.append("the report")
        return f"{' and '.join(told)} will be replaced" if told else ""

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

    # -- what happens behind it ---------------------------------------------------------------------------------------

    def _on_moved(self, scan_id: str) -> None:
        if scan_id in self._session.project:
            self.panel.set_row(self._row(scan_id))
        self.panel.set_progress(self.run.fraction)

    def _on_ended(self, told: str) -> None:
        self._list()
        if self.panel.chosen():
            self.panel.show_note(told)

    def _on_change(self, change: Change) -> None:
        if change.kind in ("added", "removed", "project"):
            self._list()
        elif change.id in self._session.project:
            self.panel.set_row(self._row(change.id))
            self._refresh()


def _exists(path: Path, field: str) -> bool:
    try:
        return path.exists()
    except OSError as error:
        raise InputError(field, f"cannot be written ({error.strerror})", "choose another place") from None
