"""Pictures of faces without a window: for reports, plates and tests."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from engine.mesh import FloatArray
from widgets.scene import camera
from widgets.scene.background import PAPER, ViewColours, apply_background
from widgets.scene.calm import calmed
from widgets.scene.face import FaceActor, Look
from widgets.scene.fiducials import FiducialMarks
from widgets.scene.fit_scene import Fitted
from widgets.scene.heatmap import HeatRange, heat_colours
from widgets.scene.lights import add_studio_light
from widgets.scene.scan_points import ScanPoints

_SUPERSAMPLING = 2


class Stills:
    """An off-screen stage on which one face after the other is pictured; close it, or use it with ``with``.

    It needs no display: on Linux without one VTK draws through EGL (``libegl1``), with the processor where there is
    no graphics card. ``VTK_DEFAULT_OPENGL_WINDOW`` set by the user wins.

    Parameters
    ----------
    width, height : int
        Size of every picture in pixels.
    colours : ViewColours
        ``PAPER`` for print.
    """

    def __init__(self, width: int, height: int, colours: ViewColours = PAPER) -> None:
        if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
            os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
        self._size = (width, height)
        self._colours = colours
        window = [width * _SUPERSAMPLING, height * _SUPERSAMPLING]
        self._plotter: Any = pv.Plotter(off_screen=True, window_size=window, lighting="none")
        stage: Any = self._plotter.render_window
        stage.SetMultiSamples(0)
        self._renderer = self._plotter.renderers[0]
        self._renderer.camera_set = True  # else pyvista's first picture places the camera itself
        apply_background(self._renderer, colours)
        add_studio_light(self._renderer)

    def __enter__(self) -> Stills:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def face(
        self,
        fit: Fitted,
        look: Look,
        *,
        picture: NDArray[np.uint8] | None = None,
        view: str = "three_quarter",
        heat: HeatRange | None = None,
        wire: float = 0.0,
        surface: bool = True,
        dots: NDArray[np.float32] | None = None,
        fiducials: Mapping[str, FloatArray] | None = None,
        levels: int | None = None,
        margin: float = 1.06,
        smooth: bool = True,
    ) -> NDArray[np.uint8]:
        """Return a picture (height, width, 3) uint8 of a fitted face.

        Parameters
        ----------
        fit : FaceFit
        look : {"shaded", "textured", "heat", "blank"}
        picture : (H, W, 3) uint8, optional
            Scan's colour picture, for the textured look.
        view : str
            A name in ``camera.VIEWS``.
        heat : HeatRange, optional
            Range of the heat look, mm.
        wire : float
            Width of the template's wire in pixels; 0 leaves it out.
        surface : bool
            Whether the surface is drawn; a wire alone hides nothing behind it.
        dots : (k, 3) float32, optional
            Points of the scan, mm.
        fiducials : mapping of str to (3,) float, optional
            Named places in mm to mark.
        levels : int, optional
            0 draws every edge as wire; the template's edges where left out.
        margin : float
            Room around the face; 1 touches the edges.
        smooth : bool
            Whether the heat look takes the mean around each vertex, as in the window, or its own distance.
        """
        actor = FaceActor(self._renderer, self._colours)
        points = ScanPoints(self._renderer, self._colours)
        marks = FiducialMarks(self._renderer)
        try:
            mesh = fit.mesh
            depth = fit.levels if levels is None else levels
            actor.set_mesh(mesh.vertices, mesh.faces, fit.normals, levels=depth, uv=mesh.uv, picture=picture)
            if look == "heat":
                actor.set_heat(heat_colours(_distances(fit, smooth), heat or HeatRange(), self._colours.missing))
            actor.set_look(look)
            actor.set_colours(self._colours, width=max(wire, 0.1) * _SUPERSAMPLING)
            actor.set_wire(wire > 0)
            actor.set_visible(surface)
            points.set_colours(self._colours, size=1.4 * _SUPERSAMPLING)
            points.set_points(dots)
            box = actor.bounds()
            if box is not None:
                camera.look(self._renderer.camera, actor.vertices(), view, self._size[0] / self._size[1], margin)
                seen = _box(dots) if dots is not None and len(dots) else actor.bounds()
                camera.clip(self._renderer.camera, seen or box)
            marks.set_points(fiducials or {})
            size = (self._size[0] * _SUPERSAMPLING, self._size[1] * _SUPERSAMPLING)
            marks.draw(self._renderer.camera, size, _SUPERSAMPLING, actor.hides if surface else None)
            return self._shoot()
        finally:
            actor.remove()
            points.remove()
            marks.remove()

    def album(
        self,
        fit: Fitted,
        shots: Sequence[tuple[Look, str]],
        *,
        picture: NDArray[np.uint8] | None = None,
        heat: HeatRange | None = None,
        margin: float = 1.06,
        smooth: bool = True,
    ) -> list[NDArray[np.uint8]]:
        """Return several pictures of one face, (look, view) each; it is put on the stage once for all of them."""
        actor = FaceActor(self._renderer, self._colours)
        try:
            mesh = fit.mesh
            actor.set_mesh(mesh.vertices, mesh.faces, fit.normals, levels=fit.levels, uv=mesh.uv, picture=picture)
            actor.set_heat(heat_colours(_distances(fit, smooth), heat or HeatRange(), self._colours.missing))
            actor.set_wire(False)
            box, taken = actor.bounds(), []
            for look, view in shots:
                actor.set_look(look)
                if box is not None:
                    camera.look(self._renderer.camera, actor.vertices(), view, self._size[0] / self._size[1], margin)
                    camera.clip(self._renderer.camera, box)
                taken.append(self._shoot())
            return taken
        finally:
            actor.remove()

    def close(self) -> None:
        """Let go of the stage."""
        self._plotter.close()

    def _shoot(self) -> NDArray[np.uint8]:
        self._plotter.render()
        image = np.asarray(self._plotter.screenshot(None, return_img=True), dtype=np.float64)
        width, height = self._size
        grid = image[: height * _SUPERSAMPLING, : width * _SUPERSAMPLING, :3]
        blocks = grid.reshape(height, _SUPERSAMPLING, width, _SUPERSAMPLING, 3)
        return np.asarray(np.clip(blocks.mean(axis=(1, 3)) + 0.5, 0, 255), dtype=np.uint8)


def _distances(fit: Fitted, smooth: bool) -> FloatArray:
    deviation = np.asarray(fit.deviation_mm, dtype=np.float64)
    return calmed(deviation, fit.mesh.vertices, fit.mesh.faces) if smooth else deviation


def _box(dots: NDArray[np.float32]) -> Sequence[float]:
    low, high = dots.min(axis=0), dots.max(axis=0)
    return tuple(float(x) for x in np.stack([low, high], axis=1).ravel())
