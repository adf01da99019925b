"""Fiducials on a face: discs of one size on screen, teal on the subject's left, violet on the right."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkProperty

from engine.mesh import FloatArray
from widgets.scene.background import rgb
from widgets.scene.camera import project

LEFT, RIGHT, MIDDLE, RIM = "#2fb8a6", "#9b7cf2", "#f0f2f5", "#1e1f22"
"""The fiducial colours of the dark theme, which every picture of a face uses."""

_RADIUS = 4.0


def side_colour(name: str) -> str:
    """Return the colour of a fiducial by the side in its name."""
    parts = name.split("_")
    return LEFT if "left" in parts else RIGHT if "right" in parts else MIDDLE


class FiducialMarks:
    """Discs with a dark rim on one renderer, all the same size whatever the distance."""

    def __init__(self, renderer: Any, scale: float = 1.0) -> None:
        self._renderer = renderer
        self._names: tuple[str, ...] = ()
        self._points = np.zeros((0, 3))
        self._data = pv.PolyData()
        self._actors: list[vtkActor] = []
        self._mappers: list[vtkPolyDataMapper] = []
        for size, coloured in ((2 * _RADIUS + 2, False), (2 * _RADIUS, True)):
            mapper = vtkPolyDataMapper()
            mapper.SetInputData(self._data)
            mapper.SetScalarModeToUsePointFieldData()
            mapper.SelectColorArray("colour")
            mapper.SetColorModeToDirectScalars()
            mapper.SetScalarVisibility(coloured)
            mapper.SetResolveCoincidentTopologyToPolygonOffset()
            mapper.SetRelativeCoincidentTopologyPointOffsetParameter(-90.0 if coloured else -60.0)
            actor = vtkActor()
            actor.SetMapper(mapper)
            style = actor.GetProperty()
            style.SetRepresentationToPoints()
            style.SetPointSize(size * scale)
            style.SetColor(*rgb(RIM))
            style.SetLighting(False)
            style.SetPoint2DShape(vtkProperty.Point2DShapeType.Round)
            actor.PickableOff()
            actor.VisibilityOff()
            renderer.add_actor(actor, reset_camera=False, render=False)
            self._actors.append(actor)
            self._mappers.append(mapper)

    def set_points(self, points: Mapping[str, FloatArray]) -> None:
        """Show named places (3,) in mm; an empty mapping shows none."""
        self._names = tuple(points)
        self._points = np.array([points[n] for n in self._names], dtype=np.float64).reshape(-1, 3)
        self._data = pv.PolyData(self._points.astype(np.float32)) if self._names else pv.PolyData()
        if self._names:
            colours = np.array([rgb(side_colour(n)) for n in self._names]) * 255.0
            self._data.point_data["colour"] = np.round(colours).astype(np.uint8)
        for actor, mapper in zip(self._actors, self._mappers, strict=True):
            mapper.SetInputData(self._data)
            actor.SetVisibility(bool(self._names))

    def set_visible(self, visible: bool) -> None:
        """Show or hide the discs."""
        for actor in self._actors:
            actor.SetVisibility(visible and bool(self._names))

    def name_at(self, camera: Any, x: float, y: float, size: tuple[float, float], reach: float = 7.0) -> str | None:
        """Return the name of the disc at a pixel from the lower left of a view of ``size`` pixels."""
        if not self._names or not self._actors[0].GetVisibility():
            return None
        distance = np.linalg.norm(project(camera, self._points, *size) - (x, y), axis=1)
        nearest = int(distance.argmin())
        return self._names[nearest] if distance[nearest] <= reach else None

    def remove(self) -> None:
        """Take the discs out of their renderer."""
        for actor in self._actors:
            self._renderer.remove_actor(actor, reset_camera=False, render=False)
