"""A small popup in which the heatmap's range is typed."""

from __future__ import annotations

from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtWidgets import QCheckBox, QDoubleSpinBox, QFrame, QGridLayout, QLabel, QPushButton, QWidget

from widgets import theme


class RangeEditor(QFrame):
    """Two numbers in mm, a button that goes back to the usual range, and whether the colours are smoothed.

    A heatmap whose colours are never smoothed has ``smooth=None`` and no box for it.

    Signals
    -------
    changed(float, float)
        The range as it is typed, always low < high.
    smooth_changed(bool)
        Whether colours are to be means of what lies around.
    """

    changed = Signal(float, float)
    smooth_changed = Signal(bool)

    def __init__(
        self, low: float, high: float, usual: tuple[float, float], parent: QWidget, *, smooth: bool | None = True
    ) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self._usual = usual
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 8, 8, 8)
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(4)
        self.low, self.high = _number(low), _number(high)
        for row, (text, box) in enumerate((("From, mm", self.low), ("To, mm", self.high))):
            label = QLabel(text)
            label.setFont(theme.font())
            label.setBuddy(box)
            grid.addWidget(label, row, 0)
            grid.addWidget(box, row, 1)
            box.valueChanged.connect(self._tell)
        reset = QPushButton(f"{usual[0]:g} to {usual[1]:g} mm")
        reset.setFont(theme.font())
        reset.clicked.connect(self._reset)
        grid.addWidget(reset, 2, 0, 1, 2)
        self.smooth = QCheckBox("&Smoothed")
        self.smooth.setToolTip("Colours are means of what lies around; figures and limits stay as measured")
        self.smooth.setFont(theme.font())
        self.smooth.setChecked(bool(smooth))
        self.smooth.toggled.connect(self.smooth_changed)
        grid.addWidget(self.smooth, 3, 0, 1, 2)
        if smooth is None:
            self.smooth.hide()
        self._limit()

    def open_at(self, place: QPoint) -> None:
        """Show the popup so that its lower right corner is near a global place."""
        self.adjustSize()
        self.move(place - QPoint(self.width(), self.height() + 8))
        self.show()
        self.high.setFocus()
        self.high.selectAll()

    def _limit(self) -> None:
        self.low.setRange(0.0, max(self.high.value() - 0.01, 0.0))
        self.high.setRange(self.low.value() + 0.01, 50.0)

    def _tell(self) -> None:
        self._limit()
        self.changed.emit(self.low.value(), self.high.value())

    def _reset(self) -> None:
        for box, value in ((self.low, self._usual[0]), (self.high, self._usual[1])):
            box.blockSignals(True)
            box.setRange(0.0, 50.0)
            box.setValue(value)
            box.blockSignals(False)
        self._tell()


def _number(value: float) -> QDoubleSpinBox:
    box = QDoubleSpinBox()
    box.setDecimals(2)
    box.setSingleStep(0.05)
    box.setRange(0.0, 50.0)
    box.setValue(value)
    box.setFont(theme.font())
    return box
