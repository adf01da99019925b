"""The control that fits a value: tick box, joined buttons, list, number with its unit, or a line of text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QLineEdit,
    QSizePolicy,
    QSpinBox,
    QWidget,
)

from widgets import theme
from widgets.parts.segments import Segments

if TYPE_CHECKING:
    from widgets.window.preferences import Described

FEW = 3
NUMBER_WIDTH = 88


class ValueInput(QWidget):
    """A control for one declared value.

    Signals
    -------
    changed(object)
        The user wants another value, of the declared type.
    """

    changed = Signal(object)

    def __init__(self, setting: Described, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._setting = setting
        self.control = self._make()
        self.control.setAccessibleName(setting.title)
        self.control.setAccessibleDescription(setting.text)
        self.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Fixed)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.control)

    def show_value(self, value: Any) -> None:
        """Show a value without telling anybody."""
        control = self.control
        control.blockSignals(True)
        if isinstance(control, QCheckBox):
            control.setChecked(bool(value))
        elif isinstance(control, Segments):
            control.set_current(str(value))
        elif isinstance(control, QComboBox):
            control.setCurrentIndex(control.findData(value))
        elif isinstance(control, QSpinBox):
            control.setValue(int(value))
        elif isinstance(control, QDoubleSpinBox):
            control.setValue(float(value))
        elif isinstance(control, QLineEdit) and control.text() != value:
            control.setText(str(value))
        control.blockSignals(False)

    def _make(self) -> QWidget:
        setting = self._setting
        if setting.choices:
            return self._choice()
        if setting.type is bool:
            box = QCheckBox()
            box.toggled.connect(lambda on: self.changed.emit(on))
            return box
        if setting.type in (int, float):
            return self._number()
        line = QLineEdit()
        line.setMinimumWidth(theme.px(200))
        line.editingFinished.connect(lambda: self.changed.emit(line.text()))
        return line

    def _choice(self) -> QWidget:
        setting = self._setting
        labels = setting.labels or tuple(map(str, setting.choices))
        if len(setting.choices) <= FEW:
            by_key = {str(value): value for value in setting.choices}
            segments = Segments(list(zip(by_key, labels, strict=True)), name=setting.title)
            segments.chosen.connect(lambda key: self.changed.emit(by_key[key]))
            return segments
        box = QComboBox()
        for value, label in zip(setting.choices, labels, strict=True):
            box.addItem(label, value)
        box.activated.connect(lambda _index: self.changed.emit(box.currentData()))
        return box

    def _number(self) -> QWidget:
        setting = self._setting
        box: QSpinBox | QDoubleSpinBox
        if setting.type is int:
            box = QSpinBox()
            box.setRange(_whole(setting.minimum, -(2**31)), _whole(setting.maximum, 2**31 - 1))
            span = box.maximum() - box.minimum()
            box.setSingleStep(10 if 100 <= span <= 1000 else 1)
        else:
            box = QDoubleSpinBox()
            box.setDecimals(2)
            box.setRange(
                -1e9 if setting.minimum is None else setting.minimum,
                1e9 if setting.maximum is None else setting.maximum,
            )
            box.setSingleStep(0.05)
        box.setSuffix(f" {setting.unit}" if setting.unit else "")
        box.setAlignment(Qt.AlignmentFlag.AlignRight)
        box.setKeyboardTracking(False)
        theme.fix(box, width=NUMBER_WIDTH)
        box.valueChanged.connect(lambda value: self.changed.emit(value))
        return box


def _whole(value: float | None, otherwise: int) -> int:
    return otherwise if value is None else round(value)
