"""The colour bar of a heatmap: unit, ticks, two handles that stay where they were put, and the share out of range."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from widgets.scene.background import ViewColours
from widgets.scene.heatmap import HeatRange, cividis, number
from widgets.scene.overlay import MARGIN
from widgets.scene.text import Shape2D, Words, rounded

Handle = Literal["low", "high"]

_WIDTH, _BAR, _HANDLE_W, _HANDLE_H = 196.0, 8.0, 6.0, 14.0
_PAD = 8.0
_SMALL = 11.0
_PLATE, _LINE = 50.0, 14.0


class ColourBar:
    """A bar in the lower right corner of a view, drawn in its pixels.

    The bar spans 0 .. ``axis`` mm. Outside a drag the axis ends at the high handle; while a handle is dragged
    the axis holds still, so that the handle follows the hand. A bar that is not ``movable`` has no handles.
    """

    def __init__(self, renderer: Any, *, movable: bool = True) -> None:
        self._movable = movable
        self._plate, self._strip = Shape2D(renderer), Shape2D(renderer)
        self._rims = {"low": Shape2D(renderer), "high": Shape2D(renderer)}
        self._handles = {"low": Shape2D(renderer), "high": Shape2D(renderer)}
        self._ticks = [Words(renderer) for _ in range(3)]
        self._share, self._note = Words(renderer), Words(renderer)
        self._height = _PLATE
        self._left = self._right = self._bottom = 0.0
        self._scale = 1.0
        self._range = HeatRange()
        self.axis = 0.2
        self._shown = True

    def set(
        self,
        heat: HeatRange,
        share: str,
        colours: ViewColours,
        size: tuple[float, float],
        scale: float = 1.0,
        axis: float | None = None,
        note: str = "",
    ) -> None:
        """Draw the bar of ``heat`` for a view of ``size`` pixels.

        Parameters
        ----------
        heat : HeatRange
        share : str
            What leaves the range, in words.
        axis : float, optional
            Value at the right end of the bar in mm, at least ``heat.high``; that value where left out.
        note : str
            How the colours were made, in words; it stands beside the share, or above it where there is no room.
        """
        self._range, self._scale = heat, scale
        self.axis = max(heat.high, axis or 0.0)
        width = max(min(_WIDTH * scale, size[0] - 2 * (MARGIN + _PAD) * scale), 1.0)
        self._share.set(share, colours.dim, _SMALL * scale)
        self._note.set(note, colours.dim, _SMALL * scale)
        stacked = bool(note) and self._note.width + self._share.width + 10 * scale > width
        self._height = (_PLATE if share or note else _PLATE - _LINE) + (_LINE if stacked else 0.0)
        plate_w, plate_h = width + 2 * _PAD * scale, self._height * scale
        plate_x, plate_y = size[0] - MARGIN * scale - plate_w, MARGIN * scale
        self._left, self._right = plate_x + _PAD * scale, plate_x + _PAD * scale + width
        self._bottom = plate_y + 21 * scale
        top = self._bottom + _BAR * scale
        self._plate.polygon(
            rounded(plate_x, plate_y, plate_w, plate_h, 3 * scale), colours.plate, colours.plate_opacity
        )
        values = np.linspace(0.0, self.axis, 196)
        index = np.clip((values - heat.low) / (heat.high - heat.low), 0.0, 1.0) * 255.0 + 0.5
        self._strip.strip(self._left, self._right, self._bottom, top, cividis()[index.astype(np.intp)])
        self._place_handles(heat, scale)
        self._place_words(heat, colours, scale)
        self._share.move(self._right - self._share.width, top + 6 * scale)
        self._note.move(self._left, top + (6 + (_LINE if stacked else 0.0)) * scale)
        if not self._shown:
            self.hide()

    def hide(self, hidden: bool = True) -> None:
        """Hide the bar or show it again."""
        self._shown = not hidden
        for shape in (self._plate, self._strip):
            shape.hide(hidden)
        for shape in (*self._handles.values(), *self._rims.values()):
            shape.hide(hidden or not self._movable)
        for words in (*self._ticks, self._share, self._note):
            words.hide(hidden)

    def handle_at(self, x: float, y: float) -> Handle | None:
        """Return the handle at a pixel from the lower left, with some room around it for the hand."""
        room = 4 * self._scale
        if (
            not (self._shown and self._movable)
            or not self._bottom - room - 3 <= y <= self._bottom + (_BAR + 3) * self._scale + room
        ):
            return None
        places = {"high": self._x(self._range.high), "low": self._x(self._range.low)}
        name, place = min(places.items(), key=lambda item: abs(item[1] - x))
        return name if abs(place - x) <= _HANDLE_W * self._scale / 2 + room else None  # type: ignore[return-value]

    def contains(self, x: float, y: float) -> bool:
        """Return whether a pixel lies on the bar's plate."""
        return (
            self._shown
            and self._left - _PAD * self._scale <= x <= self._right + _PAD * self._scale
            and MARGIN * self._scale <= y <= (MARGIN + self._height) * self._scale
        )

    def value_at(self, x: float) -> float:
        """Return the value in mm under a pixel; beyond the ends the axis goes on."""
        return (x - self._left) / max(self._right - self._left, 1.0) * self.axis

    def remove(self) -> None:
        """Take the bar out of the renderer."""
        parts: list[Shape2D | Words] = [self._plate, self._strip, *self._handles.values(), *self._rims.values()]
        for part in [*parts, *self._ticks, self._share, self._note]:
            part.remove()

    def _x(self, value: float) -> float:
        return self._left + value / self.axis * (self._right - self._left)

    def _place_handles(self, heat: HeatRange, scale: float) -> None:
        if not self._movable:
            return
        for name, value in (("low", heat.low), ("high", heat.high)):
            centre, middle = self._x(value), self._bottom + _BAR * scale / 2
            for shape, grow, colour in ((self._rims[name], 1.0, "#1e1f22"), (self._handles[name], 0.0, "#ffffff")):
                w, h = (_HANDLE_W + 2 * grow) * scale, (_HANDLE_H + 2 * grow) * scale
                shape.polygon(rounded(centre - w / 2, middle - h / 2, w, h, (1 + grow) * scale), colour)

    def _place_words(self, heat: HeatRange, colours: ViewColours, scale: float) -> None:
        base = self._bottom - 16 * scale
        low, middle, high = self._ticks
        ends = (heat.low, 0.5 * (heat.low + heat.high), heat.high)
        for words, text in zip(self._ticks, [number(v) for v in ends], strict=True):
            words.set(text, colours.text, _SMALL * scale)
        high.set(f"{number(heat.high)} mm", colours.text, _SMALL * scale)
        low_x = min(self._x(heat.low), self._right - low.width)
        high_x = min(self._x(heat.high) - high.width / 2, self._right - high.width)
        middle_x = self._x(ends[1]) - middle.width / 2
        low.move(low_x, base)
        high.move(high_x, base)
        middle.move(middle_x, base)
        gap = 6 * scale
        middle.hide(middle_x < low_x + low.width + gap or middle_x + middle.width + gap > high_x)
        low.hide(low_x + low.width + gap > high_x)
