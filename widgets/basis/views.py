"""The centre of the basis stage: hand, quasi-eigen and their change above, a frame and its reconstructions below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Signal
from PySide6.QtGui import QHideEvent, QImage, QShowEvent
from PySide6.QtWidgets import QStackedLayout, QVBoxLayout, QWidget

from engine.mesh import FloatArray, TriangleMesh
from widgets import theme
from widgets.basis.view_empty import NoRig
from widgets.basis.view_grid import GridRow, ShapeGrid
from widgets.basis.view_hand import ViewsTool
from widgets.basis.view_keys import SpaceBar
from widgets.basis.view_tools import ViewTools
from widgets.parts import picture as pictures
from widgets.scan.face_sight import VIEW_NAMES, FaceSight
from widgets.scan.range_tool import LARGEST_MM, SMALLEST_MM
from widgets.scene.basis_content import TITLES, BasisContent, Rms
from widgets.scene.basis_state import MODES, ORIGINAL, VIEWS, Mode, ViewState, places
from widgets.scene.heatmap import HeatRange
from widgets.viewers.arrangement import Cell
from widgets.viewers.mesh_viewer import MeshViewer

if TYPE_CHECKING:
    from widgets.scene.basis_scene import BasisScene

_ROOM = (1.34, 0.05)


class BasisViews(QWidget):
    """Tool row over linked views; shows what it is given and emits what the user wants.

    The 3-D part is made after the first paint; everything set before is shown once it is there. Arrays are copied.

    Signals
    -------
    mode_changed(str)
        ``side``, ``overlay``, ``wipe`` or ``grid``, chosen in the tool row.
    wireframe_changed(bool), heatmap_changed(bool), markers_changed(bool), clip_heat_changed(bool), pca_changed(bool)
        Switches of the tool row.
    range_changed(float, float)
        The user put the heatmaps' range elsewhere, mm.
    shape_chosen(str), open_requested()
        A shape of the grid was clicked; the empty stage's button.
    maximise_requested(bool), orthographic_changed(bool)
        The views are to fill the window or to go back; they are drawn without perspective, or with it.
    ready()
        The 3-D part exists.
    """

    mode_changed = Signal(str)
    wireframe_changed = Signal(bool)
    heatmap_changed = Signal(bool)
    markers_changed = Signal(bool)
    clip_heat_changed = Signal(bool)
    pca_changed = Signal(bool)
    range_changed = Signal(float, float)
    shape_chosen = Signal(str)
    maximise_requested = Signal(bool)
    orthographic_changed = Signal(bool)
    open_requested = Signal()
    ready = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._state = ViewState()
        self._content = BasisContent()
        self.scene: BasisScene | None = None
        self.viewer = MeshViewer(VIEWS, self)
        self.sight = FaceSight(self.viewer, _ROOM, ORIGINAL)
        self.viewer.ready.connect(self._build)
        self.viewer.resized.connect(self._layout)
        self.viewer.camera_changed.connect(self._turned)
        self._tool = ViewsTool(self)
        self._space = SpaceBar(self)
        self._space.held.connect(self.set_flipped)
        self.tools = ViewTools(MODES, VIEW_NAMES, self)
        self.tools.mode_chosen.connect(self.set_mode)
        self.tools.mode_chosen.connect(self.mode_changed)
        for toggled, show, changed in (
            (self.tools.wire_toggled, self.set_wireframe, self.wireframe_changed),
            (self.tools.heatmap_toggled, self.set_heatmap, self.heatmap_changed),
            (self.tools.markers_toggled, self.set_markers_visible, self.markers_changed),
            (self.tools.clip_toggled, self.set_clip_heat_visible, self.clip_heat_changed),
            (self.tools.pca_toggled, self.set_pca_visible, self.pca_changed),
        ):
            toggled.connect(show)
            toggled.connect(changed)
        self.tools.flip_held.connect(self.set_flipped)
        self.tools.maximise_toggled.connect(self.maximise_requested)
        self.tools.view_chosen.connect(self.view)
        self.tools.frame_chosen.connect(self.frame)
        self.grid = ShapeGrid(self)
        self.grid.shape_chosen.connect(self.shape_chosen)
        self.empty = NoRig(self)
        self.empty.open_requested.connect(self.open_requested)
        self._offer: pictures.Offer = pictures.offer(
            self.viewer, "shapes", "3-D views", self.image,
            overlays=True, transparent=True, menu=False,
            ready=lambda: "there is no rig" if self._content.rig is None else "",
        )  # fmt: skip
        self.tools.save_chosen.connect(lambda: pictures.requests.asked.emit(self._offer, "save"))
        self.tools.copy_chosen.connect(lambda: pictures.requests.asked.emit(self._offer, "copy"))
        self.viewer.menu_requested.connect(lambda place: pictures.pop_up(self._offer, place))
        self._pages = QStackedLayout()
        for page in (self.empty, self.viewer, self.grid):
            self._pages.addWidget(page)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.setSpacing(0)
        box.addWidget(self.tools)
        box.addLayout(self._pages, 1)
        theme.signals.changed.connect(self.apply_theme)
        self._turn_page()

    # What is shown.

    def set_rig(
        self,
        mesh: TriangleMesh | None,
        skin: NDArray[Any] | None = None,
        texture: NDArray[np.uint8] | None = None,
    ) -> None:
        """Show a rig's neutral face; shapes and frames that were shown are gone.

        Parameters
        ----------
        mesh : TriangleMesh or None
            Neutral face with its parts, mm; None shows the empty stage.
        skin : (V,) int or (N,) bool, optional
            Vertices that figures and heatmaps are about; all where left out.
        texture : (H, W, 3) uint8, optional
            The lower views wear it where the mesh has a chart.
        """
        self._content.set_rig(mesh, skin, texture)
        self.grid.set_rig(self._content.rig)
        self._turn_page()
        self._show()
        if self.scene is not None:
            self.sight.follow(self.scene)

    def set_shape(
        self,
        name: str,
        hand: FloatArray | None,
        quasi: FloatArray | None,
        note: str = "",
        titles: tuple[str, str] = TITLES,
    ) -> None:
        """Show a shape by its displacements (N, 3) in mm.

        ``note`` stands behind the quasi-eigen shape's name; ``titles`` say what the two are where they are no shape.
        """
        self._content.set_shape(name, hand, quasi, note, titles)
        self.grid.set_current(name)
        self._show()

    def set_frame(
        self,
        index: int,
        original: FloatArray | None,
        by_hand: FloatArray | None = None,
        by_quasi: FloatArray | None = None,
        rms_mm: Rms = (),
        by_pca: FloatArray | None = None,
        markers: Sequence[FloatArray | None] | None = None,
    ) -> None:
        """Show a frame, counted from 0, and its reconstructions by positions (N, 3) in mm; markers as they were."""
        self._content.set_frame(index, (original, by_hand, by_quasi, by_pca), rms_mm)
        if markers is not None:
            self._content.set_markers(*markers)
        self._show(hasty=True)

    def set_markers(
        self,
        captured: FloatArray | None,
        by_hand: FloatArray | None = None,
        by_quasi: FloatArray | None = None,
        by_pca: FloatArray | None = None,
    ) -> None:
        """Mark captured markers (K, 3) in mm, NaN where one was not seen, and where reconstructions have them."""
        self._content.set_markers(captured, by_hand, by_quasi, by_pca)
        self._show(hasty=True)

    def set_clip_heat(self, rms_vertices: FloatArray | None, which: str, frames: int = 0) -> None:
        """Set the RMS (N,) in mm over the clip of ``hand``, ``quasi_eigen`` or ``pca``; None takes it away."""
        self._content.set_clip(rms_vertices, which, frames)
        self._show()

    def set_range(self, low: float, high: float) -> None:
        """Put the heatmaps' range, mm; it stays there whatever shape comes."""
        self._content.heat = HeatRange(float(low), float(high))
        self._show()

    def set_grid(self, rows: Sequence[GridRow]) -> None:
        """Set the shapes of the grid: name, hand and quasi-eigen displacements (N, 3) in mm or None, cosine."""
        self.grid.set_rows(rows)
        self.grid.set_current(self._content.name)

    def set_message(self, *lines: str) -> None:
        """Say in two lines what belongs here while there is no rig; the usual ones without."""
        self.empty.set_message(*lines)

    def set_mode(self, mode: str) -> None:
        """Choose how the shapes are compared: ``side``, ``overlay``, ``wipe`` or ``grid``; KeyError for another."""
        MODES[mode]
        self.tools.set_mode(mode)
        self._switch(mode=cast(Mode, mode))
        self._turn_page()

    def set_wireframe(self, visible: bool) -> None:
        """Draw the edges of the mesh."""
        self._set("wire", visible, wire=visible)

    def set_heatmap(self, visible: bool) -> None:
        """Show the change of the shape beside it, or hand and quasi-eigen shape alone."""
        self._set("heatmap", visible, heat=visible)

    def set_markers_visible(self, visible: bool) -> None:
        """Show or hide the markers."""
        self._set("markers", visible, markers=visible)

    def set_clip_heat_visible(self, visible: bool) -> None:
        """Let the reconstructions wear their error over the whole clip, or skin."""
        self._set("clip", visible, clip_heat=visible)

    def set_pca_visible(self, visible: bool) -> None:
        """Show the reconstruction by PCA axes as a fourth face, or not."""
        self._set("pca", visible, pca=visible)

    def set_textured(self, textured: bool) -> None:
        """Let the lower views wear the rig's texture where it has one, or clay."""
        self._switch(textured=textured)

    def set_flipped(self, flipped: bool) -> None:
        """Show the quasi-eigen shape where the hand shape is, or the hand shape again; nothing else moves."""
        self._switch(flipped=flipped and self._state.mode != "grid")

    def set_wipe(self, share: float) -> None:
        """Put the line of the wipe, 0..1 of its view's width."""
        self._switch(wipe=float(np.clip(share, 0.02, 0.98)))

    @property
    def state(self) -> ViewState:
        """What is switched on."""
        return self._state

    @property
    def range(self) -> tuple[float, float]:
        """The heatmaps' range, mm."""
        return self._content.heat.low, self._content.heat.high

    # Where it is seen from.

    def view(self, name: str) -> None:
        """Look from a standard side, a key of ``VIEW_NAMES``, at the whole face."""
        self.sight.choose(name)
        self.frame(name)

    def frame(self, name: str | None = None) -> None:
        """Bring the whole face into the picture, from where the camera stands or from a standard view."""
        if self.scene is not None:
            self.sight.frame(self.scene, name)

    @property
    def orthographic(self) -> bool:
        """Whether the views are drawn without perspective."""
        return self.viewer.orthographic

    def set_orthographic(self, on: bool) -> None:
        """Draw without perspective, or with it; what lies at the pivot keeps its size."""
        if on != self.orthographic:
            self.sight.set_orthographic(on)
            self.orthographic_changed.emit(self.orthographic)

    # Pictures.

    def image(self, options: pictures.PictureOptions | None = None) -> QImage:
        """Return what is seen as a picture; the linked views at any scale, with words over them or without."""
        from widgets.scan.face_picture import face_image

        if self._state.mode == "grid":
            return self.grid.viewport().grab().toImage()
        return face_image(self, options or pictures.PictureOptions())

    def build_scene(self, plotter: Any, *, overlays: bool = True) -> BasisScene:
        """Return all that the views show now, on the renderers of another plotter."""
        from widgets.scene.background import view_colours
        from widgets.scene.basis_scene import BasisScene

        scene = BasisScene(plotter, self._content, view_colours(theme.current().name), overlays=overlays)
        scene.set_state(self._state)
        return scene

    # The hand.

    def bar_range(self, low: float, high: float, axis: float | None) -> None:
        """Follow a handle of a colour bar; ``axis`` keeps the bars still meanwhile, None ends the drag."""
        low = round(min(max(low, 0.0), LARGEST_MM - SMALLEST_MM), 2)
        high = round(min(max(high, low + SMALLEST_MM), LARGEST_MM), 2)
        changed = (low, high) != self.range
        self._content.heat = HeatRange(low, high)
        self._show(axis)
        if changed:
            self.range_changed.emit(low, high)

    def showEvent(self, event: QShowEvent) -> None:
        """Hear the space bar wherever in the window nobody else wants it."""
        super().showEvent(event)
        self._space.listen(self.window())

    def hideEvent(self, event: QHideEvent) -> None:
        """Leave the space bar to others."""
        self._space.forget(self.window())
        super().hideEvent(event)

    # The rest.

    def apply_theme(self) -> None:
        """Take over the window's theme."""
        current = theme.current()
        window = current.colour("window")
        self.viewer.set_window_colour((window.redF(), window.greenF(), window.blueF()))
        if self.scene is not None:
            from widgets.scene.background import view_colours

            self.scene.set_colours(view_colours(current.name))
            self._layout()
            self.viewer.redraw()

    def close(self) -> bool:
        """Let go of the 3-D part; the widget shows nothing any more."""
        if self.scene is not None:
            self.scene.close()
            self.scene = None
        self.grid.close()
        self.viewer.close()
        return super().close()

    def _build(self) -> None:
        self.scene = self.build_scene(self.viewer.plotter)
        self._space.listen(self.viewer.plotter)
        self.apply_theme()
        self._arrange()
        self.sight.settle(self.scene)
        self.ready.emit()

    def _set(self, button: str, down: bool, **changes: bool) -> None:
        self.tools.set_down(button, down)
        self._switch(**changes)

    def _switch(self, **changes: Any) -> None:
        before, self._state = self._state, replace(self._state, **changes)
        if places(self._state) != places(before):
            self._arrange()
        elif self._state != before:
            self._show(hasty="wipe" in changes)

    def _arrange(self) -> None:
        if self.scene is not None:
            self.scene.set_state(self._state)
            self.viewer.set_cells({view: Cell(*place) for view, place in places(self._state).items()})

    def _turn_page(self) -> None:
        rig, grid = self._content.rig is not None, self._state.mode == "grid"
        if rig and grid and self.scene is not None:
            from widgets.scene.camera import axes

            self.grid.set_direction(axes(self.viewer.camera)[0])
        self._pages.setCurrentWidget(self.empty if not rig else self.grid if grid else self.viewer)
        self.tools.setEnabled(rig)

    def _show(self, axis: float | None = None, *, hasty: bool = False) -> None:
        if self.scene is not None:
            self.scene.set_state(self._state)
            changed = self.scene.refresh(axis)
            if changed and hasty:
                self.viewer.hasten(changed)
            elif changed:
                self.viewer.redraw(changed)

    def _layout(self) -> None:
        if self.scene is not None:
            sizes = [self.viewer.view_size(view) for view in range(VIEWS)]
            self.scene.layout(sizes, self.viewer.scale * theme.px(100) / 100)
            self.sight.settle(self.scene)

    def _turned(self) -> None:
        self.sight.turned()
        if self.scene is not None:
            self.scene.turn()
