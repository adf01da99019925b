"""How well the face fits its scan: level of detail, figures with limits and verdicts, fit and export."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QVBoxLayout, QWidget

from widgets.parts.buttons import KeyButton
from widgets.parts.section import DimLabel
from widgets.parts.segments import Segments
from widgets.parts.tables import CheckRow, CheckTable

LEVELS = 4


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
        """``mm``, ``px``, ``deg``, or empty for a count."""

    @property
    def limit(self) -> float | None:
        """What it must not exceed."""

    @property
    def verdict(self) -> str | None:
        """``ok``, ``warn``, ``fail``, or nothing where there is no limit."""


WORDS = {
    "median_mm": ("median", "Half of the visible vertices lie nearer to the scan"),
    "p95_mm": ("95th percentile", "95 of 100 visible vertices lie nearer to the scan"),
    "p99_mm": ("99th percentile", "99 of 100 visible vertices lie nearer to the scan"),
    "max_mm": ("largest", "The visible vertex that lies farthest from the scan"),
    "filled_p95_mm": ("filled, 95th percentile", "Vertices in gaps of the scan, against the truth where it is known"),
    "vertices": ("vertices", "Vertices of the face"),
    "faces": ("triangles", "Triangles of the face"),
    "filled_vertices": ("filled vertices", "Vertices that lie in gaps of the scan and were filled in"),
    "filled_fraction": ("share filled", "Share of the vertices that were filled in"),
    "folded_faces": ("folded triangles", "Triangles that turned over; look at the fiducials beside them"),
    "fiducial_residual_px": ("fiducial residual, px", "How far the template is from the fiducials; 0 when exact"),
    "min_angle_deg": ("smallest angle, °", "The thinnest triangle; below 5° shading suffers"),
}
"""Figure name -> what is read, what it means."""


class FitPanel(QWidget):
    """Level, figures and the two actions.

    Signals
    -------
    level_changed(int)
        Level of subdivision 0..3.
    fit_requested(), export_requested()
        The buttons.
    """

    level_changed = Signal(int)
    fit_requested = Signal()
    export_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.levels = Segments([(str(k), str(k)) for k in range(LEVELS)], stretch=True, name="Level of detail")
        for k in range(LEVELS):
            parts = f"each triangle in {4**k} parts" if k else "the template itself"
            self.levels.set_tip(str(k), f"Level {k}: {parts}")
        self.to_scan = CheckTable("to scan", "mm")
        self.mesh = CheckTable("mesh", "count")
        self.fit_button = KeyButton("Fit", "Ctrl+Enter")
        self.export_button = KeyButton("Export face…")
        self.empty_label = DimLabel("Figures appear here after a fit: place the fiducials, then press Fit.")
        self.empty_label.setWordWrap(True)
        self._arrange()
        self.levels.chosen.connect(lambda key: self.level_changed.emit(int(key)))
        self.fit_button.clicked.connect(self.fit_requested)
        self.export_button.clicked.connect(self.export_requested)
        self.set_checks(None)

    def _arrange(self) -> None:
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 6, 0, 8)
        column.setSpacing(0)
        top = QHBoxLayout()
        top.setContentsMargins(8, 0, 8, 6)
        top.setSpacing(0)
        label = DimLabel("Level")
        label.setFixedWidth(72)
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
        column.addWidget(self.to_scan)
        column.addSpacing(4)
        column.addWidget(self.mesh)
        column.addStretch(1)
        buttons = QHBoxLayout()
        buttons.setContentsMargins(8, 8, 8, 0)
        buttons.setSpacing(4)
        for button in (self.fit_button, self.export_button):
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            buttons.addWidget(button, 1)
        column.addLayout(buttons)

    def set_level(self, level: int) -> None:
        """Show a level without telling anybody."""
        self.levels.set_current(str(level))

    def set_checks(self, checks: Sequence[Figure] | None) -> None:
        """Show figures in two tables: those in mm, and those of the mesh; ``None`` while there is no fit."""
        there = checks is not None
        self.to_scan.setVisible(there)
        self.mesh.setVisible(there)
        self._empty.setVisible(not there)
        self.to_scan.set_rows([_row(c) for c in checks or () if c.unit == "mm"])
        self.mesh.set_rows([_row(c) for c in checks or () if c.unit != "mm"])

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
    words, tip = WORDS.get(check.name, (check.name.replace("_", " "), ""))
    limit = "" if check.limit is None else _number(check.limit, check.unit)
    return CheckRow(words, _number(check.value, check.unit), limit, str(check.verdict or ""), tip)


def _number(value: float, unit: str) -> str:
    if value != value:
        return "–"
    if unit == "mm":
        return f"{value:.2f}"
    if unit in ("px", "deg"):
        return f"{value:.1f}" if abs(value) >= 0.05 or value == 0 else f"{value:.0e}"
    if float(value).is_integer():
        return f"{int(value):,}".replace(",", "\u2009")
    return f"{value:.3f}"
