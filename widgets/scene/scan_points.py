"""The measured points of a scan, as small dots around and behind the fitted face."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from engine.mesh import FloatArray
from widgets.scene.background import ViewColours, rgb

SKIN_MM = 1.2
"""Dots nearer to the fitted face than this are taken as lying on it, mm."""

_BESIDE_PX = 6.0

LIMIT = 24_000
"""Most dots drawn; a scan has some hundred thousand and a software renderer has to keep up."""

_BEHIND = 66.0
"""Depth offset in units of the depth buffer, so that noise does not speckle the surface it lies on."""


def sample(points: FloatArray, limit: int = LIMIT) -> tuple[NDArray[np.float32], FloatArray]:
    """Return at most ``limit`` measured points of a range image (H, W, 3), evenly but without a grid pattern.

    The choice is the same for the same scan, so that dots stay still while options change.

    Returns
    -------
    points : (k, 3) float32
        mm.
    pixels : (k, 2) float
        Where they were measured.
    """
    flat = np.asarray(points).reshape(-1, 3)
    valid = np.flatnonzero(~np.isnan(flat[:, 2]))
    if len(valid) > limit:
        chosen = np.random.default_rng(0).choice(len(valid), size=limit, replace=False)
        valid = valid[np.sort(chosen)]
    rows, columns = np.divmod(valid, points.shape[1])
    return flat[valid].astype(np.float32), np.stack([columns, rows], axis=1).astype(np.float64)


def on_surface(
    points: NDArray[np.float32],
    pixels: FloatArray,
    vertices: FloatArray,
    normals: FloatArray,
    vertex_pixels: FloatArray,
) -> NDArray[np.bool_]:
    """Return which dots (k,) lie on a fitted face, so that drawing them would only speckle it.

    A dot does where a vertex is near it in the picture and the dot is within ``SKIN_MM`` of the plane there;
    spikes and what the face misses stay.
    """
    from scipy.spatial import cKDTree  # with the first face: empty views need not wait for it

    distance, nearest = cKDTree(vertex_pixels).query(pixels, distance_upper_bound=_BESIDE_PX)
    near = np.isfinite(distance)
    nearest = np.where(near, nearest, 0)
    height = np.abs(np.einsum("ij,ij->i", points - vertices[nearest], normals[nearest]))
    return np.asarray(near & (height < SKIN_MM))


class ScanPoints:
    """The dots of one scan in one renderer.

    Parameters
    ----------
    renderer : pyvista.Renderer
    colours : ViewColours
    """

    def __init__(self, renderer: Any, colours: ViewColours) -> None:
        self._renderer = renderer
        self._cloud = pv.PolyData()
        self._mapper = vtkPolyDataMapper()
        self._mapper.ScalarVisibilityOff()
        self._mapper.SetScalarModeToUsePointFieldData()
        self._mapper.SelectColorArray("colour")
        self._mapper.SetColorModeToDirectScalars()
        self._mapper.SetInputData(self._cloud)
        self._mapper.SetResolveCoincidentTopologyToPolygonOffset()
        self._mapper.SetRelativeCoincidentTopologyPointOffsetParameter(_BEHIND)
        self._actor = vtkActor()
        self._actor.SetMapper(self._mapper)
        self._actor.GetProperty().SetLighting(False)
        self._actor.GetProperty().SetRepresentationToPoints()
        self._actor.PickableOff()
        self._actor.VisibilityOff()
        self._show = True
        renderer.add_actor(self._actor, reset_camera=False, render=False)
        self.set_colours(colours)

    def set_points(self, points: NDArray[np.float32] | None, colours: NDArray[np.uint8] | None = None) -> None:
        """Show dots (k, 3) in mm, copied, all alike or in colours (k, 3) of their own; None shows none."""
        shown = points is not None and len(points) > 0
        self._cloud = pv.PolyData(np.array(points, dtype=np.float32)) if shown else pv.PolyData()
        if shown and colours is not None:
            self._cloud.point_data["colour"] = np.array(colours, dtype=np.uint8)
        self._mapper.SetScalarVisibility(shown and colours is not None)
        self._mapper.SetInputData(self._cloud)
        self._update()

    def set_visible(self, visible: bool) -> None:
        """Show or hide the dots."""
        self._show = visible
        self._update()

    def set_colours(self, colours: ViewColours, size: float = 1.0) -> None:
        """Take over a theme's colours and the dots' size in pixels."""
        self._actor.GetProperty().SetColor(*rgb(colours.points))
        self._actor.GetProperty().SetPointSize(size)

    def remove(self) -> None:
        """Take the dots out of their renderer."""
        self._renderer.remove_actor(self._actor, reset_camera=False, render=False)

    def _update(self) -> None:
        self._actor.SetVisibility(self._show and self._cloud.n_points > 0)
