"""A row of small joined buttons that send their key; at most one is on, and those that do not fit are left out."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from widgets import theme


class Chips(QWidget):
    """Joined buttons, 24 high; none need be on, and any can be pressed again.

    Signals
    -------
    chosen(int)
        Number of the chip, from 0.
    """

    chosen = Signal(int)

    def __init__(self, name: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._texts: tuple[str, ...] = ()
        self._current, self._focus = -1, 0
        theme.fix(self, height=24)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName(name)
        self.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Fixed)
        theme.signals.changed.connect(self.updateGeometry)
        theme.signals.changed.connect(self.update)

    @property
    def texts(self) -> tuple[str, ...]:
        """What they read."""
        return self._texts

    def set_texts(self, texts: Sequence[str]) -> None:
        """Show other chips."""
        self._texts, self._current, self._focus = tuple(texts), -1, 0
        self.setVisible(bool(texts))
        self.updateGeometry()
        self.update()

    def set_current(self, index: int) -> None:
        """Turn one on without telling anybody; -1 for none."""
        if index != self._current:
            self._current = index
            self.setAccessibleDescription(self._texts[index] if 0 <= index < len(self._texts) else "")
            self.update()

    def box(self, index: int) -> QRectF:
        """Return where a chip lies, pixels of this widget; empty for one that is left out."""
        left = 0.0
        for k, width in enumerate(self._widths()):
            if left + width > self.width() + 0.5:
                return QRectF()
            if k == index:
                return QRectF(left, 0, width, self.height())
            left += width
        return QRectF()

    def _widths(self) -> list[float]:
        metrics = QFontMetrics(theme.font())
        return [float(metrics.horizontalAdvance(text) + theme.px(18)) for text in self._texts]

    def sizeHint(self) -> QSize:
        """Return the room for all."""
        return QSize(round(sum(self._widths())), theme.px(24))

    def minimumSizeHint(self) -> QSize:
        """Return no room: others need it more."""
        return QSize(0, theme.px(24))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Send the key of the chip under the mouse."""
        found = next((k for k in range(len(self._texts)) if self.box(k).contains(event.position())), None)
        if event.button() == Qt.MouseButton.LeftButton and found is not None:
            self._focus = found
            self.chosen.emit(found)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move along with the arrow keys."""
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        if step is not None and self._texts:
            self._focus = (self._focus + step) % len(self._texts)
            self.chosen.emit(self._focus)
        else:
            super().keyPressEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw frame, the one that is on, lines between and texts."""
        current, painter = theme.current(), QPainter(self)
        boxes = [box for k in range(len(self._texts)) if not (box := self.box(k)).isEmpty()]
        if not boxes:
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        clip = QPainterPath()
        clip.addRoundedRect(QRectF(0.5, 0.5, boxes[-1].right() - 1, self.height() - 1), 4, 4)
        painter.fillPath(clip, current.colour("segment_off"))
        if 0 <= self._current < len(boxes):
            painter.setClipPath(clip)
            painter.fillRect(boxes[self._current], current.colour("segment_on"))
            painter.setClipping(False)
        painter.setPen(QPen(current.colour("line"), 1))
        for box in boxes[1:]:
            x = round(box.left()) - 0.5
            painter.drawLine(QPointF(x, 0), QPointF(x, self.height()))
        if self.hasFocus():
            painter.setPen(QPen(current.colour("accent"), 1))
        painter.drawPath(clip)
        painter.setFont(theme.font())
        for k, box in enumerate(boxes):
            painter.setPen(current.colour("text" if k == self._current else "dim"))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self._texts[k])
