"""The content of the import dialog: the picture with the file's points, the table, and how the file is understood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from widgets import theme
from widgets.canvases.point_canvas import PointCanvas
from widgets.parts.buttons import KeyButton
from widgets.parts.command_line import CommandLine
from widgets.parts.section import DimLabel
from widgets.parts.segments import Segments
from widgets.scan.mapping_table import MappingRow, MappingTable

WIDTH, HEIGHT, SIDE = 1120, 700, 416
OWN = "own"
"""The key of a mapping that is no shipped one."""

_LARGEST_SIDE = 100_000


@dataclass(frozen=True)
class MappingChoice:
    """What can be chosen besides the points: keys with texts, and what is chosen now.

    ``groups`` are those of the file; ``origin`` is None where points lie in space; ``size`` is the picture the points
    were placed on, ``size_known`` whether the file says it.
    """

    mappings: Sequence[tuple[str, str]] = ()
    mapping: str = ""
    groups: Sequence[str] = ("",)
    group: str = ""
    origin: float | None = 0.0
    scale: bool = False
    size: tuple[int, int] = (1, 1)
    size_known: bool = False


@dataclass(frozen=True)
class MappingReport:
    """What is said below the table: ``lines`` of remarks, ``warning`` what looks wrong, ``problem`` what was refused.

    ``count`` fiducials would be imported.
    """

    count: int = 0
    lines: Sequence[str] = field(default=())
    warning: str = ""
    problem: str = ""


class MappingPanel(QWidget):
    """Values in, wishes out: the dialog's owner computes what they mean.

    Signals
    -------
    edited(str, str)
        A fiducial, and the points typed for it.
    point_clicked(int)
        A point of the file that the selected fiducial is to be.
    chosen(str)
        The fiducial whose row is selected.
    mapping_chosen(str), group_chosen(str), origin_chosen(float), scale_chosen(bool, int, int)
        How the file is to be understood.
    open_requested(), save_requested(), accepted(str), rejected()
        Open or save a mapping; import as ``placed`` or ``proposed``; think better of it.
    """

    edited = Signal(str, str)
    point_clicked = Signal(int)
    chosen = Signal(str)
    mapping_chosen = Signal(str)
    group_chosen = Signal(str)
    origin_chosen = Signal(float)
    scale_chosen = Signal(bool, int, int)
    open_requested = Signal()
    save_requested = Signal()
    accepted = Signal(str)
    rejected = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._showing = False
        self._groups: tuple[str, ...] = ()
        self.canvas = PointCanvas()
        self.mapping = QComboBox()
        self.mapping.setAccessibleName("Mapping")
        self.open_button, self.save_button = QPushButton("&Open..."), QPushButton("&Save...")
        self.open_button.setToolTip("Open a mapping (.toml or .json)")
        self.save_button.setToolTip("Save this table as a mapping")
        self.group = QComboBox()
        self.group.setAccessibleName("Group")
        self.origin = Segments([("0", "0"), ("0.5", "1/2"), ("1", "1")], name="First pixel")
        self.origin.setToolTip("What the file calls the centre of the top left pixel")
        self.scale = QCheckBox("Scale f&rom")
        self.scale.setToolTip("The points were placed on the same picture at another size")
        self.across, self.down = QSpinBox(), QSpinBox()
        for box, name in ((self.across, "Width of the other picture"), (self.down, "Height of the other picture")):
            box.setRange(1, _LARGEST_SIDE)
            box.setKeyboardTracking(False)
            box.setAccessibleName(name)
            theme.fix(box, 64)
        self.table = MappingTable()
        self.note = DimLabel("", theme.TABLE_PX)
        self.note.setWordWrap(True)
        self.report = DimLabel("", theme.TABLE_PX, role="text")
        self.report.setWordWrap(True)
        self.alarm = DimLabel("", theme.TABLE_PX, role="captured")
        self.alarm.setWordWrap(True)
        self.alarm.hide()
        self.command = CommandLine()
        self.state = Segments([("placed", "Placed"), ("proposed", "Proposed")], name="Import as")
        self.cancel = KeyButton("Cancel", "Esc")
        self.accept = KeyButton("Import fiducials", primary=True)
        self.accept.setDefault(True)
        self._lay_out()
        self._connect()
        theme.signals.changed.connect(self._dress)
        self._dress()

    # What is shown ------------------------------------------------------------------------------------------------

    def show_choice(self, choice: MappingChoice) -> None:
        """Show what can be chosen and what is."""
        self._showing = True
        self.mapping.clear()
        for key, text in choice.mappings:
            self.mapping.addItem(text, key)
        self.mapping.setCurrentIndex(max(0, self.mapping.findData(choice.mapping)))
        if self._groups != tuple(choice.groups):
            self._groups = tuple(choice.groups)
            self.group.clear()
            self.group.addItems(list(choice.groups))
        self.group.setCurrentIndex(max(0, self.group.findText(choice.group, Qt.MatchFlag.MatchExactly)))
        self.group.setVisible(len(choice.groups) > 1)
        self._group_label.setVisible(len(choice.groups) > 1)
        flat: tuple[QWidget, ...] = (self.origin, self._origin_label, self.scale, self._size)
        for widget in flat:
            widget.setVisible(choice.origin is not None)
        if choice.origin is not None:
            self.origin.set_current(f"{choice.origin:g}")
        self.scale.setChecked(choice.scale)
        self.across.setValue(choice.size[0])
        self.down.setValue(choice.size[1])
        for box in (self.across, self.down):
            box.setEnabled(choice.scale and not choice.size_known)
        self._showing = False

    def show_rows(self, rows: Sequence[MappingRow], note: str) -> None:
        """Show the table, and what its mapping has to say."""
        self.table.set_rows(rows)
        self.note.setText(note)
        self.note.setVisible(bool(note))

    def show_report(self, report: MappingReport) -> None:
        """Say what the import would bring, or why it cannot be."""
        self.alarm.set_role("captured" if report.problem else "stale_text")
        self.alarm.setText(report.problem or report.warning)
        self.alarm.setVisible(bool(self.alarm.text()))
        self.report.setText("\n".join(report.lines))
        text = "Import 1 fiducial" if report.count == 1 else f"Import {report.count} fiducials"
        self.accept.setText(text)
        self.accept.setAccessibleName(text)
        self.accept.updateGeometry()
        reason = "" if report.count else report.problem or "no fiducial has a point on the picture"
        self.accept.set_available(not reason, reason)

    # Inside -------------------------------------------------------------------------------------------------------

    def _lay_out(self) -> None:
        form = QGridLayout()
        form.setHorizontalSpacing(8)
        form.setVerticalSpacing(8)
        form.setColumnStretch(1, 1)
        labels = [QLabel(text) for text in ("&Mapping", "&Group", "First pi&xel")]
        for label, buddy in zip(labels, (self.mapping, self.group, self.origin), strict=True):
            label.setBuddy(buddy)
        mapping_label, self._group_label, self._origin_label = labels
        line = QHBoxLayout()
        line.setSpacing(8)
        line.addWidget(self.mapping, 1)
        line.addWidget(self.open_button)
        line.addWidget(self.save_button)
        form.addWidget(mapping_label, 0, 0)
        form.addLayout(line, 0, 1)
        form.addWidget(self._group_label, 1, 0)
        form.addWidget(self.group, 1, 1)
        self._size = QWidget()
        size = QHBoxLayout(self._size)
        size.setContentsMargins(0, 0, 0, 0)
        size.setSpacing(4)
        for widget in (self.across, QLabel("x"), self.down):
            size.addWidget(widget)
        last = QHBoxLayout()
        last.setSpacing(8)
        last.addWidget(self.origin)
        last.addStretch(1)
        last.addWidget(self.scale)
        last.addWidget(self._size)
        form.addWidget(self._origin_label, 2, 0)
        form.addLayout(last, 2, 1)
        side = QVBoxLayout()
        side.setSpacing(8)
        side.addLayout(form)
        side.addWidget(self.table, 1)
        side.addWidget(self.note)
        side.addWidget(self.alarm)
        side.addWidget(self.report)
        self._side = QWidget()
        side.setContentsMargins(0, 0, 0, 0)
        self._side.setLayout(side)
        middle = QHBoxLayout()
        middle.setSpacing(16)
        middle.addWidget(self.canvas, 1)
        middle.addWidget(self._side)
        foot = QHBoxLayout()
        foot.setSpacing(8)
        foot.addWidget(self.command, 1)
        foot.addSpacing(16)
        foot.addWidget(self.state)
        foot.addWidget(self.cancel)
        foot.addWidget(self.accept)
        box = QVBoxLayout(self)
        box.setContentsMargins(16, 16, 16, 16)
        box.setSpacing(16)
        box.addLayout(middle, 1)
        box.addLayout(foot)
        order = (
            self.mapping, self.open_button, self.save_button, self.group, self.origin, self.scale, self.across,
            self.down, self.table, self.canvas, self.command.field, self.command.button, self.state, self.cancel,
            self.accept,
        )  # fmt: skip
        for first, second in pairwise(order):
            QWidget.setTabOrder(first, second)

    def _connect(self) -> None:
        self.table.edited.connect(self.edited)
        self.table.chosen.connect(self.chosen)
        self.canvas.point_clicked.connect(self.point_clicked)
        self.mapping.activated.connect(lambda row: self.mapping_chosen.emit(str(self.mapping.itemData(row))))
        self.group.activated.connect(lambda row: self.group_chosen.emit(self.group.itemText(row)))
        self.origin.chosen.connect(lambda key: self.origin_chosen.emit(float(key)))
        self.scale.toggled.connect(self._tell_scale)
        self.across.valueChanged.connect(self._tell_scale)
        self.down.valueChanged.connect(self._tell_scale)
        self.open_button.clicked.connect(self.open_requested)
        self.save_button.clicked.connect(self.save_requested)
        self.cancel.clicked.connect(self.rejected)
        self.accept.clicked.connect(lambda: self.accepted.emit(self.state.current))

    def _tell_scale(self) -> None:
        if not self._showing:
            self.scale_chosen.emit(self.scale.isChecked(), self.across.value(), self.down.value())

    def _dress(self) -> None:
        self._side.setFixedWidth(theme.px(SIDE))
