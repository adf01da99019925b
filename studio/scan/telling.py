"""What the scan stage says of itself: the next step, the state of the fit, notes beside the docks' titles."""

from __future__ import annotations

from typing import TYPE_CHECKING

from studio.project.document import ScanItem
from studio.scan.job import template_of
from studio.scan.next_step import NextStep, next_step

if TYPE_CHECKING:
    from studio.scan.controller import ScanStage


class ScanTeller:
    """Reads the stage and tells the window; changes nothing."""

    def __init__(self, stage: ScanStage) -> None:
        self._stage = stage

    def tell(self) -> None:
        """Tell all of it anew."""
        project, item, window = self._stage.context.project, self._stage.context.item, self._stage.window
        summary = project.summary()
        begun = any(project.state(other.id).kind != "missing" for other in project.scans)
        kind = "stale" if summary.kind == "missing" and begun else summary.kind
        window.set_stage_state("scan", kind, summary.reason)
        window.set_dock_note("scans", str(len(project.scans)) if project.scans else "")
        window.set_dock_note("fiducials", self._stage.centre.fiducials.note)
        window.set_dock_note("fit", self._fit_note())
        if window.stage_id == "scan":
            window.status.set_fit(*self._fit_state(item))
        self.tell_next()
        window.actions_.refresh()

    def tell_next(self) -> None:
        """Tell the next step alone, and before it what is folded."""
        if self._stage.window.stage_id != "scan":
            return
        step, folded = self._next(), self._folded()
        keys = self._stage.window.actions_.shortcut_text(step.action) if step.action else ""
        self._stage.window.status.set_next(f"{folded}; {step.text}" if folded else step.text, keys)

    def do_next(self) -> None:
        """Do the next step, or go where it is done."""
        step = self._next()
        if step.action and self._stage.window.stage_id == "scan":
            self._stage.window.actions_[step.action].trigger()

    def _next(self) -> NextStep:
        context, judge = self._stage.context, self._stage.judge
        failing = [item.name for item in context.project.scans if judge.words(item.id).startswith("fails")]
        doubtful = context.doubtful.get(context.scan_id or "", ())
        return next_step(context.project, context.scan_id, context.fiducial, doubtful, failing)

    def _folded(self) -> str:
        warp = self._stage.display.warp
        if self._stage.display.trouble:
            return self._stage.display.trouble
        if warp is None or not len(warp.folded):
            return ""
        count = f"{len(warp.folded)} triangle{'s' if len(warp.folded) > 1 else ''} folded"
        return f"{count}: check {', '.join(warp.suspects[:3])}" if warp.suspects else count

    def _fit_note(self) -> str:
        shown = self._stage.shown
        if shown is None:
            return ""
        if shown.preview:
            return f"preview, {shown.count} of {shown.total} points"
        from engine.scan.regions import regions_of

        assumed = regions_of(template_of()).assumed
        return f"level {shown.fit.levels}" + (f", regions {assumed}" if assumed else "")

    def _fit_state(self, item: ScanItem | None) -> tuple[str, str]:
        if item is None:
            return "missing", ""
        if self._stage.trouble:
            return "missing", "no fit: see the message"
        state = self._stage.context.project.state(item.id)
        figure = "" if self._stage.shown is None else f" {self._stage.shown.median_mm:.2f} mm"
        if self._stage.shown is not None and self._stage.shown.preview:
            return "stale", f"fit preview{figure}"
        if state.kind == "fresh":
            verdict = self._stage.judge.words(item.id)
            return "fresh", f"fit fresh{figure}" + (f", {verdict}" if verdict else "")
        if state.kind == "stale":
            return "stale", f"fit stale: {state.reason}"
        return "missing", "no fit yet"
