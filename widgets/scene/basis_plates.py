"""A short text in the upper right corner of a view."""

from __future__ import annotations

from typing import Any

from widgets.scene.background import ViewColours
from widgets.scene.overlay import MARGIN
from widgets.scene.text import Shape2D, Words, rounded


class CornerPlate:
    """What must be said of a view besides its name, such as how much lies out of range."""

    def __init__(self, renderer: Any) -> None:
        self._plate, self._words = Shape2D(renderer), Words(renderer)
        self.width = 0.0

    def set(self, text: str, colours: ViewColours, size: tuple[float, float], scale: float = 1.0) -> None:
        """Write ``text`` for a view of ``size`` pixels; nothing hides the plate."""
        self._words.set(text, colours.text, 11 * scale)
        self.width = self._words.width + 12 * scale if text else 0.0
        left, bottom = size[0] - MARGIN * scale - self.width, size[1] - (MARGIN + 20) * scale
        outline = rounded(left, bottom, max(self.width, 1.0), 20 * scale, 3 * scale)
        self._plate.polygon(outline, colours.plate, colours.plate_opacity)
        self._words.move(left + 6 * scale, bottom + 5 * scale)
        self._plate.hide(not text)

    def remove(self) -> None:
        """Take everything out of the renderer."""
        self._plate.remove()
        self._words.remove()
