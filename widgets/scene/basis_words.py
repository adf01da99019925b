"""What is written over the basis stage's views: names, figures, bars, legends, and what an empty view waits for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from widgets.scene.background import ViewColours
from widgets.scene.basis_content import BasisContent, beyond, counted
from widgets.scene.basis_marks import CAPTURED, RECONSTRUCTED, Legend
from widgets.scene.basis_plates import CornerPlate
from widgets.scene.basis_state import (
    BY_HAND,
    BY_PCA,
    BY_QUASI,
    CHANGE,
    HAND,
    ORIGINAL,
    QUASI,
    ViewState,
)
from widgets.scene.colour_bar import ColourBar
from widgets.scene.materials import CLAY
from widgets.scene.overlay import Gizmo, Message, NamePlate

Size = tuple[float, float]
_NARROW = 440.0
BARS = (CHANGE, BY_QUASI)
"""Views that have a colour bar."""
_EMPTY: Mapping[int, tuple[str, str]] = {
    HAND: ("", "Choose a shape"),
    QUASI: ("", "Appears when a performance is open"),
    CHANGE: ("", "Appears when a performance is open"),
    ORIGINAL: ("No performance yet", "Open one that moves this face"),
    BY_HAND: ("", "Appears when a performance is open"),
    BY_QUASI: ("", "Appears when a performance is open"),
    BY_PCA: ("", "Appears when a performance is open"),
}


class BasisWords:
    """Everything flat in the views; without ``overlays`` there is none."""

    def __init__(self, renderers: Sequence[Any], overlays: bool) -> None:
        self._on = overlays
        self._names = [NamePlate(renderer) for renderer in renderers]
        self._corners = [CornerPlate(renderer) for renderer in renderers]
        self._messages = [Message(renderer) for renderer in renderers]
        self._legends = {view: Legend(renderers[view]) for view in (HAND, BY_HAND)}
        self._gizmo = Gizmo(renderers[ORIGINAL])
        self.bars = {view: ColourBar(renderers[view], movable=view == CHANGE) for view in BARS}
        for bar in self.bars.values():
            bar.hide()

    def write(
        self,
        view: int,
        content: BasisContent,
        state: ViewState,
        colours: ViewColours,
        size: Size,
        scale: float,
        axis: float | None,
    ) -> None:
        """Write everything for a view of ``size`` pixels."""
        if not self._on:
            return
        clipped = state.clip_heat and view in content.clip
        narrow = clipped and size[0] < _NARROW * scale
        corner = "" if narrow else self._corner(view, content, state)
        self._corners[view].set(corner, colours, size, scale)
        room = size[0] - (self._corners[view].width + 4 * scale if corner else 0.0)
        title, note = self._name(view, content, state)
        note = note.replace(f"RMS over {_over(content)}", "clip RMS") if narrow else note
        self._names[view].set(title, note, colours, (room, size[1]), scale)
        there = content.has(view) or (view == HAND and state.flipped and content.has(QUASI))
        say = ("", "") if there or content.rig is None else _EMPTY[view]
        self._messages[view].set(*say, colours, size, scale)
        bar = self.bars.get(view)
        if bar is not None:
            barred = content.change is not None if view == CHANGE else state.clip_heat and view in content.clip
            bar.hide(not barred)
            if barred:
                bar.set(content.heat if view == CHANGE else content.clip_heat, "", colours, size, scale, axis)
        if view in self._legends:
            self._legends[view].set(self._legend(view, content, state, colours), colours, scale)

    def turn(self, camera: Any, colours: ViewColours, size: Size, scale: float) -> None:
        """Draw the axes as ``camera`` sees them in a view of ``size`` pixels."""
        if self._on:
            self._gizmo.set(camera, colours, size, scale)

    def remove(self) -> None:
        """Take everything out of the renderers."""
        parts: list[Any] = [*self._names, *self._corners, *self._messages, *self._legends.values()]
        for part in [*parts, self._gizmo, *self.bars.values()]:
            part.remove()

    def _name(self, view: int, content: BasisContent, state: ViewState) -> tuple[str, str]:
        name, note = content.name, content.note
        behind = ", ".join(part for part in (name, note) if part)
        first, second = content.titles
        if view == HAND:
            if state.flipped:
                return second, behind
            return ("Overlay" if state.mode == "overlay" else first), name
        if view == QUASI:
            return second, behind
        if view == CHANGE:
            return "Change", f"{second} − {first}".lower()
        if view == ORIGINAL:
            return "Original", f"frame {counted(content.index + 1)}" if content.has(view) else ""
        title = {BY_HAND: "By hand", BY_QUASI: "By quasi-eigen", BY_PCA: "By PCA"}[view]
        if state.clip_heat and view in content.clip and content.has(view):
            return title, f"RMS over {_over(content)} {np.sqrt(np.nanmean(content.clip[view] ** 2)):.2f} mm"
        rms = content.rms.get(view)
        return title, f"RMS {rms:.2f} mm" if rms is not None and content.has(view) else ""

    def _corner(self, view: int, content: BasisContent, state: ViewState) -> str:
        if view == HAND and state.mode == "wipe" and not state.flipped:
            return content.titles[1]
        if view == CHANGE and content.change is not None:
            return beyond(content.change, content.heat)
        if view in content.clip and state.clip_heat:
            return beyond(content.clip[view], content.clip_heat)
        return ""

    def _legend(
        self, view: int, content: BasisContent, state: ViewState, colours: ViewColours
    ) -> list[tuple[str, str]]:
        red, blue = CAPTURED[colours.name], RECONSTRUCTED[colours.name]
        if view == HAND:
            over = state.mode == "overlay" and not state.flipped and content.has(QUASI) and content.has(HAND)
            return [(CLAY.colour, content.titles[0].lower()), (blue, content.titles[1].lower())] if over else []
        marked = state.markers and not state.clip_heat and content.captured is not None and view in content.rebuilt
        return [(red, "captured"), (blue, "reconstructed")] if marked else []


def _over(content: BasisContent) -> str:
    return f"{counted(content.frames)} frames" if content.frames else "the clip"
