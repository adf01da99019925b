"""A line down a view: left of it one shape, right of it the other, both in one place under one camera."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPlane

from widgets.scene.background import ViewColours
from widgets.scene.camera import axes, ray
from widgets.scene.text import Shape2D, rounded

_REACH = 7.0
"""Pixels beside the line that still take hold of it."""


class Wipe:
    """The line, its handle, and the two half spaces it makes."""

    def __init__(self, renderer: Any) -> None:
        self.left, self.right = vtkPlane(), vtkPlane()
        self._rim, self._line = Shape2D(renderer), Shape2D(renderer)
        self._grip = Shape2D(renderer)
        self._x = self._scale = 1.0
        self._shown = self._parts = False

    @property
    def shown(self) -> bool:
        """Whether the line parts anything."""
        return self._parts

    def set(
        self, share: float, camera: Any, colours: ViewColours, size: tuple[float, float], scale: float = 1.0
    ) -> None:
        """Put the line at ``share`` 0..1 of the width of a view of ``size`` pixels that ``camera`` sees."""
        self._x, self._scale = share * size[0], scale
        near, far = ray(camera, self._x, 0.0, *size)
        _, top = ray(camera, self._x, size[1], *size)
        normal = np.cross(far - near, top - near)
        normal /= np.linalg.norm(normal)
        if normal @ axes(camera)[1] < 0:
            normal = -normal
        for plane, side in ((self.left, -normal), (self.right, normal)):
            plane.SetOrigin(*near)
            plane.SetNormal(*side)
        x, middle = self._x, size[1] / 2
        for shape, half, colour in ((self._rim, 1.6, "#191a1d"), (self._line, 0.8, colours.accent)):
            half *= scale
            shape.polygon([(x - half, 0), (x + half, 0), (x + half, size[1]), (x - half, size[1])], colour)
        self._grip.polygon(rounded(x - 3 * scale, middle - 9 * scale, 6 * scale, 18 * scale, 2 * scale), "#ffffff")
        self.hide(not self._shown)

    def show(self, parts: bool, drawn: bool = True) -> None:
        """Let the line part two shapes or not, and draw it or leave it out."""
        self._parts, self._shown = parts, parts and drawn
        self.hide(not self._shown)

    def hide(self, hidden: bool = True) -> None:
        """Hide what is drawn, or show it again."""
        for shape in (self._rim, self._line, self._grip):
            shape.hide(hidden)

    def contains(self, x: float) -> bool:
        """Return whether a pixel lies on the line, with some room for the hand."""
        return self._shown and abs(x - self._x) <= _REACH * self._scale

    def remove(self) -> None:
        """Take the line out of its renderer."""
        for shape in (self._rim, self._line, self._grip):
            shape.remove()
