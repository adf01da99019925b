"""The actions of the scan stage: what each does, and why it cannot just now."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from engine.landmarks import Landmark, LandmarkState
from studio.actions import Actions
from studio.project.document import needs
from studio.scan import edits
from studio.scan.view_actions import bind_views

if TYPE_CHECKING:
    from studio.main_window import MainWindow
    from studio.scan.controller import ScanStage

NO_SCAN = "add a scan first"
NO_POINT = "choose a fiducial first (N)"


def bind_actions(stage: ScanStage, window: MainWindow) -> None:
    """Give the scan stage's declared actions their deeds and their reasons."""
    actions = window.actions_
    _bind_files(stage, window, actions)
    _bind_fiducials(stage, window, actions)
    _bind_fit(stage, actions)
    bind_views(stage, actions)


def _bind_files(stage: ScanStage, window: MainWindow, actions: Actions) -> None:
    files, context = stage.files, stage.context

    def scan() -> str:
        return "" if context.item is not None else NO_SCAN

    def some_placed() -> str:
        item, scheme = context.item, context.scheme
        if item is None or scheme is None:
            return NO_SCAN
        return "" if edits.placed(item.landmarks, scheme) else "no fiducial is placed yet"

    def edit_schemes() -> None:
        from studio.scan.scheme_dialog import open_scheme_editor

        open_scheme_editor(context, window)

    def rename() -> None:
        if context.scan_id is not None:
            window.show_dock("scans")
            stage.centre.inputs.scan_list.edit_name(context.scan_id)

    actions.bind("scan.add", files.add)
    actions.bind("scan.add_folder", files.add_folder)
    actions.bind("scan.sample", lambda: window.attempt(files.open_sample))
    actions.bind("scan.import", lambda: window.attempt(files.fiducials.ask_import), scan)
    actions.bind("scan.export", lambda: window.attempt(files.fiducials.ask_export), some_placed)
    scheme = actions.bind("scan.scheme", edit_schemes)
    for panel in (stage.centre.inputs.source_panel, stage.centre.fiducials):
        panel.scheme_editor_requested.connect(scheme.trigger)
    actions.bind("scan.place_camera", lambda: window.attempt(files.placing.open), files.placing.reason)
    actions.bind("scan.rename", rename, scan)
    actions.bind("scan.remove", lambda: context.scan_id and window.attempt(stage.remove, context.scan_id), scan)


def _bind_fiducials(stage: ScanStage, window: MainWindow, actions: Actions) -> None:
    context, editor = stage.context, stage.editor

    def point() -> Landmark | None:
        return None if context.item is None or context.fiducial is None else context.landmarks[context.fiducial]

    def reason(allowed: bool, why: str) -> str:
        if context.item is None:
            return NO_SCAN
        if point() is None:
            return NO_POINT
        return "" if allowed else why

    def can_confirm() -> str:
        known = point()
        return reason(known is not None and known.state == LandmarkState.PROPOSED, "this fiducial is not a proposal")

    def can_confirm_all() -> str:
        scheme = context.scheme
        if scheme is None:
            return NO_SCAN
        return "" if context.landmarks.names(LandmarkState.PROPOSED, order=scheme.names) else "nothing is proposed"

    def can_skip() -> str:
        known = point()
        return reason(known is not None and not known.locked, "this fiducial is locked (L)")

    def can_lock() -> str:
        known = point()
        return reason(known is not None and known.state == LandmarkState.PLACED, "only a placed fiducial can be locked")

    def can_unset() -> str:
        known = point()
        if known is not None and known.locked:
            return "this fiducial is locked (L)"
        return reason(known is not None and known.state != LandmarkState.UNSET, "this fiducial is not set")

    def can_mirror() -> str:
        item, scheme = context.item, context.scheme
        if item is None or scheme is None:
            return NO_SCAN
        return "" if edits.placed(item.landmarks, scheme) else "place fiducials on one side first"

    def can_carry() -> str:
        return "" if stage.display.carry_sources() else "no other scan has fiducials yet"

    def can_carry_to_all() -> str:
        item, scheme = context.item, context.scheme
        if item is None or scheme is None:
            return NO_SCAN
        if not edits.placed(item.landmarks, scheme):
            return "place the fiducials of this scan first"
        return "" if stage.carrier.targets() else "every other scan has its fiducials"

    def can_go_on() -> str:
        return "" if context.item is not None else NO_SCAN

    def on_current(deed: Callable[[str | None], None]) -> Callable[[], bool]:
        return lambda: window.attempt(deed, context.fiducial)

    actions.bind("scan.next", stage.go_next, can_go_on)
    actions.bind("scan.confirm", on_current(editor.confirm), can_confirm)
    actions.bind("scan.confirm_all", lambda: window.attempt(editor.confirm_all), can_confirm_all)
    actions.bind("scan.skip", on_current(editor.skip), can_skip)
    actions.bind("scan.lock", on_current(editor.lock), can_lock)
    actions.bind("scan.unset", on_current(editor.unset), can_unset)
    actions.bind("scan.mirror", lambda: window.attempt(editor.mirror), can_mirror)
    actions.bind("scan.carry", lambda: window.attempt(stage.carry), can_carry)
    actions.bind("scan.carry_to_all", lambda: window.attempt(stage.carry_to_all), can_carry_to_all)


def _bind_fit(stage: ScanStage, actions: Actions) -> None:
    context = stage.context

    def can_fit() -> str:
        item = context.item
        if item is None:
            return NO_SCAN
        needed = needs(item)
        if needed:
            return needed
        return "the fit is fresh" if context.project.state(item.id).kind == "fresh" else ""

    def can_fit_all() -> str:
        states = [(item, context.project.state(item.id)) for item in context.project.scans]
        if not states:
            return NO_SCAN
        waiting = [item for item, state in states if state.kind != "fresh" and not needs(item)]
        return "" if waiting else "no scan is waiting to be fitted"

    def can_export() -> str:
        item = context.item
        if item is None:
            return NO_SCAN
        return needs(item) or ("" if context.project.state(item.id).kind == "fresh" else "fit the face first")

    def can_copy() -> str:
        return NO_SCAN if context.item is None else needs(context.item)

    actions.bind("scan.fit", stage.fit, can_fit)
    actions.bind("scan.copy_command", stage.copy_command, can_copy)
    actions.bind("scan.fit_all", stage.fit_all, can_fit_all)
    actions.bind("scan.export_face", stage.export_face, can_export)
