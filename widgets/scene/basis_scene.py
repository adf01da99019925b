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
from widgets.scene.heatmap import heat_colours
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

    def refresh(self, axis: float | None = None) -> None:
        """Show what the content holds now; ``axis`` (mm) keeps the bars' right end while a handle is dragged."""
        content, state = self._content, self._state
        shown = places(state)
        self._sizes = {view: self._all_sizes[view] for view in shown} if self._all_sizes else {}
        for view in shown:
            self.faces[view].set_rig(content.rig)
        self.twin.set_rig(content.rig if state.together or state.flipped else None)
        self._show_shapes()
        for view in (QUASI, CHANGE, *FRAME_VIEWS):
            if view in shown:
                self.faces[view].set_pose(content.pose(view))
        for view in (HAND, QUASI):
            self.faces[view].set_wire(state.wire, self._scale)
        for view in FRAME_VIEWS:
            if view in shown:
                self.faces[view].set_wire(state.wire, self._scale)
                self._marks[view].set_visible(state.markers)
                self._marks[view].set(content.captured, content.rebuilt.get(view))
        for view in _HEAT_VIEWS:
            if view in shown:
                self._colour(view)
        if ORIGINAL in shown:
            self.faces[ORIGINAL].set_look("textured" if state.textured else "clay")
        self.words.write(content, state, self._colours, self._sizes, self._scale, axis)
        self.turn()

    def turn(self) -> None:
        """Draw again what depends on the camera alone."""
        for view, marks in self._marks.items():
            if view in self._sizes:
                marks.turn(self.camera, self._sizes[view][1])
        if HAND in self._sizes:
            self.wipe.set(self._state.wipe, self.camera, self._colours, self._sizes[HAND], self._scale)
        self.words.turn(self.camera, self._colours, self._sizes, self._scale)

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

    def read_at(self, view: int, segment: tuple[FloatArray, FloatArray] | None, place: Size) -> bool:
        """Show the value under the pointer in a heatmap, or hide it; returns whether the picture changed."""
        values = self._values(view)
        hit = None if segment is None or values is None else self.pick(view, segment)
        others = [reading.hide() for k, reading in enumerate(self._readings) if k != view]
        if hit is None or values is None:
            return self._readings[view].hide() or any(others)
        value = float(values[hit[0]])
        text = "not measured" if np.isnan(value) else f"{value:.2f} mm"
        self._readings[view].show(text, place, self._colours, self._sizes[view], self._scale)
        return True

    def close(self) -> None:
        """Take everything out of the renderers."""
        parts: list[Any] = [*self.faces, self.twin, *self._marks.values(), *self._readings]
        for part in parts:
            part.remove()
        self.wipe.remove()
        self.words.remove()
        self._renderers = []

    def _show_shapes(self) -> None:
        """Put hand and quasi-eigen shape into the first view, as the mode wants them there."""
        content, state = self._content, self._state
        hand, twin = self.faces[HAND], self.twin
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
        self.wipe.show(wiping and self._overlays)
        over = state.mode == "overlay" and both
        twin.set_tint(RECONSTRUCTED[self._colours.name] if over else None, 0.5 if over else 1.0)
        twin.set_wire(state.wire, self._scale)

    def _values(self, view: int) -> FloatArray | None:
        if view == CHANGE:
            return self._content.change
        return self._content.clip.get(view) if self._state.clip_heat else None

    def _colour(self, view: int) -> None:
        values, face = self._values(view), self.faces[view]
        if values is None:
            face.set_look("textured" if self._state.textured and view != CHANGE else "clay")
            return
        wanted = (values, self._content.heat, self._colours.name, self._content.rig)
        before = self._painted.get(view)
        if before is None or any(a is not b for a, b in zip(wanted, before, strict=True)):
            face.set_heat(heat_colours(values, self._content.heat, self._colours.missing))
            self._painted[view] = wanted
        face.set_look("heat")
