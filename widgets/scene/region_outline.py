"""The border of a region of the face, drawn over it in both views."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from engine.mesh import FloatArray, IntArray
from widgets.scene.background import rgb

LIFT_MM = 0.5


class RegionOutline:
    """Lines in one renderer, lifted a little off the face."""

    def __init__(self, renderer: Any) -> None:
        self._renderer = renderer
        self._mapper = vtkPolyDataMapper()
        self._mapper.ScalarVisibilityOff()
        self._actor = vtkActor()
        self._actor.SetMapper(self._mapper)
        self._actor.GetProperty().SetLighting(False)
        self._actor.PickableOff()
        self._actor.VisibilityOff()
        renderer.add_actor(self._actor, reset_camera=False, render=False)

    def set(self, vertices: FloatArray, normals: FloatArray, edges: IntArray, colour: str, width: float) -> None:
        """Draw edges (k, 2) between vertices (N, 3) in mm; none hide the outline."""
        self._actor.SetVisibility(len(edges) > 0)
        if not len(edges):
            return
        used, numbers = np.unique(edges, return_inverse=True)
        points = np.asarray(vertices[used] + LIFT_MM * normals[used], dtype=np.float32)
        cells = np.column_stack([np.full(len(edges), 2), numbers.reshape(-1, 2)]).ravel()
        self._mapper.SetInputData(pv.PolyData(points, lines=cells))
        self._actor.GetProperty().SetColor(*rgb(colour))
        self._actor.GetProperty().SetLineWidth(width)

    def remove(self) -> None:
        """Take the outline out of its renderer."""
        self._renderer.remove_actor(self._actor, reset_camera=False, render=False)
