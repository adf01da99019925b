"""The 3-D views as a picture of any scale: built anew off screen, so that lines and letters are as sharp as on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from PySide6.QtGui import QImage

from widgets.parts.picture import PictureOptions

if TYPE_CHECKING:
    from widgets.viewers.mesh_viewer import MeshViewer


class Pictured(Protocol):
    """Linked views that can be built a second time."""

    @property
    def viewer(self) -> MeshViewer:
        """The viewer whose arrangement and camera the picture takes."""

    def build_scene(self, plotter: Any, *, overlays: bool = True) -> Any:
        """Return all that the views show now, on the renderers of another plotter."""


_LARGEST_PX = 8192
_FINE_PX = 8_000_000
"""Up to this many pixels four are drawn to each."""


def face_image(views: Pictured, options: PictureOptions) -> QImage:
    """Return the views as they are seen now.

    Parameters
    ----------
    views : FaceViews or BasisViews
        Its 3-D part exists.
    options : PictureOptions
        Without overlays nothing is written over the face; a transparent ground has no gradient.
    """
    width, height = views.viewer.width(), views.viewer.height()
    scale = views.viewer.scale * options.scale
    scale = min(scale, _LARGEST_PX / max(width, height))
    fine = 2 if 4 * width * height * scale**2 <= _FINE_PX else 1
    pixels = _draw(views, scale * fine, options)
    if fine == 2:
        rows, columns = pixels.shape[0] // 2, pixels.shape[1] // 2
        parts = [pixels[y : 2 * rows : 2, x : 2 * columns : 2].astype(np.uint16) for y in (0, 1) for x in (0, 1)]
        pixels = ((parts[0] + parts[1] + parts[2] + parts[3] + 2) // 4).astype(np.uint8)
    rows, columns = pixels.shape[:2]
    # VTK blends onto nothing: colours come multiplied by their cover.
    kind = QImage.Format.Format_RGBA8888_Premultiplied if options.transparent else QImage.Format.Format_RGBX8888
    return QImage(np.ascontiguousarray(pixels).tobytes(), columns, rows, 4 * columns, kind).copy()


def _draw(views: Pictured, scale: float, options: PictureOptions) -> np.ndarray[Any, Any]:
    """Return the views (H, W, 4) uint8 at ``scale`` pixels to a pixel of the layout."""
    import pyvista as pv
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkWindowToImageFilter

    viewer = views.viewer
    size = [round(viewer.width() * scale), round(viewer.height() * scale)]
    plotter: Any = pv.Plotter(off_screen=True, shape=(viewer.views, 1), border=False, window_size=size, lighting="none")
    try:
        window = plotter.render_window
        window.SetMultiSamples(0)
        window.SetAlphaBitPlanes(1)
        window.SetSize(*size)
        gap = vtkRenderer()
        gap.SetBackground(*viewer.window_colour)
        gap.SetBackgroundAlpha(0.0 if options.transparent else 1.0)
        for renderer in plotter.renderers:
            window.RemoveRenderer(renderer)
        window.AddRenderer(gap)
        for renderer in plotter.renderers:
            window.AddRenderer(renderer)
            renderer.camera_set = True
        plotter.link_views()
        scene = views.build_scene(plotter, overlays=options.overlays)
        ratio = scale / viewer.scale
        camera = plotter.renderers[0].camera
        camera.DeepCopy(viewer.camera)
        for renderer in plotter.renderers:
            renderer.SetActiveCamera(camera)
        sizes = []
        for view, renderer in enumerate(plotter.renderers):
            rect = viewer.rect_of(view)
            renderer.SetDraw(rect is not None)
            if rect is not None:
                x, y, w, h = (v * ratio for v in rect)
                renderer.SetViewport(x / size[0], y / size[1], min((x + w) / size[0], 1), min((y + h) / size[1], 1))
            if options.transparent:
                renderer.SetGradientBackground(False)
                renderer.SetBackground(0.0, 0.0, 0.0)
                renderer.SetBackgroundAlpha(0.0)
            sizes.append((viewer.view_size(view)[0] * ratio, viewer.view_size(view)[1] * ratio))
        scene.layout(sizes, scale)
        if options.transparent:
            for renderer in plotter.renderers:
                renderer.SetGradientBackground(False)
                renderer.SetBackground(0.0, 0.0, 0.0)
        window.Render()
        grab = vtkWindowToImageFilter()
        grab.SetInput(window)
        grab.SetInputBufferTypeToRGBA()
        grab.ReadFrontBufferOff()
        grab.ShouldRerenderOff()
        grab.Update()
        image = grab.GetOutput()
        columns, rows, _ = image.GetDimensions()
        pixels: np.ndarray[Any, Any] = (
            vtk_to_numpy(  # type: ignore[no-untyped-call]
                image.GetPointData().GetScalars()
            )
            .reshape(rows, columns, 4)[::-1]
            .copy()
        )
        grab.SetInput(None)
        scene.close()
        window.RemoveRenderer(gap)
        return pixels
    finally:
        plotter.close()
