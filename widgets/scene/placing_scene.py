"""A mesh before its virtual camera, with rings to turn it and arrows to shift it, on any plotter."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from engine.mesh import FloatArray, TriangleMesh
from engine.scan.mesh_view import MeshView
from widgets.scene.background import ViewColours, apply_background, rgb
from widgets.scene.camera import frame, project
from widgets.scene.lights import add_studio_light

AXIS_COLOURS = ("#e5484d", "#46a758", "#3b82f6")
"""Of what turns about, or shifts along, X, Y and Z."""

_LIT = "#ffd479"
_RING_POINTS = 96
_GRASP_PX = 9.0
_DIRECTION = np.array([0.9, 0.35, 1.0])


class Handle(NamedTuple):
    """A part of the gizmo: a ring or an arrow of an axis, 0..2."""

    kind: Literal["ring", "arrow"]
    axis: int


class PlacingScene:
    """The camera's frame: the camera at +Z looks at the origin, and the mesh is turned and shifted there.

    Parameters
    ----------
    plotter : pyvista.Plotter
        On screen or off; its first renderer is used.
    mesh : TriangleMesh
        In mm, in its own frame.
    shades : (N, 3) uint8
        A colour per vertex.
    colours : ViewColours
        Of the ground.
    """

    def __init__(self, plotter: Any, mesh: TriangleMesh, shades: NDArray[np.uint8], colours: ViewColours) -> None:
        self._renderer = plotter.renderers[0]
        self._vertices = np.array(mesh.vertices)
        faces = np.column_stack([np.full(len(mesh.faces), 3), mesh.faces])
        surface = pv.PolyData(self._vertices.copy(), faces.ravel())
        surface["colour"] = np.array(shades, dtype=np.uint8)
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(surface)
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("colour")
        mapper.SetColorModeToDirectScalars()
        self._actor = vtkActor()
        self._actor.SetMapper(mapper)
        self._actor.GetProperty().SetDiffuse(0.85)
        self._actor.GetProperty().SetAmbient(0.25)
        self._renderer.add_actor(self._actor, reset_camera=False, render=False)
        self._size = 0.5 * float(np.linalg.norm(np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0)))
        self.radius = 0.62 * self._size
        self._handles = {Handle(kind, axis): self._part(kind, axis) for kind in ("ring", "arrow") for axis in range(3)}
        self._frustum = self._line_actor(np.zeros((0, 3)), [], "#ffffff", 1.5)
        self._lit: Handle | None = None
        self._scale = 1.0
        add_studio_light(self._renderer)
        self.set_colours(colours)
        self.view = MeshView()

    def set_colours(self, colours: ViewColours) -> None:
        """Draw the ground in other colours."""
        apply_background(self._renderer, colours)

    def set_scale(self, factor: float) -> None:
        """Take the mesh as ``factor`` times as large as it came; all else keeps its size on the screen."""
        self._scale = factor

    def set_view(self, view: MeshView) -> None:
        """Put mesh and camera where ``view`` has them."""
        view = view.scaled(1 / self._scale)
        self.view = view
        matrix = np.eye(4)
        matrix[:3, :3] = view.matrix
        matrix[:3, 3] = -view.matrix @ np.array(view.look_at_mm)
        placed = vtkMatrix4x4()
        placed.DeepCopy(matrix.ravel().tolist())
        self._actor.SetUserMatrix(placed)
        self._draw_frustum()

    def look(self, camera: Any, aspect: float) -> None:
        """Bring mesh, gizmo and a part of the way to the camera into the picture."""
        reach = 1.15 * self.radius
        box = np.array([[x, y, z] for x in (-reach, reach) for y in (-reach, reach) for z in (-reach, 1.6 * reach)])
        frame(camera, box, _DIRECTION, aspect, 1.05)

    @property
    def bounds(self) -> tuple[float, ...]:
        """The box that near and far plane must hold, mm."""
        reach = 3 * self._size + float(np.linalg.norm(self.view.look_at_mm))
        return (-reach, reach, -reach, reach, -reach, reach)

    def at(self, camera: Any, x: float, y: float, size: tuple[float, float]) -> tuple[Handle, FloatArray] | None:
        """Return the handle under a pixel, and its point (3,) there; None beside all of them."""
        best: tuple[float, Handle, FloatArray] | None = None
        for handle in self._handles:
            points = self._outline(handle)
            away = np.linalg.norm(project(camera, points, *size)[:, :2] - [x, y], axis=1)
            k = int(away.argmin())
            # Of two that lie one on the other, the arrow, which is the smaller.
            distance = float(away[k]) - (2.0 if handle.kind == "arrow" else 0.0)
            if away[k] <= _GRASP_PX and (best is None or distance < best[0]):
                best = distance, handle, points[k]
        return None if best is None else (best[1], best[2])

    def light(self, handle: Handle | None) -> bool:
        """Show which handle would be taken; return whether that has changed."""
        if handle == self._lit:
            return False
        for each, colour in ((self._lit, None), (handle, _LIT)):
            if each is not None:
                self._handles[each].GetProperty().SetColor(*rgb(colour or AXIS_COLOURS[each.axis]))
        self._lit = handle
        return True

    def _outline(self, handle: Handle) -> FloatArray:
        if handle.kind == "arrow":
            share = np.linspace(1.02, 1.3, 12)
            return np.asarray(np.outer(share * self.radius, np.eye(3)[handle.axis]))
        return _circle(handle.axis, self.radius)

    def _part(self, kind: str, axis: int) -> Any:
        if kind == "ring":
            points = _circle(axis, self.radius)
            return self._line_actor(points, [np.append(np.arange(len(points)), 0)], AXIS_COLOURS[axis], 3.0)
        direction = np.eye(3)[axis]
        arrow = pv.Arrow(
            start=direction * 1.02 * self.radius, direction=direction, scale=0.28 * self.radius,
            tip_length=0.5, tip_radius=0.16, shaft_radius=0.04,
        )  # fmt: skip
        return self._plain_actor(arrow, AXIS_COLOURS[axis])

    def _line_actor(self, points: FloatArray, lines: list[NDArray[np.int64]], colour: str, width: float) -> Any:
        actor = self._plain_actor(_lines(points, lines), colour)
        actor.GetProperty().SetLineWidth(width)
        return actor

    def _plain_actor(self, data: Any, colour: str) -> Any:
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(data)
        mapper.ScalarVisibilityOff()
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetLighting(False)
        actor.GetProperty().SetColor(*rgb(colour))
        self._renderer.add_actor(actor, reset_camera=False, render=False)
        return actor

    def _draw_frustum(self) -> None:
        """Draw the picture's frame where the camera looks, and the rays from it towards the camera."""
        view = self.view
        high = float(np.tan(np.deg2rad(view.field_of_view_deg) / 2)) * view.distance_mm
        wide = high * view.width / view.height
        corners = np.array([[-wide, -high, 0], [wide, -high, 0], [wide, high, 0], [-wide, high, 0]])
        # The camera itself is mostly far outside the picture: its rays are drawn a part of the way.
        share = min(1.0, 1.6 * self.radius / view.distance_mm)
        nearer = corners * (1 - share) + np.array([0, 0, view.distance_mm]) * share
        lines = [np.array([0, 1, 2, 3, 0]), np.array([4, 5, 6, 7, 4]), *(np.array([k, k + 4]) for k in range(4))]
        self._frustum.GetMapper().SetInputData(_lines(np.vstack([corners, nearer]), lines))


def _circle(axis: int, radius: float) -> FloatArray:
    angle = np.arange(_RING_POINTS) / _RING_POINTS * 2 * np.pi
    points = np.zeros((_RING_POINTS, 3))
    points[:, (axis + 1) % 3] = radius * np.cos(angle)
    points[:, (axis + 2) % 3] = radius * np.sin(angle)
    return points


def _lines(points: FloatArray, lines: list[NDArray[np.int64]]) -> Any:
    data = pv.PolyData()
    data.points = np.array(points, dtype=np.float64).reshape(-1, 3)
    data.lines = np.concatenate([np.concatenate([[len(line)], line]) for line in lines]) if lines else np.zeros(0, int)
    return data
