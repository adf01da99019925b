"""Binds the actions of the View menu to the picture and the 3-D views of the scan stage."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from studio.actions import Actions

if TYPE_CHECKING:
    from studio.scan.controller import ScanStage

SMOOTH, LOW, HIGH = "view/smooth", "view/low", "view/high"
SIDES = ("front", "left", "right", "three_quarter", "top", "back", "below")
"""Standard views that have an action."""


_NEAR = 0.16
"""How far around a fiducial the picture shows, in heights of the face."""


class Framing(QObject):
    """Brings everything, or the current fiducial's neighbourhood, into picture and 3-D at once."""

    def __init__(self, stage: ScanStage) -> None:
        super().__init__(stage)
        self._stage = stage
        self._near: str | None = None

    def all(self) -> None:
        """Bring the whole picture and face into view."""
        self._near = None
        self._stage.centre.canvas_panel.canvas.toggle_fit()
        self._stage.centre.views.frame()

    def selected(self) -> None:
        """Bring the current fiducial's neighbourhood into view; where it is there already, everything again."""
        context, centre = self._stage.context, self._stage.centre
        name, canvas = context.fiducial, centre.canvas_panel.canvas
        if name is None:
            return
        if name == self._near:
            self._near = None
            canvas.fit_view()
            centre.views.frame()
            return
        self._near = name
        place = canvas.fiducials.place(name)
        if place is not None:
            canvas.frame_about(place, _NEAR * canvas.content_rect().height())
        centre.views.frame_fiducial(name)

    def look(self, side: str) -> None:
        """Look at the whole face from a standard side."""
        self._near = None
        self._stage.centre.views.view(side)

    def reason(self) -> str:
        """Say why no fiducial can be brought near; empty where one can."""
        context, shown = self._stage.context, self._stage.shown
        if context.item is None:
            return "no scan is in view"
        if context.fiducial is None:
            return "no fiducial is selected"
        return "" if shown is not None or context.landmarks[context.fiducial].is_set else "this fiducial is not set"


def bind_views(stage: ScanStage, actions: Actions) -> None:
    """Give the actions of the View menu their deeds."""
    views, panel = stage.centre.views, stage.centre.canvas_panel
    framing = Framing(stage)

    def wire(on: bool) -> None:
        panel.wire_button.setChecked(on)
        views.set_wireframe(on)

    def no_face() -> str:
        return "" if stage.shown is not None else "there is no face yet"

    def no_views() -> str:
        return "" if views.scene is not None else "3-D is not there yet"

    actions.bind("view.frame", framing.all)
    actions.bind("view.frame_selected", framing.selected, framing.reason)
    for name, deed, start in (
        ("view.wire", wire, views.wireframe),
        ("view.points", views.set_points, views.points),
        ("view.heat", views.set_heatmap, views.heatmap),
        ("view.textured", lambda on: views.set_mode("textured" if on else "shaded"), views.mode == "textured"),
        ("view.loupe", panel.loupe_button.setChecked, False),
    ):
        action = actions.bind(name, deed)
        action.setChecked(start)
    actions.bind("view.orthographic", views.set_orthographic, no_views)
    views.orthographic_changed.connect(actions["view.orthographic"].setChecked)
    views.wireframe_changed.connect(actions["view.wire"].setChecked)
    views.points_changed.connect(actions["view.points"].setChecked)
    views.heatmap_changed.connect(actions["view.heat"].setChecked)
    views.mode_changed.connect(lambda mode: actions["view.textured"].setChecked(mode == "textured"))
    panel.loupe_button.toggled.connect(actions["view.loupe"].setChecked)
    for side in SIDES:
        actions.bind(f"view.{side}", lambda side=side: framing.look(side), no_face)
    _follow_heatmap(stage)


def _follow_heatmap(stage: ScanStage) -> None:
    """Let the views and the settings agree on the heatmap's range and on whether it is smoothed."""
    views, settings = stage.centre.views, stage.window.settings

    def show(key: str) -> None:
        if key == SMOOTH:
            views.set_smooth(settings[SMOOTH])
        elif key in (LOW, HIGH) and settings[LOW] < settings[HIGH]:  # both ends change one after the other
            views.set_range(settings[LOW], settings[HIGH])

    def keep(smooth: bool) -> None:
        settings[SMOOTH] = smooth

    def keep_range(low: float, high: float) -> None:
        settings.changed.disconnect(show)  # the views show it already; one end alone is no range of theirs
        try:
            settings[LOW], settings[HIGH] = low, high
        finally:
            settings.changed.connect(show)

    show(SMOOTH)
    show(HIGH)
    settings.changed.connect(show)
    views.smooth_changed.connect(keep)
    views.range_changed.connect(keep_range)
