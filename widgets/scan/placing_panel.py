"""The content of the dialog that places a mesh before its virtual camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from PySide6.QtCore import QSize, Qt, QTimer, Signal
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from engine.errors import InputError
from engine.files.mesh_unit import mm_per_unit
from engine.scan.mesh_preview import LightMesh, vertex_colours
from engine.scan.mesh_view import MeshView, view_mesh
from widgets import theme
from widgets.canvases.pictures import depth_thumbnail, to_image
from widgets.parts.section import DimLabel
from widgets.scan.placing_fields import PlacingFields
from widgets.scan.placing_tool import PlacingTool
from widgets.viewers.mesh_viewer import MeshViewer

PREVIEW = QSize(168, 208)
_WAIT_MS = 40


@dataclass(frozen=True)
class Placing:
    """What the panel begins with.

    ``light`` is the mesh to show, mm in ``unit``; ``view`` where the camera stands now; ``automatic`` where it would
    be placed by itself, with ``said`` on how surely.
    """

    light: LightMesh
    unit: str
    view: MeshView
    automatic: MeshView
    said: str


class PlacingPanel(QWidget):
    """The mesh in 3-D with its gizmo, what the camera sees, and the numbers.

    Signals
    -------
    told(str)
        What is wrong, empty when nothing is.
    """

    told = Signal(str)

    def __init__(self, placing: Placing, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._placing = placing
        self.view, self.unit = placing.view, placing.unit
        self._light = placing.light
        self.scene: Any = None
        self.viewer = MeshViewer(1, self)
        self.viewer.setMinimumSize(360, 360)
        self.viewer.ready.connect(self._build)
        self.viewer.resized.connect(self._clip)
        self.viewer.set_tool(PlacingTool(self))
        self.fields = PlacingFields(self.view, self.unit, self)
        self.fields.view_changed.connect(self.show_view)
        self.fields.unit_changed.connect(self._take_unit)
        self.fields.refused.connect(self.told)
        self.colour_picture, self.range_picture = QLabel(), QLabel()
        for label, name in (
            (self.colour_picture, "Colour that the camera sees"),
            (self.range_picture, "Range that the camera sees"),
        ):
            label.setFixedSize(PREVIEW)
            label.setAlignment(Qt.AlignmentFlag.AlignCenter)
            label.setAccessibleName(name)
        self.note = DimLabel(placing.said)
        self.note.setWordWrap(True)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(_WAIT_MS)
        self._timer.timeout.connect(self.refresh)
        self._lay_out()
        theme.signals.changed.connect(self._dress)
        self._dress()
        self.refresh()

    def _lay_out(self) -> None:
        pictures = QGridLayout()
        pictures.setSpacing(8)
        for column, (label, text) in enumerate(
            ((self.colour_picture, "colour"), (self.range_picture, "range, near bright"))
        ):
            pictures.addWidget(label, 0, column)
            pictures.addWidget(DimLabel(text), 1, column)
        steps = QGridLayout()
        steps.setSpacing(4)
        for row, (axis, names) in enumerate(
            ((1, ("Turn left 90°", "Turn right 90°")), (0, ("Tilt up 90°", "Tilt down 90°")),
             (2, ("Roll right 90°", "Roll left 90°")))
        ):  # fmt: skip
            for column, (name, sign) in enumerate(zip(names, (-1, 1), strict=True)):
                steps.addWidget(_button(name, lambda a=axis, s=sign: self.step(a, s)), row, column)
        self.automatic = _button("&Automatic", lambda: self.show_view(self._resized(self._placing.automatic)))
        self.automatic.setToolTip("Place the camera by the mesh's symmetry and its nose")
        self.reset = _button("R&eset", self._reset)
        self.reset.setToolTip("Go back to where the camera stood when this window was opened")
        whole = QHBoxLayout()
        whole.setSpacing(8)
        whole.addWidget(self.automatic)
        whole.addWidget(self.reset)
        side = QVBoxLayout()
        side.setSpacing(8)
        side.addLayout(pictures)
        side.addWidget(self.fields)
        side.addLayout(steps)
        side.addLayout(whole)
        side.addWidget(self.note)
        side.addStretch(1)
        line = QHBoxLayout(self)
        line.setContentsMargins(0, 0, 0, 0)
        line.setSpacing(16)
        line.addWidget(self.viewer, 1)
        line.addLayout(side)

    # What is shown.

    def show_view(self, view: MeshView) -> None:
        """Show another view in all places."""
        self.view = view
        self.fields.show_view(view)
        self.told.emit("")
        if self.scene is not None:
            self.scene.set_view(view)
            self._clip()
            self.viewer.hasten()
        if not self._timer.isActive():
            self._timer.start()

    def refresh(self) -> None:
        """Look at the mesh and show what the camera sees, small."""
        share = min(PREVIEW.width() / self.view.width, PREVIEW.height() / self.view.height)
        size = max(16, round(self.view.width * share)), max(16, round(self.view.height * share))
        try:
            seen = view_mesh(self._light, replace(self.view, width=size[0], height=size[1]))
        except InputError as error:
            self.colour_picture.setPixmap(QPixmap())
            self.range_picture.setPixmap(QPixmap())
            self.told.emit(str(error))
            return
        colour = np.full((*size[::-1], 3), 190, dtype=np.uint8) if seen.colour is None else seen.colour
        self.colour_picture.setPixmap(QPixmap.fromImage(to_image(colour)))
        self.range_picture.setPixmap(QPixmap.fromImage(to_image(depth_thumbnail(-seen.points[..., 2], *size))))

    def step(self, axis: int, sign: int) -> None:
        """Turn the mesh by a quarter about an axis of the camera, 0..2."""
        quarter = np.eye(3)
        one, two = (axis + 1) % 3, (axis + 2) % 3
        quarter[one, one] = quarter[two, two] = 0
        quarter[one, two], quarter[two, one] = -sign, sign
        self.show_view(self.view.rotated(quarter))

    # What the gizmo asks for.

    @property
    def scale(self) -> float:
        """Millimetres of the view in one of the scene, which keeps the unit it was opened with."""
        return mm_per_unit(self.unit) / mm_per_unit(self._placing.unit)

    def camera_and_size(self) -> tuple[Any, tuple[float, float]]:
        """Return the 3-D view's camera, and its size in screen pixels."""
        return self.viewer.camera, self.viewer.view_size(0)

    def turn_by_hand(self, view: MeshView) -> None:
        """Take the view that a drag has led to."""
        self.show_view(view)

    def redraw(self) -> None:
        """Draw the 3-D view again."""
        self.viewer.redraw()

    def release(self) -> None:
        """Let go of the 3-D view; the panel is of no use afterwards."""
        self._timer.stop()
        self.viewer.close()

    # Inside.

    def _build(self) -> None:
        from widgets.scene.background import view_colours
        from widgets.scene.placing_scene import PlacingScene

        colours = view_colours("dark" if theme.current().is_dark else "light")
        self.scene = PlacingScene(self.viewer.plotter, self._light.mesh, vertex_colours(self._light), colours)
        self.scene.set_view(self.view)
        width, height = self.viewer.view_size(0)
        self.scene.look(self.viewer.camera, width / height)
        self.viewer.set_pivot(np.zeros(3))
        self._clip()
        self.viewer.camera_moved()

    def _clip(self) -> None:
        if self.scene is not None:
            self.viewer.set_bounds(self.scene.bounds)

    def _dress(self) -> None:
        current = theme.current()
        frame = f"border: 1px solid {current.line}; background: {current.view_bottom};"
        self.colour_picture.setStyleSheet(frame)
        self.range_picture.setStyleSheet(frame)
        if self.scene is not None:
            from widgets.scene.background import view_colours

            self.scene.set_colours(view_colours("dark" if current.is_dark else "light"))
            self.viewer.redraw()

    def _resized(self, view: MeshView) -> MeshView:
        """Return an automatic view at the chosen size of the picture and in the chosen unit."""
        factor = mm_per_unit(self.unit) / mm_per_unit(self._placing.unit)
        return replace(view.scaled(factor), width=self.view.width, height=self.view.height)

    def _reset(self) -> None:
        self._take_unit(self._placing.unit)
        self.fields.show_unit(self.unit)
        self.show_view(self._placing.view)

    def _take_unit(self, unit: str) -> None:
        """Scale mesh and view together: the picture stays, its millimetres change."""
        factor = mm_per_unit(unit) / mm_per_unit(self.unit)
        try:
            view = self.view.scaled(factor)
        except InputError as error:
            self.fields.show_unit(self.unit)
            self.told.emit(str(error))
            return
        self.unit = unit
        mesh = self._placing.light.mesh
        whole = mm_per_unit(unit) / mm_per_unit(self._placing.unit)
        self._light = replace(self._placing.light, mesh=mesh.with_vertices(mesh.vertices * whole))
        if self.scene is not None:
            self.scene.set_scale(whole)
        self.show_view(view)


def _button(text: str, deed: Any) -> QPushButton:
    button = QPushButton(text)
    button.setAutoDefault(False)
    button.clicked.connect(lambda _checked=False: deed())
    return button
