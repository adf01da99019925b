"""The error of a performance over time, and its playback."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QSize, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QDockWidget, QVBoxLayout, QWidget

from engine.mesh import FloatArray
from widgets import theme
from widgets.basis.transport import Transport
from widgets.basis.words import BASES, ROLES
from widgets.canvases.timeline import NAMES, TimelineCanvas
from widgets.canvases.tracks import Curve, Track
from widgets.parts import picture
from widgets.parts.playback import Playback
from widgets.parts.titles import DockTitle


class TimelinePanel(QWidget):
    """Transport, ruler and curves; scrubbing, zooming, playing.

    In a dock with a title bar of ours the transport stands in that bar.

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
        self.setAutoFillBackground(True)
        self.transport = Transport()
        self.canvas = TimelineCanvas(
            "The error of every frame by hand and by quasi-eigen appears here: open a rig and a performance."
        )
        self.canvas.waiting = "The error of every frame appears here when the basis has been made."
        self.playback = Playback(self)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(0)
        self._column.addWidget(self.transport)
        self._column.addWidget(self.canvas, 1)
        self._in_title = False
        self.setFocusProxy(self.canvas)
        self.canvas.setToolTip("Drag to go through the frames; wheel zooms, middle drag shifts, double click shows all")
        self.canvas.frame_changed.connect(self._go)
        self.transport.frame_wanted.connect(self._go)
        self.transport.wanted.connect(self._do)
        self.transport.loop_changed.connect(self._set_loop)
        self.playback.frame_changed.connect(self._played)
        self.playback.playing_changed.connect(self.transport.set_playing)
        self.playback.playing_changed.connect(self.playing_changed)
        empty = "there are no curves yet"
        picture.offer(self.canvas, "timeline", "error over time", table=self.canvas.cells,
                      ready=lambda: "" if self.canvas.frames else empty)  # fmt: skip

    @property
    def frame(self) -> int:
        """The frame at the playhead, from 0."""
        return self.canvas.frame

    @property
    def is_playing(self) -> bool:
        """Whether it plays."""
        return self.playback.is_playing

    def set_clip(self, frames: int, fps: float = 0.0) -> None:
        """Show a performance of so many frames at ``fps`` Hz; 0 while there is none."""
        self.playback.set_clip(frames, fps)
        self.canvas.set_clip(frames, max(1, round(fps)))
        self.transport.set_clip(frames, fps)
        self.set_frame(min(self.canvas.frame, max(0, frames - 1)))

    def set_frame(self, frame: int) -> None:
        """Put the playhead to a frame, from 0, without telling anybody."""
        self.playback.set_frame(frame)
        self._show(frame)

    def set_curves(self, alpha: Mapping[str, FloatArray], rms_mm: Mapping[str, FloatArray]) -> None:
        """Show errors of every frame: basis key -> (L,) alpha in %, and (L,) RMS in mm."""
        tracks = (("α", "%", alpha), ("RMS", "mm", rms_mm))
        self.canvas.set_tracks([Track(t, unit, _curves(by)) for t, unit, by in tracks if by])

    def set_worst(self, frames: Sequence[int]) -> None:
        """Mark the worst frames, from 0, the worst first."""
        self.canvas.set_marks(frames, BASES["quasi_eigen"])
        self.transport.set_worst(tuple(int(f) for f in frames))
        self.transport.set_frame(self.frame)

    def set_trained(self, start: int, stop: int) -> None:
        """Mark the frames that the axes are trained on: first, and the one after the last."""
        self.canvas.set_span((start, stop))

    def set_loop(self, loop: bool) -> None:
        """Begin again at the end, or stop there."""
        self.transport.loop_button.setChecked(loop)

    def play(self) -> None:
        """Play from the playhead, from the start when it stands at the end."""
        self.playback.play()

    def pause(self) -> None:
        """Stop playing where it is."""
        self.playback.pause()

    def toggle_play(self) -> None:
        """Play or pause."""
        if self.is_playing:
            self.pause()
        else:
            self.play()

    def step(self, frames: int) -> None:
        """Move the playhead by so many frames and tell; playing pauses."""
        self.pause()
        self._go(self.frame + frames)

    def close_playback(self) -> None:
        """Stop the clock."""
        self.playback.pause()

    def _do(self, wanted: str) -> None:
        if wanted == "play":
            self.toggle_play()
        elif wanted in ("previous", "next"):
            self.step(-1 if wanted == "previous" else 1)
        else:
            self._go(0 if wanted == "first" else self.canvas.frames - 1)

    def _go(self, frame: int) -> None:
        frame = min(max(0, frame), max(0, self.canvas.frames - 1))
        changed = frame != self.playback.frame
        self.set_frame(frame)
        if changed:
            self.frame_changed.emit(frame)

    def _played(self, frame: int) -> None:
        self._show(frame)
        self.frame_changed.emit(frame)

    def _show(self, frame: int) -> None:
        self.canvas.set_frame(frame)
        self.transport.set_frame(self.canvas.frame)

    def _set_loop(self, loop: bool) -> None:
        self.playback.loop = loop

    def showEvent(self, event: QShowEvent) -> None:
        """Move the transport into the dock's title bar, where there is one of ours."""
        dock = self.parentWidget()
        bar = dock.titleBarWidget() if isinstance(dock, QDockWidget) else None
        if not self._in_title and isinstance(bar, DockTitle):
            self._in_title = True
            self._column.removeWidget(self.transport)
            bar.set_middle(self.transport, NAMES)
        super().showEvent(event)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(1432, theme.px(148))


def _curves(by_basis: Mapping[str, FloatArray]) -> tuple[Curve, ...]:
    known = [key for key in BASES if key in by_basis]
    return tuple(Curve(BASES[key], by_basis[key], ROLES[key], key == "pca") for key in known)
