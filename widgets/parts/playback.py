"""A clock that walks through frames at their own rate: where drawing is slow, frames are skipped, never slowed."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import QObject, Qt, QTimer, Signal

FASTEST_HZ = 60.0


class Playback(QObject):
    """Plays frames by the clock on the wall.

    Parameters
    ----------
    clock : callable
        Seconds, ever rising.

    Signals
    -------
    frame_changed(int)
        Playback came to a frame, from 0.
    playing_changed(bool)
        It began or ended.
    """

    frame_changed = Signal(int)
    playing_changed = Signal(bool)

    def __init__(self, parent: QObject | None = None, clock: Callable[[], float] = time.perf_counter) -> None:
        super().__init__(parent)
        self._clock = clock
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self.tick)
        self._frames, self._fps, self._frame = 0, 0.0, 0
        self._since, self._from = 0.0, 0
        self.loop = False

    @property
    def frame(self) -> int:
        """The frame it is at, from 0."""
        return self._frame

    @property
    def is_playing(self) -> bool:
        """Whether it plays."""
        return self._timer.isActive()

    def set_clip(self, frames: int, fps: float) -> None:
        """Take other frames: how many, and how many a second; it stops."""
        self.pause()
        self._frames, self._fps = max(0, frames), fps
        self._frame = min(self._frame, max(0, frames - 1))

    def set_frame(self, frame: int) -> None:
        """Go to a frame, kept within the clip, without telling; playing goes on from there."""
        self._frame = min(max(0, frame), max(0, self._frames - 1))
        self._since, self._from = self._clock(), self._frame

    def play(self) -> None:
        """Play from where it is; from the start when that is the end."""
        if self.is_playing or self._frames < 2 or self._fps <= 0:
            return
        begin = 0 if self._frame >= self._frames - 1 else self._frame
        moved = begin != self._frame
        self.set_frame(begin)
        self._timer.start(max(1, round(1000 / min(self._fps, FASTEST_HZ))))
        self.playing_changed.emit(True)
        if moved:
            self.frame_changed.emit(begin)

    def pause(self) -> None:
        """Stop where it is."""
        if self.is_playing:
            self._timer.stop()
            self.playing_changed.emit(False)

    def tick(self) -> None:
        """Go to the frame whose time it is."""
        passed = self._from + int((self._clock() - self._since) * self._fps + 1e-6)
        last = self._frames - 1
        ended = passed >= last and not self.loop
        frame = last if ended else passed % self._frames
        if frame != self._frame:
            self._frame = frame
            self.frame_changed.emit(frame)
        if ended:
            self.pause()
