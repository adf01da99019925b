"""Where a scan comes from and what is done to it before the fit: source, repair, template."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QPushButton,
    QSizePolicy,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from engine.mesh import FloatArray
from widgets import theme
from widgets.canvases.pictures import CHECK, depth_thumbnail, to_image
from widgets.parts.buttons import IconButton
from widgets.parts.section import Section

THUMB_HEIGHT = 104
UNITS = ("mm", "cm", "m")


@dataclass(frozen=True)
class SourceView:
    """What is said about a scan's source.

    ``missing_fraction`` is 0..1, ``spikes`` a count of pixels, ``depth`` (H, W) in mm with NaN = missing. ``unit`` is
    in words; where it was assumed, ``open_unit`` is what was taken and ``assumed`` says why. ``is_mesh`` where a
    virtual camera saw it, which can be placed elsewhere.
    """

    name: str
    depth_file: str
    width: int
    height: int
    unit: str
    missing_fraction: float
    spikes: int
    depth: FloatArray | None = field(default=None, compare=False, repr=False)
    open_unit: str = ""
    assumed: str = ""
    is_mesh: bool = False


class SourcePanel(QWidget):
    """Three sections below the list of scans.

    Signals
    -------
    options_changed(dict)
        Options of the fit that the user changed, by name: ``remove_spikes``, ``spike_mm``, ``fill_gaps``,
        ``largest_gap_px``, ``smooth``.
    unit_changed(str)
        The scan is to be read in ``mm``, ``cm`` or ``m``.
    place_requested()
        The virtual camera before the mesh is to be placed.
    scheme_changed(str)
        The name of another scheme.
    scheme_editor_requested()
        The schemes are to be looked at or changed.
    carry_requested(str)
        The fiducials of the scan with this id are to be proposed here.
    carry_source_changed(str)
        The user chose another scan to carry from.
    """

    options_changed = Signal(dict)
    unit_changed = Signal(str)
    place_requested = Signal()
    scheme_changed = Signal(str)
    scheme_editor_requested = Signal()
    carry_requested = Signal(str)
    carry_source_changed = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        self.source = Section("Source")
        self._values = {name: self.source.add_value(name) for name in ("Depth", "Size", "Unit", "Missing", "Spikes")}
        self.unit = QComboBox()
        self.unit.addItems(UNITS)
        self.unit.setAccessibleName("Unit")
        theme.fix(self.unit, height=20)
        self.source.share_row("Unit", self.unit)
        self.thumbnail = DepthThumbnail()
        self.source.add_widget(self.thumbnail)
        self.place = QPushButton("Place camera...")
        self.place.setToolTip("Turn the mesh before its virtual camera")
        self.source.add_widget(self.place)
        self.repair = Section("Repair")
        self.remove_spikes = QCheckBox("Remove spikes above")
        self.spike_mm = _decimal(0.5, 50.0, " mm")
        self.fill_gaps = QCheckBox("Fill gaps up to")
        self.largest_gap_px = _whole(1, 200, " px")
        self.smooth = QCheckBox("Smooth away the noise")
        self.repair.add_widget(_pair(self.remove_spikes, self.spike_mm, "Height of a spike above which it is removed"))
        self.repair.add_widget(_pair(self.fill_gaps, self.largest_gap_px, "Width of the largest gap that is filled"))
        self.repair.add_widget(_pair(self.smooth, None, ""))
        self.template = Section("Template")
        self.scheme = QComboBox()
        self.carry_from = QComboBox()
        self.carry_button = IconButton("copy", "Propose the fiducials of the chosen scan here", edge=22)
        for box in (self.scheme, self.carry_from):
            box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            box.setMinimumContentsLength(6)
        self.scheme_button = IconButton("more", "Fiducial scheme: change it, or make another", edge=22)
        self.scheme.setAccessibleName("Scheme")
        self.template.add_input("Scheme", _side_by_side(self.scheme, self.scheme_button))
        self.carry_from.setAccessibleName("Carry from")
        self.template.add_input("Carry from", _side_by_side(self.carry_from, self.carry_button))
        for section in (self.source, self.repair, self.template):
            column.addWidget(section)
        column.addStretch(1)
        self._connect()
        self.set_source(None)
        self.set_carry_sources([])

    def _connect(self) -> None:
        self.remove_spikes.toggled.connect(lambda on: self._say("remove_spikes", on))
        self.fill_gaps.toggled.connect(lambda on: self._say("fill_gaps", on))
        self.smooth.toggled.connect(lambda on: self._say("smooth", on))
        self.spike_mm.valueChanged.connect(lambda v: self._say("spike_mm", v))
        self.largest_gap_px.valueChanged.connect(lambda v: self._say("largest_gap_px", v))
        self.unit.textActivated.connect(self.unit_changed)
        self.place.clicked.connect(lambda _checked=False: self.place_requested.emit())
        self.scheme.activated.connect(lambda _: self.scheme_changed.emit(self.scheme.currentData()))
        self.scheme_button.clicked.connect(self.scheme_editor_requested)
        self.carry_from.activated.connect(lambda _: self.carry_source_changed.emit(self.carry_source() or ""))
        self.carry_button.clicked.connect(lambda: self.carry_requested.emit(self.carry_source() or ""))

    def _say(self, name: str, value: Any) -> None:
        self._enable()
        self.options_changed.emit({name: value})

    def _enable(self) -> None:
        self.spike_mm.setEnabled(self.remove_spikes.isEnabled() and self.remove_spikes.isChecked())
        self.spike_mm.setToolTip("" if self.spike_mm.isEnabled() else "Spikes are not removed: tick the box first")
        self.largest_gap_px.setEnabled(self.fill_gaps.isEnabled() and self.fill_gaps.isChecked())
        gaps = self.largest_gap_px.isEnabled()
        self.largest_gap_px.setToolTip("" if gaps else "Gaps are not filled: tick the box first")

    def set_source(self, source: SourceView | None) -> None:
        """Show where the scan comes from; ``None`` while no scan is chosen."""
        self.source.set_note("" if source is None else source.name)
        texts = dict.fromkeys(self._values, "–")
        if source is not None:
            share = source.spikes / max(source.width * source.height, 1)
            texts = {
                "Depth": source.depth_file,
                "Size": f"{source.width} × {source.height} px",
                "Unit": source.unit,
                "Missing": f"{100 * source.missing_fraction:.1f} %",
                "Spikes": f"{source.spikes} px, {100 * share:.2f} %",
            }
        for name, text in texts.items():
            self._values[name].set_text(text)
        is_open = source is not None and bool(source.open_unit)
        self._values["Unit"].setVisible(not is_open)
        self.unit.setVisible(is_open)
        if source is not None and is_open:
            scaled = [] if source.open_unit in UNITS else [source.open_unit]
            self.unit.clear()
            self.unit.addItems([*UNITS, *scaled])
            self.unit.setCurrentText(source.open_unit)
            self.unit.setToolTip(f"{source.assumed}. Choose another to read the file again")
            self.unit.setAccessibleDescription(source.assumed)
        self.place.setVisible(source is not None and source.is_mesh)
        self.thumbnail.set_depth(None if source is None else source.depth)
        reason = "" if source is not None else "Choose a scan first"
        for widget in (self.remove_spikes, self.fill_gaps, self.smooth, self.scheme):
            widget.setEnabled(source is not None)
            widget.setToolTip(reason)
        self._enable()

    def set_options(self, options: Mapping[str, Any]) -> None:
        """Show options of the fit without telling anybody; names as in ``options_changed``."""
        inputs: dict[str, QCheckBox | QSpinBox | QDoubleSpinBox] = {
            "remove_spikes": self.remove_spikes, "fill_gaps": self.fill_gaps, "smooth": self.smooth,
            "spike_mm": self.spike_mm, "largest_gap_px": self.largest_gap_px,
        }  # fmt: skip
        for name, widget in inputs.items():
            if name in options:
                widget.blockSignals(True)
                if isinstance(widget, QCheckBox):
                    widget.setChecked(bool(options[name]))
                elif isinstance(widget, QSpinBox):
                    widget.setValue(round(options[name]))
                else:
                    widget.setValue(float(options[name]))
                widget.blockSignals(False)
        self._enable()

    def set_schemes(self, schemes: Sequence[tuple[str, str]]) -> None:
        """Offer schemes: (name, text), e.g. ``("closed", "closed, 20 points")``."""
        chosen = self.scheme.currentData()
        self.scheme.clear()
        for name, text in schemes:
            self.scheme.addItem(text, name)
        self.set_scheme(chosen)

    def set_scheme(self, name: str | None) -> None:
        """Show which scheme is used."""
        index = self.scheme.findData(name)
        if index >= 0:
            self.scheme.setCurrentIndex(index)

    def set_carry_sources(self, scans: Sequence[tuple[str, str]], current: str | None = None) -> None:
        """Offer scans to carry fiducials from: (id, name); ``current`` is preferred to what was chosen before."""
        chosen = current if current is not None else self.carry_source()
        self.carry_from.clear()
        for scan_id, name in scans:
            self.carry_from.addItem(name, scan_id)
        index = self.carry_from.findData(chosen)
        self.carry_from.setCurrentIndex(max(index, 0) if scans else -1)
        reason = "" if scans else "No other scan has fiducials yet"
        self.carry_from.setEnabled(bool(scans))
        self.carry_from.setToolTip(reason)
        self.carry_button.set_available(bool(scans), reason)

    def carry_source(self) -> str | None:
        """Return the id of the scan to carry from."""
        data = self.carry_from.currentData()
        return None if data is None else str(data)


class DepthThumbnail(QWidget):
    """The depth of a scan, near bright, missing pixels checked, with a line that says so."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._depth: FloatArray | None = None
        self._image: QImage | None = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        theme.fix(self, height=6 + THUMB_HEIGHT + 20)
        self.setAccessibleName("Depth, near bright")
        theme.signals.changed.connect(self.update)

    def set_depth(self, depth: FloatArray | None) -> None:
        """Show a depth image (H, W), mm."""
        if depth is not self._depth:
            self._depth, self._image = depth, None
            self.update()

    def sizeHint(self) -> QSize:
        """Return the room for picture and line."""
        return QSize(216, theme.px(6 + THUMB_HEIGHT + 20))

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw picture and line."""
        current = theme.current()
        painter = QPainter(self)
        height, line_height = theme.px(THUMB_HEIGHT), theme.px(20)
        box = QRectF(0, 6, self.width(), height)
        painter.fillRect(box, theme.overlay().colour("view_bottom"))
        if self._depth is not None:
            scale = self.devicePixelRatioF()
            size = (round(self.width() * scale), round(height * scale))
            if self._image is None or (self._image.width(), self._image.height()) != size:
                self._image = to_image(depth_thumbnail(self._depth, *size))
            painter.drawImage(box, self._image)
        painter.setFont(theme.font(theme.TABLE_PX))
        painter.setPen(current.colour("dim"))
        line = QRectF(0, 6 + height, self.width(), line_height)
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter, "depth, near bright")
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight, "missing")
        width = painter.fontMetrics().horizontalAdvance("missing")
        left, top = line.right() - width - 17, line.center().y() - 5
        for row in range(2):
            for column in range(2):
                shade = CHECK[(row + column + 1) % 2]
                painter.fillRect(QRectF(left + 5 * column, top + 5 * row, 5, 5), QColor(*shade))


def _pair(check: QCheckBox, value: QWidget | None, name: str) -> QWidget:
    row = QWidget()
    theme.fix(row, height=26)
    line = QHBoxLayout(row)
    line.setContentsMargins(0, 0, 0, 0)
    line.setSpacing(4)
    line.addWidget(check, 1)
    if value is not None:
        theme.fix(value, width=64)
        value.setAccessibleName(name)
        line.addWidget(value)
    return row


def _decimal(low: float, high: float, suffix: str) -> QDoubleSpinBox:
    box = QDoubleSpinBox()
    box.setDecimals(1)
    box.setSingleStep(0.5)
    box.setRange(low, high)
    _dress(box, suffix)
    return box


def _whole(low: int, high: int, suffix: str) -> QSpinBox:
    box = QSpinBox()
    box.setRange(low, high)
    _dress(box, suffix)
    return box


def _dress(box: QSpinBox | QDoubleSpinBox, suffix: str) -> None:
    box.setSuffix(suffix)
    box.setAlignment(Qt.AlignmentFlag.AlignRight)
    box.setKeyboardTracking(False)
    theme.fix(box, height=22)


def _side_by_side(box: QComboBox, button: QWidget) -> QWidget:
    result = QWidget()
    line = QHBoxLayout(result)
    line.setContentsMargins(0, 0, 0, 0)
    line.setSpacing(2)
    line.addWidget(box, 1)
    line.addWidget(button)
    return result
