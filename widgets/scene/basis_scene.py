"""The linked pictures of the basis stage: shapes above, a frame and its reconstructions below."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from engine.mesh import FloatArray
from widgets.scene.background import ViewColours, apply_background
from widgets.scene.basis_content import BasisContent
from widgets.scene.basis_face import RigFace
from widgets.scene.basis_marks import RECONSTRUCTED, MarkerPairs
from widgets.scene.basis_state import (
    BY_HAND,
    BY_PCA,
    BY_QUASI,
    CHANGE,
    FRAME_VIEWS,
    HAND,
    ORIGINAL,
    QUASI,
    VIEWS,
    ViewState,
    places,
)
from widgets.scene.basis_wipe import Wipe
from widgets.scene.basis_words import BasisWords
from widgets.scene.heatmap import HeatRange, heat_colours
from widgets.scene.lights import add_studio_light
from widgets.scene.overlay import Reading

Size = tuple[float, float]
_HEAT_VIEWS = (CHANGE, BY_HAND, BY_QUASI, BY_PCA)


class BasisScene:
    """Everything in the linked views, on the first seven renderers of any pyvista plotter.

    It reads a ``BasisContent`` and changes nothing of it; ``refresh`` brings the pictures up to date, and a face
    whose pose is the same value as before is not touched. Sizes and places are pixels of the view, from the lower
    left; ``scale`` is how many screen pixels make one pixel of the layout. Without ``overlays`` nothing is written
    over the faces.
    """

    def __init__(self, plotter: Any, content: BasisContent, colours: ViewColours, *, overlays: bool = True) -> None:
        self._renderers = list(plotter.renderers)[:VIEWS]
        self._content, self._colours = content, colours
        self._state = ViewState()
        self.faces = [RigFace(renderer) for renderer in self._renderers]
        self.twin = RigFace(self._renderers[HAND])
        self._marks = {view: MarkerPairs(self._renderers[view]) for view in FRAME_VIEWS}
        self.wipe = Wipe(self._renderers[HAND])
        self.words = BasisWords(self._renderers, overlays)
        self._readings = [Reading(renderer) for renderer in self._renderers]
        self._painted: dict[int, tuple[Any, ...]] = {}
        self._drawn: dict[int, tuple[Any, ...]] = {}
        self._all_sizes: list[Size] = []
        self._sizes: dict[int, Size] = {}
        self._scale = 1.0
        self._overlays = overlays
        for renderer in self._renderers:
            add_studio_light(renderer)
        self.set_colours(colours)

    @property
    def camera(self) -> Any:
        """The camera all views share."""
        return self._renderers[HAND].camera

    @property
    def empty(self) -> bool:
        """Whether there is no rig."""
        return self._content.rig is None

    @property
    def state(self) -> ViewState:
        """What is switched on."""
        return self._state

    def set_state(self, state: ViewState) -> None:
        """Take over what is switched on; ``refresh`` shows it."""
        self._state = state

    def set_colours(self, colours: ViewColours) -> None:
        """Dress all views in a theme."""
        self._colours = colours
        self._painted.clear()
        for renderer in self._renderers:
            apply_background(renderer, colours)
        for marks in self._marks.values():
            marks.set_colours(colours, self._scale)

    def layout(self, sizes: Sequence[Size], scale: float) -> None:
        """Place everything written for views of these sizes in pixels, one size for each of the views."""
        self._all_sizes, changed, self._scale = list(sizes), scale != self._scale, scale
        if changed:
            self.set_colours(self._colours)
        self.refresh()
        self.turn()

    def refresh(self, axis: float | None = None) -> set[int]:
        """Show what the content holds now; returns the views whose picture changed.

        ``axis`` (mm) keeps the bars' right end while a handle is dragged. A view all of whose data are the same
        values as before is not touched.
        """
        content, state = self._content, self._state
        shown = places(state)
        self._sizes = {view: self._all_sizes[view] for view in shown} if self._all_sizes else {}
        signs = {view: self._sign(view, axis) for view in shown}
        changed = {view for view, sign in signs.items() if not _same(sign, self._drawn.get(view, ()))}
        self._drawn = signs
        for view in sorted(changed):
            face = self.faces[view]
            face.set_rig(content.rig)
            if view == HAND:
                self._show_shapes()
            else:
                face.set_pose(content.pose(view))
            face.set_wire(state.wire, self._scale)
            if view in FRAME_VIEWS:
                self._marks[view].set_visible(state.markers and not state.clip_heat and not face.empty)
                self._marks[view].set(content.captured, content.rebuilt.get(view))
                face.set_look("textured" if state.textured else "clay")
            if view in _HEAT_VIEWS:
                self._colour(view)
            if view in self._sizes:
                self.words.write(view, content, state, self._colours, self._sizes[view], self._scale, axis)
                self._turn_view(view)
        return changed

    def turn(self) -> None:
        """Draw again what depends on the camera alone."""
        for view in self._sizes:
            self._turn_view(view)

    def _turn_view(self, view: int) -> None:
        size = self._sizes[view]
        if view in self._marks:
            self._marks[view].turn(self.camera, size[1])
        if view == HAND and self.wipe.shown:
            self.wipe.set(self._state.wipe, self.camera, self._colours, size, self._scale)
        if view == ORIGINAL:
            self.words.turn(self.camera, self._colours, size, self._scale)

    def framed(self) -> FloatArray:
        """Return the points (N, 3) in mm to bring into the picture; none where there is no rig."""
        rig = self._content.rig
        return np.zeros((0, 3)) if rig is None else rig.outline

    def bounds(self) -> Sequence[float] | None:
        """Return the box that holds the rig in every sensible pose, mm."""
        rig = self._content.rig
        if rig is None:
            return None
        low, high = rig.neutral.points.min(axis=0) - 60.0, rig.neutral.points.max(axis=0) + 60.0
        return tuple(float(x) for x in np.stack([low, high], axis=1).ravel())

    def pick(self, view: int, segment: tuple[FloatArray, FloatArray]) -> tuple[int, FloatArray] | None:
        """Return vertex and place in mm where a line of sight meets the face of a view."""
        face = self.faces[view] if not self.faces[view].empty else self.twin
        return face.locate(*segment)

    def read_at(self, view: int, segment: tuple[FloatArray, FloatArray] | None, place: Size) -> set[int]:
        """Show the value under the pointer in a heatmap, or hide it; returns the views whose picture changed."""
        values = self._values(view)
        hit = None if segment is None or values is None else self.pick(view, segment)
        changed = {k for k, reading in enumerate(self._readings) if (k != view or hit is None) and reading.hide()}
        if hit is None or values is None:
            return changed
        value = float(values[hit[0]])
        text = "not measured" if np.isnan(value) else f"{value:.2f} mm"
        self._readings[view].show(text, place, self._colours, self._sizes[view], self._scale)
        return changed | {view}

    def close(self) -> None:
        """Take everything out of the renderers."""
        parts: list[Any] = [*self.faces, self.twin, *self._marks.values(), *self._readings]
        for part in parts:
            part.remove()
        self.wipe.remove()
        self.words.remove()
        self._renderers = []

    def _sign(self, view: int, axis: float | None) -> tuple[Any, ...]:
        """Return all that a view's picture depends on, but for the camera."""
        content, state = self._content, self._state
        parts: list[Any] = [content.rig, content.pose(view), self._colours, self._scale, self._sizes.get(view)]
        if view in (HAND, QUASI):
            parts += [content.name, content.note, content.titles, state.mode, state.wire]
        if view == HAND:
            twin = content.pose(QUASI) if state.together or state.flipped else None
            parts += [state.flipped, twin, state.wipe if state.mode == "wipe" else None, content.has(QUASI)]
        if view == CHANGE:
            parts += [content.titles, state.wire]
        if view in _HEAT_VIEWS and self._values(view) is not None:
            parts += [self._values(view), self._range(view), axis]
        if view in FRAME_VIEWS:
            parts += [content.index, content.rms.get(view), content.rebuilt.get(view), content.captured]
            parts += [state.markers, state.textured, state.wire, state.clip_heat, content.frames]
        return tuple(parts)

    def _show_shapes(self) -> None:
        """Put hand and quasi-eigen shape into the first view, as the mode wants them there."""
        content, state = self._content, self._state
        hand, twin = self.faces[HAND], self.twin
        twin.set_rig(content.rig if state.together or state.flipped else None)
        both = state.together and not state.flipped
        hand.set_visible(not state.flipped)
        if not state.flipped:
            hand.set_pose(content.pose(HAND))
        twin.set_visible(both or state.flipped)
        if both or state.flipped:
            twin.set_pose(content.pose(QUASI))
        wiping = state.mode == "wipe" and both
        hand.set_planes([self.wipe.left] if wiping else [])
        twin.set_planes([self.wipe.right] if wiping else [])
        self.wipe.show(wiping, self._overlays)
        over = state.mode == "overlay" and both
        twin.set_tint(RECONSTRUCTED[self._colours.name] if over else None, 0.5 if over else 1.0)
        twin.set_wire(state.wire, self._scale)

    def _values(self, view: int) -> FloatArray | None:
        if view == CHANGE:
            return self._content.change
        return self._content.clip.get(view) if self._state.clip_heat else None

    def _range(self, view: int) -> HeatRange:
        return self._content.heat if view == CHANGE else self._content.clip_heat

    def _colour(self, view: int) -> None:
        values, face = self._values(view), self.faces[view]
        if values is None:
            face.set_look("textured" if self._state.textured and view != CHANGE else "clay")
            return
        heat = self._range(view)
        wanted = (values, heat, self._colours.name, self._content.rig)
        before = self._painted.get(view)
        if before is None or not _same(wanted, before):
            face.set_heat(heat_colours(values, heat, self._colours.missing))
            self._painted[view] = wanted
        face.set_look("heat")


def _same(first: tuple[Any, ...], second: tuple[Any, ...]) -> bool:
    """Return whether two tuples hold the very same objects, or equal plain values."""
    if len(first) != len(second):
        return False
    plain = (str, float, int, tuple, HeatRange, ViewColours, type(None))
    return all(
        a is b or (isinstance(a, plain) and isinstance(b, plain) and a == b) for a, b in zip(first, second, strict=True)
    )
