"""The scan's picture as it stands in its canvas, at any scale, with what lies over it or without."""

from __future__ import annotations

from PySide6.QtCore import QPoint
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QWidget

from widgets.canvases.image_canvas import ImageCanvas
from widgets.parts.picture import PictureOptions, canvas_for


def canvas_image(canvas: ImageCanvas, options: PictureOptions, *, wire: bool) -> QImage:
    """Return what the canvas shows: pixels of the scan, template and fiducials are drawn anew at the scale.

    Without overlays only the scan's picture is there: no template, no fiducials, no labels. ``wire`` says whether the
    template is shown in the canvas, as it is again afterwards.
    """
    marks = canvas.fiducials.visible

    def paint(painter: QPainter) -> None:
        # A graphics view has a ``render`` of its own, which draws its scene alone.
        QWidget.render(canvas if options.overlays else canvas.viewport(), painter, QPoint())

    canvas.sharpness = float(options.scale)
    try:
        if not options.overlays:
            canvas.set_wire_visible(False)
            canvas.set_fiducials_visible(False)
        return canvas_for(canvas.size(), canvas.devicePixelRatioF(), options, paint)
    finally:
        canvas.sharpness = 1.0
        canvas.set_wire_visible(wire)
        canvas.set_fiducials_visible(marks)
