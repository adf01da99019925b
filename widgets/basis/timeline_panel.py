"""The error of a performance over time, and its playback."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget

from engine.mesh import FloatArray


class TimelinePanel(QWidget):
    """Transport, ruler and curves; scrubbing, zooming, playing.

    Signals
    -------
    frame_changed(int)
        The frame the user went to or playback came to, from 0.
    playing_changed(bool)
        Playback began or ended.
    """

    frame_changed = Signal(int)
    playing_changed = Signal(bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._frame, self._frames, self._fps = 0, 0, 0.0

    @property
    def frame(self) -> int:
        """The frame at the playhead, from 0."""
        return self._frame

    @property
    def is_playing(self) -> bool:
        """Whether it plays."""
        return False

    def set_clip(self, frames: int, fps: float = 0.0) -> None:
        """Show a performance of so many frames at ``fps`` Hz; 0 while there is none."""
        self._frames, self._fps = frames, fps

    def set_frame(self, frame: int) -> None:
        """Put the playhead to a frame, from 0, without telling anybody."""
        self._frame = frame

    def set_curves(self, alpha: Mapping[str, FloatArray], rms_mm: Mapping[str, FloatArray]) -> None:
        """Show errors of every frame: basis key -> (L,) alpha in %, and (L,) RMS in mm."""

    def set_worst(self, frames: Sequence[int]) -> None:
        """Mark the worst frames, from 0, the worst first."""

    def set_trained(self, start: int, stop: int) -> None:
        """Mark the frames that the axes are trained on: first, and the one after the last."""

    def play(self) -> None:
        """Play from the playhead, from the start when it stands at the end."""

    def pause(self) -> None:
        """Stop playing where it is."""

    def toggle_play(self) -> None:
        """Play or pause."""

    def step(self, frames: int) -> None:
        """Move the playhead by so many frames and tell."""

    def close_playback(self) -> None:
        """Stop the clock for good."""

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(1432, 196)
