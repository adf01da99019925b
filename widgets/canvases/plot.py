"""What every plot is drawn with: lines that lie on pixels, curves that break at gaps, and what an empty one says."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shiboken6
from PySide6.QtCore import QLineF, QRectF, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from engine.mesh import FloatArray
from widgets import theme

MIDDLE = Qt.AlignmentFlag.AlignVCenter
RIGHT = Qt.AlignmentFlag.AlignRight
CENTRE = Qt.AlignmentFlag.AlignHCenter
_PIECE, _LONG = 96, 400


class Plot(QWidget):
    """A widget that draws itself anew when the theme changes, and a sentence while it has nothing to draw.

    Parameters
    ----------
    sentence : str
        What belongs here while it is empty.
    """

    def __init__(self, sentence: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.sentence = sentence
        theme.signals.changed.connect(self.forget)

    def forget(self) -> None:
        """Let go of what was drawn ahead, and draw anew."""
        self.updateGeometry()
        self.update()

    def paint_sentence(self, painter: QPainter, rect: QRectF) -> None:
        """Write what belongs here."""
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(theme.current().colour("dim"))
        painter.drawText(rect, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self.sentence)


def advance(text: str, pixels: int = theme.TABLE_PX, *, bold: bool = False) -> int:
    """Return the width of a text in the interface font."""
    return QFontMetrics(theme.font(pixels, bold=bold)).horizontalAdvance(text)


def across(painter: QPainter, left: float, right: float, y: float, pen: QPen) -> None:
    """Draw a level line of one sharp pixel."""
    painter.fillRect(QRectF(left, math.floor(y), right - left, 1), pen.color())


def upright(painter: QPainter, x: float, top: float, bottom: float, pen: QPen) -> None:
    """Draw an upright line of one sharp pixel."""
    painter.fillRect(QRectF(math.floor(x), top, 1, bottom - top), pen.color())


def polygon(x: FloatArray, y: FloatArray) -> QPolygonF:
    """Return points (P,), pixels, as Qt takes them."""
    made = QPolygonF()
    made.resize(len(x))
    if len(x):
        pointer: Any = shiboken6.VoidPtr
        pairs: FloatArray = np.frombuffer(pointer(made.data(), 16 * len(x), True), np.float64).reshape(-1, 2)
        pairs[:, 0], pairs[:, 1] = x, y
    return made


def draw_curve(painter: QPainter, x: FloatArray, y: FloatArray) -> None:
    """Draw a line through points (P,), pixels, with the painter's pen; it breaks where one is not finite."""
    good = np.isfinite(x) & np.isfinite(y)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.view(np.int8), [0]])))
    ratio = painter.device().devicePixelRatioF()
    wide = round(painter.pen().widthF() * ratio)
    shifts = [(0.0, 0.0)]
    painter.save()
    if len(x) > _LONG and wide > 1:
        # Qt draws lines of one pixel of the screen quickly and wider ones slowly: several beside each other are wide.
        pen = QPen(painter.pen())
        pen.setCosmetic(True)
        pen.setWidthF(1.0)
        painter.setPen(pen)
        steps = [(k - (wide - 1) / 2) / ratio for k in range(wide)]
        shifts = [*((0.0, step) for step in steps), *((step, 0.0) for step in steps)]
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        # The time that Qt takes for a line wider than a pixel of the screen grows with the square of its points.
        for k in range(start, max(start + 1, stop - 1), _PIECE):
            piece = slice(k, min(k + _PIECE + 1, stop))
            for right, down in shifts:
                painter.drawPolyline(polygon(x[piece] + right, y[piece] + down))
    painter.restore()


def swatch(painter: QPainter, x: float, y: float, pen: QPen) -> None:
    """Draw the short line that stands for a curve, 10 wide at 100 %, from ``x`` at the height ``y``."""
    pen = QPen(pen)
    pen.setWidthF(2.0)
    if pen.style() == Qt.PenStyle.CustomDashLine:
        pen.setDashPattern([1.0, 0.8])
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    painter.setPen(pen)
    painter.drawLine(QLineF(x, y, x + theme.px(10), y))
