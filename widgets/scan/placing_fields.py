"""The numbers of a virtual camera before a mesh: angles, distance, field of view, size, unit."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QDoubleSpinBox, QFormLayout, QLabel, QSpinBox, QWidget

from engine.errors import InputError
from engine.files.mesh_unit import mm_per_unit, scaled_unit
from engine.scan.mesh_view import MAX_SIDE_PX, MeshView

_UNITS = ("mm", "cm", "m")


class PlacingFields(QWidget):
    """A form of numbers; values in, wishes out.

    Signals
    -------
    view_changed(MeshView)
        The user typed a number.
    unit_changed(str)
        The user chose another unit: ``mm``, ``cm``, ``m`` or millimetres, as ``"85.3 mm"``.
    refused(str)
        Why what was typed is no unit; empty once it is one again.
    """

    view_changed = Signal(object)
    unit_changed = Signal(str)
    refused = Signal(str)

    def __init__(self, view: MeshView, unit: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._view, self._unit, self._quiet = view, unit, False
        form = QFormLayout(self)
        form.setContentsMargins(0, 0, 0, 0)
        form.setHorizontalSpacing(16)
        form.setVerticalSpacing(4)
        self.turn = _decimal(-180, 180, "°", "About the upright axis, + to the picture's right")
        self.tilt = _decimal(-180, 180, "°", "About the axis across, + looks down")
        self.roll = _decimal(-180, 180, "°", "About the line of sight, + against the clock")
        for box in (self.turn, self.tilt, self.roll):
            box.setWrapping(True)
        self.distance = _decimal(10, 100_000, " mm", "From the middle of the picture to the camera", 10)
        self.field = _decimal(1, 120, "°", "From the lower to the upper edge of the picture", 0.5)
        self.field.setDecimals(2)
        self.width_px = _whole("Columns of the picture")
        self.height_px = _whole("Rows of the picture")
        self.unit = QComboBox()
        self.unit.setEditable(True)
        self.unit.addItems(_UNITS)
        self.unit.setToolTip("What one unit of the file is: mm, cm, m, or a number of millimetres, as 85.3 mm")
        rows: tuple[tuple[str, QWidget], ...] = (
            ("&Turn", self.turn), ("T&ilt", self.tilt), ("&Roll", self.roll), ("&Distance", self.distance),
            ("&Field of view", self.field), ("&Width", self.width_px), ("&Height", self.height_px),
            ("U&nit", self.unit),
        )  # fmt: skip
        for text, field in rows:
            label = QLabel(text)
            label.setBuddy(field)
            form.addRow(label, field)
        for box in (self.turn, self.tilt, self.roll):
            box.valueChanged.connect(self._turn)
        self.distance.valueChanged.connect(lambda value: self._change(distance_mm=value))
        self.field.valueChanged.connect(lambda value: self._change(field_of_view_deg=value))
        self.width_px.valueChanged.connect(lambda value: self._change(width=value))
        self.height_px.valueChanged.connect(lambda value: self._change(height=value))
        self.unit.activated.connect(lambda _index: self._choose_unit())
        line = self.unit.lineEdit()
        assert line is not None
        line.editingFinished.connect(self._choose_unit)
        self.show_view(view)
        self.show_unit(unit)

    def show_view(self, view: MeshView) -> None:
        """Show a view without telling anybody."""
        self._view, self._quiet = view, True
        for box, value in zip((self.turn, self.tilt, self.roll), view.angles_deg, strict=True):
            box.setValue(value)
        self.distance.setValue(view.distance_mm)
        self.field.setValue(view.field_of_view_deg)
        self.width_px.setValue(view.width)
        self.height_px.setValue(view.height)
        self._quiet = False

    def show_unit(self, unit: str) -> None:
        """Show a unit without telling anybody."""
        self._unit = unit
        self.unit.setCurrentText(unit)

    def _turn(self) -> None:
        if not self._quiet:
            self._view = self._view.turned(self.turn.value(), self.tilt.value(), self.roll.value())
            self.view_changed.emit(self._view)

    def _change(self, **values: float) -> None:
        if not self._quiet:
            self._view = replace(self._view, **values)  # type: ignore[arg-type]
            self.view_changed.emit(self._view)

    def _choose_unit(self) -> None:
        typed = self.unit.currentText().strip()
        if typed == self._unit:
            self.refused.emit("")
            return
        try:
            number = f"{float(typed)} mm" if _is_number(typed) else typed
            unit = scaled_unit(mm_per_unit(number))
        except InputError as error:
            self.refused.emit(str(error))
            return
        self.show_unit(unit)
        self.unit_changed.emit(unit)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _decimal(low: float, high: float, suffix: str, tip: str, step: float = 1.0) -> QDoubleSpinBox:
    box = QDoubleSpinBox()
    box.setRange(low, high)
    box.setDecimals(1)
    box.setSingleStep(step)
    box.setSuffix(suffix)
    box.setKeyboardTracking(False)
    box.setToolTip(tip)
    return box


def _whole(tip: str) -> QSpinBox:
    box = QSpinBox()
    box.setRange(16, MAX_SIDE_PX)
    box.setSingleStep(50)
    box.setSuffix(" px")
    box.setKeyboardTracking(False)
    box.setToolTip(tip)
    return box
