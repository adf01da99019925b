"""The row that plays a performance: to the ends, step, play, loop; the frame to type, and the worst frames."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QWidget

from widgets import theme
from widgets.basis.words import count
from widgets.parts.buttons import IconButton
from widgets.parts.chips import Chips
from widgets.parts.frame_field import FrameField
from widgets.parts.section import DimLabel, ShyLabel


class _Mark(QWidget):
    """The triangle that marks the worst frames."""

    def __init__(self) -> None:
        super().__init__()
        theme.fix(self, width=14, height=24)
        theme.signals.changed.connect(self.update)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, unit = QPainter(self), self.height() / 24
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.current().colour("stale"))
        painter.drawPolygon(QPolygonF([QPointF(x * unit, y * unit) for x, y in ((2, 8.5), (11, 8.5), (6.5, 15.5))]))


class Transport(QWidget):
    """Buttons, frame field and chips.

    Signals
    -------
    wanted(str)
        ``first``, ``previous``, ``play``, ``next`` or ``last``.
    loop_changed(bool)
        Whether playback begins again at the end.
    frame_wanted(int)
        A frame typed or chosen, from 0.
    """

    wanted = Signal(str)
    loop_changed = Signal(bool)
    frame_wanted = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        tips = {
            "first": "First frame (Home)", "previous": "One frame back (Left)", "play": "Play or pause",
            "next": "One frame on (Right)", "last": "Last frame (End)",
        }  # fmt: skip
        self.buttons = {key: IconButton(key, tip) for key, tip in tips.items()}
        self.buttons["play"].setProperty("raised", True)
        self.loop_button = IconButton("loop", "Begin again at the end", checkable=True)
        self.field = FrameField("Frame", "Frame, from 1: type one to go there")
        self.rest = ShyLabel("")
        self.worst_label = ShyLabel("worst frames")
        self.chips = Chips("Worst frames")
        self._mark = _Mark()
        for widget in (self.chips, self.worst_label, self._mark):
            widget.setToolTip("The worst frames by quasi-eigen: a click goes there")
        self._worst: tuple[int, ...] = ()
        self._frames, self._fps = 0, 0.0
        self._arrange()
        for key, button in self.buttons.items():
            button.clicked.connect(lambda _checked=False, key=key: self.wanted.emit(key))
        self.loop_button.toggled.connect(self.loop_changed)
        self.field.valueChanged.connect(lambda value: self.frame_wanted.emit(value - 1))
        self.chips.chosen.connect(lambda k: self.frame_wanted.emit(self._worst[k]))
        self.set_clip(0, 0.0)
        self.set_worst(())

    def _arrange(self) -> None:
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 8, 0)
        row.setSpacing(0)
        for button in self.buttons.values():
            row.addWidget(button)
        row.addSpacing(4)
        row.addWidget(self.loop_button)
        row.addSpacing(8)
        row.addWidget(DimLabel("frame", role="text"))
        row.addSpacing(4)
        row.addWidget(self.field)
        row.addSpacing(6)
        row.addWidget(self.rest, 1)
        row.addStretch(1)
        row.addWidget(self._mark)
        row.addWidget(self.worst_label)
        row.addSpacing(8)
        row.addWidget(self.chips)
        theme.fix(self, height=28)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def set_clip(self, frames: int, fps: float) -> None:
        """Take another clip."""
        self._frames, self._fps = frames, fps
        self.field.blockSignals(True)
        self.field.setRange(1, max(1, frames))
        self.field.fit(max(1, frames))
        self.field.blockSignals(False)
        for widget in (*self.buttons.values(), self.loop_button, self.field):
            widget.setEnabled(frames > 0)
        self.buttons["play"].set_available(frames > 1 and fps > 0, "" if frames else "Open a performance first")
        self.set_frame(0)

    def set_frame(self, frame: int) -> None:
        """Show a frame, from 0, without telling anybody."""
        self.field.show_value(frame + 1)
        text = ""
        if self._frames:
            time = f", {frame / self._fps:.3f} s, {self._fps:g} fps" if self._fps > 0 else ""
            text = f"of {count(self._frames)}{time}"
        self.rest.setText(text)
        self.chips.set_current(self._worst.index(frame) if frame in self._worst else -1)

    def set_worst(self, frames: tuple[int, ...]) -> None:
        """Offer the worst frames, from 0, the worst first."""
        self._worst = frames
        self.chips.set_texts([count(f + 1) for f in frames])
        for widget in (self._mark, self.worst_label):
            widget.setVisible(bool(frames))

    def set_playing(self, playing: bool) -> None:
        """Show whether it plays."""
        self.buttons["play"].set_icon_name("pause" if playing else "play")

    def minimumSizeHint(self) -> QSize:
        """Return the room for what cannot be left out."""
        return QSize(theme.px(6 * 24 + 8 + 96), theme.px(28))
