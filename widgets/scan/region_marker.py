"""Shows in both 3-D views where a region of the face lies: its border as a line, put there in place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from engine.mesh import FloatArray, IntArray
from widgets import theme
from widgets.scan.face_views import FaceViews

if TYPE_CHECKING:
    from widgets.scene.region_outline import RegionOutline

WIDTH_PX = 2.0


class RegionMarker:
    """Draws over the views of ``FaceViews`` once their graphics are there."""

    def __init__(self, views: FaceViews) -> None:
        self._views = views
        self._outlines: list[RegionOutline] = []
        self.shown = 0

    def show(self, vertices: FloatArray, normals: FloatArray, edges: IntArray) -> None:
        """Draw the edges (k, 2) between vertices (N, 3) in mm with unit normals; none clear the views."""
        if self._views.scene is None:
            return
        if not self._outlines:
            if not len(edges):
                return
            from widgets.scene.region_outline import RegionOutline  # with VTK, which the first paint need not wait for

            self._outlines = [RegionOutline(renderer) for renderer in list(self._views.viewer.plotter.renderers)[:2]]
        colour = theme.overlay().accent
        for outline in self._outlines:
            outline.set(vertices, normals, edges, colour, WIDTH_PX * self._views.viewer.scale)
        self.shown = len(edges)
        self._views.viewer.redraw()

    def clear(self) -> None:
        """Draw nothing."""
        if self.shown:
            self.show(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 2), dtype=np.int64))

    def close(self) -> None:
        """Take everything out of the views; before they close."""
        if self._views.scene is not None:
            for outline in self._outlines:
                outline.remove()
        self._outlines = []
