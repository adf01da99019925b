"""How well the face fits its scan: level of detail, figures with limits and verdicts, fit and export."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton, QScrollArea, QSizePolicy, QVBoxLayout, QWidget

from engine.scan.region_names import MEANING
from widgets import theme
from widgets.parts.buttons import KeyButton
from widgets.parts.section import DimLabel
from widgets.parts.segments import Segments
from widgets.parts.tables import CheckRow, CheckTable
from widgets.scan.region_table import Region, RegionTable

LEVELS = 4
FIGURES_PX = 232
"""Height of the figures beyond which they scroll where the panel is low."""


class Figure(Protocol):
    """A measured value as the engine's quality report gives it."""

    @property
    def name(self) -> str:
        """Which figure."""

    @property
    def value(self) -> float:
        """Its value in ``unit``."""

    @property
    def unit(self) -> str:
        """``mm``, ``count``, ``%``, ``degrees`` or ``px``."""

    @property
    def limit(self) -> float | None:
        """What it must not exceed."""

    @property
    def verdict(self) -> str | None:
        """``ok``, ``warn``, ``fail``, or nothing where there is no limit."""


TIPS = {
    "median": "Half of the measured vertices lie nearer to the scan",
    "95th percentile": "95 of 100 measured vertices lie nearer to the scan",
    "99th percentile": "99 of 100 measured vertices lie nearer to the scan",
    "largest": "The measured vertex that lies farthest from the scan",
    "scan noise": "How far neighbouring pixels of the scan scatter; no fit can be truer than its scan",
    "vertices": "Vertices of the face",
    "filled vertices": "Vertices in gaps of the scan, filled in from what surrounds them",
    "folded triangles": "Triangles that turned over; look at the fiducials beside them",
    "smallest angle": "The sharpest corner of any triangle",
}
"""Figure name -> what it means."""

SIGNS = {"mm": "", "count": "", "": "", "%": ", %", "degrees": ", °", "px": ", px"}
"""Unit -> what the name is given where the header does not say it."""


class FitPanel(QWidget):
    """Level, figures and the two actions.

    Signals
    -------
    level_changed(int)
        Level of subdivision 0..3.
    fit_requested(), export_requested(), limits_requested()
        The buttons.
    """

    level_changed = Signal(int)
    limits_requested = Signal()
    fit_requested = Signal()
    export_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.levels = Segments([(str(k), str(k)) for k in range(LEVELS)], stretch=True, name="Level of detail")
        for k in range(LEVELS):
            parts = f"each triangle in {4**k} parts" if k else "the template itself"
            self.levels.set_tip(str(k), f"Level {k}: {parts}")
        self.to_scan = CheckTable("to scan", "mm")
        self.mesh = CheckTable("mesh", "count")
        self.regions = RegionTable()
        self.regions.set_meaning(MEANING)
        self.limits_button = QPushButton("Limits…")
        self.limits_button.setToolTip("Say what passes, warns and fails")
        self.limits_button.clicked.connect(self.limits_requested)
        self.fit_button = KeyButton("Fit", "Ctrl+Enter")
        self.export_button = KeyButton("Export face…")
        self.empty_label = DimLabel("Figures appear here after a fit: place the fiducials, then press Fit.")
        self.empty_label.setWordWrap(True)
        self._arrange()
        self.levels.chosen.connect(lambda key: self.level_changed.emit(int(key)))
        self.fit_button.clicked.connect(self.fit_requested)
        self.export_button.clicked.connect(self.export_requested)
        self.set_level(2)
        self.set_checks(None)

    def _arrange(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 6, 0, 8)
        column.setSpacing(0)
        top = QHBoxLayout()
        top.setContentsMargins(8, 0, 8, 6)
        top.setSpacing(0)
        label = DimLabel("Level")
        theme.fix(label, width=72)
        label.setBuddy(self.levels)
        top.addWidget(label)
        top.addWidget(self.levels, 1)
        column.addLayout(top)
        self._empty = QWidget()
        inside = QVBoxLayout(self._empty)
        inside.setContentsMargins(8, 8, 8, 8)
        inside.addWidget(self.empty_label)
        self._empty.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Maximum)
        column.addWidget(self._empty)
        self._area = self._tables()
        column.addWidget(self._area, 1)
        buttons = QHBoxLayout()
        buttons.setContentsMargins(8, 8, 8, 0)
        buttons.setSpacing(4)
        for button in (self.fit_button, self.export_button, self.limits_button):
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            buttons.addWidget(button, 1)
        column.addLayout(buttons)

    def _tables(self) -> QScrollArea:
        self._figures = QWidget()
        column = QVBoxLayout(self._figures)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.to_scan)
        column.addWidget(self.regions)
        column.addWidget(self.mesh)
        column.addStretch(1)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setWidget(self._figures)
        return area

    def set_level(self, level: int) -> None:
        """Show a level without telling anybody."""
        self.levels.set_current(str(level))

    def set_checks(self, checks: Sequence[Figure] | None) -> None:
        """Show figures in two tables: those in mm, and those of the mesh; ``None`` while there is no fit."""
        there = checks is not None
        self.to_scan.setVisible(there)
        self.mesh.setVisible(there)
        self.regions.setVisible(there and bool(self.regions.rows))
        self._empty.setVisible(not there)
        self.to_scan.set_rows([_row(c) for c in checks or () if c.unit == "mm"])
        self.mesh.set_rows([_row(c) for c in checks or () if c.unit != "mm"])
        self._area.setMinimumHeight(min(self._figures.sizeHint().height(), FIGURES_PX) if there else 0)

    def set_regions(self, regions: Sequence[Region]) -> None:
        """Show the figures of the regions of the face; none while there is no fit."""
        self.regions.set_rows(regions)
        self.regions.setVisible(bool(regions))

    def set_fit_available(self, available: bool, reason: str = "") -> None:
        """Allow to fit, or say why not."""
        self.fit_button.set_available(available, reason)

    def set_export_available(self, available: bool, reason: str = "") -> None:
        """Allow to export, or say why not."""
        self.export_button.set_available(available, reason)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(296, 312)


def _row(check: Figure) -> CheckRow:
    limit = "" if check.limit is None else _number(check.limit, check.unit)
    name = check.name + SIGNS.get(check.unit, f", {check.unit}")
    return CheckRow(name, _number(check.value, check.unit), limit, str(check.verdict or ""), TIPS.get(check.name, ""))


def _number(value: float, unit: str) -> str:
    if value != value:
        return "–"
    if unit == "mm":
        return f"{value:.2f}"
    if unit in ("count", ""):
        return f"{round(value):,}".replace(",", "\u00a0")
    return f"{value:.1f}"
