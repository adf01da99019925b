"""Regions, limits, report and batch in the window: pointing shows, edits are steps, long work is a task."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from shiboken6 import isValid

from engine.progress import Progress
from engine.scan.limits import Limits
from studio import dialogs
from studio.project.document import Change
from studio.scan.follower import ShownFit
from studio.scan.job import template_of
from studio.scan.limit_commands import SetLimits
from studio.scan.limits_dialog import LimitsDialog, my_limits
from widgets.scan.region_marker import RegionMarker

if TYPE_CHECKING:
    from engine.scan.quality import RegionQuality
    from studio.report.job import ReportResult
    from studio.scan.batch_dialog import BatchDialog
    from studio.scan.batch_run import BatchRun
    from studio.scan.controller import ScanStage

REPORT_FILTER = "Report (*.pdf)"


class QualityStage(QObject):
    """Connects the region table, the limits and the report with the scan stage."""

    def __init__(self, stage: ScanStage) -> None:
        super().__init__(stage)
        self.stage, self.window = stage, stage.window
        self.panel = stage.centre.fit
        self.marker = RegionMarker(stage.centre.views)
        self._shown: ShownFit | None = None
        self._pointed = ""
        self._batch: BatchDialog | None = None
        self._run: BatchRun | None = None
        self.panel.regions.pointed.connect(self._point)
        self.panel.limits_requested.connect(self.edit_limits)
        stage.follower.shown.connect(self._on_shown)
        stage.context.scan_changed.connect(lambda: self._show(stage.shown))
        self.window.session.changed.connect(self._on_change)
        self.window.session.begun.connect(self._begin)
        stage.centre.views.ready.connect(lambda: self._point(self._pointed))
        actions = self.window.actions_
        actions.bind("scan.limits", self.edit_limits)
        actions.bind("scan.batch", self.open_batch, lambda: "" if stage.context.project.scans else "add a scan first")
        actions.bind("file.report", self.write_report, self._no_report)
        self._begin()

    # -- regions ------------------------------------------------------------------------------------------------------

    def _on_shown(self, scan_id: str, shown: ShownFit | None) -> None:
        if scan_id == self.stage.context.scan_id:
            self._show(shown)

    def _show(self, shown: ShownFit | None) -> None:
        self._shown = shown
        self.panel.set_regions(self._regions(self.stage.context.project.limits))
        self._point(self._pointed)

    def _regions(self, limits: Limits) -> tuple[RegionQuality, ...]:
        if self._shown is None:
            return ()
        from engine.scan.quality import measure_regions
        from engine.scan.regions import regions_of

        return measure_regions(self._shown.fit, regions_of(template_of()), limits)

    def _point(self, name: str) -> None:
        self._pointed = name
        if self._shown is None or not name:
            self.marker.clear()
            return
        from engine.scan.regions import border, regions_of

        fit = self._shown.fit
        self.marker.show(fit.mesh.vertices, fit.normals, border(regions_of(template_of()), name, fit.levels))

    # -- limits -------------------------------------------------------------------------------------------------------

    def _begin(self) -> None:
        """Give a project that has just begun the user's own limits."""
        project = self.window.session.project
        self.window.attempt(lambda: project.set_limits(my_limits()))

    def _on_change(self, change: Change) -> None:
        if change.kind == "limits":
            self.stage.follower.judge_anew()
            item = self.stage.context.item
            if item is not None:
                self.stage.follower.follow(item)
            self._show(self._shown)

    def edit_limits(self) -> None:
        """Open the dialog of the limits."""
        dialog = LimitsDialog(self.stage.context.project.limits, self.judge, self.window.settings, self.window)
        dialog.accepted.connect(lambda: self.take_limits(dialog.limits))
        dialog.open()

    def take_limits(self, limits: Limits) -> None:
        """Judge by other limits, as a step."""
        project = self.stage.context.project
        if limits != project.limits:
            self.window.session.stack.push(SetLimits(project, limits))

    def judge(self, limits: Limits) -> tuple[dict[str, str], str]:
        """Return what limits make of the scan in view: a verdict a region, and a line on all of it."""
        item = self.stage.context.item
        if self._shown is None or item is None:
            return {}, "No scan is fitted, so there is nothing to judge yet."
        from engine.scan.quality import measure, overall, verdicts

        regions = self._regions(limits)
        checks = verdicts(measure(self._shown.fit), limits)
        bad = [f"{check.name} {check.verdict}" for check in checks if check.verdict not in (None, "ok")]
        said = {"ok": "passes", "warn": "is a warning", "fail": "fails"}[str(overall(checks, regions))]
        return {r.name: str(r.verdict) for r in regions}, f"{item.name} {said}" + (f": {', '.join(bad)}" if bad else "")

    # -- batch --------------------------------------------------------------------------------------------------------

    def open_batch(self) -> None:
        """Open the dialog that fits many scans, or bring it to the front."""
        from studio.scan.batch_dialog import BatchDialog
        from studio.scan.batch_run import BatchRun

        if self._run is None:
            self._run = BatchRun(self.window.session, self.start_report, self)
            self._run.ended.connect(self._tell_batch)
        if self._batch is None or not isValid(self._batch):
            self._batch = BatchDialog(self._run, self.window.session, self.window)
        self._batch.show()
        self._batch.raise_()
        self._batch.activateWindow()

    def _tell_batch(self, told: str) -> None:
        """Say what became of a batch whose dialog was closed meanwhile."""
        if self._batch is None or not isValid(self._batch) or not self._batch.isVisible():
            self.window.message.tell("info", f"Fit all scans: {told}")

    # -- report -------------------------------------------------------------------------------------------------------

    def _no_report(self) -> str:
        project = self.stage.context.project
        if not project.scans:
            return "add a scan first"
        from studio.project.document import needs

        there = any(project.fit(item.id) is not None or not needs(item) for item in project.scans)
        return "" if there else "no scan is ready to be fitted"

    def write_report(self) -> None:
        """Ask for a file and write the report of all scans beside the window."""
        name = f"{self.stage.context.project.name}.pdf"
        path = dialogs.save_file(self.window, self.window.settings, "Write report", name, REPORT_FILTER)
        if path is not None:
            self.start_report(path)

    def start_report(self, path: Path) -> None:
        """Write the report of all scans to a file, as a task."""
        from studio.report.job import scans_of
        from studio.report.options import ReportOptions
        from studio.report.process import run_apart

        project = self.stage.context.project
        scans, limits, title = scans_of(project), project.limits, project.name

        def work(progress: Progress) -> ReportResult:
            options = ReportOptions(heat_mm=max(self.window.settings["view/high"], 0.01))
            return run_apart(scans, limits, options, path, progress, title=title, date=datetime.date.today())

        def done(result: ReportResult) -> None:
            for scan_id, (key, fit) in result.fits.items():
                project.put_fit(scan_id, key, fit)
            left = f"; {len(result.absent)} without a fit" if result.absent else ""
            self.window.message.tell("info", f"Wrote {result.files[0]} with {len(result.names)} scans{left}")

        self.window.session.tasks.submit(f"Writing “{path.name}”", work, done, key=f"report {path}")

    def close(self) -> None:
        """Let go of the views and of the batch."""
        if self._batch is not None and isValid(self._batch):
            self._batch.reject()
        self.marker.close()
