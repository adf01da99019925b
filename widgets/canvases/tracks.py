"""What a timeline shows: curves over one axis, with their names, units and colours."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QPen

from engine.mesh import FloatArray
from widgets import theme


@dataclass(frozen=True)
class Curve:
    """One curve: its name, a value a frame (L,), a colour role, and whether it is dashed."""

    name: str
    values: FloatArray = field(compare=False, repr=False)
    role: str = "text"
    dashed: bool = False

    def pen(self, width: float = 1.0) -> QPen:
        """Return the pen it is drawn with."""
        pen = QPen(theme.current().colour(self.role), width)
        if self.dashed:
            pen.setStyle(Qt.PenStyle.CustomDashLine)
            pen.setDashPattern([3.0, 2.0])
        return pen


@dataclass(frozen=True)
class Track:
    """Curves over one axis from 0: title, unit, and the curves."""

    title: str
    unit: str
    curves: tuple[Curve, ...]

    @property
    def largest(self) -> float:
        """The largest value of its curves."""
        tops = [float(np.nanmax(c.values)) for c in self.curves if np.isfinite(c.values).any()]
        return max(tops, default=0.0)


def grouped(frame: int) -> str:
    """Return the number of a frame as it is read, from 1, in groups of three."""
    return f"{frame + 1:,}".replace(",", "\u00a0")
