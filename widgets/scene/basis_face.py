"""One rig in one renderer, in whatever pose it is given: every part in its own material, in buffers of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkPlane, vtkStaticCellLocator
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from engine.mesh import FloatArray
from widgets.scene.background import rgb
from widgets.scene.basis_rig import MATERIALS, Piece, Pose, RigLook
from widgets.scene.materials import HEAT, PAINTED
from widgets.scene.occlusion import tint

Look = Literal["clay", "textured", "heat"]
_HEAT_DEPTH = 0.35
_BEHIND_MM = 0.06
"""How far a rig that lets others shine through draws back, so that it does not flicker where both lie in one place."""
_WIRE, _WIRE_HEAT, _WIRE_OPACITY = "#14161a", "#ffffff", 0.30


class _Part:
    """One piece of the rig: a surface that owns its buffers, and its actor."""

    def __init__(self, renderer: Any, piece: Piece, look: RigLook) -> None:
        self.piece = piece
        self.shade = tint(look.openness_of(piece), _HEAT_DEPTH)
        points: Any = look.neutral.points[piece.source]
        triangles: Any = piece.faces.copy()
        self.surface = pv.PolyData.from_regular_faces(points, triangles)
        self.surface.point_data["Normals"] = look.neutral.normals[piece.source]
        self.surface.point_data.active_normals_name = "Normals"
        self.surface.point_data["colour"] = piece.colours.copy()
        self.texture: pv.Texture | None = None
        if piece.uv is not None and look.texture is not None and piece.material == "skin":
            self.surface.active_texture_coordinates = piece.uv.copy()
            self.texture = pv.Texture(look.texture.copy())  # type: ignore[no-untyped-call]
            self.texture.InterpolateOn()
            self.texture.MipmapOn()
            self.texture.RepeatOff()
        self.mapper = vtkPolyDataMapper()
        self.mapper.SetInputData(self.surface)
        self.mapper.SetScalarModeToUsePointFieldData()
        self.mapper.SelectColorArray("colour")
        self.mapper.SetColorModeToDirectScalars()
        self.actor = vtkActor()
        self.actor.SetMapper(self.mapper)
        self.actor.VisibilityOff()
        renderer.add_actor(self.actor, reset_camera=False, render=False)

    def put(self, pose: Pose, back: float) -> None:
        np.take(pose.points, self.piece.source, axis=0, out=np.asarray(self.surface.points), mode="clip")
        buffer = np.asarray(self.surface.point_data["Normals"])
        np.take(pose.normals, self.piece.source, axis=0, out=buffer, mode="clip")
        if back:
            np.asarray(self.surface.points)[:] -= np.float32(back) * buffer
        self.surface.GetPoints().Modified()
        self.surface.GetPointData().GetNormals().Modified()
        self.surface.Modified()

    def paint(self, colours: NDArray[np.uint8]) -> None:
        np.asarray(self.surface.point_data["colour"])[:] = colours
        self.surface.GetPointData().GetArray("colour").Modified()
        self.surface.Modified()


class RigFace:
    """The rig in one renderer; poses are copied into its own buffers, nothing it is given is kept or written to.

    Parameters
    ----------
    renderer : pyvista.Renderer
    """

    def __init__(self, renderer: Any) -> None:
        self._renderer = renderer
        self._rig: RigLook | None = None
        self._parts: list[_Part] = []
        self._pose: Pose | None = None
        self._look: Look = "clay"
        self._heat: NDArray[np.uint8] | None = None
        self._tint: str | None = None
        self._opacity = 1.0
        self._show, self._wire, self._width = True, False, 1.0
        self._planes: tuple[vtkPlane, ...] = ()
        self._locator: tuple[vtkStaticCellLocator, _Part] | None = None

    @property
    def empty(self) -> bool:
        """Whether there is nothing to be seen."""
        return self._pose is None

    @property
    def pose(self) -> Pose | None:
        """The pose that is shown."""
        return self._pose

    @property
    def surfaces(self) -> list[pv.PolyData]:
        """What VTK draws, a surface a part."""
        return [part.surface for part in self._parts]

    def set_rig(self, rig: RigLook | None) -> None:
        """Take over another rig; nothing is seen of it before it has a pose."""
        if rig is self._rig:
            return
        self._drop()
        self._rig, self._pose, self._heat = rig, None, None
        if rig is not None:
            self._parts = [_Part(self._renderer, piece, rig) for piece in rig.pieces]
        for part in self._parts:
            for plane in self._planes:
                part.mapper.AddClippingPlane(plane)
        self._dress()

    def set_pose(self, pose: Pose | None) -> bool:
        """Show the rig in a pose, or nothing; returns whether anything changed."""
        if pose is self._pose:
            return False
        appears = (pose is None) != (self._pose is None)
        self._pose, self._locator = pose, None
        if pose is not None:
            for part in self._parts:
                part.put(pose, self._back)
        if appears:
            self._show_parts()
        return True

    def set_look(self, look: Look) -> None:
        """Choose clay, the rig's texture (clay where it has none), or the colours of ``set_heat``."""
        if look != self._look:
            self._look = look
            self._dress()

    def set_heat(self, colours: NDArray[np.uint8] | None) -> None:
        """Set the colours (N, 3) uint8 of the heat look."""
        self._heat = None if colours is None else np.array(colours, dtype=np.uint8)
        if self._look == "heat":
            self._dress()

    def set_tint(self, colour: str | None, opacity: float = 1.0) -> None:
        """Colour all of the rig alike, keeping its shadows, and let others shine through."""
        if (colour, opacity) == (self._tint, self._opacity):
            return
        self._tint, self._opacity = colour, opacity
        if self._pose is not None:
            for part in self._parts:
                part.put(self._pose, self._back)
        self._dress()

    def set_visible(self, visible: bool) -> None:
        """Show the rig or hide it."""
        if visible != self._show:
            self._show = visible
            self._show_parts()

    def set_wire(self, visible: bool, width: float = 1.0) -> None:
        """Draw the edges of all faces, ``width`` pixels wide, or leave them out."""
        if (visible, width) != (self._wire, self._width):
            self._wire, self._width = visible, width
            self._dress()

    def set_planes(self, planes: Sequence[vtkPlane]) -> None:
        """Show only what lies on the normals' side of planes; they may move afterwards."""
        self._planes = tuple(planes)
        for part in self._parts:
            part.mapper.RemoveAllClippingPlanes()
            for plane in self._planes:
                part.mapper.AddClippingPlane(plane)

    def locate(self, start: FloatArray, end: FloatArray) -> tuple[int, FloatArray] | None:
        """Return the vertex nearest to where the segment start .. end first meets the skin, and that place in mm."""
        if self._pose is None or not self._parts or not self._show:
            return None
        if self._locator is None:
            part = self._parts[0]
            locator = vtkStaticCellLocator()
            locator.SetDataSet(part.surface)
            locator.BuildLocator()
            self._locator = locator, part
        locator, part = self._locator
        place, local = [0.0] * 3, [0.0] * 3
        sub: Any = mutable(0)
        where: Any = mutable(0.0)
        cell: Any = mutable(-1)
        if not locator.IntersectWithLine(start.tolist(), end.tolist(), 0.0, where, place, local, sub, cell):
            return None
        point = np.array(place)
        corners = part.piece.source[part.piece.faces[int(cell)]]
        distance = np.linalg.norm(self._pose.points[corners] - point, axis=1)
        return int(corners[int(distance.argmin())]), point

    def remove(self) -> None:
        """Take the rig out of its renderer and let go of its buffers."""
        self._drop()
        self._rig = self._pose = None

    @property
    def _back(self) -> float:
        return _BEHIND_MM if self._opacity < 1.0 else 0.0

    def _drop(self) -> None:
        for part in self._parts:
            self._renderer.remove_actor(part.actor, reset_camera=False, render=False)
            part.actor.SetTexture(None)  # type: ignore[arg-type]
            part.mapper.RemoveAllClippingPlanes()
        self._parts, self._locator = [], None

    def _dress(self) -> None:
        for part in self._parts:
            surface = part.actor.GetProperty()
            material, texture = MATERIALS[part.piece.material], None
            colours = part.piece.colours
            if self._look == "heat" and self._heat is not None:
                material = HEAT
                colours = np.clip(self._heat[part.piece.source] * part.shade + 0.5, 0, 255).astype(np.uint8)
            elif self._tint is not None:
                wanted = np.array(rgb(self._tint)) * 255.0 * part.shade**1.6
                colours = np.clip(wanted + 0.5, 0, 255).astype(np.uint8)
            elif self._look == "textured" and part.texture is not None:
                material, texture = PAINTED, part.texture
                colours = np.clip(255.0 * part.shade**1.4 + 0.5, 0, 255).astype(np.uint8)
            material.apply(surface)
            part.actor.SetTexture(texture)  # type: ignore[arg-type]
            surface.SetColor(1.0, 1.0, 1.0)
            surface.SetOpacity(self._opacity)
            # The lining lies close behind the lips: where a shape thins them, its outside would be seen through.
            surface.SetBackfaceCulling(self._opacity < 1.0 or part.piece.material == "mouth")
            surface.SetEdgeVisibility(self._wire)
            surface.SetEdgeColor(*rgb(_WIRE_HEAT if material is HEAT else _WIRE))
            surface.SetEdgeOpacity(_WIRE_OPACITY if material is not HEAT else 0.4 * _WIRE_OPACITY)
            surface.SetLineWidth(self._width)
            part.paint(colours)
        self._show_parts()

    def _show_parts(self) -> None:
        for part in self._parts:
            part.actor.SetVisibility(self._show and self._pose is not None)
