"""What is written over a 3-D view: its name, a message where it is empty, a reading at the pointer, the axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from widgets.scene.background import ViewColours
from widgets.scene.camera import axes
from widgets.scene.text import Shape2D, Words, rounded

MARGIN = 4.0
"""Distance of everything written from the corner of its view, in pixels."""

_TEXT = 12.0
_SMALL = 11.0


class NamePlate:
    """The name of a view with a note behind it, in its upper left corner."""

    def __init__(self, renderer: Any) -> None:
        self._plate = Shape2D(renderer)
        self._title, self._note = Words(renderer, bold=True), Words(renderer)

    def set(self, title: str, note: str, colours: ViewColours, size: tuple[float, float], scale: float = 1.0) -> None:
        """Write title and note for a view of ``size`` pixels, ``scale`` screen pixels to a pixel of the layout."""
        self._title.set(title, colours.text, _TEXT * scale)
        self._note.set(note, colours.dim, _TEXT * scale)
        padding, gap, height = 6 * scale, 6 * scale if note else 0.0, 20 * scale
        room = size[0] - 2 * MARGIN * scale - 2 * padding
        while note and self._title.width + gap + self._note.width > room:
            note = note.rpartition(", ")[0]
            self._note.set(note, colours.dim, _TEXT * scale)
        gap = gap if note else 0.0
        left, bottom = MARGIN * scale, size[1] - MARGIN * scale - height
        width = 2 * padding + self._title.width + gap + self._note.width
        self._plate.polygon(rounded(left, bottom, width, height, 3 * scale), colours.plate, colours.plate_opacity)
        base = bottom + 4 * scale
        self._title.move(left + padding, base)
        self._note.move(left + padding + self._title.width + gap, base)
        self._plate.hide(not title)

    def remove(self) -> None:
        """Take everything out of the renderer."""
        for part in (self._plate, self._title, self._note):
            part.remove()


class Message:
    """Two lines where a view has no face to show: what belongs here, and what to do."""

    def __init__(self, renderer: Any) -> None:
        self._plate = Shape2D(renderer)
        self._first, self._second = Words(renderer, bold=True), Words(renderer)

    def set(
        self,
        first: str,
        second: str,
        colours: ViewColours,
        size: tuple[float, float],
        scale: float = 1.0,
        *,
        low: bool = False,
    ) -> None:
        """Write both lines in the middle of a view of ``size`` pixels, or ``low`` in it; empty lines vanish."""
        self._first.set(first, colours.text, _TEXT * scale)
        self._second.set(second, colours.dim, _SMALL * scale)
        middle = 40 * scale if low else size[1] / 2
        self._first.move((size[0] - self._first.width) / 2, middle + 2 * scale)
        self._second.move((size[0] - self._second.width) / 2, middle - 16 * scale)
        width = max(self._first.width, self._second.width) + 20 * scale
        bottom, top = middle - 24 * scale, middle + (24 if first else 4) * scale
        outline = rounded((size[0] - width) / 2, bottom, width, top - bottom, 3 * scale)
        self._plate.polygon(outline, colours.plate, colours.plate_opacity)
        self._plate.hide(not (first or second))

    def remove(self) -> None:
        """Take both lines out of the renderer."""
        for part in (self._plate, self._first, self._second):
            part.remove()


class Reading:
    """A short text on a plate beside the pointer, with a mark on what it speaks of."""

    def __init__(self, renderer: Any) -> None:
        self._plate, self._mark = Shape2D(renderer), Shape2D(renderer)
        self._words = Words(renderer)
        self.visible = False

    def show(
        self,
        text: str,
        place: tuple[float, float],
        colours: ViewColours,
        size: tuple[float, float],
        scale: float = 1.0,
    ) -> None:
        """Write ``text`` beside ``place`` (pixels from the lower left), inside a view of ``size`` pixels."""
        self._words.set(text, colours.text, _SMALL * scale)
        width, height = self._words.width + 12 * scale, 18 * scale
        left = place[0] + 12 * scale
        if left + width > size[0] - MARGIN * scale:
            left = place[0] - 12 * scale - width
        left = max(left, MARGIN * scale)
        bottom = float(np.clip(place[1] + 8 * scale, MARGIN * scale, size[1] - height - MARGIN * scale))
        self._plate.polygon(rounded(left, bottom, width, height, 3 * scale), colours.plate, 0.92)
        self._words.move(left + 6 * scale, bottom + 4 * scale)
        angles = np.linspace(0, 2 * np.pi, 17)
        ring = np.stack([place[0] + 4 * scale * np.cos(angles), place[1] + 4 * scale * np.sin(angles)], axis=1)
        self._mark.lines(ring.tolist(), [range(17)], colours.text, 1.0 * scale)
        self.visible = True

    def hide(self) -> bool:
        """Hide the reading; returns whether it was there."""
        was = self.visible
        for part in (self._plate, self._mark, self._words):
            part.hide()
        self.visible = False
        return was

    def remove(self) -> None:
        """Take everything out of the renderer."""
        for part in (self._plate, self._mark, self._words):
            part.remove()


_AXES = (("X", "#e5484d"), ("Y", "#4fb477"), ("Z", "#3b82f6"))


class Gizmo:
    """The three axes of the frame, small, in the lower right corner: +X subject's left, +Y up, +Z out of the face."""

    def __init__(self, renderer: Any) -> None:
        self._arms = [Shape2D(renderer) for _ in _AXES]
        self._names = [Words(renderer) for _ in _AXES]

    def set(self, camera: Any, colours: ViewColours, size: tuple[float, float], scale: float = 1.0) -> None:
        """Draw the axes as ``camera`` sees them in a view of ``size`` pixels."""
        back, right, up = axes(camera)
        centre = np.array([size[0] - 34 * scale, 30 * scale])
        for k in np.argsort(back):
            name, colour = _AXES[k]
            arm = 19 * scale * np.array([right[k], up[k]])
            tip = centre + arm
            self._arms[k].lines([centre.tolist(), tip.tolist()], [(0, 1)], colour, 1.6 * scale)
            self._names[k].set(name, colours.dim, 9 * scale)
            length = float(np.linalg.norm(arm))
            away = arm / length if length > 4 * scale else np.array([-0.7, -0.7])
            place = tip + 7 * scale * away - np.array([self._names[k].width / 2, 4.5 * scale])
            self._names[k].move(*place)

    def remove(self) -> None:
        """Take the axes out of the renderer."""
        parts: list[Shape2D | Words] = [*self._arms, *self._names]
        for part in parts:
            part.remove()
