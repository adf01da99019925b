"""Gives the mouse to what can be dragged in the basis stage's views: the wipe's line and the colour bars' handles."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QCursor

from engine.mesh import FloatArray
from widgets.scan.range_editor import RangeEditor
from widgets.scan.range_tool import SMALLEST_MM
from widgets.scene.basis_state import CHANGE, HAND, START_RANGE_MM

if TYPE_CHECKING:
    from widgets.basis.views import BasisViews
    from widgets.scene.colour_bar import ColourBar


class ViewsTool:
    """What gets the left button before the camera."""

    def __init__(self, views: BasisViews) -> None:
        self._views = views
        self._held: str | None = None
        self._bar_view = -1
        self._axis = self._offset = 0.0
        views.viewer.hovered.connect(self.hover)
        views.viewer.left.connect(self.leave)
        views.viewer.set_tool(self)
        views.viewer.set_picker(self.pick)

    def press(self, view: int, x: float, y: float) -> bool:
        """Take hold of the wipe or a handle; a press beside a handle stays on its plate and turns nothing."""
        if self._on_wipe(view, x):
            self._held = "wipe"
            return True
        bar = self._bar(view, x, y)
        if bar is None:
            return False
        self._held, self._bar_view, self._axis = bar.handle_at(x, y), view, bar.axis
        if self._held is not None:
            low, high = self._views.range
            self._offset = (low if self._held == "low" else high) - bar.value_at(x)
        return True

    def drag(self, x: float, y: float) -> None:
        """Move what is held."""
        views = self._views
        if self._held == "wipe":
            views.set_wipe(x / views.viewer.view_size(HAND)[0])
            return
        bar = views.scene.words.bars[self._bar_view] if views.scene is not None and self._held is not None else None
        if bar is None:
            return
        value = bar.value_at(x) * self._axis / bar.axis + self._offset
        low, high = views.range
        if self._held == "low":
            views.bar_range(min(value, high - SMALLEST_MM), high, self._axis)
        else:
            views.bar_range(low, max(value, low + SMALLEST_MM), self._axis)

    def release(self) -> None:
        """Let go; a bar ends at its handle again."""
        held, self._held = self._held, None
        if held in ("low", "high"):
            self._views.bar_range(*self._views.range, None)

    def double_click(self, view: int, x: float, y: float) -> bool:
        """Open the numeric editor of a bar; put the wipe back into the middle."""
        if self._on_wipe(view, x):
            self._views.set_wipe(0.5)
            return True
        if view != CHANGE or self._bar(view, x, y) is None:
            return False
        views = self._views
        editor = RangeEditor(*views.range, START_RANGE_MM, views, smooth=None)
        editor.changed.connect(lambda low, high: views.bar_range(low, high, None))
        editor.open_at(QCursor.pos())
        return True

    def cursor(self, view: int, x: float, y: float) -> Qt.CursorShape | None:
        """Return the pointer over the line or a bar."""
        if self._on_wipe(view, x):
            return Qt.CursorShape.SplitHCursor
        bar = self._bar(view, x, y)
        if bar is None:
            return None
        return Qt.CursorShape.SizeHorCursor if bar.handle_at(x, y) else Qt.CursorShape.ArrowCursor

    def pick(self, segment: tuple[FloatArray, FloatArray]) -> FloatArray | None:
        """Return the place in mm where a line of sight meets the face of the first view."""
        scene = self._views.scene
        hit = None if scene is None else scene.pick(HAND, segment)
        return None if hit is None else hit[1]

    def hover(self, view: int, x: float, y: float) -> None:
        """Show the value under the pointer in a heatmap."""
        scene, viewer = self._views.scene, self._views.viewer
        if scene is None:
            return
        sight = None if self._bar(view, x, y) is not None or scene.empty else viewer.segment(view, x, y)
        changed = scene.read_at(view, sight, (x, y))
        if changed:
            viewer.hasten(changed)

    def leave(self) -> None:
        """Hide the value under the pointer."""
        scene = self._views.scene
        changed = scene.read_at(HAND, None, (0.0, 0.0)) if scene is not None else set()
        if changed:
            self._views.viewer.redraw(changed)

    def _on_wipe(self, view: int, x: float) -> bool:
        scene = self._views.scene
        return scene is not None and view == HAND and scene.wipe.contains(x)

    def _bar(self, view: int, x: float, y: float) -> ColourBar | None:
        scene = self._views.scene
        bar = scene.words.bars.get(view) if scene is not None else None
        return bar if bar is not None and bar.contains(x, y) else None
