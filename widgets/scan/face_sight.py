"""From where the fitted face is seen: standard sides, framing, and whether the user has turned the views since."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from widgets.viewers.mesh_viewer import MeshViewer

VIEW_NAMES = {
    "three_quarter": "Three-quarter, right",
    "front": "Front",
    "three_quarter_left": "Three-quarter, left",
    "left": "Subject's left",
    "right": "Subject's right",
    "back": "Back",
    "top": "Top",
    "bottom": "Bottom",
    "below": "From below",
}
"""Views that ``FaceSight.choose`` knows, as the menu names them."""
NEIGHBOURHOOD_MM = 32.0
"""How far around a fiducial is shown when it is framed."""
_ELSEWHERE_MM = 80.0
_ROOM = (1.2, 0.035)
"""Margin and lift of the face in its view: room for the name above it and the colour bar below."""


class Subject(Protocol):
    """What stands before the camera."""

    @property
    def empty(self) -> bool:
        """Whether there is no face."""

    def framed(self) -> NDArray[np.float64]:
        """Return the points (N, 3) in mm to bring into the picture."""

    def bounds(self) -> Sequence[float] | None:
        """Return the box of all that is seen, mm."""


class FaceSight:
    """Places the camera of a viewer before a scene.

    Parameters
    ----------
    viewer : MeshViewer
        Its views share one camera.
    room : tuple of float
        Margin and lift of the face in its view; see ``widgets.scene.camera.look``.
    view : int
        The view that the face must fill.

    Attributes
    ----------
    centre : (3,) array
        Middle of what was framed last, mm.
    """

    def __init__(self, viewer: MeshViewer, room: tuple[float, float] = _ROOM, view: int = 0) -> None:
        self._viewer = viewer
        self._room, self._view = room, view
        self._side = "three_quarter"
        self._framed = self._touched = False
        self.centre: NDArray[np.float64] = np.zeros(3)

    def choose(self, side: str) -> None:
        """Make a key of ``VIEW_NAMES`` the side that ``settle`` looks from."""
        if side not in VIEW_NAMES:
            raise KeyError(side)
        self._side = side

    def frame(self, scene: Subject, side: str | None = None) -> None:
        """Bring all of the scene into the picture, from where the camera stands or from a standard side."""
        from widgets.scene import camera as hand

        points = scene.framed()
        if not len(points):
            return
        width, height = self._viewer.view_size(self._view)
        if side is None and self._framed:
            hand.frame(self._viewer.camera, points, hand.axes(self._viewer.camera)[0], width / height, *self._room)
        else:
            hand.look(self._viewer.camera, points, side or self._side, width / height, *self._room)
        self._framed = not scene.empty
        self.centre = points.mean(axis=0)
        self._viewer.set_pivot(self.centre)
        self.bound(scene)
        self._viewer.camera_moved()
        self._touched = side is None

    def frame_place(self, scene: Subject, place: NDArray[np.float64]) -> None:
        """Bring the neighbourhood of a place (3,) in mm into the middle, seen as before."""
        from widgets.scene import camera as hand

        width, height = self._viewer.view_size(self._view)
        away = NEIGHBOURHOOD_MM / np.tan(np.radians(hand.ANGLE_DEG) / 2) * max(1.0, height / width)
        hand.place(self._viewer.camera, place, hand.axes(self._viewer.camera)[0], float(away))
        self._viewer.set_pivot(place)
        self._framed = self._touched = True
        self.bound(scene)
        self._viewer.camera_moved()

    def follow(self, scene: Subject) -> None:
        """Keep the camera before another face of the same subject; frame the first one and another subject's."""
        if not self._framed or self._elsewhere(scene):
            self.frame(scene, self._side)
        else:
            self.bound(scene)

    def settle(self, scene: Subject) -> None:
        """Frame the scene from the chosen side again unless the user has turned it."""
        if not self._touched:
            self.frame(scene, self._side)

    def turned(self) -> None:
        """Note that the user has moved the camera."""
        self._touched = True

    def bound(self, scene: Subject) -> None:
        """Put near and far plane around the scene."""
        self._viewer.set_bounds(scene.bounds())

    def set_orthographic(self, on: bool) -> None:
        """Draw without perspective, or with it; that alone does not count as turned."""
        touched = self._touched
        self._viewer.set_orthographic(on)
        self._touched = touched

    def _elsewhere(self, scene: Subject) -> bool:
        """Return whether another subject sits so far from the last one that it may be out of sight."""
        if scene.empty:
            return False
        return bool(np.linalg.norm(scene.framed().mean(axis=0) - self.centre) > _ELSEWHERE_MM)
