"""Fiducials on a face: discs of one size on screen, teal on the subject's left, violet on the right."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from engine.mesh import FloatArray
from widgets.scene.camera import eye_of, project
from widgets.scene.text import Shape2D

LEFT, RIGHT, MIDDLE, RIM = "#2fb8a6", "#9b7cf2", "#f0f2f5", "#1e1f22"
"""The fiducial colours of the dark theme, which every picture of a face uses."""

RADIUS_PX = 4.0
_STEPS = 20

Hides = Callable[[FloatArray, FloatArray], bool]


def side_colour(name: str) -> str:
    """Return the colour of a fiducial by the side in its name."""
    parts = name.split("_")
    return LEFT if "left" in parts else RIGHT if "right" in parts else MIDDLE


class FiducialMarks:
    """Discs with a dark rim in one renderer, all the same size whatever the distance; hidden ones are left out."""

    def __init__(self, renderer: Any) -> None:
        self._renderer = renderer
        self._names: tuple[str, ...] = ()
        self._points = np.zeros((0, 3))
        self._seen: dict[str, tuple[float, float]] = {}
        self._discs: list[tuple[Shape2D, Shape2D]] = []

    def set_points(self, points: Mapping[str, FloatArray]) -> None:
        """Mark named places (3,) in mm; an empty mapping marks none."""
        self._names = tuple(points)
        self._points = np.array([points[n] for n in self._names], dtype=np.float64).reshape(-1, 3)
        while len(self._discs) < len(self._names):
            self._discs.append((Shape2D(self._renderer), Shape2D(self._renderer)))

    def draw(self, camera: Any, size: tuple[float, float], scale: float = 1.0, hides: Hides | None = None) -> None:
        """Draw the discs as ``camera`` sees them in a view of ``size`` pixels.

        Parameters
        ----------
        scale : float
            Screen pixels to a pixel of the layout.
        hides : callable, optional
            ``hides(eye, point)`` tells whether something stands before a point, mm.
        """
        places = project(camera, self._points, *size) if self._names else np.zeros((0, 2))
        angles = 2 * np.pi * np.arange(_STEPS) / _STEPS
        circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        self._seen = {}
        for disc in self._discs[len(self._names) :]:
            disc[0].hide()
            disc[1].hide()
        for name, point, place, (rim, fill) in zip(self._names, self._points, places, self._discs, strict=False):
            if hides is not None and hides(eye_of(camera, point), point):
                rim.hide()
                fill.hide()
                continue
            self._seen[name] = (float(place[0]), float(place[1]))
            rim.polygon((place + (RADIUS_PX + 1) * scale * circle).tolist(), RIM)
            fill.polygon((place + RADIUS_PX * scale * circle).tolist(), side_colour(name))

    def name_at(self, x: float, y: float, reach: float = 7.0) -> str | None:
        """Return the name of the disc within ``reach`` pixels of a pixel from the lower left."""
        near = {name: float(np.hypot(px - x, py - y)) for name, (px, py) in self._seen.items()}
        name = min(near, key=near.__getitem__, default=None)
        return name if name is not None and near[name] <= reach else None

    def remove(self) -> None:
        """Take the discs out of their renderer."""
        for rim, fill in self._discs:
            rim.remove()
            fill.remove()
