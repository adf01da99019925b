"""The two pictures of a fitted face: as it looks, and how far it lies from the scan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.mesh import BoolArray, FloatArray, TriangleMesh
from engine.scan.range_image import RangeImage
from widgets.scene.background import ViewColours, apply_background
from widgets.scene.calm import SMOOTHED, calmed
from widgets.scene.camera import corners
from widgets.scene.colour_bar import ColourBar
from widgets.scene.face import FaceActor
from widgets.scene.fiducials import FiducialMarks
from widgets.scene.heatmap import HeatRange, heat_colours, share_text
from widgets.scene.lights import add_studio_light
from widgets.scene.overlay import Gizmo, Message, NamePlate, Reading
from widgets.scene.scan_points import ScanPoints, on_surface, sample

FACE, DISTANCE = 0, 1
"""Indices of the two views."""

Size = tuple[float, float]


class Fitted(Protocol):
    """What a picture needs to know of a fit; ``engine.scan.fit.FaceFit`` has it all."""

    @property
    def mesh(self) -> TriangleMesh:
        """Vertices in mm, faces, chart."""

    @property
    def normals(self) -> FloatArray:
        """Unit normals (N, 3)."""

    @property
    def pixels(self) -> FloatArray:
        """Where the vertices lie (N, 2) on the picture."""

    @property
    def filled(self) -> BoolArray:
        """Vertices (N,) on missing data."""

    @property
    def deviation_mm(self) -> FloatArray:
        """Distance (N,) to the scan, NaN where filled."""

    @property
    def levels(self) -> int:
        """How often the template was subdivided."""


class FitScene:
    """Everything in the two linked views, on the first two renderers of any pyvista plotter.

    It holds copies of what it shows and changes nothing. Sizes and places are pixels of the view, from the
    lower left; ``scale`` is how many screen pixels make one pixel of the layout. Without ``overlays`` nothing is
    written over the face: no names, no marks, no colour bar.
    """

    def __init__(self, plotter: Any, colours: ViewColours, *, overlays: bool = True) -> None:
        self._overlays = overlays
        self._renderers = list(plotter.renderers)[:2]
        self._colours = colours
        self.faces = [FaceActor(renderer, colours) for renderer in self._renderers]
        self._points = [ScanPoints(renderer, colours) for renderer in self._renderers]
        self._names = [NamePlate(renderer) for renderer in self._renderers]
        self._messages = [Message(renderer) for renderer in self._renderers]
        self._marks = FiducialMarks(self._renderers[FACE])
        self._gizmo = Gizmo(self._renderers[FACE])
        self.bar = ColourBar(self._renderers[DISTANCE])
        self._readings = [Reading(renderer) for renderer in self._renderers]
        self._deviation = np.zeros(0)
        self._filled = np.zeros(0, dtype=bool)
        self._heat = HeatRange()
        self._smooth = True
        self._calm: FloatArray | None = None
        self._axis: float | None = None
        self._look: Literal["shaded", "textured"] = "textured"
        self._wire, self._dots = True, True
        self._note = ""
        self._measured: tuple[NDArray[np.float32], FloatArray] | None = None
        self._dot_colours: NDArray[np.uint8] | None = None
        self._scan_bounds: Sequence[float] | None = None
        self._sizes: list[Size] = [(1.0, 1.0)] * 2
        self._scale = 1.0
        for renderer in self._renderers:
            add_studio_light(renderer)
        self.faces[DISTANCE].set_look("heat")
        self.set_look("textured")
        self.set_wire(True)
        self.set_colours(colours)

    @property
    def camera(self) -> Any:
        """The camera both views share."""
        return self._renderers[FACE].camera

    @property
    def heat(self) -> HeatRange:
        """The range of the colour bar, mm."""
        return self._heat

    @property
    def empty(self) -> bool:
        """Whether there is no face."""
        return self.faces[FACE].empty

    def set_scan(self, scan: RangeImage | None) -> None:
        """Show a sample of a scan's points, or none."""
        self._measured = None if scan is None else sample(scan.points)
        self._dot_colours = None
        if scan is not None and scan.colour is not None and self._measured is not None:
            columns, rows = self._measured[1].astype(np.intp).T
            self._dot_colours = scan.colour[rows, columns]
        self._scan_bounds = None
        if self._measured is not None and len(self._measured[0]):
            # Spikes stand far out; the middle 99 % say where the subject is.
            low, high = np.percentile(self._measured[0], [0.5, 99.5], axis=0)
            self._scan_bounds = tuple(np.stack([low, high], axis=1).ravel())
        self._put_dots(None)

    def set_fit(self, fit: Fitted | None, picture: Any | None = None) -> None:
        """Show a fitted face with a colour picture (H, W, 3) uint8, or nothing."""
        if fit is None:
            for face in self.faces:
                face.clear()
            self._deviation, self._filled = np.zeros(0), np.zeros(0, dtype=bool)
        else:
            self._deviation, self._filled = np.array(fit.deviation_mm), np.array(fit.filled)
            self._calm = None
            mesh = fit.mesh
            for face, texture in zip(self.faces, (picture, None), strict=True):
                face.set_mesh(mesh.vertices, mesh.faces, fit.normals, levels=fit.levels, uv=mesh.uv, picture=texture)
            self._colour_distance()
        self._put_dots(fit)
        self.write()

    def set_fiducials(self, points: Mapping[str, FloatArray]) -> None:
        """Mark named places in mm on the face."""
        self._marks.set_points(points)
        self.turn()

    def set_look(self, look: Literal["shaded", "textured"]) -> None:
        """Show the face as clay or with the scan's picture."""
        self._look = look
        self.faces[FACE].set_look(look)

    def set_wire(self, visible: bool) -> None:
        """Show or hide the template's edges."""
        self._wire = visible
        self.faces[FACE].set_wire(visible)

    def set_points(self, visible: bool) -> None:
        """Show or hide the scan's points in both views."""
        self._dots = visible
        for cloud in self._points:
            cloud.set_visible(visible)

    def set_heat(self, heat: HeatRange, axis: float | None = None) -> None:
        """Colour distances over a range; ``axis`` (mm) keeps the bar's right end still while a handle is dragged."""
        self._heat, self._axis = heat, axis
        self._colour_distance()
        self.write()

    def set_smooth(self, smooth: bool) -> None:
        """Colour each vertex by the mean around it, or by its own value; figures are always its own."""
        if smooth != self._smooth:
            self._smooth = smooth
            self._colour_distance()
            self.write()

    def set_note(self, note: str) -> None:
        """Add a word to the name of the first view, such as that it is a preview."""
        self._note = note

    def set_colours(self, colours: ViewColours) -> None:
        """Dress both views in a theme."""
        self._colours = colours
        for renderer in self._renderers:
            apply_background(renderer, colours)
        for face, cloud in zip(self.faces, self._points, strict=True):
            face.set_colours(colours, width=self._scale)
            cloud.set_colours(colours, size=1.2 * self._scale)
        self._colour_distance()

    def layout(self, sizes: Sequence[Size], scale: float) -> None:
        """Place everything written for views of these sizes in pixels."""
        self._sizes = list(sizes)
        changed, self._scale = scale != self._scale, scale
        if changed:
            self.set_colours(self._colours)
        self.write()

    def write(self) -> None:
        """Write names, messages, colour bar and axes again."""
        if not self._overlays:
            self.bar.hide()
            return
        colours, scale = self._colours, self._scale
        parts: list[str] = [self._look] if not self.empty else []
        parts += ["template wire"] if self._wire and not self.empty else []
        parts += ["scan points"] if self._dots and self._scan_bounds is not None else []
        note = ", ".join(parts)
        if self._note and not self.empty:
            note = f"{self._note}: {note}" if note else self._note
        self._names[FACE].set("Fitted face", note, colours, self._sizes[FACE], scale)
        hollow = bool(self._filled.any())
        seen = "visible vertices, filled ones grey" if hollow else "visible vertices"
        self._names[DISTANCE].set("Distance to scan", "" if self.empty else seen, colours, self._sizes[DISTANCE], scale)
        say = ("No fitted face yet", "Place five fiducials, confirm the rest, then fit") if self.empty else ("", "")
        low = self._dots and self._scan_bounds is not None
        self._messages[FACE].set(*say, colours, self._sizes[FACE], scale, low=low)
        say = ("", "The distance appears with the face") if self.empty else ("", "")
        self._messages[DISTANCE].set(*say, colours, self._sizes[DISTANCE], scale, low=low)
        share = share_text(self._deviation, self._heat)
        note = SMOOTHED if self._smooth else ""
        self.bar.set(self._heat, share, colours, self._sizes[DISTANCE], scale, self._axis, note)
        self.bar.hide(self.empty)
        self.turn()

    def turn(self) -> None:
        """Draw again what depends on the camera alone."""
        if not self._overlays:
            return
        self._marks.draw(self.camera, self._sizes[FACE], self._scale, self.faces[FACE].hides)
        self._gizmo.set(self.camera, self._colours, self._sizes[FACE], self._scale)

    def framed(self) -> FloatArray:
        """Return the points (N, 3) in mm to bring into the picture: the face's, else the scan's box, else none."""
        if not self.empty:
            return self.faces[FACE].vertices()
        return np.zeros((0, 3)) if self._scan_bounds is None else corners(self._scan_bounds)

    def bounds(self) -> Sequence[float] | None:
        """Return the box of all that is seen, mm."""
        boxes = [np.array(b).reshape(3, 2) for b in (self.faces[FACE].bounds(), self._scan_bounds) if b is not None]
        if not boxes:
            return None
        low = np.min([b[:, 0] for b in boxes], axis=0)
        high = np.max([b[:, 1] for b in boxes], axis=0)
        return tuple(np.stack([low, high], axis=1).ravel())

    def pick(self, segment: tuple[FloatArray, FloatArray]) -> tuple[int, FloatArray] | None:
        """Return vertex and place in mm where a line of sight meets the face."""
        return self.faces[FACE].locate(*segment)

    def read_at(self, view: int, segment: tuple[FloatArray, FloatArray] | None, place: Size) -> bool:
        """Show the value under the pointer in a view, or hide it; returns whether the picture changed."""
        hit = None if segment is None else self.pick(segment)
        other = self._readings[1 - view].hide()
        if hit is None:
            return self._readings[view].hide() or other
        name = None
        if view == FACE:
            name = self._marks.name_at(*place, 7.0 * self._scale)
        text = name or self.describe(hit[0])
        self._readings[view].show(text, place, self._colours, self._sizes[view], self._scale)
        return True

    def describe(self, vertex: int) -> str:
        """Return what is known of a vertex in a few words, such as ``0.07 mm``."""
        value = self._deviation[vertex] if vertex < len(self._deviation) else float("nan")
        return "filled, not measured" if np.isnan(value) else f"{value:.2f} mm"

    def close(self) -> None:
        """Take everything out of the renderers."""
        parts: list[Any] = [*self.faces, *self._points, *self._names, *self._messages, *self._readings]
        for part in parts:
            part.remove()
        self._marks.remove()
        self._gizmo.remove()
        self.bar.remove()
        self._renderers = []

    def _put_dots(self, fit: Fitted | None) -> None:
        dots, colours = None, None
        if self._measured is not None:
            dots, pixels = self._measured
            if fit is not None:
                dots = dots[~on_surface(dots, pixels, fit.mesh.vertices, fit.normals, fit.pixels)]
            else:
                # Without a face the scan is all there is to see: in its own colours.
                colours = self._dot_colours
        for cloud, paint in zip(self._points, (colours, None), strict=True):
            cloud.set_points(dots, paint)

    def _colour_distance(self) -> None:
        if self.empty:
            return
        face = self.faces[DISTANCE]
        if self._smooth and self._calm is None:
            self._calm = calmed(self._deviation, face.vertices(), face.faces)
        values = self._calm if self._smooth and self._calm is not None else self._deviation
        face.set_heat(heat_colours(values, self._heat, self._colours.missing))
