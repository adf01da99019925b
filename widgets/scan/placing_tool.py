"""Gives the mouse to the rings and arrows that place a mesh before its virtual camera."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from PySide6.QtCore import Qt
from scipy.spatial.transform import Rotation

from engine.mesh import FloatArray
from engine.scan.mesh_view import MeshView
from widgets.scene.camera import project
from widgets.scene.placing_scene import Handle, PlacingScene

_LEAST_PX = 0.02


class PlacingOwner(Protocol):
    """Who shows the scene and holds the view."""

    @property
    def scene(self) -> PlacingScene | None:
        """What is drawn, None before that."""

    @property
    def view(self) -> MeshView:
        """Where the camera stands."""

    @property
    def scale(self) -> float:
        """Millimetres of the view in one of the scene."""

    def camera_and_size(self) -> tuple[Any, tuple[float, float]]:
        """Return the 3-D view's camera, and its size in screen pixels."""

    def turn_by_hand(self, view: MeshView) -> None:
        """Take the view that a drag has led to."""

    def redraw(self) -> None:
        """Draw the 3-D view again."""


class PlacingTool:
    """Turns a drag of a handle into a view.

    A handle's point moves over the screen by so many pixels for a radian or a millimetre; the hand's way along that
    direction is what turns or shifts the mesh, from whatever side it is looked at.
    """

    def __init__(self, owner: PlacingOwner) -> None:
        self._owner = owner
        self._handle: Handle | None = None
        self._point: FloatArray = np.zeros(3)
        self._last = (0.0, 0.0)

    def _under(self, x: float, y: float) -> tuple[Handle, FloatArray] | None:
        scene = self._owner.scene
        if scene is None:
            return None
        camera, size = self._owner.camera_and_size()
        return scene.at(camera, x, y, size)

    def press(self, _view: int, x: float, y: float) -> bool:
        """Take hold of the handle under the pixel."""
        found = self._under(x, y)
        if found is None:
            return False
        self._handle, self._point = found
        self._last = (x, y)
        return True

    def drag(self, x: float, y: float) -> None:
        """Turn or shift by the way since the last call."""
        if self._handle is None:
            return
        axis = np.eye(3)[self._handle.axis]
        along = np.cross(axis, self._point) if self._handle.kind == "ring" else axis
        camera, size = self._owner.camera_and_size()
        step = 1e-3 if self._handle.kind == "ring" else 1.0
        ends = project(camera, np.array([self._point, self._point + step * along]), *size)[:, :2]
        slope = (ends[1] - ends[0]) / step
        square = float(slope @ slope)
        moved = np.array([x - self._last[0], y - self._last[1]])
        self._last = (x, y)
        least = _LEAST_PX * (float(np.linalg.norm(self._point)) if self._handle.kind == "ring" else 1.0)
        amount = float(moved @ slope) / max(square, least * least)
        view = self._owner.view
        if self._handle.kind == "ring":
            turn = np.asarray(Rotation.from_rotvec(axis * amount).as_matrix())
            self._point = turn @ self._point
            self._owner.turn_by_hand(view.rotated(turn))
        else:
            away = axis * amount * self._owner.scale
            x_mm, y_mm, z_mm = (np.array(view.look_at_mm) - view.matrix.T @ away).tolist()
            self._owner.turn_by_hand(replace(view, look_at_mm=(x_mm, y_mm, z_mm)))

    def release(self) -> None:
        """Let go."""
        self._handle = None

    def double_click(self, _view: int, _x: float, _y: float) -> bool:
        """Leave double clicks to the camera."""
        return False

    def cursor(self, _view: int, x: float, y: float) -> Qt.CursorShape | None:
        """Light the handle under the pixel and show a hand over it."""
        found = self._under(x, y)
        scene = self._owner.scene
        if scene is not None and scene.light(None if found is None else found[0]):
            self._owner.redraw()
        return None if found is None else Qt.CursorShape.PointingHandCursor
