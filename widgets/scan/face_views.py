"""The fitted face in 3-D: a row of tools over two linked views, the face and its distance to the scan."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtGui import QAction, QGuiApplication, QImage
from PySide6.QtWidgets import QFileDialog, QFrame, QHBoxLayout, QLabel, QMenu, QVBoxLayout, QWidget

from engine.scan.range_image import RangeImage
from widgets import theme
from widgets.parts.buttons import IconButton
from widgets.parts.segments import Segments
from widgets.scan.range_editor import RangeEditor
from widgets.viewers.mesh_viewer import MeshViewer

if TYPE_CHECKING:
    from widgets.scene.fit_scene import FitScene, Fitted

FACE, DISTANCE = 0, 1

VIEW_NAMES = {
    "three_quarter": "Three-quarter, right",
    "front": "Front",
    "three_quarter_left": "Three-quarter, left",
    "left": "Subject's left",
    "right": "Subject's right",
    "top": "Top",
    "below": "From below",
}
"""Views that ``FaceViews.view`` knows, as the menu names them."""

START_RANGE_MM = (0.0, 0.2)
_ELSEWHERE_MM = 80.0
_LARGEST_MM, _SMALLEST_MM = 50.0, 0.01


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
    maximise_requested(bool)
        The user wants the views to fill the window, or to go back.
    picture_saved(str)
        A picture was written to this path; empty where it went to the clipboard.
    failed(str)
        A picture could not be written: one line for the status bar.
    ready()
        The 3-D part exists.
    """

    mode_changed = Signal(str)
    wireframe_changed = Signal(bool)
    points_changed = Signal(bool)
    heatmap_changed = Signal(bool)
    range_changed = Signal(float, float)
    maximise_requested = Signal(bool)
    picture_saved = Signal(str)
    failed = Signal(str)
    ready = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._fit: Fitted | None = None
        self._scan: RangeImage | None = None
        self._fiducials: dict[str, int] = {}
        self._note = ""
        self._mode: Literal["shaded", "textured"] = "textured"
        self._wire, self._dots, self._distance = True, True, True
        self._range = START_RANGE_MM
        self._framed, self._touched = False, False
        self._view = "three_quarter"
        self._centre = np.zeros(3)
        self.scene: FitScene | None = None
        self.viewer = MeshViewer(2, self)
        self.viewer.ready.connect(self._build)
        self.viewer.resized.connect(self._layout)
        self.viewer.camera_changed.connect(self._turned)
        self.viewer.hovered.connect(self._hover)
        self.viewer.left.connect(self._leave)
        self.viewer.set_tool(_BarTool(self))
        self._make_row()
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.setSpacing(0)
        box.addWidget(self._row)
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
        self._level.setText(f"level {fit.levels}" if fit is not None else "")
        self._allow()
        if self.scene is not None:
            if changed:
                self.scene.set_scan(scan)
            self._show_fit()
            if not self._framed or self._elsewhere():
                self.frame(self._view)
            else:
                self._bound()
            self.viewer.render()

    def set_preview_note(self, note: str) -> None:
        """Write a note before the first view's name, such as ``preview, 17 of 20 points``; empty for none."""
        if note != self._note:
            self._note = note
            if self.scene is not None:
                self.scene.set_note(note)
                self.scene.write()
                self.viewer.render()

    def set_mode(self, mode: Literal["shaded", "textured"]) -> None:
        """Show the face as clay or with the scan's colour picture."""
        self._mode = mode
        self._modes.set_current(mode)
        self._update()

    def set_wireframe(self, visible: bool) -> None:
        """Show or hide the template's edges."""
        self._wire = visible
        self._set_button("wire", visible)
        self._update()

    def set_points(self, visible: bool) -> None:
        """Show or hide the scan's points."""
        self._dots = visible
        self._set_button("points", visible)
        self._update()

    def set_heatmap(self, visible: bool) -> None:
        """Show the distance view beside the face, or the face alone."""
        self._distance = visible
        self._set_button("heatmap", visible)
        if self.scene is not None:
            self.viewer.set_shown((FACE, DISTANCE) if visible else (FACE,))
        self._update()

    def set_range(self, low: float, high: float) -> None:
        """Put the heatmap's range, mm; it stays there whatever data comes."""
        self._range = (float(low), float(high))
        self._recolour()

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
        if name not in VIEW_NAMES:
            raise KeyError(name)
        self._view = name
        self.frame(name)

    def frame(self, name: str | None = None) -> None:
        """Bring the whole face into the picture, from where the camera stands or from a standard view."""
        from widgets.scene import camera as hand

        if self.scene is None:
            return
        box = self.scene.face_bounds()
        if box is None:
            return
        width, height = self.viewer.view_size(FACE)
        if name is None and self._framed:
            hand.frame(self.viewer.camera, box, hand.axes(self.viewer.camera)[0], width / height)
        else:
            hand.look(self.viewer.camera, box, name or self._view, width / height)
        self._framed = self._fit is not None
        self._centre = np.array(box, dtype=np.float64).reshape(3, 2).mean(axis=1)
        self.viewer.set_pivot(self._centre)
        self._bound()
        self.viewer.camera_moved()
        self._touched = name is None

    # Pictures.

    def picture(self) -> NDArray[np.uint8]:
        """Return both views as they are seen, (H, W, 3) uint8."""
        return self.viewer.picture()

    def save_picture(self, path: str | Path | None = None) -> None:
        """Write the views as PNG; without a path ask for one."""
        if path is None:
            path, _ = QFileDialog.getSaveFileName(self, "Save picture", "face.png", "PNG picture (*.png)")
            if not path:
                return
        if _image(self.picture()).save(str(path), "PNG"):
            self.picture_saved.emit(str(path))
        else:
            self.failed.emit(f"{path}: the picture could not be written; choose another folder")

    def copy_picture(self) -> None:
        """Put the views on the clipboard."""
        QGuiApplication.clipboard().setImage(_image(self.picture()))
        self.picture_saved.emit("")

    # The rest.

    def apply_theme(self) -> None:
        """Take over the window's theme."""
        current = theme.current()
        self._dress_row()
        window = current.colour("window")
        self.viewer.set_window_colour((window.redF(), window.greenF(), window.blueF()))
        if self.scene is not None:
            from widgets.scene.background import view_colours

            self.scene.set_colours(view_colours(current.name))
            self.scene.write()
            self.viewer.render()

    def close(self) -> bool:
        """Let go of the 3-D part; the widget shows nothing any more."""
        if self.scene is not None:
            self.scene.close()
            self.scene = None
        self.viewer.close()
        return super().close()

    def bar_range(self, low: float, high: float, axis: float | None) -> None:
        """Follow a handle of the colour bar; ``axis`` keeps the bar still meanwhile, None ends the drag."""
        low = round(min(max(low, 0.0), _LARGEST_MM - _SMALLEST_MM), 2)
        high = round(min(max(high, low + _SMALLEST_MM), _LARGEST_MM), 2)
        changed = (low, high) != self._range
        self._range = (low, high)
        self._recolour(axis)
        if changed:
            self.range_changed.emit(low, high)

    def edit_range(self, at: QPoint) -> None:
        """Open a small editor for the range at a global place."""
        editor = RangeEditor(*self._range, START_RANGE_MM, self)
        editor.changed.connect(lambda low, high: self.bar_range(low, high, None))
        editor.open_at(at)

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
        self.frame(self._view)
        self.ready.emit()

    def _show_fit(self) -> None:
        if self.scene is None:
            return
        picture = self._scan.colour if self._scan is not None else None
        self.scene.set_fit(self._fit, picture)
        places = {}
        if self._fit is not None:
            vertices = self._fit.mesh.vertices
            places = {name: vertices[k] for name, k in self._fiducials.items() if 0 <= k < len(vertices)}
        self.scene.set_fiducials(places)

    def _update(self) -> None:
        if self.scene is not None:
            self.scene.set_look(self._mode)
            self.scene.set_wire(self._wire)
            self.scene.set_points(self._dots)
            self.scene.write()
            self.viewer.render()

    def _recolour(self, axis: float | None = None) -> None:
        if self.scene is not None:
            from widgets.scene.heatmap import HeatRange

            self.scene.set_heat(HeatRange(*self._range), axis)
            self.viewer.render()

    def _layout(self) -> None:
        if self.scene is not None:
            self.scene.layout([self.viewer.view_size(FACE), self.viewer.view_size(DISTANCE)], self.viewer.scale)
            if not self._touched:
                self.frame(self._view)

    def _bound(self) -> None:
        if self.scene is not None:
            self.viewer.set_bounds(self.scene.bounds())

    def _elsewhere(self) -> bool:
        """Return whether another subject sits so far from the last one that it may be out of sight."""
        box = self.scene.face_bounds() if self.scene is not None else None
        if box is None or self._fit is None:
            return False
        return bool(np.linalg.norm(np.reshape(box, (3, 2)).mean(axis=1) - self._centre) > _ELSEWHERE_MM)

    def _turned(self) -> None:
        self._touched = True
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
            self.viewer.render()

    def _leave(self) -> None:
        if self.scene is not None and self.scene.read_at(FACE, None, (0, 0)):
            self.viewer.render()

    # The tool row.

    def _make_row(self) -> None:
        self._row = QWidget(self)
        self._row.setFixedHeight(32)
        self._row.setAutoFillBackground(True)
        line = QHBoxLayout(self._row)
        line.setContentsMargins(8, 0, 8, 0)
        line.setSpacing(4)
        self._modes = Segments([("shaded", "Shaded"), ("textured", "Textured")], name="Surface of the face")
        self._modes.set_current(self._mode)
        self._modes.set_tip("shaded", "Clay under studio light")
        self._modes.set_tip("textured", "The scan's colour picture")
        self._modes.chosen.connect(self._choose_mode)
        line.addWidget(self._modes)
        self._divider = QFrame(self._row)
        self._divider.setFixedSize(1, 16)
        line.addSpacing(4)
        line.addWidget(self._divider)
        line.addSpacing(4)
        self._buttons: dict[str, IconButton] = {}
        toggles = (
            ("wire", "wire", "Template wire over the face (W)", self._toggle_wire),
            ("points", "dots", "Points of the scan (P)", self._toggle_points),
            ("heatmap", "heatmap", "Distance to the scan (H)", self._toggle_heatmap),
        )
        for key, icon, tip, action in toggles:
            button = IconButton(icon, tip, checkable=True)
            button.setChecked(True)
            button.clicked.connect(action)
            self._buttons[key] = button
            line.addWidget(button)
        line.addStretch(1)
        self._level = QLabel("")
        self._level.setToolTip("How often the template was subdivided")
        line.addWidget(self._level)
        line.addSpacing(4)
        for key, icon, tip in (
            ("views", "four-views", "Look from a standard side (F frames the face)"),
            ("camera", "camera", "Save this picture, or copy it"),
            ("maximise", "fit-view", "Let the views fill the window, or go back"),
        ):
            button = IconButton(icon, tip, checkable=key == "maximise")
            self._buttons[key] = button
            line.addWidget(button)
        self._buttons["maximise"].clicked.connect(self.maximise_requested)
        self._menus = [self._view_menu(), self._camera_menu()]
        for key, menu in zip(("views", "camera"), self._menus, strict=True):
            self._buttons[key].clicked.connect(lambda _=False, k=key, m=menu: self._drop(k, m))
        self._dress_row()
        self._allow()

    def _view_menu(self) -> QMenu:
        menu = QMenu(self)
        for key, text in VIEW_NAMES.items():
            action = QAction(text, menu)
            action.triggered.connect(lambda _=False, name=key: self.view(name))
            menu.addAction(action)
        menu.addSeparator()
        whole = QAction("Frame the face", menu)
        whole.triggered.connect(lambda _=False: self.frame())
        menu.addAction(whole)
        return menu

    def _camera_menu(self) -> QMenu:
        menu = QMenu(self)
        for text, action in (("Save picture…", self.save_picture), ("Copy picture", self.copy_picture)):
            entry = QAction(text, menu)
            entry.triggered.connect(lambda _=False, run=action: run())
            menu.addAction(entry)
        return menu

    def _drop(self, key: str, menu: QMenu) -> None:
        button = self._buttons[key]
        corner = button.mapToGlobal(QPoint(button.width(), button.height()))
        menu.popup(corner - QPoint(menu.sizeHint().width(), 0))

    def _dress_row(self) -> None:
        current = theme.current()
        self._level.setFont(theme.font())
        self._level.setStyleSheet(f"color: {current.dim}")
        self._divider.setStyleSheet(f"background: {current.line}")

    def _allow(self) -> None:
        textured = self._scan is None or self._scan.colour is not None
        self._modes.set_available("textured", textured, "This scan has no colour picture")

    def _set_button(self, key: str, down: bool) -> None:
        self._buttons[key].setChecked(down)

    def _choose_mode(self, mode: str) -> None:
        self.set_mode("shaded" if mode == "shaded" else "textured")
        self.mode_changed.emit(mode)

    def _toggle_wire(self, down: bool) -> None:
        self.set_wireframe(down)
        self.wireframe_changed.emit(down)

    def _toggle_points(self, down: bool) -> None:
        self.set_points(down)
        self.points_changed.emit(down)

    def _toggle_heatmap(self, down: bool) -> None:
        self.set_heatmap(down)
        self.heatmap_changed.emit(down)


class _BarTool:
    """Gives the mouse to the handles of the colour bar."""

    def __init__(self, views: FaceViews) -> None:
        self._views = views
        self._held: str | None = None
        self._axis = 0.0
        self._offset = 0.0

    def _bar(self, view: int) -> Any:
        scene = self._views.scene
        return scene.bar if scene is not None and view == DISTANCE and not scene.empty else None

    def press(self, view: int, x: float, y: float) -> bool:
        """Take hold of a handle; a press beside it stays on the plate and turns nothing."""
        bar = self._bar(view)
        if bar is None or not bar.contains(x, y):
            return False
        self._held = bar.handle_at(x, y)
        self._axis = bar.axis
        if self._held is not None:
            low, high = self._views.range
            self._offset = (low if self._held == "low" else high) - bar.value_at(x)
        return True

    def drag(self, x: float, y: float) -> None:
        """Move the held handle."""
        bar = self._bar(DISTANCE)
        if bar is None or self._held is None:
            return
        value = bar.value_at(x) * self._axis / bar.axis + self._offset
        low, high = self._views.range
        if self._held == "low":
            self._views.bar_range(min(value, high - _SMALLEST_MM), high, self._axis)
        else:
            self._views.bar_range(low, max(value, low + _SMALLEST_MM), self._axis)

    def release(self) -> None:
        """Let the bar end at its handle again."""
        if self._held is not None:
            self._held = None
            self._views.bar_range(*self._views.range, None)

    def double_click(self, view: int, x: float, y: float) -> bool:
        """Open the numeric editor."""
        bar = self._bar(view)
        if bar is None or not bar.contains(x, y):
            return False
        self._views.edit_range(self._views.cursor().pos())
        return True

    def cursor(self, view: int, x: float, y: float) -> Qt.CursorShape | None:
        """Return the pointer over the bar."""
        bar = self._bar(view)
        if bar is None or not bar.contains(x, y):
            return None
        return Qt.CursorShape.SizeHorCursor if bar.handle_at(x, y) else Qt.CursorShape.ArrowCursor


def _image(picture: NDArray[np.uint8]) -> QImage:
    height, width = picture.shape[:2]
    return QImage(picture.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888).copy()
