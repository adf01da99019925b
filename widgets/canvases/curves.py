"""How much each axis holds: bars of the shares, the curve of their sum, and the number of axes that was chosen."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QEvent, QPoint, QRectF, QSize, Qt
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from engine.mesh import FloatArray
from widgets import theme
from widgets.canvases.plot import MIDDLE, RIGHT, Plot, across, advance, draw_curve, upright
from widgets.canvases.ticks import ticks

_LEFT, _FOOT, _TOP = 24, 30, 6
_SHOWN = 1.27
_FEWEST = 8


class ScreePlot(Plot):
    """Shares of the variance 0..1 by axis, and their sum."""

    def __init__(self, sentence: str = "", parent: QWidget | None = None) -> None:
        super().__init__(sentence, parent)
        self.shares: FloatArray | None = None
        self.cumulative: FloatArray | None = None
        self.count = 0
        self._note = ""
        self._hover = -1
        self.setMouseTracking(True)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Variance by axis")

    def set_spectrum(self, shares: FloatArray | None, cumulative: FloatArray | None, count: int, note: str) -> None:
        """Show shares (r,) and their sums (r,), both 0..1; ``count`` axes were chosen, which ``note`` says."""
        self.shares, self.cumulative = shares, cumulative
        self.count, self._note = count, note
        self.setAccessibleDescription(note)
        self.forget()

    @property
    def shown(self) -> int:
        """How many axes are drawn: a quarter more than were chosen."""
        if self.shares is None:
            return 0
        return min(len(self.shares), max(_FEWEST, int(np.ceil(_SHOWN * self.count))))

    def box(self) -> QRectF:
        """Return where bars and curve are drawn, pixels of this widget."""
        px = theme.px
        return QRectF(px(_LEFT), px(_TOP), max(1, self.width() - px(_LEFT)), max(1, self.height() - px(_FOOT + _TOP)))

    def x_of(self, axis: float) -> float:
        """Return the middle of the bar of an axis, from 0."""
        box = self.box()
        return box.left() + (axis + 0.5) / max(1, self.shown) * box.width()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Say what the axis under the pointer holds."""
        box, shown = self.box(), self.shown
        axis = int((event.position().x() - box.left()) / box.width() * shown) if shown else -1
        axis = axis if 0 <= axis < shown and event.position().x() >= box.left() else -1
        if axis != self._hover:
            self._hover = axis
            self.update()
            if axis < 0 or self.shares is None or self.cumulative is None:
                QToolTip.hideText()
            else:
                text = (
                    f"axis {axis + 1}: {100 * self.shares[axis]:.2f} %, with those before {self.cumulative[axis]:.4f}"
                )
                QToolTip.showText(event.globalPosition().toPoint() + QPoint(8, 8), text, self)

    def leaveEvent(self, event: QEvent) -> None:
        """Let the axis go."""
        self._hover = -1
        self.update()
        super().leaveEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw grid, bars, curve and the number chosen."""
        painter, current = QPainter(self), theme.current()
        if self.shares is None or self.cumulative is None or not len(self.shares):
            self.paint_sentence(painter, QRectF(self.rect()))
            return
        box, px, shown = self.box(), theme.px, self.shown
        painter.setFont(theme.font(theme.AXIS_PX))
        values, _ = ticks(0.0, 1.0, 2 if box.height() > px(40) else 1)
        for value in values:
            y = box.bottom() - value * box.height()
            across(painter, box.left(), box.right(), y, QPen(current.colour("line", 0.8), 1))
            painter.setPen(current.colour("dim"))
            painter.drawText(QRectF(0, y - px(7), px(_LEFT) - 5, px(14)), MIDDLE | RIGHT, f"{value:g}")
        wide = box.width() / shown
        for axis in range(shown):
            high = float(self.shares[axis]) * box.height()
            role = "text" if axis == self._hover else "missing" if axis >= self.count else "dim"
            area = QRectF(box.left() + axis * wide, box.bottom() - high, max(1.0, wide - 1), high)
            painter.fillRect(area, current.colour(role))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(current.colour("text"), 1.3))
        at = np.arange(shown, dtype=np.float64)
        draw_curve(painter, box.left() + (at + 0.5) * wide, box.bottom() - self.cumulative[:shown] * box.height())
        if 0 < self.count <= shown:
            self._paint_chosen(painter, box)
        painter.setPen(current.colour("dim"))
        painter.setFont(theme.font(theme.AXIS_PX))
        line = QRectF(box.left(), box.bottom() + 2, box.width(), px(14))
        painter.drawText(line, MIDDLE, "axis 1")
        painter.drawText(line, MIDDLE | RIGHT, str(shown))
        caption = "share of variance, cumulative"
        if advance(caption, theme.AXIS_PX) > box.width():
            caption = "variance, cumulative"
        painter.drawText(QRectF(box.left(), line.bottom(), box.width() + 4, px(14)), MIDDLE, caption)

    def _paint_chosen(self, painter: QPainter, box: QRectF) -> None:
        current, px = theme.current(), theme.px
        x = self.x_of(self.count - 1)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        upright(painter, x, box.top(), box.bottom(), QPen(current.colour("accent"), 1))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        wide = advance(self._note, theme.AXIS_PX) + 2
        before = x - 5 - wide >= box.left()
        left = x - 5 - wide if before else min(x + 5, box.right() - wide)
        painter.setPen(current.colour("accent_text"))
        area = QRectF(left, box.center().y() - px(7), wide, px(14))
        painter.fillRect(area, current.colour("panel", 0.8))
        painter.drawText(area, MIDDLE | Qt.AlignmentFlag.AlignHCenter, self._note)

    def cells(self) -> list[list[str]]:
        """Return shares and sums as rows of cells, for a spreadsheet."""
        if self.shares is None or self.cumulative is None:
            return []
        pairs = zip(self.shares, self.cumulative, strict=True)
        return [
            ["axis", "share", "cumulative"],
            *([str(k + 1), f"{a:.6g}", f"{b:.6g}"] for k, (a, b) in enumerate(pairs)),
        ]

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(theme.px(150), theme.px(138))

    def minimumSizeHint(self) -> QSize:
        """Return the least that can be read."""
        return QSize(theme.px(100), theme.px(48 + _FOOT))
