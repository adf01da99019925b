"""The fitted face in 3-D: a row of tools over two linked views, the face and its distance to the scan."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPoint, Signal
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QVBoxLayout, QWidget

from engine.scan.range_image import RangeImage
from widgets import theme
from widgets.parts import picture as pictures
from widgets.scan.face_sight import VIEW_NAMES, FaceSight
from widgets.scan.face_tools import FaceTools
from widgets.scan.range_editor import RangeEditor
from widgets.scan.range_tool import LARGEST_MM, SMALLEST_MM, RangeTool
from widgets.viewers.mesh_viewer import MeshViewer

if TYPE_CHECKING:
    from widgets.scene.colour_bar import ColourBar
    from widgets.scene.fit_scene import FitScene, Fitted

FACE, DISTANCE = 0, 1

START_RANGE_MM = (0.0, 0.2)


class FaceViews(QWidget):
    """Tool row and two linked views; shows what it is given and emits what the user wants.

    The 3-D part is made after the first paint; everything set before is shown once it is there.

    Signals
    -------
    mode_changed(str)
        ``shaded`` or ``textured``, chosen in the tool row.
    wireframe_changed(bool), points_changed(bool), heatmap_changed(bool)
        Switches of the tool row.
    range_changed(float, float)
        The user put the heatmap's range elsewhere, mm.
    smooth_changed(bool)
        The user wants the heatmap's colours smoothed, or as measured.
    maximise_requested(bool)
        The user wants the views to fill the window, or to go back.
    orthographic_changed(bool)
        The views are drawn without perspective, or with it.
    ready()
        The 3-D part exists.
    """

    mode_changed = Signal(str)
    wireframe_changed = Signal(bool)
    points_changed = Signal(bool)
    heatmap_changed = Signal(bool)
    range_changed = Signal(float, float)
    smooth_changed = Signal(bool)
    maximise_requested = Signal(bool)
    orthographic_changed = Signal(bool)
    ready = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._fit: Fitted | None = None
        self._scan: RangeImage | None = None
        self._fiducials: dict[str, int] = {}
        self._note = ""
        self._mode: Literal["shaded", "textured"] = "textured"
        self._wire, self._dots, self._distance = True, True, True
        self._range, self._smooth = START_RANGE_MM, True
        self.scene: FitScene | None = None
        self.viewer = MeshViewer(2, self)
        self.sight = FaceSight(self.viewer)
        self.viewer.ready.connect(self._build)
        self.viewer.resized.connect(self._layout)
        self.viewer.camera_changed.connect(self._turned)
        self.viewer.hovered.connect(self._hover)
        self.viewer.left.connect(self._leave)
        self.viewer.set_tool(RangeTool(self))
        self.tools = FaceTools(VIEW_NAMES, self)
        self.tools.mode_chosen.connect(self._choose_mode)
        for toggled, show, changed in (
            (self.tools.wire_toggled, self.set_wireframe, self.wireframe_changed),
            (self.tools.points_toggled, self.set_points, self.points_changed),
            (self.tools.heatmap_toggled, self.set_heatmap, self.heatmap_changed),
        ):
            toggled.connect(show)
            toggled.connect(changed)
        self.tools.maximise_toggled.connect(self.maximise_requested)
        self.tools.view_chosen.connect(self.view)
        self.tools.frame_chosen.connect(self.frame)
        self._offer: pictures.Offer = pictures.offer(
            self.viewer, "face", "3-D view", self.image,
            overlays=True, transparent=True, ready=self._nothing, menu=False,
        )  # fmt: skip
        self.tools.save_chosen.connect(lambda: pictures.requests.asked.emit(self._offer, "save"))
        self.tools.copy_chosen.connect(lambda: pictures.requests.asked.emit(self._offer, "copy"))
        self.viewer.menu_requested.connect(lambda place: pictures.pop_up(self._offer, place))
        self._allow()
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.setSpacing(0)
        box.addWidget(self.tools)
        box.addWidget(self.viewer, 1)
        theme.signals.changed.connect(self.apply_theme)

    # What is shown.

    def set_fit(
        self, fit: Fitted | None, scan: RangeImage | None = None, *, fiducials: Mapping[str, int] | None = None
    ) -> None:
        """Show a fitted face over its scan.

        Parameters
        ----------
        fit : FaceFit or None
            None shows that there is no face yet.
        scan : RangeImage, optional
            Its points are drawn as dots, its colour is the texture.
        fiducials : mapping of str to int, optional
            Vertices to mark by name.
        """
        changed = scan is not self._scan
        self._fit, self._scan, self._fiducials = fit, scan, dict(fiducials or {})
        self.tools.set_level(f"level {fit.levels}" if fit is not None else "")
        self._allow()
        if self.scene is not None:
            if changed:
                self.scene.set_scan(scan)
            self._show_fit()
            self.sight.follow(self.scene)
            self.viewer.redraw()

    def set_preview_note(self, note: str) -> None:
        """Write a note before the first view's name, such as ``preview, 17 of 20 points``; empty for none."""
        if note != self._note:
            self._note = note
            if self.scene is not None:
                self.scene.set_note(note)
                self.scene.write()
                self.viewer.redraw()

    def set_mode(self, mode: Literal["shaded", "textured"]) -> None:
        """Show the face as clay or with the scan's colour picture."""
        self._mode = mode
        self.tools.set_mode(mode)
        self._update()

    def set_wireframe(self, visible: bool) -> None:
        """Show or hide the template's edges."""
        self._wire = visible
        self.tools.set_down("wire", visible)
        self._update()

    def set_points(self, visible: bool) -> None:
        """Show or hide the scan's points."""
        self._dots = visible
        self.tools.set_down("points", visible)
        self._update()

    def set_heatmap(self, visible: bool) -> None:
        """Show the distance view beside the face, or the face alone."""
        self._distance = visible
        self.tools.set_down("heatmap", visible)
        if self.scene is not None:
            self.viewer.set_shown((FACE, DISTANCE) if visible else (FACE,))
        self._update()

    def set_range(self, low: float, high: float) -> None:
        """Put the heatmap's range, mm; it stays there whatever data comes."""
        self._range = (float(low), float(high))
        self._recolour()

    def set_smooth(self, smooth: bool) -> None:
        """Colour the heatmap by the mean around each vertex, or by its own distance."""
        self._smooth = smooth
        self._recolour()

    @property
    def bar(self) -> ColourBar | None:
        """The colour bar, None while there is no face."""
        return self.scene.bar if self.scene is not None and not self.scene.empty else None

    @property
    def mode(self) -> str:
        """``shaded`` or ``textured``."""
        return self._mode

    @property
    def range(self) -> tuple[float, float]:
        """The heatmap's range, mm."""
        return self._range

    @property
    def wireframe(self) -> bool:
        """Whether the template's edges are shown."""
        return self._wire

    @property
    def points(self) -> bool:
        """Whether the scan's points are shown."""
        return self._dots

    @property
    def heatmap(self) -> bool:
        """Whether the distance view is shown."""
        return self._distance

    # Where it is seen from.

    def view(self, name: str) -> None:
        """Look from a standard side, a key of ``VIEW_NAMES``, at the whole face."""
        self.sight.choose(name)
        self.frame(name)

    def frame(self, name: str | None = None) -> None:
        """Bring the whole face into the picture, from where the camera stands or from a standard view."""
        if self.scene is not None:
            self.sight.frame(self.scene, name)

    def frame_fiducial(self, name: str) -> bool:
        """Bring a fiducial's neighbourhood on the face into the middle, seen as before; returns whether it is there."""
        place = self._places().get(name)
        if self.scene is None or place is None:
            return False
        self.sight.frame_place(self.scene, np.array(place))
        return True

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

    def picture(self) -> NDArray[np.uint8]:
        """Return both views as they are seen, (H, W, 3) uint8."""
        return self.viewer.picture()

    def image(self, options: pictures.PictureOptions) -> QImage:
        """Return both views as a picture of any scale, with what is written over them or without."""
        from widgets.scan.face_picture import face_image

        if options == pictures.PictureOptions():
            return _image(self.picture())
        return face_image(self, options)

    def _nothing(self) -> str:
        return "" if self.scene is not None else "3-D is not there yet"

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
        self.viewer.close()
        return super().close()

    def bar_range(self, low: float, high: float, axis: float | None) -> None:
        """Follow a handle of the colour bar; ``axis`` keeps the bar still meanwhile, None ends the drag."""
        low = round(min(max(low, 0.0), LARGEST_MM - SMALLEST_MM), 2)
        high = round(min(max(high, low + SMALLEST_MM), LARGEST_MM), 2)
        changed = (low, high) != self._range
        self._range = (low, high)
        self._recolour(axis)
        if changed:
            self.range_changed.emit(low, high)

    def edit_range(self, at: QPoint) -> None:
        """Open a small editor for the range at a global place."""
        editor = RangeEditor(*self._range, START_RANGE_MM, self, smooth=self._smooth)
        editor.smooth_changed.connect(self.set_smooth)
        editor.smooth_changed.connect(self.smooth_changed)
        editor.changed.connect(lambda low, high: self.bar_range(low, high, None))
        editor.open_at(at)

    def build_scene(self, plotter: Any, *, overlays: bool = True) -> FitScene:
        """Return all that the views show now, on the first two renderers of another plotter."""
        from widgets.scene.background import view_colours
        from widgets.scene.fit_scene import FitScene
        from widgets.scene.heatmap import HeatRange

        scene = FitScene(plotter, view_colours(theme.current().name), overlays=overlays)
        scene.set_note(self._note)
        scene.set_scan(self._scan)
        scene.set_smooth(self._smooth)
        scene.set_heat(HeatRange(*self._range))
        scene.set_fit(self._fit, self._scan.colour if self._scan is not None else None)
        scene.set_fiducials(self._places())
        scene.set_look(self._mode)
        scene.set_wire(self._wire)
        scene.set_points(self._dots)
        return scene

    def _build(self) -> None:
        from widgets.scene.background import view_colours
        from widgets.scene.fit_scene import FitScene

        self.scene = FitScene(self.viewer.plotter, view_colours(theme.current().name))
        self.viewer.set_picker(self._pick)
        self.viewer.set_shown((FACE, DISTANCE) if self._distance else (FACE,))
        self.apply_theme()
        self.scene.set_note(self._note)
        self.scene.set_scan(self._scan)
        self._recolour()
        self._show_fit()
        self._update()
        self._layout()
        self.sight.settle(self.scene)
        self.ready.emit()

    def _show_fit(self) -> None:
        if self.scene is None:
            return
        self.scene.set_fit(self._fit, self._scan.colour if self._scan is not None else None)
        self.scene.set_fiducials(self._places())

    def _places(self) -> dict[str, NDArray[np.float64]]:
        if self._fit is None:
            return {}
        vertices = self._fit.mesh.vertices
        return {name: vertices[k] for name, k in self._fiducials.items() if 0 <= k < len(vertices)}

    def _update(self) -> None:
        if self.scene is not None:
            self.scene.set_look(self._mode)
            self.scene.set_wire(self._wire)
            self.scene.set_points(self._dots)
            self.scene.write()
            self.viewer.redraw()

    def _recolour(self, axis: float | None = None) -> None:
        if self.scene is not None:
            from widgets.scene.heatmap import HeatRange

            self.scene.set_smooth(self._smooth)
            self.scene.set_heat(HeatRange(*self._range), axis)
            self.viewer.redraw()

    def _layout(self) -> None:
        if self.scene is not None:
            self.scene.layout([*map(self.viewer.view_size, (FACE, DISTANCE))], self.viewer.scale * theme.px(100) / 100)
            self.sight.settle(self.scene)

    def _turned(self) -> None:
        self.sight.turned()
        if self.scene is not None:
            self.scene.turn()

    def _pick(self, segment: tuple[NDArray[np.float64], NDArray[np.float64]]) -> NDArray[np.float64] | None:
        hit = self.scene.pick(segment) if self.scene is not None else None
        return None if hit is None else hit[1]

    def _hover(self, view: int, x: float, y: float) -> None:
        if self.scene is None:
            return
        over_bar = view == DISTANCE and self.scene.bar.contains(x, y)
        sight = None if over_bar or self.scene.empty else self.viewer.segment(view, x, y)
        if self.scene.read_at(view, sight, (x, y)):
            self.viewer.hasten()

    def _leave(self) -> None:
        if self.scene is not None and self.scene.read_at(FACE, None, (0, 0)):
            self.viewer.redraw()

    def _allow(self) -> None:
        textured = self._scan is None or self._scan.colour is not None
        self.tools.allow_texture(textured, "This scan has no colour picture")

    def _choose_mode(self, mode: str) -> None:
        self.set_mode("shaded" if mode == "shaded" else "textured")
        self.mode_changed.emit(mode)


def _image(picture: NDArray[np.uint8]) -> QImage:
    height, width = picture.shape[:2]
    return QImage(picture.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888).copy()
