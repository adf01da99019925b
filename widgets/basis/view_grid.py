"""All shapes at once: hand above quasi-eigen, a tile a shape; a click chooses it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPoint, QRect, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QFontMetrics, QImage, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent
from PySide6.QtWidgets import QAbstractScrollArea, QWidget

from engine.mesh import FloatArray
from widgets import theme

if TYPE_CHECKING:
    from widgets.scene.basis_rig import RigLook
    from widgets.scene.basis_stills import RigStills

GridRow = tuple[str, FloatArray | None, FloatArray | None, float | None]
"""Name, hand and quasi-eigen displacements (N, 3) in mm, cosine between them."""
_PICTURE, _GAP, _PAD, _FOOT, _HEAD = 108, 8, 8, 20, 24
_LEAST_COSINE = 0.85
_MOVES_MM = 2.0
_WORDS = "hand above, quasi-eigen below, cosine between them"


class ShapeGrid(QAbstractScrollArea):
    """Tiles of thumbnails that are drawn one after the other while it is seen, those in sight first.

    Signals
    -------
    shape_chosen(str)
    """

    shape_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows: list[GridRow] = []
        self._pictures: dict[tuple[int, int], QImage] = {}
        self._rig: RigLook | None = None
        self._direction = np.array([-0.52, 0.10, 1.0])
        self._current = -1
        self._stage: RigStills | None = None
        self._rest: QImage | None = None
        self._sharp = 0
        self.setFrameShape(self.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("All shapes, hand above quasi-eigen")
        self._next = QTimer(self)
        self._next.setSingleShot(True)
        self._next.timeout.connect(self._draw_one)
        theme.signals.changed.connect(self._again)

    @property
    def rows(self) -> list[GridRow]:
        """The shapes that are shown."""
        return self._rows

    @property
    def complete(self) -> bool:
        """Whether every thumbnail is there."""
        return not self._missing()

    def set_rig(self, rig: RigLook | None) -> None:
        """Take another rig; its shapes come after it."""
        self._rig, self._rows, self._current = rig, [], -1
        self._again()

    def set_rows(self, rows: Sequence[GridRow]) -> None:
        """Show shapes; pictures of arrays that are the very same ones are kept."""
        before = {(row[0], k, id(row[1 + k])): (i, k) for i, row in enumerate(self._rows) for k in (0, 1)}
        kept = {}
        for i, row in enumerate(rows):
            for k in (0, 1):
                old = before.get((row[0], k, id(row[1 + k])))
                if old in self._pictures:
                    kept[(i, k)] = self._pictures[old]
        anew = not {row[0] for row in rows} <= {row[0] for row in self._rows}
        self._rows, self._pictures = list(rows), kept
        if anew:
            self._again()
        self._measure()
        self._go_on()

    def set_current(self, name: str) -> None:
        """Mark a shape."""
        found = next((i for i, row in enumerate(self._rows) if row[0] == name), -1)
        if found != self._current and found >= 0:
            self._reveal(found)
        self._current = found
        self.viewport().update()

    def set_direction(self, direction: FloatArray) -> None:
        """Look at all shapes from a direction (3,), seen from the face."""
        if not np.allclose(direction, self._direction):
            self._direction = np.array(direction)
            self._again()

    def tile(self, index: int) -> QRect:
        """Return where a shape's tile lies, pixels of the viewport."""
        row, column = divmod(index, self._columns())
        size = self._tile_size()
        left = theme.px(_PAD) + column * (size.width() + theme.px(_GAP))
        top = theme.px(_HEAD) + row * (size.height() + theme.px(_GAP)) - self.verticalScrollBar().value()
        return QRect(left, top, size.width(), size.height())

    def close(self) -> bool:
        """Let go of the stage that draws thumbnails."""
        self._next.stop()
        if self._stage is not None:
            self._stage.close()
            self._stage = None
        return super().close()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the tiles in sight."""
        current = theme.current()
        painter = QPainter(self.viewport())
        painter.fillRect(event.rect(), current.colour("window"))
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        metrics = QFontMetrics(theme.font(theme.TABLE_PX))
        edge = self._tile_size().width()
        head = QRect(theme.px(_PAD), -self.verticalScrollBar().value(), self.viewport().width(), theme.px(_HEAD))
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(current.colour("dim"))
        painter.drawText(head, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, _WORDS)
        for i, (name, _hand, _quasi, cosine) in enumerate(self._rows):
            box = self.tile(i)
            if not box.intersects(event.rect()):
                continue
            chosen = i == self._current
            painter.fillRect(box, current.colour("selection" if chosen else "panel"))
            for k in (0, 1):
                place = QRect(box.left(), box.top() + k * edge, edge, edge)
                image = self._pictures.get((i, k))
                if image is not None:
                    painter.drawImage(place, image)
                else:
                    painter.fillRect(place, current.colour("panel"))
                    if self._rest is not None and self._rows[i][1 + k] is not None:
                        painter.setOpacity(0.35)
                        painter.drawImage(place, self._rest)
                        painter.setOpacity(1.0)
            foot = box.adjusted(theme.px(4), 2 * edge, -theme.px(4), 0)
            figure = "" if cosine is None or not np.isfinite(cosine) else f"{cosine:.2f}"
            drifts = cosine is not None and cosine < _LEAST_COSINE
            painter.setPen(current.colour("stale_text" if drifts else "text" if chosen else "dim"))
            painter.drawText(foot, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, figure)
            room = foot.width() - metrics.horizontalAdvance(figure) - theme.px(6)
            if drifts:
                mark = theme.px(12)
                room -= mark + theme.px(2)
                corner = QPoint(foot.left() + room + theme.px(4), foot.center().y() - mark // 2)
                theme.icon("warning", "stale_text", 12).paint(painter, QRect(corner, QSize(mark, mark)))
            painter.setPen(current.colour("text"))
            words = metrics.elidedText(name, Qt.TextElideMode.ElideRight, room)
            painter.drawText(foot, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, words)
            if chosen:
                painter.setPen(QPen(current.colour("accent"), 2))
                painter.drawRect(box.adjusted(1, 1, -1, -1))
        painter.end()
        self._go_on()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Lay the tiles out again."""
        super().resizeEvent(event)
        self._measure()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Choose the shape under the mouse."""
        index = self.index_at(event.position().toPoint())
        if event.button() == Qt.MouseButton.LeftButton and index is not None:
            self._choose(index)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Choose a neighbour with the arrow keys."""
        columns = self._columns()
        steps = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1, Qt.Key.Key_Up: -columns, Qt.Key.Key_Down: columns}
        step = steps.get(Qt.Key(event.key()))
        if step is None or not self._rows:
            super().keyPressEvent(event)
            return
        wanted = 0 if self._current < 0 else self._current + step
        if 0 <= wanted < len(self._rows):
            self._choose(wanted)

    def index_at(self, place: QPoint) -> int | None:
        """Return the shape whose tile is at a place of the viewport."""
        return next((i for i in range(len(self._rows)) if self.tile(i).contains(place)), None)

    def _choose(self, index: int) -> None:
        self._current = index
        self._reveal(index)
        self.viewport().update()
        self.shape_chosen.emit(self._rows[index][0])

    def _reveal(self, index: int) -> None:
        """Scroll until a shape's tile is in sight."""
        bar, box = self.verticalScrollBar(), self.tile(index)
        if box.top() < 0:
            bar.setValue(bar.value() + box.top() - theme.px(_PAD))
        elif box.bottom() > self.viewport().height():
            bar.setValue(bar.value() + box.bottom() - self.viewport().height() + theme.px(_PAD))

    def _room(self) -> int:
        return self.viewport().width() - 2 * theme.px(_PAD) + theme.px(_GAP)

    def _columns(self) -> int:
        """Return the fewest columns whose lines all fit, or as many as there is room for."""
        gap, most = theme.px(_GAP), max(1, self._room() // (theme.px(_PICTURE) + theme.px(_GAP)))
        high = self.viewport().height() - theme.px(_HEAD)
        for columns in range(1, most):
            line = 2 * (self._room() // columns - gap) + theme.px(_FOOT) + gap
            if -(-len(self._rows) // columns) * line <= high:
                return columns
        return most

    def _tile_size(self) -> QSize:
        edge = max(self._room() // self._columns() - theme.px(_GAP), 1)
        return QSize(edge, 2 * edge + theme.px(_FOOT))

    def _measure(self) -> None:
        columns = self._columns()
        lines = -(-len(self._rows) // columns)
        step = self._tile_size().height() + theme.px(_GAP)
        height = theme.px(_HEAD) + lines * step
        if self._stage is not None and self._edge() > 1.25 * self._sharp:
            self._forget()
        bar = self.verticalScrollBar()
        bar.setRange(0, max(0, height - self.viewport().height()))
        bar.setPageStep(self.viewport().height())
        bar.setSingleStep(step // 4)
        self.viewport().update()

    def _edge(self) -> int:
        return round(self._tile_size().width() * self.devicePixelRatioF())

    def _forget(self) -> None:
        self._pictures.clear()
        self._rest = None
        if self._stage is not None:
            self._stage.close()
            self._stage = None

    def _again(self) -> None:
        self._forget()
        self._measure()
        self._go_on()

    def _missing(self) -> list[tuple[int, int]]:
        wanted = [(i, k) for i, row in enumerate(self._rows) for k in (0, 1) if row[1 + k] is not None]
        return [key for key in wanted if key not in self._pictures]

    def _go_on(self) -> None:
        if self._rig is not None and self.isVisible() and not self._next.isActive() and self._missing():
            self._next.start(0)

    def _draw_one(self) -> None:
        missing = self._missing()
        if self._rig is None or not missing or not self.isVisible():
            return
        from widgets.scene.background import view_colours
        from widgets.scene.basis_stills import RigStills

        if self._stage is None:
            edge = self._sharp = self._edge()
            self._stage = RigStills(edge, edge, view_colours(theme.current().name))
            self._stage.look(self._rig, self._direction, 0.98, beside=self._farthest(self._rig))
            self._rest = _image(self._stage.picture(self._rig, self._rig.neutral))
            self.viewport().update()
        seen = self.viewport().rect()
        key = next((k for k in missing if self.tile(k[0]).intersects(seen)), missing[0])
        displacements = self._rows[key[0]][1] if key[1] == 0 else self._rows[key[0]][2]
        assert displacements is not None
        self._pictures[key] = _image(self._stage.picture(self._rig, self._rig.moved(displacements)))
        self.viewport().update(self.tile(key[0]))
        self._go_on()

    def _farthest(self, rig: RigLook) -> FloatArray:
        """Return where shapes put what they move far (k, 3), mm: an open jaw must not leave the picture."""
        found = [np.zeros((0, 3))]
        for displacements in (shape for row in self._rows for shape in row[1:3] if shape is not None):
            far = rig.skin & ((displacements**2).sum(axis=1) > _MOVES_MM**2)
            found.append(rig.neutral.points[far] + displacements[far])
        return np.vstack(found)


def _image(pixels: NDArray[np.uint8]) -> QImage:
    height, width = pixels.shape[:2]
    return QImage(pixels.tobytes(), width, height, 3 * width, QImage.Format.Format_RGB888).copy()
