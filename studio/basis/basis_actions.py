"""Binds the actions of the basis stage to what they do, with the reasons why they cannot be used just now."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from widgets.parts.choice_dialog import ChoiceDialog
from widgets.scene.basis_state import MODES

if TYPE_CHECKING:
    from studio.basis.controller import BasisStage
    from studio.main_window import MainWindow
    from studio.project.basis_state import BasisItems

NO_RIG = "open a hand-sculpted rig first"
NO_MOTION = "open a performance first"
SIDES = ("front", "left", "right", "three_quarter", "top", "back", "below")


def bind_actions(stage: BasisStage, window: MainWindow) -> None:
    """Give the basis stage's declared actions their deeds and their reasons."""
    _bind_files(stage, window)
    _bind_shapes(stage, window)
    _bind_basis(stage, window)
    _bind_time(stage, window)
    _bind_views(stage, window)


def _bind_files(stage: BasisStage, window: MainWindow) -> None:
    bind, files, exports = window.actions_.bind, stage.files, stage.exports

    bind("basis.add_rig", files.add_rig)
    bind("basis.add_motion", files.add_motion)
    bind("basis.sample", lambda: window.attempt(files.open_sample))
    bind("basis.relink", files.missing.ask, files.missing.reason)
    bind("basis.export", lambda: window.attempt(exports.export_basis), exports.reason)
    bind("basis.export_animated", lambda: window.attempt(exports.export_animated), exports.reason)
    bind("basis.export_objects", lambda: window.attempt(exports.export_objects), exports.reason)
    bind("basis.export_weights", lambda: window.attempt(exports.export_curves), exports.reason)
    bind("basis.report", lambda: window.attempt(exports.export_report), exports.reason)


def _bind_shapes(stage: BasisStage, window: MainWindow) -> None:
    bind, context, editor = window.actions_.bind, stage.context, stage.editor

    def shape() -> str:
        if context.hand is None:
            return NO_RIG
        return "" if context.shape is not None else "choose a shape first"

    def several() -> str:
        return shape() or ("" if len(context.chosen) > 1 else "mark at least two shapes (Ctrl+click)")

    def one_to_spare() -> str:
        return shape() or ("" if len(context.chosen) < len(context.names) else "a rig keeps at least one shape")

    def rig() -> str:
        return "" if context.rig is not None else NO_RIG

    def rename() -> None:
        if context.shape is not None:
            window.show_dock("shapes")
            stage.centre.shapes.edit_name(context.shape)

    def edit(kind: str) -> Callable[[], object]:
        return lambda: window.attempt(editor.edit_chosen, kind)

    bind("basis.rename", rename, shape)
    bind("basis.mirror", edit("mirror"), shape)
    bind("basis.split", edit("split"), shape)
    bind("basis.combine", edit("combine"), several)
    bind("basis.duplicate", edit("duplicate"), shape)
    bind("basis.remove", edit("remove"), one_to_spare)
    bind("basis.map_arkit", lambda: window.attempt(editor.map_names, "arkit"), rig)
    bind("basis.map_facs", lambda: window.attempt(editor.map_names, "facs"), rig)


def _bind_basis(stage: BasisStage, window: MainWindow) -> None:
    bind, context, follower = window.actions_.bind, stage.context, stage.follower

    def can_analyse() -> str:
        state = stage.teller.state
        if follower.busy:
            return "it is being made"
        if state.kind == "fresh":
            return "the basis is fresh"
        from studio.basis.results import needs

        return needs(context.basis)

    def can_move() -> str:
        if context.shape is None:
            return NO_RIG
        return "" if stage.display.analysis is not None else "there is no basis yet"

    def move(amount: float) -> None:
        window.attempt(stage.set_amounts, dict.fromkeys(context.chosen, amount))

    def weak() -> str:
        if stage.display.analysis is None:
            return "there is no basis yet"
        return "" if stage.teller.weak_shapes() else "every shape looks like its hand shape"

    def choose(title: str, verb: str, items: BasisItems[Any], present: str | None, deed: Callable[[str], None]) -> None:
        names = [(item.id, item.name) for item in items]
        dialog = ChoiceDialog(title, verb, items.word.capitalize(), names, present, window)
        dialog.picked.connect(lambda item_id: window.attempt(deed, item_id))
        dialog.open()

    def choose_hand() -> None:
        choose("Hand-sculpted rig", "Use rig", context.basis.rigs, context.setup.hand, stage.choose_hand)

    def choose_motion() -> None:
        motions, present = context.basis.motions, context.setup.motion
        choose("Performance to measure by", "Use performance", motions, present, stage.choose_motion)

    def choice(items: BasisItems[Any], present: object, none: str) -> str:
        """Return why there is nothing to choose from; the only one can be chosen where none is in use."""
        if not len(items):
            return none
        return "" if len(items) > 1 or present is None else f"there is only one {items.word}"

    def remove(item_id: str | None) -> None:
        if item_id is not None:
            window.attempt(stage.remove_item, item_id)

    def settings() -> str:
        return "" if context.motion is not None else NO_MOTION

    bind("basis.analyse", follower.restart, can_analyse)
    bind("basis.next", stage.go_next, weak)
    bind("basis.to_hand", lambda: move(0.0), can_move)
    bind("basis.to_quasi", lambda: move(1.0), can_move)
    bind("basis.choose_hand", choose_hand, lambda: choice(context.basis.rigs, context.hand, NO_RIG))
    bind("basis.choose_motion", choose_motion, lambda: choice(context.basis.motions, context.motion, NO_MOTION))
    bind("basis.motion_settings", lambda: window.attempt(stage.motion_settings.open), settings)
    bind("basis.remove_rig", lambda: remove(context.setup.hand), lambda: "" if context.hand is not None else NO_RIG)
    bind("basis.remove_motion", lambda: remove(context.setup.motion), settings)
    bind("basis.copy_command", lambda: window.attempt(stage.copy_command), lambda: _inputs(stage))


def _inputs(stage: BasisStage) -> str:
    if stage.context.hand is None:
        return NO_RIG
    return "" if stage.context.motion is not None else NO_MOTION


def _bind_time(stage: BasisStage, window: MainWindow) -> None:
    bind, timeline, follower = window.actions_.bind, stage.centre.timeline, stage.follower

    def moving() -> str:
        return "" if follower.prepared is not None else NO_MOTION

    def worst() -> None:
        frames = stage.display.worst
        if frames:
            here = stage.context.frame
            at = frames.index(here) + 1 if here in frames else 0
            stage.go_to_frame(frames[at % len(frames)])

    bind("basis.play", timeline.toggle_play, moving)
    bind("basis.frame_back", lambda: timeline.step(-1), moving)
    bind("basis.frame_on", lambda: timeline.step(1), moving)
    bind("basis.worst", worst, lambda: "" if stage.display.worst else "there are no figures yet")


def _bind_views(stage: BasisStage, window: MainWindow) -> None:
    actions, views = window.actions_, stage.centre.views

    def no_views() -> str:
        return "" if views.scene is not None else "3-D is not there yet"

    def no_rig() -> str:
        return "" if stage.context.rig is not None else NO_RIG

    def show_pca(on: bool) -> None:
        views.set_pca_visible(on)
        stage.want_pca(on)

    state = views.state
    actions.bind("view.frame", views.frame, no_rig, tip="Bring the whole face into view")
    for name, deed, start, changed, text, tip in (
        ("view.wire", views.set_wireframe, state.wire, views.wireframe_changed, "", "Show the edges of the mesh"),
        (
            "view.points", views.set_markers_visible, state.markers, views.markers_changed,
            "&Markers", "Show captured and reconstructed markers",
        ),
        ("view.heat", views.set_heatmap, state.heat, views.heatmap_changed, "", "Show the change of the shape in mm"),
        ("basis.clip_heat", views.set_clip_heat_visible, state.clip_heat, views.clip_heat_changed, "", ""),
        ("basis.pca", show_pca, state.pca, views.pca_changed, "", ""),
        ("view.orthographic", views.set_orthographic, views.orthographic, views.orthographic_changed, "", ""),
    ):  # fmt: skip
        actions.bind(name, deed, no_views if name == "view.orthographic" else no_rig, text=text, tip=tip)
        actions.start(name, start)
        changed.connect(lambda on, name=name: _show(window, name, on))

    def show_mode(mode: str) -> None:
        for key in MODES:
            actions.mark(f"basis.{key}", key == mode)

    def choose_mode(mode: str) -> None:
        views.set_mode(mode)
        stage.display.show_grid()
        show_mode(mode)

    for mode in MODES:
        actions.bind(f"basis.{mode}", lambda _on, mode=mode: choose_mode(mode), no_rig)
        actions.start(f"basis.{mode}", mode == state.mode)
    views.mode_changed.connect(show_mode)
    for side in SIDES:
        actions.bind(f"view.{side}", lambda side=side: views.view(side), no_rig)


def _show(window: MainWindow, name: str, on: bool) -> None:
    if window.stage_id == "basis":
        window.actions_[name].setChecked(on)
