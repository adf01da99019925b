"""The image of a scan with its tools above and its name in the corner."""

from __future__ import annotations

from PySide6.QtCore import QRect, QSize, Qt, Signal
from PySide6.QtGui import QImage, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from engine.mesh import BoolArray, FloatArray
from widgets import theme
from widgets.canvases.canvas_picture import canvas_image
from widgets.canvases.depth_bar import DepthBar
from widgets.canvases.image_canvas import ImageCanvas
from widgets.canvases.pictures import Picture
from widgets.parts import picture
from widgets.parts.buttons import IconButton
from widgets.parts.plates import OverlayPlate
from widgets.parts.section import ShyLabel
from widgets.parts.segments import Segments

TOOL_ROW = 32


class ToolRow(QWidget):
    """A row of tools on the panel's colour, 32 high."""

    def __init__(self, parent: QWidget | None = None, *, line: bool = False) -> None:
        super().__init__(parent)
        self._line = line
        theme.fix(self, height=TOOL_ROW)
        self.row = QHBoxLayout(self)
        self.row.setContentsMargins(4, 0, 4, 0)
        self.row.setSpacing(2)
        theme.signals.changed.connect(self.update)

    def add_separator(self) -> None:
        """Add a short upright line."""
        self.row.addWidget(_Upright())

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the ground, and the line below where there is one."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), theme.current().colour("panel"))
        if self._line:
            painter.fillRect(QRect(0, self.height() - 1, self.width(), 1), theme.current().colour("window"))


class _Upright(QWidget):
    def __init__(self) -> None:
        super().__init__()
        theme.fix(self, 16, 24)
        theme.signals.changed.connect(self.update)

    def paintEvent(self, _event: QPaintEvent) -> None:
        QPainter(self).fillRect(QRect(self.width() // 2, 4, 1, self.height() - 8), theme.current().colour("line"))


class CanvasPanel(QWidget):
    """The image canvas (``canvas``) with its tool row and the plate that names the scan.

    Signals
    -------
    view_changed(str)
        ``colour``, ``depth`` or ``missing``.
    wire_toggled(bool), fiducials_toggled(bool)
        The template, the fiducials are shown or not.
    """

    view_changed = Signal(str)
    wire_toggled = Signal(bool)
    fiducials_toggled = Signal(bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.canvas = ImageCanvas(self)
        self.tools = ToolRow(self)
        self.views = Segments([("colour", "Colour"), ("depth", "Depth"), ("missing", "Missing")], name="Picture shown")
        self.views.set_tip("colour", "Colour picture")
        self.views.set_tip("depth", "Depth, near bright; the bar below sets its range")
        self.views.set_tip("missing", "Pixels without a measurement (checked) and spikes (amber)")
        self.wire_button = IconButton("wire", "Template over the picture (W)", checkable=True)
        self.fiducial_button = IconButton("points", "Fiducials over the picture", checkable=True)
        self.loupe_button = IconButton("loupe", "Keep the loupe in sight (Z)", checkable=True)
        self.fit_button = IconButton("fit-view", "Frame the face, again: the whole picture (F)")
        self.zoom_label = ShyLabel("")
        self._arrange()
        self.plate = OverlayPlate(parent=self.canvas)
        self.depth_bar = DepthBar(self.canvas)
        self.depth_bar.hide()
        self._name, self._size = "", ""
        self.setFocusProxy(self.canvas)
        self._connect()
        self._offer()

    def _offer(self) -> None:
        def take(options: picture.PictureOptions) -> QImage:
            return canvas_image(self.canvas, options, wire=self.wire_button.isChecked())

        made = picture.offer(
            self.canvas, "picture", "picture", take,
            overlays=True, ready=lambda: "" if self._name else "there is no picture yet", menu=False,
        )  # fmt: skip
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.customContextMenuRequested.connect(lambda place: picture.pop_up(made, self.mapToGlobal(place)))

    def _arrange(self) -> None:
        row = self.tools.row
        row.addWidget(self.views)
        self.tools.add_separator()
        for button in (self.wire_button, self.fiducial_button, self.loupe_button):
            row.addWidget(button)
        row.addStretch(1)
        row.addWidget(self.zoom_label)
        row.addSpacing(6)
        row.addWidget(self.fit_button)
        self.wire_button.setChecked(True)
        self.fiducial_button.setChecked(True)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.tools)
        column.addWidget(self.canvas, 1)

    def _connect(self) -> None:
        canvas = self.canvas
        self.views.chosen.connect(self.set_view)
        canvas.view_changed.connect(self._show_view)
        self.wire_button.toggled.connect(canvas.set_wire_visible)
        self.wire_button.toggled.connect(self.wire_toggled)
        self.fiducial_button.toggled.connect(canvas.set_fiducials_visible)
        self.fiducial_button.toggled.connect(self.fiducials_toggled)
        self.loupe_button.toggled.connect(canvas.set_loupe_kept)
        self.fit_button.clicked.connect(canvas.toggle_fit)
        canvas.zoom_changed.connect(self._show_zoom)
        self.depth_bar.range_changed.connect(canvas.set_contrast)
        self.depth_bar.reset_requested.connect(canvas.reset_contrast)
        canvas.contrast_changed.connect(self.depth_bar.set_range)

    def set_scan(
        self,
        name: str,
        colour: Picture | None,
        depth: FloatArray | None,
        valid: BoolArray | None = None,
        spikes: BoolArray | None = None,
    ) -> None:
        """Show a scan: name, colour (H, W, 3), depth (H, W) mm, masks (H, W) of what is valid and what is a spike."""
        shown = colour if colour is not None else depth
        self._name = name
        self._size = "" if shown is None else f"{shown.shape[1]} × {shown.shape[0]}"
        self.canvas.set_pictures(colour, depth, valid, spikes)
        self.views.set_available("depth", depth is not None, "The scan has no depth")
        self.views.set_available("missing", valid is not None, "The scan has no mask of what was measured")
        if depth is not None:
            self.depth_bar.set_limits(*_limits(depth))
            self.depth_bar.set_range(*self.canvas.contrast)
        self._show_zoom(self.canvas.zoom)
        self._show_view(self.canvas.view)

    def _show_zoom(self, zoom: float) -> None:
        self.zoom_label.setText(f"{100 * zoom:.0f} %" if self._name else "")

    def set_view(self, view: str) -> None:
        """Show ``colour``, ``depth`` or ``missing``."""
        self.canvas.set_view(view)

    def _show_view(self, view: str) -> None:
        self.views.set_current(view)
        self.plate.set_text(self._name, f"{view}, {self._size}" if self._name else "")
        self.depth_bar.setVisible(view == "depth" and bool(self._name))
        self._place()
        self.view_changed.emit(view)

    def _place(self) -> None:
        self.plate.move(4, 4)
        bar = self.depth_bar.sizeHint()
        self.depth_bar.setGeometry(
            self.canvas.width() - bar.width() - 4, self.canvas.height() - bar.height() - 4, bar.width(), bar.height()
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep plate and bar in their corners."""
        super().resizeEvent(event)
        self._place()

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(446, theme.px(TOOL_ROW) + 556)

    def minimumSizeHint(self) -> QSize:
        """Return the room the tools need."""
        return QSize(self.tools.minimumSizeHint().width(), theme.px(TOOL_ROW) + 160)

    def focus_canvas(self) -> None:
        """Give the keys to the picture."""
        self.canvas.setFocus(Qt.FocusReason.OtherFocusReason)


def _limits(depth: FloatArray) -> tuple[float, float]:
    import numpy as np

    valid = depth[np.isfinite(depth)]
    return (0.0, 1.0) if valid.size == 0 else (float(valid.min()), float(valid.max()))
