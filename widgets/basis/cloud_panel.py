"""The picture behind the idea (Kim & Ko 2007, figure 1): frames as a cloud, and where the shapes point in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget

from engine.mesh import FloatArray


class CloudPanel(QWidget):
    """Frames as points over the first axes, with the directions of shapes.

    Signals
    -------
    frame_chosen(int)
        The frame clicked, from 0.
    """

    frame_chosen = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)

    def set_cloud(self, points: FloatArray | None, frames: FloatArray | None = None) -> None:
        """Show coordinates (F, k) mm of frames on the first axes; ``frames`` (F,) are their numbers, 0.. without."""

    def set_directions(self, directions: Mapping[str, FloatArray], names: Sequence[str] = ()) -> None:
        """Show shapes by their coordinates (n, k) mm: basis key -> (n, k), the quasi-eigen and hand-made ones by
        ``names``."""

    def set_current(self, name: str | None) -> None:
        """Single out a shape; the others are dimmed."""

    def set_frame(self, frame: int) -> None:
        """Ring a frame, from 0."""

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(296, 280)
