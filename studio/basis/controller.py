"""The basis stage: the widgets' signals become commands and tasks, the project's changes become what is shown."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtGui import QGuiApplication

from studio.basis.basis_actions import bind_actions
from studio.basis.commands import ChooseInput, RemoveItem, RenameItem, SetAmounts, SetBasisOptions
from studio.basis.context import BasisContext
from studio.basis.display import BasisDisplay
from studio.basis.exports import BasisExports
from studio.basis.files import BasisFiles
from studio.basis.follower import BasisFollower
from studio.basis.motion_settings import MotionSettings
from studio.basis.shape_editor import ShapeEditor
from studio.basis.telling import BasisTeller
from studio.basis.workspace import BasisWorkspace
from studio.project.basis_state import BASIS_KINDS
from studio.project.document import Change, ItemState
from studio.stages import DockSpec

if TYPE_CHECKING:
    from PySide6.QtWidgets import QWidget

    from engine.mesh import FloatArray
    from studio.main_window import MainWindow


class BasisStage(QObject):
    """Connects the basis widgets with the project of a window.

    Attributes
    ----------
    centre : BasisWorkspace
        The work zone; ``docks`` stand beside it.
    context : BasisContext
        Which shape and which frame are in view.
    follower, display, files, editor, exports : QObject
        What keeps the basis up to date, shows it, reads files, edits shapes, and writes files.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.window = window
        self.context = BasisContext(window.session, self)
        self.centre = BasisWorkspace(window)
        self.docks: tuple[DockSpec, ...] = self.centre.docks
        self.zones = self.centre.zones
        self.follower = BasisFollower(lambda: window.session.project.basis, window.session.tasks, self)
        self.display = BasisDisplay(self.context, self.follower, self.centre, self)
        self.files = BasisFiles(window, self.context)
        self.editor = ShapeEditor(self)
        self.exports = BasisExports(self)
        self.motion_settings = MotionSettings(self)
        self.teller = BasisTeller(self)
        self.told = ItemState("missing")
        self._connect_project()
        self._connect_inputs()
        self._connect_results()
        self._connect_views()
        bind_actions(self, window)
        self._on_replaced()

    @property
    def empty_place(self) -> QWidget | None:
        """Nothing is covered by the welcome page: the views say themselves what belongs there."""
        return None

    @property
    def usual_view(self) -> QWidget:
        """What is pictured where neither the mouse nor the keys are in another view."""
        return self.centre.views.viewer

    @property
    def subject(self) -> str:
        """The shape in view."""
        return self.context.shape or ""

    # -- wiring -------------------------------------------------------------------------------------------------------

    def _connect_project(self) -> None:
        session = self.window.session
        session.changed.connect(self._on_change)
        session.replaced.connect(self._on_replaced)
        session.title_changed.connect(self.teller.tell_next)
        session.tasks.changed.connect(lambda task: None if task.quiet else self.teller.tell_next())
        self.window.status.next_clicked.connect(self.teller.do_next)
        self.context.shape_changed.connect(self._on_shape)
        self.context.frame_changed.connect(self.display.show_frame)
        self.follower.changed.connect(self._on_followed)
        self.follower.added.connect(self._on_added)
        self.follower.failed.connect(lambda text: self.window.message.tell("error", text))
        self.files.told.connect(self.window.message.tell)

    def _connect_inputs(self) -> None:
        shapes, motion, edit = self.centre.shapes, self.centre.motion, self.editor
        shapes.selected.connect(self.select_shape)
        shapes.view.clicked.connect(lambda _index: self._leave_eigenface())
        shapes.selection_changed.connect(self.context.mark)
        shapes.rename_requested.connect(self._attempt(edit.rename))
        shapes.reorder_requested.connect(self._attempt(edit.reorder))
        shapes.edit_requested.connect(self._attempt(edit.edit))
        shapes.mapping_requested.connect(self._attempt(edit.map_names))
        shapes.add_requested.connect(self.files.add_rig)
        motion.open_requested.connect(self.files.add_motion)
        motion.settings_requested.connect(self._attempt(self.motion_settings.open))
        motion.driver_chosen.connect(self._attempt(self.choose_driver))
        motion.train_changed.connect(lambda start, stop: self.set_options({"train": self._train(start, stop)}))
        motion.coverage_changed.connect(lambda value: self.set_options({"coverage": value, "count": None}))
        motion.count_changed.connect(lambda value: self.set_options({"count": value}))
        motion.bounds_chosen.connect(lambda value: self.set_options({"bounds": value}))
        motion.affine_chosen.connect(lambda value: self.set_options({"affine": value}))
        motion.ridge_changed.connect(lambda value: self.set_options({"ridge": value}))

    def _connect_results(self) -> None:
        work = self.centre
        work.shape.amount_dragged.connect(self._drag_amount)
        work.shape.amount_set.connect(self._attempt(self._set_amount))
        work.error.bounds_chosen.connect(lambda value: self.set_options({"bounds": value}))
        work.error.statistic_chosen.connect(work.error.set_statistic)
        work.projection.shape_chosen.connect(self.select_shape)
        work.projection.axis_chosen.connect(self.show_axis)
        work.advice.action_requested.connect(self._attempt(self.take_advice))
        work.eigen.values_dragged.connect(self.display.show_eigenface)
        work.eigen.values_set.connect(self.display.show_eigenface)
        work.eigen.axis_chosen.connect(work.projection.set_axis)
        work.cloud.frame_chosen.connect(self.go_to_frame)
        work.guide.shape_chosen.connect(self.select_shape)
        work.timeline.frame_changed.connect(self.context.show_frame)

    def _connect_views(self) -> None:
        views = self.centre.views
        views.maximise_requested.connect(self.window.hide_docks)
        self.window.habits.layouts.release_by(views.tools.buttons["maximise"], views.maximise_requested.emit)
        views.ready.connect(self.window.views_ready)
        views.shape_chosen.connect(self.select_shape)
        views.open_requested.connect(self.files.add_rig)
        views.pca_changed.connect(self.want_pca)
        views.mode_changed.connect(lambda _mode: self.display.show_grid())

    def _attempt(self, deed: Callable[..., object]) -> Callable[..., bool]:
        return lambda *values: self.window.attempt(deed, *values)

    # -- deeds --------------------------------------------------------------------------------------------------------

    def set_options(self, values: Mapping[str, object]) -> bool:
        """Choose how axes are found and weights are solved; what cannot be is told, and what was is shown again."""

        def push() -> None:
            command = SetBasisOptions(self.context.project, values)
            if command.changes:
                self.window.session.stack.push(command)

        done = self.window.attempt(push)
        if not done:
            self.display.show_choices()
        return done

    def _train(self, start: int, stop: int) -> tuple[int, int] | None:
        prepared = self.follower.prepared
        whole = prepared is not None and (start, stop) == (0, len(prepared.motion))
        return None if whole else (start, stop)

    def choose_driver(self, rig_id: str) -> None:
        """Let the curves drive a rig."""
        chosen = None if not rig_id or rig_id == self.context.setup.hand else rig_id
        if chosen != self.context.setup.driver:
            self.window.session.stack.push(ChooseInput(self.context.project, "driver", chosen))

    def choose_hand(self, rig_id: str) -> None:
        """Make a rig of the project the hand-sculpted one."""
        if rig_id != self.context.setup.hand:
            self.window.session.stack.push(ChooseInput(self.context.project, "hand", rig_id))

    def choose_motion(self, motion_id: str) -> None:
        """Measure by another performance of the project."""
        if motion_id != self.context.setup.motion:
            self.window.session.stack.push(ChooseInput(self.context.project, "motion", motion_id))

    def rename_item(self, item_id: str, name: str) -> None:
        """Give a rig or a performance another name."""
        self.window.session.stack.push(RenameItem(self.context.project, item_id, name))

    def remove_item(self, item_id: str) -> None:
        """Take a rig or a performance out of the project."""
        self.window.session.stack.push(RemoveItem(self.context.project, item_id))

    def _drag_amount(self, amount: float) -> None:
        self.display.preview(dict.fromkeys(self.context.chosen, amount))

    def _set_amount(self, amount: float) -> None:
        chosen = self.context.chosen
        self.display.end_preview()
        if chosen:
            self.set_amounts(dict.fromkeys(chosen, amount))
        self.display.show_shape()

    def set_amounts(self, amounts: Mapping[str, float]) -> None:
        """Move shapes between hand (0) and quasi-eigen (1)."""
        setup = self.context.setup
        if any(setup.amount(name) != value for name, value in amounts.items()):
            self.window.session.stack.push(SetAmounts(self.context.project, amounts))

    def take_advice(self, key: str) -> None:
        """Do what a button of the advice says (`advice_items`)."""
        kind, _, rest = key.partition("|")
        if kind == "keep":
            name, _, amount = rest.rpartition("|")
            self.context.select_shape(name)
            self.set_amounts({name: float(amount)})
        elif kind == "keep_all" and self.follower.advice is not None:
            self.set_amounts({drift.name: drift.amount for drift in self.follower.advice.drifting})
        elif kind == "shape":
            self.context.select_shape(rest)
        elif kind == "axis":
            self.show_axis(int(rest))
        elif kind == "frame":
            self.go_to_frame(int(rest))

    def show_axis(self, axis: int) -> None:
        """Show two standard deviations along an axis, from 0."""
        import numpy as np

        analysis = self.follower.analysis
        if analysis is None or not 0 <= axis < analysis.result.principal.count:
            return
        values: FloatArray = np.zeros(analysis.result.principal.count)
        values[axis] = 2.0
        self.centre.projection.set_axis(axis)
        self.centre.eigen.set_axis(axis)
        self.centre.eigen.set_values(values)
        self.display.show_eigenface(values)
        self.window.show_dock("eigenfaces")

    def select_shape(self, name: str) -> None:
        """Bring a shape into view, also where an eigenface stands in its place."""
        self.context.select_shape(name)
        self._leave_eigenface()

    def _leave_eigenface(self) -> None:
        if self.display.eigenface:
            self.display.show_shape()

    def go_to_frame(self, frame: int) -> None:
        """Bring a frame into view, counted from 0."""
        self.centre.timeline.set_frame(frame)
        self.context.show_frame(frame)

    def go_next(self) -> None:
        """Go to the next shape that no longer looks like its hand shape, going round."""
        weak = self.teller.weak_shapes()
        if weak:
            at = weak.index(self.context.shape) + 1 if self.context.shape in weak else 0
            self.context.select_shape(weak[at % len(weak)])

    def copy_command(self) -> None:
        """Put the command line that makes the same basis on the clipboard."""
        text = self.exports.command()
        QGuiApplication.clipboard().setText(text)
        lacks = self.exports.not_in_command()
        told = f"Copied the command; it leaves out: {', '.join(lacks)}" if lacks else "Copied the command of this basis"
        self.window.message.tell("info", told)

    def drop(self, paths: Sequence[Path]) -> None:
        """Take in dropped rigs, performances and pairs of markers."""
        self.files.drop(paths)

    # -- what happens -------------------------------------------------------------------------------------------------

    def _on_replaced(self) -> None:
        self.centre.timeline.pause()
        self.context.shape, self.context.marked, self.context.frame = None, (), 0
        self.follower.forget()
        self.context.follow()
        self.display.show_all()
        self.follower.follow()
        self.teller.tell()

    def _on_change(self, change: Change) -> None:
        if change.kind not in BASIS_KINDS:
            return
        if change.kind in ("rigs", "rig", "setup"):
            self.display.show_rig()
            self.context.follow()
        self.display.show_motion()
        self.display.show_choices()
        self.display.show_shapes()
        self.display.show_shape()
        self.display.show_grid()
        self.follower.follow()
        self.teller.tell()

    def _on_shape(self) -> None:
        self.display.show_shape()
        self.teller.tell()

    def _on_followed(self) -> None:
        self.display.show_motion()
        self.display.show_shapes()
        self.display.show_shape()
        self.display.show_grid()
        self.display.show_figures()
        self.display.show_frame()
        self.teller.tell()

    def _on_added(self) -> None:
        self.display.show_advice()
        self.teller.tell()

    def want_pca(self, wanted: bool) -> None:
        """Make the reconstruction by PCA axes, or none any more."""
        self.display.frames.pca = wanted
        self.display.show_frame()

    # -- views --------------------------------------------------------------------------------------------------------

    def came_into_view(self) -> None:
        """Say in the status line what comes next."""
        self.teller.tell()

    def reset_layout(self) -> None:
        """There is nothing in the work zone whose room is shared."""

    def close(self) -> None:
        """Let go of the 3-D views and the clocks."""
        self.centre.timeline.close_playback()
        self.follower.close()
        self.centre.views.close()
