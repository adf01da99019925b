"""Captured markers red, reconstructed ones blue, a line from one to the other; and the legend that says so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from widgets.scene.background import ViewColours
from widgets.scene.camera import axes, distance_of
from widgets.scene.overlay import MARGIN
from widgets.scene.text import Shape2D, Words, rounded

Float32 = NDArray[np.float32]
CAPTURED = {"dark": "#e5484d", "light": "#d13438", "paper": "#d13438"}
RECONSTRUCTED = {"dark": "#3b82f6", "light": "#2563eb", "paper": "#2563eb"}
_RIM = "#191a1d"
_SIZE, _RIM_PX = 5.6, 1.8
_NEARER_MM = 1.2
"""How far markers are moved towards the eye along their line of sight, so that the skin they sit on hides none."""


class _Dots:
    """Points or lines of one colour and one size on screen."""

    def __init__(self, renderer: Any, *, lines: bool = False) -> None:
        self._renderer, self._lines = renderer, lines
        self._data = pv.PolyData()
        self._mapper = vtkPolyDataMapper()
        self._mapper.ScalarVisibilityOff()
        self.actor = vtkActor()
        self.actor.SetMapper(self._mapper)
        look = self.actor.GetProperty()
        look.SetLighting(False)
        if not lines:
            look.SetRepresentationToPoints()
            look.SetRenderPointsAsSpheres(True)
        self.actor.PickableOff()
        self.actor.VisibilityOff()
        renderer.add_actor(self.actor, reset_camera=False, render=False)

    def put(self, points: Float32) -> None:
        """Show points (k, 3), or lines between the first and the second half of them."""
        shown = len(points) > 0
        if shown and self._data.n_points == len(points):
            np.asarray(self._data.points)[:] = points
            self._data.GetPoints().Modified()
            self._data.Modified()
        elif shown:
            half = len(points) // 2
            pairs = np.column_stack([np.full(half, 2), np.arange(half), half + np.arange(half)]).ravel()
            self._data = pv.PolyData(points.copy(), lines=pairs) if self._lines else pv.PolyData(points.copy())
            self._mapper.SetInputData(self._data)
        self.actor.SetVisibility(shown)

    def remove(self) -> None:
        self._renderer.remove_actor(self.actor, reset_camera=False, render=False)


class MarkerPairs:
    """The markers of one view, all the same size whatever the distance; those behind the head are hidden by it."""

    def __init__(self, renderer: Any) -> None:
        self._lines = _Dots(renderer, lines=True)
        self._rims = _Dots(renderer)
        self._captured, self._rebuilt = _Dots(renderer), _Dots(renderer)
        self._given: tuple[Float32 | None, Float32 | None] = (None, None)
        self._show = True
        self._scale = 1.0

    def set(self, captured: Float32 | None, rebuilt: Float32 | None) -> None:
        """Take captured and reconstructed markers (K, 3) in mm; NaN marks none, None all of a kind."""
        self._given = (captured, rebuilt)

    def set_visible(self, visible: bool) -> None:
        """Show the markers or hide them."""
        self._show = visible

    def set_colours(self, colours: ViewColours, scale: float) -> None:
        """Take over a theme's colours, ``scale`` screen pixels to a pixel of the layout."""
        self._scale = scale
        for dots, colour, size in (
            (self._rims, _RIM, _SIZE + _RIM_PX),
            (self._captured, CAPTURED[colours.name], _SIZE),
            (self._rebuilt, RECONSTRUCTED[colours.name], _SIZE),
        ):
            dots.actor.GetProperty().SetColor(*pv.Color(colour).float_rgb)
            dots.actor.GetProperty().SetPointSize(size * scale)
        self._lines.actor.GetProperty().SetColor(*pv.Color(colours.text).float_rgb)
        self._lines.actor.GetProperty().SetLineWidth(1.2 * scale)

    def turn(self, camera: Any, height: float) -> None:
        """Place everything before the skin as ``camera`` sees it in a view ``height`` pixels high."""
        none = np.zeros((0, 3), dtype=np.float32)
        captured, rebuilt = (none if g is None or not self._show else g for g in self._given)
        pair = none
        if len(captured) and len(rebuilt):
            both = np.isfinite(captured).all(axis=1) & np.isfinite(rebuilt).all(axis=1)
            pair = np.concatenate([captured[both], rebuilt[both]])
        captured = captured[np.isfinite(captured).all(axis=1)]
        rebuilt = rebuilt[np.isfinite(rebuilt).all(axis=1)]
        # A disc bulges towards the eye as a ball would: its rim must lie a whole ball behind it.
        ball = 0.5 * (_SIZE + _RIM_PX) * self._scale * _mm_of_pixel(camera, height)
        self._rims.put(_nearer(camera, np.concatenate([captured, rebuilt]), _NEARER_MM))
        self._lines.put(_nearer(camera, pair, _NEARER_MM + ball + 0.2))
        self._captured.put(_nearer(camera, captured, _NEARER_MM + ball + 0.4))
        self._rebuilt.put(_nearer(camera, rebuilt, _NEARER_MM + 2.0 * ball + 0.6))

    def remove(self) -> None:
        """Take the markers out of their renderer."""
        for dots in (self._lines, self._rims, self._captured, self._rebuilt):
            dots.remove()


class Legend:
    """Discs with words beside them on a plate in the lower left corner of a view."""

    def __init__(self, renderer: Any, entries: int = 2) -> None:
        self._plate = Shape2D(renderer)
        self._discs = [Shape2D(renderer) for _ in range(entries)]
        self._words = [Words(renderer) for _ in range(entries)]

    def set(self, entries: list[tuple[str, str]], colours: ViewColours, scale: float = 1.0) -> None:
        """Write pairs of colour and word; none hides the legend."""
        x, middle = (MARGIN + 6) * scale, (MARGIN + 10) * scale
        for k, (disc, words) in enumerate(zip(self._discs, self._words, strict=True)):
            disc.hide(k >= len(entries))
            words.set(entries[k][1] if k < len(entries) else "", colours.text, 11 * scale)
            if k >= len(entries):
                continue
            angle = np.linspace(0, 2 * np.pi, 21)[:-1]
            circle = np.stack([x + 4 * scale * (1 + np.cos(angle)), middle + 4 * scale * np.sin(angle)], axis=1)
            disc.polygon(circle.tolist(), entries[k][0])
            words.move(x + 12 * scale, middle - 5 * scale)
            x += 12 * scale + words.width + 12 * scale
        width = x - (MARGIN + 6) * scale
        outline = rounded(MARGIN * scale, MARGIN * scale, width, 20 * scale, 3 * scale)
        self._plate.polygon(outline, colours.plate, colours.plate_opacity)
        self._plate.hide(not entries)

    def remove(self) -> None:
        """Take the legend out of its renderer."""
        parts: list[Shape2D | Words] = [self._plate, *self._discs, *self._words]
        for part in parts:
            part.remove()


def _mm_of_pixel(camera: Any, height: float) -> float:
    """Return how many mm a pixel of a view ``height`` pixels high shows at the focus."""
    return float(2.0 * distance_of(camera) * np.tan(np.radians(camera.GetViewAngle()) / 2.0) / max(height, 1.0))


def _nearer(camera: Any, points: Float32, by: float) -> Float32:
    """Return points (k, 3) moved ``by`` mm towards the eye: they keep their places in the picture."""
    if not len(points):
        return points
    if camera.GetParallelProjection():
        return np.asarray(points + by * axes(camera)[0], dtype=np.float32)
    towards = np.array(camera.GetPosition()) - points
    away = np.linalg.norm(towards, axis=1, keepdims=True)
    return np.asarray(points + towards * (by / np.maximum(away, 1e-6)), dtype=np.float32)
