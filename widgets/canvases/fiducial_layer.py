"""How the fiducials of one picture are drawn and found under the mouse, in screen pixels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPen

from engine.landmarks import Landmark, LandmarkScheme, LandmarkSet, LandmarkState, Side
from widgets import theme
from widgets.parts.glyphs import draw_current, draw_landmark

REACH = 9.0
LABEL_GAP, LABEL_HEIGHT = 27.0, 18.0


@dataclass
class FiducialLayer:
    """The fiducials over a picture: which there are, which one is current, which one the hand holds.

    ``held`` is a name with its place while it is dragged; it stands in for the place in ``landmarks``.
    """

    scheme: LandmarkScheme | None = None
    landmarks: LandmarkSet = LandmarkSet({})  # noqa: RUF009  (frozen, empty)
    current: str | None = None
    held: tuple[str, QPointF] | None = None
    visible: bool = True

    def place(self, name: str) -> QPointF | None:
        """Return where a fiducial is, image pixels; ``None`` while it has no place."""
        if self.held is not None and self.held[0] == name:
            return self.held[1]
        point = self.landmarks[name]
        if not point.is_set and point.state is not LandmarkState.SKIPPED:
            return None
        return QPointF(point.x, point.y) if point.x == point.x and point.y == point.y else None

    def at(self, position: QPointF, to_view: Callable[[QPointF], QPointF]) -> str | None:
        """Return the fiducial nearest to a screen position, within reach; the current one wins a tie."""
        if self.scheme is None or not self.visible:
            return None
        best, best_distance = None, REACH
        for name in self.scheme.names:
            place = self.place(name)
            if place is None:
                continue
            off = to_view(place) - position
            distance = (off.x() ** 2 + off.y() ** 2) ** 0.5 - (0.5 if name == self.current else 0.0)
            if distance < best_distance:
                best, best_distance = name, distance
        return best

    def paint(self, painter: QPainter, to_view: Callable[[QPointF], QPointF], view: QRectF) -> None:
        """Draw every fiducial, the ring and the name of the current one; the painter is in screen pixels."""
        if self.scheme is None or not self.visible:
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        palette = theme.overlay()
        for landmark in self.scheme:
            place = self.place(landmark.name)
            if place is not None:
                draw_landmark(painter, to_view(place), self._shown(landmark.name), landmark.side, palette=palette)
        if self.current is None or self.current not in self.scheme:
            return
        place = self.place(self.current)
        if place is not None and view.adjusted(-12, -12, 12, 12).contains(to_view(place)):
            draw_current(painter, to_view(place), palette=palette)
            self._paint_name(painter, to_view(place), self.scheme[self.current].side, view)

    def _shown(self, name: str) -> Landmark:
        point = self.landmarks[name]
        if self.held is not None and self.held[0] == name:
            return Landmark(point.x, point.y, LandmarkState.PLACED, point.locked)
        return point

    def _paint_name(self, painter: QPainter, at: QPointF, side: Side, view: QRectF) -> None:
        assert self.current is not None
        palette, font = theme.overlay(), theme.font()
        width = QFontMetrics(font).horizontalAdvance(self.current) + 12.0
        leftwards = side is not Side.LEFT
        if leftwards and at.x() - LABEL_GAP - width < view.left() + 4:
            leftwards = False
        elif not leftwards and at.x() + LABEL_GAP + width > view.right() - 4:
            leftwards = True
        left = at.x() - LABEL_GAP - width if leftwards else at.x() + LABEL_GAP
        box = QRectF(round(left), round(at.y() - LABEL_HEIGHT / 2), width, LABEL_HEIGHT)
        edge = box.right() if leftwards else box.left()
        painter.setPen(QPen(palette.colour("accent"), 1.2))
        painter.drawLine(QPointF(edge, at.y()), QPointF(at.x() + (-9.9 if leftwards else 9.9), at.y()))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(palette.colour("plate", 0.92))
        painter.drawRoundedRect(box, 3, 3)
        painter.setFont(font)
        painter.setPen(palette.colour("text"))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self.current)
