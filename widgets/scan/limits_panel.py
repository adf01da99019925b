"""What fits are judged by, to be edited: limits of the whole face, and warn and fail for every region's figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QAbstractItemModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDoubleSpinBox,
    QGridLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from engine.errors import InputError
from engine.scan.limits import FIGURES, LARGEST, Bounds, Limits, RegionLimits
from widgets import theme
from widgets.parts.section import DimLabel
from widgets.parts.tables import VERDICT_ROLES
from widgets.scan.region_table import WORDS

FACE = (
    ("median_mm", "Median, mm", 3, 1.0),
    ("p99_mm", "99th percentile, mm", 3, 1.0),
    ("max_mm", "Largest, mm", 3, 1.0),
    ("noise_mm", "Scan noise, mm", 3, 1.0),
    ("filled_fraction", "Filled, %", 1, 100.0),
    ("folded_faces", "Folded triangles", 0, 1.0),
    ("tolerance", "Fail from, times the limit", 1, 1.0),
)
"""Field of ``Limits``, what it is called, decimals, and what one is multiplied with to be shown."""

_HEADS = {"median_mm": "median, mm", "p95_mm": "95th pct., mm", "max_mm": "largest, mm", "filled_fraction": "filled, %"}
_SHARE = {"filled_fraction": 100.0}


GIVEN = Qt.ItemDataRole.UserRole
"""Where a cell keeps its text as it was given, and the value that stands for."""

Index = QModelIndex | QPersistentModelIndex


class LimitsPanel(QWidget):
    """Spin boxes for the whole face over a table of the regions; beside each region the verdict of the present scan.

    Signals
    -------
    changed()
        A value was edited.
    import_requested(), export_requested(), default_requested(), accepted(), rejected()
        The buttons.
    """

    changed = Signal()
    import_requested = Signal()
    export_requested = Signal()
    default_requested = Signal()
    accepted = Signal()
    rejected = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._names: tuple[str, ...] = ()
        self._filling = False
        self._base = Limits()
        self._given: dict[str, tuple[float, float]] = {}
        self.face: dict[str, QDoubleSpinBox] = {}
        self.table = QTableWidget(self)
        self.table.setColumnCount(2 + 2 * len(FIGURES))
        heads = [_HEADS[name].replace(",", f"\n{end},") for name in FIGURES for end in ("warn", "fail")]
        self.table.setHorizontalHeaderLabels(["region\n", *heads, "this scan\n"])
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(theme.px(24))
        self.table.setItemDelegate(_NumberDelegate(self.table))
        self.table.setAlternatingRowColors(True)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.AllEditTriggers)
        self.table.setTabKeyNavigation(False)
        self.table.setAccessibleName("Limits of the regions")
        self.table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.table.itemChanged.connect(self._edited)
        self.trouble = QLabel("")
        self.trouble.setWordWrap(True)
        self.overall = QLabel("")
        self.reset_button = QPushButton("&Reset")
        self.reset_button.setToolTip("Go back to the limits as they come with the program")
        self.default_button = QPushButton("Save as my &default")
        self.default_button.setToolTip("Begin new projects with these limits")
        self.import_button, self.export_button = QPushButton("&Import\u2026"), QPushButton("E&xport\u2026")
        self.cancel_button, self.apply_button = QPushButton("Cancel"), QPushButton("&Apply")
        self.apply_button.setProperty("primary", True)
        self._arrange()
        self.reset_button.clicked.connect(lambda: self.set_limits(Limits(), self._names, tell=True))
        self.import_button.clicked.connect(self.import_requested)
        self.export_button.clicked.connect(self.export_requested)
        self.default_button.clicked.connect(self.default_requested)
        self.cancel_button.clicked.connect(self.rejected)
        self.apply_button.clicked.connect(self.accepted)

    def _arrange(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 16, 16, 16)
        column.setSpacing(8)
        column.addWidget(DimLabel("Whole face: above a limit is a warning, above its multiple a failure", bold=True))
        grid = QGridLayout()
        grid.setHorizontalSpacing(16)
        grid.setVerticalSpacing(4)
        for k, (name, text, decimals, share) in enumerate(FACE):
            box = QDoubleSpinBox()
            box.setDecimals(decimals)
            box.setRange(1.0 if name == "tolerance" else 0.0, 100.0 if share > 1 else LARGEST)
            box.setSingleStep(10.0**-decimals if decimals < 3 else 0.01)
            box.setKeyboardTracking(True)
            box.setAccessibleName(text)
            box.valueChanged.connect(self._edited)
            label = QLabel(text)
            label.setBuddy(box)
            grid.addWidget(label, k // 4 * 2, k % 4)
            grid.addWidget(box, k // 4 * 2 + 1, k % 4)
            self.face[name] = box
        column.addLayout(grid)
        column.addSpacing(8)
        column.addWidget(DimLabel("Regions: above warn is a warning, above fail a failure", bold=True))
        column.addWidget(self.table, 1)
        column.addWidget(self.overall)
        column.addWidget(self.trouble)
        buttons = QHBoxLayout()
        buttons.setSpacing(8)
        for button in (self.import_button, self.export_button, self.default_button, self.reset_button):
            button.setAutoDefault(False)
            buttons.addWidget(button)
        buttons.addStretch(1)
        self.cancel_button.setAutoDefault(False)
        self.apply_button.setDefault(True)
        buttons.addWidget(self.cancel_button)
        buttons.addWidget(self.apply_button)
        column.addLayout(buttons)

    def set_limits(self, limits: Limits, names: Sequence[str], *, tell: bool = False) -> None:
        """Show limits for the regions ``names``."""
        self._filling = True
        self._base = limits
        for name, _text, _decimals, share in FACE:
            given, box = float(getattr(limits, name)), self.face[name]
            box.setValue(given * share)
            self._given[name] = box.value(), given
        if tuple(names) != self._names:
            self._names = tuple(names)
            self.table.setRowCount(len(self._names))
        for row, region in enumerate(self._names):
            self._put(row, 0, region, editable=False)
            for k, figure in enumerate(FIGURES):
                bounds, share = getattr(limits.region(region), figure), _SHARE.get(figure, 1.0)
                for column, value in ((1 + 2 * k, bounds.warn), (2 + 2 * k, bounds.fail)):
                    text = f"{share * value:.4g}"
                    self._put(row, column, text).setData(GIVEN, (text, value))
        self._filling = False
        if tell:
            self._edited()

    def limits(self) -> Limits:
        """Return the limits as they are shown; what was not edited is what was given, to the last digit.

        Raises
        ------
        InputError
            Naming the region and figure whose failure comes before its warning.
        """
        regions = dict(self._base.regions)
        for row, region in enumerate(self._names):
            bounds = {}
            for k, figure in enumerate(FIGURES):
                share = _SHARE.get(figure, 1.0)
                warn, fail = (self._number(row, 1 + 2 * k + end, share) for end in (0, 1))
                try:
                    bounds[figure] = Bounds(warn, fail)
                except InputError as error:
                    head = _HEADS[figure].split(",")[0]
                    problem = f"{error.subject} {error.problem}" if error.subject == "fail" else error.problem
                    raise InputError(f"{region}, {head}", problem, error.remedy) from None
            found = RegionLimits(**bounds)
            if found != self._base.region(region):
                regions[region] = found
        values = {name: self._face_value(name, share) for name, _text, _decimals, share in FACE}
        folded = round(values.pop("folded_faces"))
        return Limits(**values, folded_faces=folded, regions=regions)

    def show_verdicts(self, verdicts: Mapping[str, str], overall: str) -> None:
        """Show what the present scan would be judged; empty without a fit."""
        self._filling = True
        for row, region in enumerate(self._names):
            verdict = verdicts.get(region, "")
            item = self._put(row, 1 + 2 * len(FIGURES), WORDS.get(verdict, "\u2013"), editable=False)
            item.setForeground(QColor(getattr(theme.current(), VERDICT_ROLES.get(verdict, "dim"))))
        self._filling = False
        self.overall.setText(overall)

    def show_trouble(self, problem: str) -> None:
        """Say what is wrong with the values; empty when nothing is."""
        self.trouble.setText(problem)
        self.trouble.setStyleSheet(f"color: {theme.current().captured}")
        for button in (self.apply_button, self.export_button, self.default_button):
            button.setEnabled(not problem)

    def _put(self, row: int, column: int, text: str, *, editable: bool = True) -> QTableWidgetItem:
        item = self.table.item(row, column)
        if item is None:
            item = QTableWidgetItem()
            if not editable:
                item.setFlags(Qt.ItemFlag.ItemIsEnabled)
            else:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.table.setItem(row, column, item)
        item.setText(text)
        return item

    def _face_value(self, name: str, share: float) -> float:
        value = self.face[name].value()
        shown, given = self._given.get(name, (value, value / share))
        return given if value == shown else value / share

    def _number(self, row: int, column: int, share: float) -> float:
        item = self.table.item(row, column)
        text, kept = ("", None) if item is None else (item.text(), item.data(GIVEN))
        if kept is not None and kept[0] == text:
            return float(kept[1])
        try:
            return float(text.replace(",", ".")) / share
        except ValueError:
            return float("nan")

    def _edited(self, *_values: object) -> None:
        if not self._filling:
            self.changed.emit()


class _NumberDelegate(QStyledItemDelegate):
    """Edits a cell with a spin box."""

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, _index: Index) -> QWidget:
        """Return the spin box of a cell."""
        box = QDoubleSpinBox(parent)
        box.setDecimals(3)
        box.setRange(0.0, LARGEST)
        box.setSingleStep(0.01)
        box.setFrame(False)
        box.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        return box

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        """Show the cell's value."""
        if isinstance(editor, QDoubleSpinBox):
            editor.setValue(float(str(index.data() or "0")))
            editor.setProperty("shown", editor.value())
            editor.selectAll()

    def setModelData(self, editor: QWidget, model: QAbstractItemModel, index: Index) -> None:
        """Take the value over."""
        if isinstance(editor, QDoubleSpinBox):
            editor.interpretText()
            if editor.value() != editor.property("shown"):  # the editor shows fewer digits than there may be
                model.setData(index, f"{editor.value():.6g}")
