"""A fitted face as a 3-D view shows it: clay, picture or heat, with the template's wire over it."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from engine.mesh import FloatArray
from widgets.scene.background import ViewColours, rgb
from widgets.scene.materials import BLANK, CLAY, HEAT, PICTURE, Material
from widgets.scene.occlusion import openness, tint
from widgets.scene.wire import coarse_edges

Look = Literal["shaded", "textured", "heat", "blank"]
"""Clay, picture, colours of values, or nothing but what it hides (for a wire)."""

_WIRE_LIFT_MM = 0.12
_HIDDEN_MM = 3.0
_CLAY_DEPTH = 0.62
_HEAT_DEPTH = 0.35


class FaceActor:
    """One face in one renderer, with buffers of its own.

    Every array that comes in is **copied**: ``pyvista.PolyData`` would alias the engine's read-only memory as
    writeable. New positions of the same faces are written into the existing buffers.

    Parameters
    ----------
    renderer : pyvista.Renderer
        Of any plotter, on screen or off.
    colours : ViewColours
        For the wire and for missing values.
    """

    def __init__(self, renderer: Any, colours: ViewColours) -> None:
        self._renderer = renderer
        self._colours = colours
        self.surface = pv.PolyData()
        self._edges = pv.PolyData()
        self._edge_list = np.zeros((0, 2), dtype=np.int64)
        self._faces = np.zeros((0, 3), dtype=np.int64)
        self._open: FloatArray | None = None
        self._heat: NDArray[np.uint8] | None = None
        self._texture: pv.Texture | None = None
        self._look: Look = "shaded"
        self._locator: Any = None
        self._mapper = vtkPolyDataMapper()
        self._mapper.SetInputData(self.surface)
        self._mapper.SetScalarModeToUsePointFieldData()
        self._mapper.SelectColorArray("colour")
        self._mapper.SetColorModeToDirectScalars()
        self._actor = vtkActor()
        self._actor.SetMapper(self._mapper)
        self._wire_mapper = vtkPolyDataMapper()
        self._wire_mapper.SetInputData(self._edges)
        self._wire_mapper.ScalarVisibilityOff()
        self._wire = vtkActor()
        self._wire.SetMapper(self._wire_mapper)
        self._wire.GetProperty().SetLighting(False)
        self._wire.GetProperty().SetLineWidth(1.0)
        self._wire.VisibilityOff()
        self._actor.VisibilityOff()
        self._show, self._show_wire = True, False
        renderer.add_actor(self._actor, reset_camera=False, render=False)
        renderer.add_actor(self._wire, reset_camera=False, render=False)
        self.set_colours(colours)

    @property
    def empty(self) -> bool:
        """Whether there is no face yet."""
        return not len(self._faces)

    @property
    def faces(self) -> NDArray[np.int64]:
        """Vertex indices (F, 3) of the face that is shown."""
        return self._faces

    def set_mesh(
        self,
        vertices: FloatArray,
        faces: NDArray[np.integer],
        normals: FloatArray,
        *,
        levels: int = 0,
        uv: FloatArray | None = None,
        picture: NDArray[np.uint8] | None = None,
    ) -> None:
        """Show a face.

        Parameters
        ----------
        vertices, normals : (N, 3) float
            Positions in mm, unit normals.
        faces : (F, 3) int
        levels : int
            How often the template was subdivided; decides which edges the wire shows.
        uv : (N, 2) float, optional
            Texture coordinates, origin top left.
        picture : (H, W, 3) uint8, optional
            Scan's colour picture; without it the textured look falls back to clay.
        """
        indices: NDArray[np.int64] = np.array(faces, dtype=np.int64)
        same = indices.shape == self._faces.shape and len(vertices) == self.surface.n_points
        if same and (indices == self._faces).all():
            self.update_points(vertices, normals)
        else:
            self._rebuild(vertices, indices, normals, levels)
        if uv is not None:
            flipped: Any = np.empty((len(uv), 2), dtype=np.float32)
            flipped[:, 0], flipped[:, 1] = uv[:, 0], 1.0 - uv[:, 1]
            self.surface.active_texture_coordinates = flipped
        self._set_picture(picture if uv is not None else None)
        self._dress()

    def clear(self) -> None:
        """Show no face."""
        self._faces = np.zeros((0, 3), dtype=np.int64)
        self._open = self._heat = None
        self._locator = None
        self._show_actors()

    def update_points(self, vertices: FloatArray, normals: FloatArray) -> None:
        """Write new positions (N, 3) in mm and normals (N, 3) of the same faces into the buffers."""
        points, buffer = np.asarray(self.surface.points), np.asarray(self.surface.point_data["Normals"])
        points[:] = vertices
        buffer[:] = normals
        self.surface.GetPoints().Modified()
        self.surface.GetPointData().GetNormals().Modified()
        self.surface.Modified()
        np.asarray(self._edges.points)[:] = points + _WIRE_LIFT_MM * buffer
        self._edges.GetPoints().Modified()
        self._edges.Modified()
        self._open = None
        self._locator = None
        if self._look != "textured":
            self._dress()

    def set_look(self, look: Look) -> None:
        """Choose what the surface wears; see ``Look``."""
        if look != self._look:
            self._look = look
            self._dress()

    def set_heat(self, colours: NDArray[np.uint8]) -> None:
        """Set the colours (N, 3) uint8 of the heat look."""
        self._heat = np.array(colours, dtype=np.uint8)
        if self._look == "heat":
            self._dress()

    def set_wire(self, visible: bool) -> None:
        """Show or hide the template's edges."""
        self._show_wire = visible
        self._show_actors()

    def set_visible(self, visible: bool) -> None:
        """Show or hide the surface itself; the wire keeps its own switch."""
        self._show = visible
        self._show_actors()

    def set_colours(self, colours: ViewColours, width: float = 1.0) -> None:
        """Take over a theme's colours and the wire's width in pixels."""
        self._colours = colours
        wire = self._wire.GetProperty()
        wire.SetColor(*rgb(colours.wire))
        wire.SetOpacity(colours.wire_opacity)
        wire.SetLineWidth(width)

    def locate(self, start: FloatArray, end: FloatArray) -> tuple[int, FloatArray] | None:
        """Return the vertex nearest to where the segment start .. end first meets the face, and that place in mm."""
        if self.empty or not self._show:
            return None
        if self._locator is None:
            self._locator = vtkStaticCellLocator()
            self._locator.SetDataSet(self.surface)
            self._locator.BuildLocator()
        place, local, part = [0.0] * 3, [0.0] * 3, mutable(0)
        where, cell = mutable(0.0), mutable(-1)
        if not self._locator.IntersectWithLine(start.tolist(), end.tolist(), 0.0, where, place, local, part, cell):
            return None
        point = np.array(place)
        corners = self._faces[int(cell)]
        distance = np.linalg.norm(np.asarray(self.surface.points)[corners] - point, axis=1)
        return int(corners[int(distance.argmin())]), point

    def hides(self, eye: FloatArray, point: FloatArray) -> bool:
        """Return whether the face stands between the eye and a point on it, both in mm."""
        hit = self.locate(eye, point)
        return hit is not None and float(np.linalg.norm(hit[1] - point)) > _HIDDEN_MM

    def vertices(self) -> FloatArray:
        """Return a copy of the positions (N, 3) in mm that are shown; none where there is no face."""
        return np.zeros((0, 3)) if self.empty else np.array(self.surface.points, dtype=np.float64)

    def bounds(self) -> tuple[float, float, float, float, float, float] | None:
        """Return x, y, z ranges in mm of the face that is shown."""
        if self.empty:
            return None
        box = self.surface.bounds
        return (box[0], box[1], box[2], box[3], box[4], box[5])

    def remove(self) -> None:
        """Take the face out of its renderer and let go of its buffers."""
        for actor in (self._actor, self._wire):
            self._renderer.remove_actor(actor, reset_camera=False, render=False)
        self._actor.SetTexture(None)  # type: ignore[arg-type]
        self._texture = None
        self._locator = None

    def _rebuild(self, vertices: FloatArray, faces: NDArray[np.int64], normals: FloatArray, levels: int) -> None:
        points: Any = np.array(vertices, dtype=np.float32)
        triangles: Any = faces.copy()
        self._faces = faces
        self.surface = pv.PolyData.from_regular_faces(points, triangles)
        self.surface.point_data["Normals"] = np.array(normals, dtype=np.float32)
        self.surface.point_data.active_normals_name = "Normals"
        self._edge_list = coarse_edges(faces, levels)
        lifted = points + np.float32(_WIRE_LIFT_MM) * np.asarray(self.surface.point_data["Normals"])
        cells = np.column_stack([np.full(len(self._edge_list), 2), self._edge_list]).ravel()
        self._edges = pv.PolyData(lifted, lines=cells)
        self._mapper.SetInputData(self.surface)
        self._wire_mapper.SetInputData(self._edges)
        self._open = self._heat = None
        self._locator = None

    def _set_picture(self, picture: NDArray[np.uint8] | None) -> None:
        if picture is None:
            self._texture = None
            return
        self._texture = pv.Texture(np.array(picture))  # type: ignore[no-untyped-call]
        self._texture.InterpolateOn()
        self._texture.MipmapOn()
        self._texture.RepeatOff()

    def _dress(self) -> None:
        if self.empty:
            self._show_actors()
            return
        count = self.surface.n_points
        texture, material = None, CLAY
        if self._look == "heat" and self._heat is not None and len(self._heat) == count:
            material, colours = HEAT, self._heat * tint(self._openness(), _HEAT_DEPTH)
        elif self._look == "textured" and self._texture is not None:
            material, texture, colours = PICTURE, self._texture, np.full((count, 3), 255.0)
        elif self._look == "blank":
            material, colours = BLANK, np.full((count, 3), np.array(rgb(self._colours.bottom)) * 255.0)
        else:
            colours = np.array(rgb(CLAY.colour)) * 255.0 * tint(self._openness(), _CLAY_DEPTH)
        self._paint(material, texture, colours)

    def _paint(self, material: Material, texture: pv.Texture | None, colours: NDArray[Any]) -> None:
        material.apply(self._actor.GetProperty())
        self._actor.SetTexture(texture)  # type: ignore[arg-type]
        if texture is None:
            self.surface.point_data["colour"] = np.clip(colours + 0.5, 0, 255).astype(np.uint8)
            self._mapper.ScalarVisibilityOn()
        else:
            self._mapper.ScalarVisibilityOff()
            self._actor.GetProperty().SetColor(1.0, 1.0, 1.0)
        self._show_actors()

    def _openness(self) -> FloatArray:
        if self._open is None:
            points = np.asarray(self.surface.points, dtype=np.float64)
            normals = np.asarray(self.surface.point_data["Normals"], dtype=np.float64)
            self._open = openness(points, self._faces, normals)
        return self._open

    def _show_actors(self) -> None:
        self._actor.SetVisibility(self._show and not self.empty)
        self._wire.SetVisibility(self._show_wire and not self.empty)
