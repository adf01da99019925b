"""The picture of a scan as colour, depth or what is missing: the part of the canvas that knows no fiducials."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QWidget

from engine.mesh import BoolArray, FloatArray
from widgets.canvases import pictures
from widgets.canvases.pan_zoom import PanZoomView
from widgets.canvases.pictures import Picture

VIEWS = ("colour", "depth", "missing")


class ScanView(PanZoomView):
    """A scan's picture in three views, with the depths that are shown bright and dark.

    Signals
    -------
    view_changed(str)
        ``colour``, ``depth`` or ``missing``.
    contrast_changed(float, float)
        Near and far in mm.
    """

    view_changed = Signal(str)
    contrast_changed = Signal(float, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._image: Picture | None = None
        self._depth: FloatArray | None = None
        self._valid: BoolArray | None = None
        self._spikes: BoolArray | None = None
        self._window: tuple[float, float] | None = None
        self._own = (0.0, 1.0)
        self._view = "colour"

    def set_pictures(
        self,
        image: Picture | None,
        depth: FloatArray | None,
        valid: BoolArray | None = None,
        spikes: BoolArray | None = None,
    ) -> None:
        """Take colour (H, W, 3), depth (H, W) mm and both masks (H, W) of another scan at once."""
        self._image, self._valid, self._spikes = image, valid, spikes
        self._take_depth(depth)
        self._redraw()

    def set_image(self, image: Picture | None) -> None:
        """Show the colour picture (H, W, 3) uint8; ``None`` where the scan has none."""
        self._image = image
        self._redraw()

    def set_depth(self, depth: FloatArray | None) -> None:
        """Take the depth (H, W) in mm, NaN = missing."""
        self._take_depth(depth)
        self._redraw()

    def _take_depth(self, depth: FloatArray | None) -> None:
        self._depth = depth
        self._own = (0.0, 1.0) if depth is None else pictures.depth_window(depth)

    def set_missing(self, valid: BoolArray | None, spikes: BoolArray | None = None) -> None:
        """Take the masks (H, W) of what was measured and of what stands out."""
        self._valid, self._spikes = valid, spikes
        self._redraw()

    def set_view(self, view: str) -> None:
        """Show ``colour``, ``depth`` (near bright) or ``missing`` (missing checked, spikes amber)."""
        if view != self._view and view in VIEWS:
            self._view = view
            self._redraw()
            self.view_changed.emit(view)

    @property
    def view(self) -> str:
        """What is shown: ``colour``, ``depth`` or ``missing``."""
        return self._view

    def set_contrast(self, near: float, far: float) -> None:
        """Show depths between ``near`` and ``far`` mm, whatever the scan; it stays until ``reset_contrast``."""
        self._window = (near, max(far, near + 0.1))
        self._redraw()
        self.contrast_changed.emit(*self._window)

    def reset_contrast(self) -> None:
        """Let the scan choose the depths again."""
        self._window = None
        self._redraw()
        self.contrast_changed.emit(*self.contrast)

    @property
    def contrast(self) -> tuple[float, float]:
        """Depths in mm that are shown bright and dark."""
        return self._own if self._window is None else self._window

    def picture(self) -> Picture | None:
        """Return what is shown, (H, W, 3) uint8, without the fiducials."""
        base = self._image
        if self._depth is not None and (self._view == "depth" or base is None):
            base = pictures.depth_picture(self._depth, *self.contrast)
        if self._view == "missing" and base is not None and self._valid is not None:
            return pictures.with_missing(base, self._valid, self._spikes, marked=True)
        return base

    def _redraw(self) -> None:
        picture = self.picture()
        self._show_pixmap(QPixmap() if picture is None else QPixmap.fromImage(pictures.to_image(picture)))
