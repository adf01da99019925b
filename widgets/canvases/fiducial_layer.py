"""How the fiducials of one picture are drawn and found under the mouse, in screen pixels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPen

from engine.landmarks import Landmark, LandmarkScheme, LandmarkSet, LandmarkState, Side
from widgets import theme
from widgets.parts.glyphs import draw_current, draw_landmark

REACH = 9.0
LABEL_GAP, LABEL_HEIGHT = 27.0, 18.0


@dataclass
class Press:
    """A left press that has not been let go: on the fiducial ``name``, or to place it where ``name`` has no place.

    ``clicked`` is where it is placed when the press ends without a drag; None when that only selects.
    """

    name: str
    start: QPointF
    last: QPointF
    place: QPointF
    placing: bool
    dragging: bool = False
    clicked: QPointF | None = None


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
            self._paint_name(painter, to_view(place), self.label_box(to_view, view))

    def _shown(self, name: str) -> Landmark:
        point = self.landmarks[name]
        if self.held is not None and self.held[0] == name:
            return Landmark(point.x, point.y, LandmarkState.PLACED, point.locked)
        return point

    def label_box(self, to_view: Callable[[QPointF], QPointF], view: QRectF) -> QRectF:
        """Return where the current name stands, screen pixels: beside its fiducial, in the view, over no other one."""
        place = None if self.current is None else self.place(self.current)
        if self.scheme is None or self.current is None or place is None:
            return QRectF()
        at, others = to_view(place), [self.place(name) for name in self.scheme.names if name != self.current]
        taken = [to_view(other) for other in others if other is not None]
        width, height = QFontMetrics(theme.font()).horizontalAdvance(self.current) + 12.0, theme.px(LABEL_HEIGHT)
        outward = 1 if self.scheme[self.current].side is Side.LEFT else -1
        boxes = []
        for up in (0, -theme.px(28), theme.px(28)):
            for way in (outward, -outward):
                left = at.x() + LABEL_GAP if way > 0 else at.x() - LABEL_GAP - width
                boxes.append(QRectF(round(left), round(at.y() + up - height / 2), width, height))
        inside = [box for box in boxes if view.adjusted(4, 4, -4, -4).contains(box)] or boxes[:1]
        free = [box for box in inside if not any(box.adjusted(-5, -5, 5, 5).contains(other) for other in taken)]
        return (free or inside)[0]

    def _paint_name(self, painter: QPainter, at: QPointF, box: QRectF) -> None:
        assert self.current is not None
        palette = theme.overlay()
        edge = QPointF(box.right() if box.center().x() < at.x() else box.left(), box.center().y())
        line = QLineF(edge, at)
        line.setLength(line.length() - 9.9)
        painter.setPen(QPen(palette.colour("accent"), 1.2))
        painter.drawLine(line)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(palette.colour("plate", 0.92))
        painter.drawRoundedRect(box, 3, 3)
        painter.setFont(theme.font())
        painter.setPen(palette.colour("text"))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self.current)
