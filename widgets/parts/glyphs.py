"""The marks that mean something everywhere: fiducials by state and side, and dots of freshness."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from engine.landmarks import Landmark, LandmarkState, Side
from widgets import theme
from widgets.theme import Theme

LARGE_TEXT = 110
"""Text scale in per cent above which words give way to room."""
RIM = QColor("#191a1d")
CROSS = QColor("#979da7")


def draw_landmark(
    painter: QPainter,
    centre: QPointF,
    point: Landmark,
    side: Side,
    *,
    palette: Theme,
    radius: float = 4.0,
    rim: bool = True,
) -> None:
    """Draw a fiducial's mark: ring proposed, disc placed, square locked, cross skipped, faint dot unset.

    Parameters
    ----------
    painter : QPainter
        With antialiasing on.
    centre : QPointF
        In the painter's pixels.
    point : Landmark
        Its state and lock choose the form.
    side : Side
        Chooses the colour.
    palette : Theme
        Where the colours come from; ``theme.overlay()`` over pictures.
    radius : float
        Of the disc, pixels.
    rim : bool
        Whether a dark rim of 1 px sets it off from a picture.
    """
    colour = palette.side(side)
    if point.state is LandmarkState.SKIPPED:
        arm = radius * 0.75
        ends = [(QPointF(-arm, -arm), QPointF(arm, arm)), (QPointF(-arm, arm), QPointF(arm, -arm))]
        pens = [QPen(RIM, 3.4)] if rim else []
        for pen in [*pens, QPen(CROSS if rim else palette.colour("missing"), 1.6)]:
            pen.setCapStyle(Qt.PenCapStyle.RoundCap)
            painter.setPen(pen)
            for start, end in ends:
                painter.drawLine(centre + start, centre + end)
        return
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if point.state is LandmarkState.PROPOSED:
        if rim:
            painter.setPen(QPen(RIM, 2.9))
            painter.drawEllipse(centre, radius, radius)
        painter.setPen(QPen(colour, 1.8))
        painter.drawEllipse(centre, radius, radius)
        return
    if point.state is LandmarkState.UNSET:
        painter.setPen(QPen(palette.colour("missing"), 1))
        painter.drawEllipse(centre, radius * 0.5, radius * 0.5)
        return
    painter.setPen(QPen(RIM, 1) if rim else Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    if point.locked:
        half = radius - 0.5
        painter.drawRect(QRectF(centre.x() - half, centre.y() - half, 2 * half, 2 * half))
    else:
        painter.drawEllipse(centre, radius, radius)


def draw_current(painter: QPainter, centre: QPointF, *, palette: Theme, radius: float = 9.0) -> None:
    """Draw the accent ring round the fiducial whose turn it is."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(palette.colour("accent"), 1.8))
    painter.drawEllipse(centre, radius, radius)


def draw_state_dot(painter: QPainter, centre: QPointF, state: str, diameter: float = 7.0) -> None:
    """Draw the dot of ``fresh``, ``stale`` (filled) or ``missing`` (ring)."""
    current = theme.current()
    if state == "missing":
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(current.colour("missing"), 1.2))
        painter.drawEllipse(centre, diameter / 2 - 0.6, diameter / 2 - 0.6)
    else:
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(current.colour("fresh" if state == "fresh" else "stale"))
        painter.drawEllipse(centre, diameter / 2, diameter / 2)


class StateDot(QWidget):
    """A dot of freshness as a widget of 8 px at 100 %."""

    def __init__(self, state: str = "missing", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._state = state
        theme.fix(self, 8, 8)
        theme.signals.changed.connect(self.update)

    def set_state(self, state: str) -> None:
        """Show ``fresh``, ``stale`` or ``missing``."""
        self._state = state
        self.setAccessibleName(state)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the dot."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = self.width() / 2
        draw_state_dot(painter, QPointF(middle, middle), self._state, theme.px(7))


class Legend(QWidget):
    """A mark with its word, 16 high: what a colour or a form means."""

    def __init__(self, word: str, point: Landmark, side: Side, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._word, self._point, self._side = word, point, side
        self.setAccessibleName(word)
        self.setToolTip(word)
        theme.signals.changed.connect(self.updateGeometry)
        theme.signals.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        """Return the room for mark and word."""
        from PySide6.QtGui import QFontMetrics

        return QSize(
            theme.px(13) + QFontMetrics(theme.font(theme.TABLE_PX)).horizontalAdvance(self._word), theme.px(16)
        )

    def minimumSizeHint(self) -> QSize:
        """Return the size hint; with large text, the room for the mark and a letter or two."""
        least = theme.px(30) if theme.px(100) > LARGE_TEXT else self.sizeHint().width()
        return QSize(min(least, self.sizeHint().width()), theme.px(16))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw mark and word."""
        current = theme.current()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        centre, radius = QPointF(theme.px(4.5), self.height() / 2), 3.5 * theme.px(8) / 8
        draw_landmark(painter, centre, self._point, self._side, palette=current, radius=radius, rim=False)
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(current.colour("dim"))
        box = QRectF(theme.px(12), 0, self.width() - theme.px(12), self.height())
        word = painter.fontMetrics().elidedText(self._word, Qt.TextElideMode.ElideRight, round(box.width()))
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter, word)
