"""Curves over the frames of a clip: ruler, tracks with their names at the left, marks, and a playhead to drag."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPixmap, QPolygonF, QResizeEvent
from PySide6.QtGui import QWheelEvent as Wheel
from PySide6.QtWidgets import QSizePolicy, QWidget

from engine.mesh import FloatArray
from widgets import theme
from widgets.canvases.decimate import polyline
from widgets.canvases.plot import MIDDLE, RIGHT, Plot, across, advance, draw_curve, swatch, upright
from widgets.canvases.ticks import ceiling, tick_text, ticks
from widgets.canvases.tracks import Track, grouped

NAMES, RULER, TRACK = 232, 20, 74
"""Width of the names, height of the ruler and of a track, pixels of 100 %."""
FEWEST = 8.0
"""Frames that the width shows at least."""
_LEFT, _RIGHT, _ROW = 32, 16, 16
_NEAR = 7.0


class TimelineCanvas(Plot):
    """Ruler and tracks of a clip; ``sentence`` stands there without a clip, ``waiting`` without curves.

    Left drag scrubs, wheel zooms at the pointer, middle drag or Shift + wheel shifts, double click shows all. Keys:
    arrows step (Shift: ten frames), Page Up and Down a second, Home and End.

    Signals
    -------
    frame_changed(int)
        The frame the user went to, from 0.
    """

    frame_changed = Signal(int)

    def __init__(self, sentence: str = "", parent: QWidget | None = None) -> None:
        super().__init__(sentence, parent)
        self.frames, self.frame, self.second = 0, 0, 30
        self.tracks: tuple[Track, ...] = ()
        self.waiting, self._marked = "", ""
        self.marks: tuple[int, ...] = ()
        self._span: tuple[int, int] | None = None
        self._low, self._high = 0.0, 1.0
        self._tops: tuple[float, ...] = ()
        self._drawn: QPixmap | None = None
        self._shift_from: tuple[float, float, float] | None = None
        self._scrubs = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Timeline")

    # -- what is shown ---------------------------------------------------------------------------------------

    def set_clip(self, frames: int, second: int = 30) -> None:
        """Show a clip of so many frames, ``second`` of them a second; 0 while there is none."""
        self.frames, self.second = max(0, frames), max(1, second)
        self.frame = min(self.frame, max(0, frames - 1))
        self.show_all()

    def set_tracks(self, tracks: Sequence[Track]) -> None:
        """Show other curves."""
        self.tracks = tuple(tracks)
        self._tops = tuple(ceiling(track.largest, 3) for track in self.tracks)
        self.forget()

    def set_marks(self, frames: Sequence[int], curve: str = "") -> None:
        """Mark frames with a small triangle that a click goes to, on the curve so named or on the highest."""
        self.marks, self._marked = tuple(frames), curve
        self.forget()

    def set_span(self, span: tuple[int, int] | None) -> None:
        """Underline a range of frames on the ruler: first, and the one after the last."""
        self._span = span
        self.forget()

    def set_frame(self, frame: int) -> None:
        """Put the playhead to a frame without telling anybody; a view that is zoomed in turns the page."""
        self.frame = min(max(0, frame), max(0, self.frames - 1))
        width = self._high - self._low
        if not self._low <= self.frame <= self._high:
            self._look(self.frame - 0.05 * width, self.frame + 0.95 * width)
        self.setAccessibleDescription(f"frame {grouped(self.frame)} of {grouped(self.frames - 1)}")
        self.update()

    def show_all(self) -> None:
        """Show the whole clip."""
        self._look(0.0, max(1.0, self.frames - 1.0))

    def forget(self) -> None:
        """Draw the curves anew."""
        self._drawn = None
        super().forget()

    @property
    def view(self) -> tuple[float, float]:
        """Frames at the left and the right end, from 0."""
        return self._low, self._high

    def _look(self, low: float, high: float) -> None:
        whole = max(1.0, self.frames - 1.0)
        width = min(max(high - low, min(FEWEST, whole)), whole)
        low = min(max(0.0, low), whole - width)
        self._low, self._high = low, low + width
        self.forget()

    # -- places ----------------------------------------------------------------------------------------------

    def plot_box(self) -> QRectF:
        """Return where curves are drawn, pixels of this widget; the ruler lies above it."""
        left = theme.px(NAMES) + theme.px(_LEFT)
        top = theme.px(RULER)
        return QRectF(left, top, max(1.0, self.width() - left - theme.px(_RIGHT)), max(1.0, self.height() - top))

    def x_of(self, frame: float) -> float:
        """Return the place of a frame."""
        box = self.plot_box()
        return box.left() + (frame - self._low) / (self._high - self._low) * box.width()

    def frame_at(self, x: float) -> int:
        """Return the frame at a place, kept within the clip."""
        return min(max(0, round(self._place(x))), max(0, self.frames - 1))

    def _place(self, x: float) -> float:
        box = self.plot_box()
        return self._low + (x - box.left()) / box.width() * (self._high - self._low)

    def track_box(self, index: int) -> QRectF:
        """Return the box of a track, over the width of the plot; more curves have more room."""
        box, shares = self.plot_box(), [len(track.curves) + 1 for track in self.tracks]
        line = box.height() / max(1, sum(shares))
        return QRectF(box.left(), box.top() + line * sum(shares[:index]), box.width(), line * shares[index])

    def _y_of(self, index: int, values: FloatArray) -> FloatArray:
        box = self.track_box(index)
        low, high = box.bottom() - theme.px(7), box.top() + theme.px(9)
        placed: FloatArray = low + np.asarray(values, dtype=np.float64) / self._tops[index] * (high - low)
        return placed

    def mark_place(self, frame: int) -> QPointF | None:
        """Return the tip of a mark, or nothing where it is out of view."""
        if not (self._low <= frame <= self._high) or not self.tracks:
            return None
        curves = [c for c in self.tracks[0].curves if c.name == self._marked] or self.tracks[0].curves
        values = [c.values[frame] for c in curves if frame < len(c.values)]
        top = float(np.nanmax(values)) if len(values) and np.isfinite(values).any() else self._tops[0]
        y = float(self._y_of(0, np.array([top]))[0]) - 3.0
        return QPointF(self.x_of(frame), max(y, self.track_box(0).top() + 7.0))

    # -- hands -----------------------------------------------------------------------------------------------

    def _go(self, frame: int) -> None:
        frame = min(max(0, frame), max(0, self.frames - 1))
        if self.frames and frame != self.frame:
            self.set_frame(frame)
            self.frame_changed.emit(frame)

    def _mark_at(self, position: QPointF) -> int | None:
        for frame in self.marks:
            tip = self.mark_place(frame)
            if tip is not None and abs(tip.x() - position.x()) <= _NEAR and -12 <= position.y() - tip.y() <= 4:
                return frame
        return None

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin to scrub, or to shift the view; on a mark, go to its frame."""
        if not self.frames:
            return
        x = event.position().x()
        if event.button() == Qt.MouseButton.MiddleButton:
            self._shift_from = (x, self._low, self._high)
        elif event.button() == Qt.MouseButton.LeftButton and x >= theme.px(NAMES):
            marked = self._mark_at(event.position())
            self._scrubs = marked is None
            self._go(self.frame_at(x) if marked is None else marked)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Scrub or shift."""
        x = event.position().x()
        if self._shift_from is not None:
            start, low, high = self._shift_from
            moved = (start - x) / self.plot_box().width() * (high - low)
            self._look(low + moved, high + moved)
        elif self._scrubs:
            self._go(self.frame_at(x))

    def mouseReleaseEvent(self, _event: QMouseEvent) -> None:
        """Let go."""
        self._scrubs, self._shift_from = False, None

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Show the whole clip."""
        if event.button() == Qt.MouseButton.LeftButton and event.position().x() >= theme.px(NAMES):
            self.show_all()

    def wheelEvent(self, event: Wheel) -> None:
        """Zoom at the pointer; with Shift, or sideways, shift."""
        turn, sideways = event.angleDelta().y(), event.angleDelta().x()
        width = self._high - self._low
        if sideways or event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            moved = -(sideways or turn) / 120.0 * 0.1 * width
            self._look(self._low + moved, self._high + moved)
        elif turn:
            at = min(max(self._place(event.position().x()), self._low), self._high)
            factor = 0.8 ** (turn / 120.0)
            self._look(at - (at - self._low) * factor, at + (self._high - at) * factor)
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Step, leap, or go to an end."""
        stride = 10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
        goals = {
            Qt.Key.Key_Left: self.frame - stride,
            Qt.Key.Key_Right: self.frame + stride,
            Qt.Key.Key_PageUp: self.frame - self.second,
            Qt.Key.Key_PageDown: self.frame + self.second,
            Qt.Key.Key_Home: 0,
            Qt.Key.Key_End: self.frames - 1,
        }
        goal = goals.get(Qt.Key(event.key()))
        if goal is None or not self.frames:
            super().keyPressEvent(event)
        else:
            self._go(goal)

    # -- drawing ---------------------------------------------------------------------------------------------

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Draw anew."""
        self._drawn = None
        super().resizeEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the curves when they changed, else only the playhead and the values at it."""
        painter = QPainter(self)
        ratio = painter.device().devicePixelRatioF()
        if not self.frames:
            self._paint_ground(painter)
            names = theme.px(NAMES)
            self.paint_sentence(painter, QRectF(names + 16, 0, self.width() - names - 32, self.height()))
            return
        if self._drawn is None or self._drawn.devicePixelRatio() != ratio:
            self._drawn = QPixmap(self.size() * ratio)
            self._drawn.setDevicePixelRatio(ratio)
            self._drawn.fill(theme.current().colour("timeline"))
            with_curves = QPainter(self._drawn)
            self._paint_still(with_curves)
            with_curves.end()
        painter.drawPixmap(0, 0, self._drawn)
        self._paint_values(painter)
        self._paint_playhead(painter)

    def _paint_ground(self, painter: QPainter) -> None:
        current, names = theme.current(), theme.px(NAMES)
        painter.fillRect(self.rect(), current.colour("timeline"))
        painter.fillRect(QRectF(0, 0, names, self.height()), current.colour("panel"))

    def _paint_still(self, painter: QPainter) -> None:
        current = theme.current()
        self._paint_ground(painter)
        box = self.plot_box()
        faint = QPen(current.colour("line", 0.62), 1)
        self._paint_ruler(painter, box, faint)
        for index, track in enumerate(self.tracks):
            self._paint_track(painter, index, track, faint)
        if not self.tracks and self.waiting:
            painter.setFont(theme.font(theme.TABLE_PX))
            painter.setPen(current.colour("dim"))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self.waiting)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(current.colour("stale"))
        painter.setClipRect(box)
        for frame in self.marks:
            tip = self.mark_place(frame)
            if tip is not None:
                painter.drawPolygon(QPolygonF([tip, tip + QPointF(-4, -5), tip + QPointF(4, -5)]))

    def _paint_ruler(self, painter: QPainter, box: QRectF, faint: QPen) -> None:
        current, height, px = theme.current(), theme.px(RULER), theme.px
        room = max(2, int(box.width() / px(130)))
        numbers, step = ticks(self._low + 1, self._high + 1, room)
        painter.setFont(theme.font(theme.AXIS_PX))
        painter.setPen(current.colour("dim"))
        painter.drawText(QRectF(0, 0, px(NAMES) - 12, height), MIDDLE | RIGHT, "frame")
        strong = QPen(current.colour("dim", 0.8), 1)
        step = max(1.0, step)
        for number in dict.fromkeys([1.0, *(n for n in numbers if n >= 1 and n == int(n))]):
            if not self._low <= number - 1 <= self._high:
                continue
            x = self.x_of(number - 1)
            upright(painter, x, height, self.height(), faint)
            upright(painter, x, height - px(8), height, strong)
            painter.setPen(current.colour("dim"))
            text = f"{int(number):,}".replace(",", "\u00a0")
            wide = advance(text, theme.AXIS_PX)
            at = min(x + 4, self.width() - wide - 4)
            if number != 1 or numbers[:1] == (1.0,) or step > 1:
                painter.drawText(QRectF(at, 0, wide + 4, height - px(4)), MIDDLE, text)
        quarter = step / 4 if step >= 4 else 1.0
        small, _ = ticks(self._low + 1, self._high + 1, int((self._high - self._low) / quarter) + 1)
        if len(small) < box.width() / 5:
            for number in np.arange(np.ceil((self._low + 1) / quarter), (self._high + 1) / quarter) * quarter:
                upright(painter, self.x_of(number - 1), height - px(5), height, strong)
        if self._span is not None and self._span != (0, self.frames):
            left, right = (min(max(self.x_of(f), box.left()), box.right()) for f in self._span)
            painter.fillRect(QRectF(left, height - 2, right - left, 2), current.colour("fresh"))
        across(painter, 0, self.width(), height, QPen(current.colour("window"), 1))

    def _paint_track(self, painter: QPainter, index: int, track: Track, faint: QPen) -> None:
        current, box, px = theme.current(), self.track_box(index), theme.px
        if index:
            across(painter, 0, px(NAMES), box.top(), QPen(current.colour("window"), 1))
            across(painter, px(NAMES), self.width(), box.top(), QPen(current.colour("panel"), 1))
        painter.setFont(theme.font(theme.AXIS_PX))
        values, step = ticks(0.0, self._tops[index], 3 if box.height() > px(48) else 1)
        for value in values:
            y = float(self._y_of(index, np.array([value]))[0])
            across(painter, box.left(), box.right(), y, faint)
            painter.setPen(current.colour("dim"))
            where = QRectF(px(NAMES), y - px(7), px(_LEFT) - 6, px(14))
            painter.drawText(where, MIDDLE | RIGHT, tick_text(value, step))
        top = self._title_top(index)
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(current.colour("text"))
        painter.drawText(QRectF(8, top, px(80), px(_ROW)), MIDDLE, track.title)
        for row, curve in enumerate(track.curves):
            y = top + px(_ROW) * (row + 1)
            swatch(painter, 8, y + px(_ROW) / 2, curve.pen())
            painter.setFont(theme.font(theme.TABLE_PX))
            painter.setPen(current.colour("dim"))
            painter.drawText(QRectF(8 + px(18), y, px(120), px(_ROW)), MIDDLE, curve.name)
        painter.save()
        painter.setClipRect(box)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for curve in reversed(track.curves):
            frames, drawn = polyline(curve.values, self._low, self._high, round(box.width()))
            painter.setPen(curve.pen())
            draw_curve(painter, box.left() + (frames - self._low) / (self._high - self._low) * box.width(),
                       self._y_of(index, drawn))  # fmt: skip
        painter.restore()

    def _title_top(self, index: int) -> float:
        box, rows = self.track_box(index), len(self.tracks[index].curves) + 1
        spare = max(0.0, box.height() - theme.px(_ROW) * rows)
        return box.top() + min(theme.px(6), spare / 2)

    def _paint_values(self, painter: QPainter) -> None:
        current, px = theme.current(), theme.px
        painter.setFont(theme.font(theme.TABLE_PX))
        right = px(NAMES) - 12
        for index, track in enumerate(self.tracks):
            top = self._title_top(index)
            painter.setPen(current.colour("dim"))
            head = f"{track.unit} at frame {grouped(self.frame)}"
            painter.drawText(QRectF(8, top, right - 8, px(_ROW)), MIDDLE | RIGHT, head)
            painter.setPen(current.colour("text"))
            for row, curve in enumerate(track.curves):
                value = float(curve.values[self.frame]) if self.frame < len(curve.values) else float("nan")
                text = f"{value:.2f}" if np.isfinite(value) else "–"
                painter.drawText(QRectF(8, top + px(_ROW) * (row + 1), right - 8, px(_ROW)), MIDDLE | RIGHT, text)

    def _paint_playhead(self, painter: QPainter) -> None:
        if not self._low - 0.5 <= self.frame <= self._high + 0.5:
            return
        x = round(self.x_of(self.frame)) + 0.5
        accent, unit = theme.current().colour("accent"), theme.px(RULER) / RULER
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(accent, 1.5))
        painter.drawLine(QPointF(x, 2), QPointF(x, self.height()))
        painter.setPen(QPen(accent, 1.2, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin))
        painter.setBrush(accent)
        shape = ((-5.4, 2.0), (5.4, 2.0), (5.4, 9.0), (0.0, 14.0), (-5.4, 9.0))
        painter.drawPolygon(QPolygonF([QPointF(x + a * unit, b * unit) for a, b in shape]))
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(theme.current().colour("accent", 0.6), 1))
            painter.drawRect(QRectF(theme.px(NAMES) + 0.5, 0.5, self.width() - theme.px(NAMES) - 1, self.height() - 1))

    def cells(self) -> list[list[str]]:
        """Return the curves as rows of cells: frame, then a column each."""
        curves = [(f"{t.title} {c.name} {t.unit}", c.values) for t in self.tracks for c in t.curves]
        rows = [["frame", *(name for name, _ in curves)]]
        for k in range(self.frames):
            rows.append([str(k + 1), *(f"{v[k]:.6g}" if k < len(v) else "" for _, v in curves)])
        return rows

    def sizeHint(self) -> QSize:
        """Return ruler and tracks."""
        return QSize(1200, theme.px(RULER) + theme.px(TRACK) * max(2, len(self.tracks)))

    def minimumSizeHint(self) -> QSize:
        """Return the least in which no name of a curve is cut."""
        rows = sum(theme.px(_ROW) * (len(t.curves) + 1) + 2 for t in self.tracks) or theme.px(72)
        return QSize(theme.px(NAMES) + theme.px(160), theme.px(RULER) + rows)
