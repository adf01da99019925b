"""The scan stage: the widgets' signals become commands and tasks, the project's changes become what is shown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtGui import QGuiApplication

from engine.progress import Progress
from studio.project.basis_state import BASIS_KINDS
from studio.project.document import Change, ScanItem
from studio.scan.carrier import Carrier
from studio.scan.commands import RemoveScan, RenameScan
from studio.scan.context import ScanContext
from studio.scan.display import ScanDisplay
from studio.scan.editor import FiducialEditor
from studio.scan.face_export import FaceExport
from studio.scan.files import ScanFiles
from studio.scan.follower import PREVIEW_LEVELS, FitFollower, ShownFit
from studio.scan.job import FitInputs, as_command, input_key, inputs_of, run, template_of
from studio.scan.judge import Judge
from studio.scan.next_step import first_unfinished, next_scan
from studio.scan.quality_stage import QualityStage
from studio.scan.scan_actions import bind_actions
from studio.scan.telling import ScanTeller
from studio.scan.workspace import ScanWorkspace
from studio.stages import DockSpec

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from studio.main_window import MainWindow


class ScanStage(QObject):
    """Connects the scan widgets with the project of a window.

    Attributes
    ----------
    centre : ScanWorkspace
        The work zone; ``docks`` stand beside it.
    context : ScanContext
        Which scan and which fiducial are in view.
    editor, files, display, follower : QObject
        What edits, reads and writes, shows, and keeps the face up to date.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.window = window
        self.context = ScanContext(window.session, self)
        self.centre = ScanWorkspace(window)
        self.docks: tuple[DockSpec, ...] = self.centre.docks
        self.zones, self.empty_place = self.centre.zones, self.centre.canvas_panel
        self.usual_view = self.centre.views.viewer
        self.editor = FiducialEditor(self.context, self)
        self.files = ScanFiles(window, self.context, self.editor)
        self.carrier = Carrier(self.context, self)
        self.display = ScanDisplay(self.context, self.centre, self)
        self.follower = FitFollower(lambda: window.session.project, window.session.tasks, self)
        self.exports = FaceExport(window)
        self.shown: ShownFit | None = None
        self.trouble = ""
        window.recovery.in_view = lambda: self.context.scan_id
        self.judge = Judge(self.context, self)
        self.judge.changed.connect(self.display.show_list)
        self.display.verdict_of = self.judge.words
        self.teller = ScanTeller(self)
        self.judge.changed.connect(self.teller.tell)
        self._connect_project()
        self._connect_picture()
        self._connect_panels()
        self._connect_views()
        self.centre.restore_layout(window.settings["window/work"])
        self.quality = QualityStage(self)
        bind_actions(self, window)
        self._on_replaced()

    # -- wiring -------------------------------------------------------------------------------------------------------

    def _connect_project(self) -> None:
        session = self.window.session
        session.changed.connect(self._on_change)
        session.replaced.connect(self._on_replaced)
        session.title_changed.connect(self.teller.tell_next)
        self.window.status.next_clicked.connect(self.teller.do_next)
        self.context.scan_changed.connect(self._on_scan)
        self.context.fiducial_changed.connect(self._on_fiducial)
        self.follower.shown.connect(self._on_shown)
        self.follower.failed.connect(self._on_failed)
        self.files.told.connect(self.window.message.tell)
        self.carrier.told.connect(self.window.message.tell)

    def _connect_picture(self) -> None:
        canvas, template, edit = self.centre.canvas_panel.canvas, self.centre.template_panel, self.editor
        canvas.place_requested.connect(self._attempt(edit.place))
        canvas.selected.connect(self.context.select_fiducial)
        canvas.drag_moved.connect(lambda n, x, y: self.display.show_drag(edit.placed_at(n, x, y)))
        canvas.drag_cancelled.connect(lambda _name: self.display.show_landmarks())
        canvas.moved.connect(self._finish_drag)
        canvas.nudged.connect(self._attempt(edit.nudge))
        canvas.unset_requested.connect(self._attempt(edit.unset))
        canvas.skip_requested.connect(self._attempt(edit.skip))
        canvas.lock_requested.connect(lambda name, _locked: self.window.attempt(edit.lock, name))
        canvas.confirm_requested.connect(self._attempt(edit.confirm))
        canvas.refused.connect(lambda name, why: self.window.message.tell("info", f"{name} {why}"))
        template.selected.connect(self.context.select_fiducial)
        template.confirm_requested.connect(self._attempt(edit.confirm))
        template.skip_requested.connect(self._attempt(edit.skip))
        template.confirm_all_requested.connect(self._attempt(edit.confirm_all))

    def _connect_panels(self) -> None:
        scans, source = self.centre.inputs.scan_list, self.centre.inputs.source_panel
        table, fit, edit = self.centre.fiducials, self.centre.fit, self.editor
        scans.selected.connect(self.context.select_scan)
        scans.add_requested.connect(self.files.add)
        scans.rename_requested.connect(self._attempt(self.rename))
        scans.remove_requested.connect(self._attempt(self.remove))
        source.options_changed.connect(self._attempt(edit.set_options))
        source.scheme_changed.connect(self._attempt(edit.set_scheme))
        source.unit_changed.connect(self._attempt(self.files.read_again))
        source.place_requested.connect(self._attempt(self.files.placing.open))
        self.files.kept.connect(self.display.show_source)
        source.carry_requested.connect(lambda _source: self.window.attempt(self.carry))
        table.selected.connect(self.context.select_fiducial)
        table.edited.connect(self._attempt(edit.move))
        table.unset_requested.connect(self._attempt(edit.unset))
        table.lock_requested.connect(lambda name, _locked: self.window.attempt(edit.lock, name))
        table.mirror_requested.connect(self._attempt(edit.mirror))
        table.carry_requested.connect(self._attempt(self.carry))
        table.import_requested.connect(self._attempt(self.files.fiducials.ask_import))
        table.export_requested.connect(self._attempt(self.files.fiducials.ask_export))
        fit.level_changed.connect(lambda level: self.window.attempt(edit.set_options, {"levels": level}))
        fit.fit_requested.connect(self.fit)
        fit.export_requested.connect(self.export_face)

    def _connect_views(self) -> None:
        views = self.centre.views
        views.maximise_requested.connect(self._maximise)
        self.window.habits.layouts.release_by(views.tools.buttons["maximise"], views.maximise_requested.emit)
        views.ready.connect(self.window.views_ready)
        views.ready.connect(self._warm_up)

    def _attempt(self, deed: Callable[..., object]) -> Callable[..., bool]:
        return lambda *values: self.window.attempt(deed, *values)

    def _warm_up(self) -> None:
        """Load beside the window what the first click would wait for."""

        def work(_progress: Progress) -> None:
            import engine.files.scan
            import engine.scan.fit  # noqa: F401
            import studio.project.recovery  # noqa: F401

            template_of().refine(PREVIEW_LEVELS)

        self.window.session.tasks.submit("Warming up", work, lambda _done: None, quiet=True)

    @property
    def subject(self) -> str:
        """The name of the scan in view; empty without one."""
        return self.context.name()

    def came_into_view(self) -> None:
        """Say what comes next."""
        self.teller.tell()

    # -- deeds --------------------------------------------------------------------------------------------------------

    def go_next(self) -> None:
        """Go to the next unfinished fiducial, or to the next scan that is not fresh."""
        current = self.context.scan_id
        if current is None:
            return
        if first_unfinished(self.context.project, current) is not None:
            self.context.advance()
        else:
            following = next_scan(self.context.project, current)
            if following is not None:
                self.context.select_scan(following)
        self.centre.canvas_panel.focus_canvas()

    def carry(self) -> None:
        """Propose the fiducials of the scan chosen under *Carry from* on the scan in view."""
        source = self.centre.inputs.source_panel.carry_source()
        if source is not None and self.context.scan_id is not None:
            self.carrier.carry(source, [self.context.scan_id])

    def carry_to_all(self) -> None:
        """Propose the fiducials of the scan in view on all others that need some."""
        targets = [item.id for item in self.carrier.targets()]
        if self.context.scan_id is not None and targets:
            self.carrier.carry(self.context.scan_id, targets)

    def drop(self, paths: Sequence[Path]) -> None:
        """Take in dropped scans, folders of scans and fiducials."""
        self.files.drop(paths)

    def rename(self, scan_id: str, name: str) -> None:
        """Give a scan another name."""
        self.window.session.stack.push(RenameScan(self.context.project, scan_id, name))

    def remove(self, scan_id: str) -> None:
        """Take a scan out of the project."""
        self.window.session.stack.push(RemoveScan(self.context.project, scan_id))

    def fit(self) -> None:
        """Fit the scan in view with its own options."""
        item = self.context.item
        if item is not None:
            self._fit_one(item)

    def fit_all(self) -> None:
        """Fit every scan that is ready and not fresh."""
        for item in self.context.project.scans:
            if self._is_ready(item) and self.context.project.state(item.id).kind != "fresh":
                self._fit_one(item)

    def export_face(self) -> None:
        """Ask for a name and export the face of the scan in view."""
        item = self.context.item
        if item is not None and self.context.project.state(item.id).kind == "fresh":
            fit, image = self.context.project.fit(item.id), self.context.image
            if fit is not None and image is not None:
                self.exports.ask(item, image, fit)

    def copy_command(self) -> None:
        """Put the command line that makes the same fit on the clipboard."""
        item = self.context.item
        if item is not None:
            QGuiApplication.clipboard().setText(as_command(item, item.options))
            name = f"{item.name}_fiducials.json"
            self.window.message.tell("info", f"Copied the command; it reads {name}, which Export fiducials writes")

    def _is_ready(self, item: ScanItem) -> bool:
        state = self.context.project.state(item.id)
        return state.kind != "missing" or state.reason == "no fit yet"

    def _fit_one(self, item: ScanItem) -> None:
        project, key = self.context.project, input_key(item)
        inputs = inputs_of(item, project.range_image(item.id))
        repaired = self.follower.repaired

        def work(progress: Progress) -> FaceFit:
            scan = repaired.get(item.image_key, project.range_image(item.id), item.options, progress)
            return run(FitInputs(scan, inputs.fiducials, inputs.scheme), item.options, progress)

        def done(fit: FaceFit) -> None:
            project.put_fit(item.id, key, fit)  # beside the stack: a push would cut off what can still be redone
            self.follower.forget()
            self._follow()

        self.window.session.tasks.submit(f"Fitting “{item.name}”", work, done, key=f"fit {item.id}")

    # -- what happens -------------------------------------------------------------------------------------------------

    def _on_replaced(self) -> None:
        self.display.show_schemes()
        self.context.scan_id = None
        self.follower.forget()
        scans = self.context.project.scans
        if scans:
            self.context.select_scan(scans[0].id)
            self.centre.canvas_panel.canvas.fit_view()
        else:
            self.context.fiducial = None
            self._on_scan()

    def _on_change(self, change: Change) -> None:
        if change.kind in BASIS_KINDS:
            return
        here = change.id == self.context.scan_id
        if change.kind == "schemes":
            self.display.show_schemes()
        elif change.kind in ("added", "removed"):
            self.context.follow()
        elif here and change.kind == "landmarks":
            self.display.show_landmarks()
            self._follow()
        elif here and change.kind == "scheme":
            self.display.show_scheme()
            self.context.follow()
            self._follow()
        elif here and change.kind == "options":
            self.display.show_options()
            self._follow()
            self._look_for_spikes()
        elif here and change.kind == "source":
            self._on_scan()
        elif here and change.kind == "name":
            self.display.show_source()
        elif here and change.kind == "fit":
            self._follow()
        self.display.show_list()
        self.teller.tell()

    def _on_scan(self) -> None:
        self.display.show_scan()
        self.shown, self.trouble = None, ""
        self.display.show_fit(None)
        self.follower.forget()
        self._follow()
        self._look_for_spikes()
        self.teller.tell()

    def _on_fiducial(self) -> None:
        self.display.show_current()
        self.teller.tell()

    def _finish_drag(self, name: str, x: float, y: float) -> None:
        if not self.window.attempt(self.editor.move, name, x, y):
            self.display.show_landmarks()

    def _follow(self) -> None:
        item = self.context.item
        if item is not None:
            self.trouble = ""
            self.follower.follow(item)

    def _look_for_spikes(self) -> None:
        item, image = self.context.item, self.context.image
        if item is None or image is None:
            return
        repaired = self.follower.repaired
        self.window.session.tasks.submit(
            "Looking for spikes",
            lambda progress: repaired.get(item.image_key, image, item.options, progress),
            lambda scan: self.display.show_spikes(scan.spikes) if self.context.image is image else None,
            failed=lambda _error: None,
            key="spikes",
            quiet=True,
        )

    def _on_shown(self, scan_id: str, shown: ShownFit | None) -> None:
        if scan_id == self.context.scan_id:
            self.shown, self.trouble = shown, ""
            self.display.show_fit(shown)
            self.teller.tell()

    def _on_failed(self, scan_id: str, text: str) -> None:
        if scan_id == self.context.scan_id:
            self.trouble = text
            self.window.message.tell("error", self._unlikely_size() or text)
            self.teller.tell()

    def _unlikely_size(self) -> str:
        """Return what to do where a scan is no face's size: all else that goes wrong follows from it."""
        from engine.files.scan_file import size_warnings

        item, image = self.context.item, self.context.image
        if item is None or image is None:
            return ""
        found = size_warnings(image, item.source.unit)
        return f"{item.name}: {found[0]}; choose the unit under Source, or undo" if found else ""

    # -- views --------------------------------------------------------------------------------------------------------

    def _maximise(self, alone: bool) -> None:
        self.centre.show_views_alone(alone)
        self.window.hide_docks(alone)

    def reset_layout(self) -> None:
        """Share the room as at first."""
        self.centre.reset()

    def close(self) -> None:
        """Note how the room is shared; let go of the 3-D views."""
        state = self.centre.layout_state()
        if not state.isEmpty():
            self.window.settings["window/work"] = state
        self.quality.close()
        self.centre.views.close()
