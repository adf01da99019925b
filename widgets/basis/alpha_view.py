"""The table of alpha: a row a basis, a column for each bounds of the weights; a click chooses the bounds."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QRect, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QHelpEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from widgets import theme
from widgets.basis.words import BASES, BOUNDS, DASH, figure, pen_of
from widgets.canvases.plot import swatch
from widgets.parts import picture
from widgets.parts.tables import HEADER_HEIGHT, paint_header, paint_row

AlphaTable = Mapping[str, Mapping[str, tuple[float, float]]]
"""Basis -> bounds -> alpha in %: mean over frames, pooled."""
ROW = 22
_TIPS = {
    "0..1": "Weights between 0 and 1",
    "-1..2": "Weights between −1 and 2",
    "free": "Weights without bounds",
}
_PCA = " (PCA: 1 unit = 1 std. dev.)"


class AlphaView(QWidget):
    """Three bases under three bounds; the bounds in use are bold.

    Signals
    -------
    bounds_chosen(str)
        Key of ``words.BOUNDS``.
    """

    bounds_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._alpha: AlphaTable = {}
        self._bounds, self._statistic = "-1..2", "mean"
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAccessibleName("Reproduction error in % by basis and bounds of the weights")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        theme.signals.changed.connect(self.updateGeometry)
        theme.signals.changed.connect(self.update)
        picture.offer(self, "alpha", "table of the reproduction error", table=self.cells)

    @property
    def bounds(self) -> str:
        """Key of the bounds in use."""
        return self._bounds

    def set_alpha(self, alpha: AlphaTable | None) -> None:
        """Show other errors in %."""
        self._alpha = alpha or {}
        self._tell()

    def set_bounds(self, bounds: str) -> None:
        """Mark the bounds in use without telling anybody."""
        self._bounds = bounds if bounds in BOUNDS else self._bounds
        self._tell()

    def set_statistic(self, statistic: str) -> None:
        """Show ``mean`` or ``pooled``."""
        self._statistic = statistic
        self._tell()

    def _tell(self) -> None:
        words = [f"{BASES[b]} {self._text(b, self._bounds)} %" for b in BASES if b in self._alpha]
        self.setAccessibleDescription(f"weights in {BOUNDS[self._bounds]}: " + ", ".join(words))
        self.update()

    def _text(self, basis: str, bounds: str) -> str:
        pair = self._alpha.get(basis, {}).get(bounds)
        return DASH if pair is None else figure(pair[0 if self._statistic == "mean" else 1])

    def _bold(self, basis: str) -> str:
        """Return the column whose value counts; PCA is the reference with free weights."""
        # Within bounds its unit is a standard deviation, which compares with no other row.
        known = self._alpha.get(basis, {})
        compared = self._bounds in known and basis != "pca"
        return self._bounds if compared or "free" not in known else "free"

    def cells(self) -> list[list[str]]:
        """Return the table as rows of cells, for a spreadsheet."""
        head = [f"alpha %, {self._statistic}, weights in", *BOUNDS.values()]
        return [head, *([BASES[b], *(self._text(b, bounds) for bounds in BOUNDS)] for b in BASES)]

    def column_box(self, bounds: str) -> QRect:
        """Return where a column of numbers lies, pixels of this widget."""
        px, k = theme.px, list(BOUNDS).index(bounds)
        small = QFontMetrics(theme.font(theme.TABLE_PX))
        names = 8 + px(16) + max(small.horizontalAdvance(name) for name in BASES.values()) + px(8)
        widest = max(small.horizontalAdvance(text) for text in BOUNDS.values()) + px(4)
        width = min(px(64), max((self.width() - 8 - names) // len(BOUNDS), widest))
        return QRect(self.width() - 8 - width * (len(BOUNDS) - k), 0, width, self.height())

    def _bounds_at(self, x: float) -> str | None:
        return next((b for b in BOUNDS if self.column_box(b).left() <= x <= self.column_box(b).right()), None)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Choose the bounds of the column under the mouse."""
        bounds = self._bounds_at(event.position().x())
        if event.button() == Qt.MouseButton.LeftButton and bounds is not None:
            self._choose(bounds)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Choose other bounds with the arrow keys."""
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        if step is None:
            super().keyPressEvent(event)
            return
        keys = list(BOUNDS)
        self._choose(keys[min(max(0, keys.index(self._bounds) + step), len(keys) - 1)])

    def _choose(self, bounds: str) -> None:
        if bounds != self._bounds:
            self.set_bounds(bounds)
            self.bounds_chosen.emit(bounds)

    def event(self, event: QEvent) -> bool:
        """Say what a column means."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            bounds = self._bounds_at(event.pos().x())
            tip = "" if bounds is None else f"{_TIPS[bounds]}{_PCA}\nA click shows curves and views with them"
            QToolTip.showText(event.globalPos(), tip, self)
            return True
        return super().event(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw header and rows."""
        painter, current, px = QPainter(self), theme.current(), theme.px
        head, height = px(HEADER_HEIGHT), px(ROW)
        paint_header(painter, QRect(0, 0, self.width(), head))
        middle, right = Qt.AlignmentFlag.AlignVCenter, Qt.AlignmentFlag.AlignRight
        painter.drawText(QRect(8, 0, px(100), head), middle, "weights in")
        for bounds, text in BOUNDS.items():
            box = self.column_box(bounds)
            chosen = bounds == self._bounds
            painter.setPen(current.colour("text" if chosen else "dim"))
            painter.drawText(QRect(box.left(), 0, box.width(), head), middle | right, text)
            if chosen and self.hasFocus():
                painter.fillRect(
                    QRect(box.left() + px(16), head - 2, box.width() - px(16), 2), current.colour("accent")
                )
        for index, basis in enumerate(BASES):
            top = head + index * height
            paint_row(painter, QRect(0, top, self.width(), height), index)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            swatch(painter, 8, top + height / 2, pen_of(basis))
            painter.setFont(theme.font(theme.TABLE_PX))
            painter.setPen(current.colour("text"))
            painter.drawText(QRect(8 + px(16), top, px(90), height), middle, BASES[basis])
            for bounds in BOUNDS:
                box, chosen = self.column_box(bounds), bounds == self._bold(basis)
                painter.setFont(theme.font(theme.TABLE_PX, bold=chosen))
                other_units = basis == "pca" and bounds != "free"
                painter.setPen(current.colour("missing" if other_units else "text" if chosen else "dim"))
                cell = QRect(box.left(), top, box.width(), height)
                painter.drawText(cell, middle | right, self._text(basis, bounds))

    def sizeHint(self) -> QSize:
        """Return header and rows."""
        return QSize(theme.px(280), theme.px(HEADER_HEIGHT) + theme.px(ROW) * len(BASES))

    def minimumSizeHint(self) -> QSize:
        """Return the size hint: no row is ever cut."""
        return QSize(theme.px(224), self.sizeHint().height())
