"""Gives the mouse to the handles of a colour bar that VTK draws."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QCursor

if TYPE_CHECKING:
    from widgets.scene.colour_bar import ColourBar

DISTANCE = 1
"""The view that has the bar."""

SMALLEST_MM, LARGEST_MM = 0.01, 50.0
"""The narrowest range and the largest value a handle can be put to."""


class RangeOwner(Protocol):
    """Who holds the range and the bar."""

    @property
    def bar(self) -> ColourBar | None:
        """The bar, None while nothing is shown."""

    @property
    def range(self) -> tuple[float, float]:
        """Low and high end in mm."""

    def bar_range(self, low: float, high: float, axis: float | None) -> None:
        """Follow a handle; ``axis`` keeps the bar still meanwhile, None ends the drag."""

    def edit_range(self, at: QPoint) -> None:
        """Open a numeric editor at a global place."""


class RangeTool:
    """Gives the mouse to the handles of the colour bar."""

    def __init__(self, views: RangeOwner) -> None:
        self._views = views
        self._held: str | None = None
        self._axis = 0.0
        self._offset = 0.0

    def _bar(self, view: int) -> ColourBar | None:
        return self._views.bar if view == DISTANCE else None

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
            self._views.bar_range(min(value, high - SMALLEST_MM), high, self._axis)
        else:
            self._views.bar_range(low, max(value, low + SMALLEST_MM), self._axis)

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
        self._views.edit_range(QCursor.pos())
        return True

    def cursor(self, view: int, x: float, y: float) -> Qt.CursorShape | None:
        """Return the pointer over the bar."""
        bar = self._bar(view)
        if bar is None or not bar.contains(x, y):
            return None
        return Qt.CursorShape.SizeHorCursor if bar.handle_at(x, y) else Qt.CursorShape.ArrowCursor
