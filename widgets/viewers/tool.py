"""What a thing drawn in a 3-D view must know to be dragged there."""

from __future__ import annotations

from typing import Protocol

from PySide6.QtCore import Qt


class Tool(Protocol):
    """Something drawn in a view that wants the mouse before the camera gets it."""

    def press(self, view: int, x: float, y: float) -> bool:
        """Take a press at a pixel from the view's lower left; return whether it is wanted."""

    def drag(self, x: float, y: float) -> None:
        """Follow the mouse."""

    def release(self) -> None:
        """Let go."""

    def double_click(self, view: int, x: float, y: float) -> bool:
        """Take a double click; return whether it is wanted."""

    def cursor(self, view: int, x: float, y: float) -> Qt.CursorShape | None:
        """Return the pointer over a pixel, None where it is not ours."""
