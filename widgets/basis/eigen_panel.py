"""Eigenfaces: a slider per axis of the motion, in standard deviations."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRect, QSize, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton, QScrollArea, QVBoxLayout, QWidget

from engine.mesh import FloatArray
from widgets import theme
from widgets.basis.words import figure
from widgets.parts.section import DimLabel
from widgets.parts.tables import HEADER_HEIGHT, paint_header, paint_row
from widgets.parts.value_slider import ValueSlider

LIMIT = 3.0
"""Standard deviations to either side."""
NAME, VALUE, ROW = 76, 48, 24


class _Header(QWidget):
    def __init__(self) -> None:
        super().__init__()
        theme.fix(self, height=HEADER_HEIGHT)
        theme.signals.changed.connect(self.update)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, px = QPainter(self), theme.px
        paint_header(painter, self.rect())
        middle, right = Qt.AlignmentFlag.AlignVCenter, Qt.AlignmentFlag.AlignRight
        painter.drawText(QRect(8, 0, px(40), self.height()), middle, "axis")
        painter.drawText(QRect(0, 0, px(NAME), self.height()), middle | right, "var. %")
        bar = px(8)
        left, wide = px(NAME + 8) + px(6), self.width() - bar - px(NAME + 8) - px(VALUE + 16) - px(12)
        for share, text in ((0.0, "−3"), (0.5, "0"), (1.0, "3")):
            place = round(left + share * wide)
            painter.drawText(
                QRect(place - px(20), 0, px(40), self.height()), middle | Qt.AlignmentFlag.AlignHCenter, text
            )
        painter.drawText(QRect(0, 0, self.width() - bar - 8, self.height()), middle | right, "std. dev.")


class _AxisRow(QWidget):
    """A row: number and share of the axis, slider, value."""

    pressed = Signal(int)

    def __init__(self, axis: int) -> None:
        super().__init__()
        self.axis, self.share, self.chosen = axis, float("nan"), False
        self.slider = ValueSlider(-LIMIT, LIMIT, 0.0, 0.1, f"Axis {axis + 1}")
        self.slider.set_role("dim")
        theme.fix(self, height=ROW)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        self._left, self._right = QWidget(), QWidget()
        theme.fix(self._left, width=NAME + 8)
        theme.fix(self._right, width=VALUE + 16)
        for filler in (self._left, self._right):
            filler.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        row.addWidget(self._left)
        row.addWidget(self.slider, 1)
        row.addWidget(self._right)
        self.slider.dragged.connect(self.update)
        theme.signals.changed.connect(self.update)

    def mousePressEvent(self, _event: QMouseEvent) -> None:
        self.pressed.emit(self.axis)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, px, current = QPainter(self), theme.px, theme.current()
        paint_row(painter, self.rect(), self.axis, self.chosen)
        if self.chosen:
            painter.fillRect(QRect(0, 0, 2, self.height()), current.colour("accent"))
        middle, right = Qt.AlignmentFlag.AlignVCenter, Qt.AlignmentFlag.AlignRight
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(current.colour("text"))
        painter.drawText(QRect(8, 0, px(40), self.height()), middle, str(self.axis + 1))
        painter.drawText(QRect(0, 0, self.width() - 8, self.height()), middle | right, figure(self.slider.value))
        painter.setPen(current.colour("text" if self.chosen else "dim"))
        painter.drawText(QRect(0, 0, px(NAME), self.height()), middle | right, figure(100 * self.share, 1))


class EigenPanel(QWidget):
    """A slider per axis, -3..3 standard deviations, with the trained range shaded.

    Signals
    -------
    values_dragged(object), values_set(object)
        (m,) float array in standard deviations: while a slider moves, and when it is let go.
    axis_chosen(int)
        The axis the user works on, from 0.
    """

    values_dragged = Signal(object)
    values_set = Signal(object)
    axis_chosen = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.rows: list[_AxisRow] = []
        self._axis = -1
        self._header = _Header()
        self.reset_button = QPushButton("Reset all")
        self.reset_button.setToolTip("Back to the mean of the performance: every axis to 0")
        self.legend = DimLabel("shaded: range of the trained frames", theme.TABLE_PX)
        self.empty = DimLabel(
            "A slider for each axis of the performance appears here: open a performance, and its eigenfaces can be "
            "looked at one by one."
        )
        self._arrange()
        self.reset_button.clicked.connect(self._reset)
        self.set_axes(None)

    def _arrange(self) -> None:
        self.empty.setWordWrap(True)
        self.empty.setContentsMargins(8, 8, 8, 8)
        self._inside = QWidget()
        self._list = QVBoxLayout(self._inside)
        self._list.setContentsMargins(0, 0, 0, 0)
        self._list.setSpacing(0)
        self._list.addStretch(1)
        self._area = QScrollArea()
        self._area.setWidgetResizable(True)
        self._area.setFrameShape(QFrame.Shape.NoFrame)
        self._area.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        self._area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._area.setWidget(self._inside)
        self._foot = QWidget()
        row = QHBoxLayout(self._foot)
        row.setContentsMargins(8, 6, 8, 8)
        row.addWidget(self.legend, 1)
        row.addWidget(self.reset_button)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.empty)
        column.addWidget(self._header)
        column.addWidget(self._area, 1)
        column.addWidget(self._foot)
        column.addStretch(0)

    @property
    def note(self) -> str:
        """What stands beside the dock's name: how many axes there are."""
        return f"{len(self.rows)} axes" if len(self.rows) != 1 else "1 axis"

    @property
    def values(self) -> FloatArray:
        """(m,) standard deviations as the sliders stand."""
        return np.array([row.slider.value for row in self.rows], dtype=np.float64)

    def set_axes(
        self, deviations: FloatArray | None, shares: FloatArray | None = None, ranges: FloatArray | None = None
    ) -> None:
        """Show axes; sliders that were there stay where they are.

        Parameters
        ----------
        deviations : (m,) float, or None
            Standard deviation of each axis, mm (root of the eigenvalue).
        shares : (m,) float, optional
            Share of the variance, 0..1.
        ranges : (m, 2) float, optional
            Least and largest coordinate of the training frames, in standard deviations.
        """
        number = 0 if deviations is None else len(deviations)
        while len(self.rows) > number:
            row = self.rows.pop()
            self._list.removeWidget(row)
            row.hide()
            row.deleteLater()
        while len(self.rows) < number:
            self._add()
        for k, row in enumerate(self.rows):
            assert deviations is not None
            row.share = float("nan") if shares is None else float(shares[k])
            row.slider.set_band(None if ranges is None else (float(ranges[k][0]), float(ranges[k][1])))
            row.setToolTip(f"Axis {k + 1}: one standard deviation is {float(deviations[k]):.3g} mm over all vertices")
            row.update()
        self.legend.setVisible(ranges is not None)
        for widget in (self._header, self._area, self._foot):
            widget.setVisible(number > 0)
        self.empty.setVisible(not number)
        if self._axis >= number:
            self.set_axis(None)

    def _add(self) -> None:
        row = _AxisRow(len(self.rows))
        self.rows.append(row)
        self._list.insertWidget(len(self.rows) - 1, row)
        row.pressed.connect(self._choose)
        row.slider.dragged.connect(lambda _v, axis=row.axis: self._moved(axis, held=True))
        row.slider.released.connect(lambda _v, axis=row.axis: self._moved(axis, held=False))

    def set_values(self, values: FloatArray) -> None:
        """Show other values (m,) without telling anybody."""
        for row, value in zip(self.rows, values, strict=False):
            row.slider.set_value(float(value))
            row.update()

    def set_axis(self, axis: int | None) -> None:
        """Mark an axis, from 0, without telling anybody."""
        self._axis = -1 if axis is None else axis
        for row in self.rows:
            row.chosen = row.axis == self._axis
            row.slider.set_role("accent" if row.chosen else "dim")
            row.update()
        if 0 <= self._axis < len(self.rows):
            self._area.ensureWidgetVisible(self.rows[self._axis], 0, 0)

    def _choose(self, axis: int) -> None:
        if axis != self._axis:
            self.set_axis(axis)
            self.axis_chosen.emit(axis)

    def _moved(self, axis: int, held: bool) -> None:
        self._choose(axis)
        self.rows[axis].update()
        if held:
            self.values_dragged.emit(self.values)
        else:
            self.values_set.emit(self.values)

    def _reset(self) -> None:
        if np.any(self.values):
            self.set_values(np.zeros(len(self.rows)))
            self.values_set.emit(self.values)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(theme.px(296), theme.px(240))

    def minimumSizeHint(self) -> QSize:
        """Return the room for one axis: the rest scrolls."""
        return QSize(theme.px(232), theme.px(44))
