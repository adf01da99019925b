"""A magnifier that shows single pixels round a place, with a cross and its coordinates."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPixmap
from PySide6.QtWidgets import QWidget

from widgets import theme

EDGE, GAP, PLATE, ZOOM = 122, 2, 16, 8


class Loupe(QWidget):
    """122 px of picture at 8 x without smoothing, and a plate with the coordinates below; mouse events pass through.

    Frame and plate follow the text scale; the magnification stays.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        theme.fix(self, EDGE, EDGE + GAP + PLATE)
        self._pixmap = QPixmap()
        self._at = QPointF()
        self.hide()

    @property
    def at(self) -> QPointF:
        """The place in the middle, image pixels."""
        return self._at

    def set_picture(self, pixmap: QPixmap) -> None:
        """Look at another picture."""
        self._pixmap = pixmap
        self.update()

    def look_at(self, place: QPointF) -> None:
        """Show a place in image pixels (centres at integers)."""
        self._at = QPointF(place)
        self.setAccessibleName(f"{place.x():.1f}, {place.y():.1f} px")
        self.update()

    def sizeHint(self) -> QSize:
        """Return the fixed size."""
        return QSize(theme.px(EDGE), theme.px(EDGE + GAP + PLATE))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the pixels, the cross, the ring and the coordinates."""
        palette, edge = theme.overlay(), self.width()
        painter = QPainter(self)
        frame = QRectF(0, 0, edge, edge)
        painter.fillRect(frame, palette.colour("view_bottom"))
        painter.save()
        painter.setClipRect(frame)
        painter.translate(edge / 2, edge / 2)
        painter.scale(ZOOM, ZOOM)
        painter.translate(-(self._at.x() + 0.5), -(self._at.y() + 0.5))
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, False)
        painter.drawPixmap(0, 0, self._pixmap)
        painter.restore()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QPointF(edge / 2, edge / 2)
        painter.setPen(QPen(QColor(255, 255, 255, 150), 1))
        for start, end in ((0.0, 0.44), (0.56, 1.0)):
            painter.drawLine(QPointF(start * edge, edge / 2), QPointF(end * edge, edge / 2))
            painter.drawLine(QPointF(edge / 2, start * edge), QPointF(edge / 2, end * edge))
        painter.setPen(QPen(palette.colour("accent"), 1.8))
        painter.drawEllipse(middle, 7, 7)
        painter.setPen(QPen(palette.colour("text"), 1))
        painter.drawRect(frame.adjusted(0.5, 0.5, -0.5, -0.5))
        plate = QRectF(0, edge + GAP, edge, self.height() - edge - GAP)
        painter.fillRect(plate, palette.colour("plate", palette.plate_alpha))
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(palette.colour("text"))
        box = plate.adjusted(6, 0, -6, 0)
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter, f"{self._at.x():.1f}, {self._at.y():.1f} px")
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight, f"{ZOOM} ×")
