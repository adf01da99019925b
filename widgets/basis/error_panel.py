"""The reproduction error: three bases under three bounds, and the checks that say whether they mean something."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QScrollArea, QVBoxLayout, QWidget

from widgets import theme
from widgets.basis.alpha_view import AlphaTable, AlphaView
from widgets.basis.words import DASH, count, judged
from widgets.parts.section import DimLabel
from widgets.parts.segments import Segments
from widgets.parts.tables import CheckRow, CheckTable

LEAST_HAND_RATIO, LARGEST_PCA_RATIO, LARGEST_WEIGHT, LEAST_COSINE = 3.5, 1.3, 3.0, 0.85
"""What a basis is judged by; see the tips of the checks."""


@dataclass(frozen=True)
class BasisFigures:
    """What the checks judge; None where it is not known yet.

    Parameters
    ----------
    hand_ratio : float, optional
        Alpha by hand over alpha by quasi-eigen, both in the bounds in use.
    pca_ratio : float, optional
        Alpha by quasi-eigen over alpha of free PCA.
    weight_p99 : float, optional
        99th percentile of the absolute quasi-eigen weights.
    median_cosine : float, optional
        Median over the shapes of the cosine to the hand shape.
    rank : int, optional
        Rank of W.
    shapes, axes : int
        n and m.
    """

    hand_ratio: float | None = None
    pca_ratio: float | None = None
    weight_p99: float | None = None
    median_cosine: float | None = None
    rank: int | None = None
    shapes: int = 0
    axes: int = 0


def check_rows(figures: BasisFigures) -> list[CheckRow]:
    """Return the checks as they are read, with limits and verdicts."""

    def row(name: str, value: float | None, limit: float, at_least: bool, tip: str) -> CheckRow:
        sign, known = "≥" if at_least else "≤", value is not None and value == value
        verdict = ""
        if value is not None and known:
            verdict = "ok" if (value >= limit if at_least else value <= limit) else "warn"
        return CheckRow(name, judged(value, limit, at_least), f"{sign} {limit:.2f}", verdict, tip)

    rank = "" if figures.rank is None else f"{figures.rank} / {figures.axes}"
    full = "" if figures.rank is None else "ok" if figures.rank == figures.axes else "warn"
    tip = "Axes that the shapes can reach together; fewer than there are axes means that some are missed"
    return [
        row("hand / quasi-eigen", figures.hand_ratio, LEAST_HAND_RATIO, True,
            "How many times the error by hand is that by quasi-eigen, both within the bounds in use"),
        row("quasi-eigen / PCA", figures.pca_ratio, LARGEST_PCA_RATIO, False,
            "How many times the error by quasi-eigen is that of PCA with free weights, the least possible"),
        row("weights, 99th pct |w|", figures.weight_p99, LARGEST_WEIGHT, False,
            "99 of 100 quasi-eigen weights are smaller; large ones cannot be edited by hand"),
        row("median cosine", figures.median_cosine, LEAST_COSINE, True,
            "How much the shapes still look like the hand shapes"),
        CheckRow("rank of W", rank or DASH, "", full, tip),
    ]  # fmt: skip


class ErrorPanel(QWidget):
    """Table of alpha and table of checks.

    Signals
    -------
    bounds_chosen(str)
        Key of ``words.BOUNDS``.
    statistic_chosen(str)
        ``mean`` or ``pooled``.
    """

    bounds_chosen = Signal(str)
    statistic_chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self.table = AlphaView()
        self.checks = CheckTable("check", "value")
        self.statistic = Segments([("mean", "mean of frames"), ("pooled", "pooled")], stretch=True, name="Statistic")
        self.statistic.set_tip("mean", "Mean over the frames of 100 |v* − v| / |v*| (Kim & Ko 2007, eq. 6)")
        self.statistic.set_tip("pooled", "100 times the root of all squared errors over all squared |v*|")
        self.empty = DimLabel(
            "How well hand, quasi-eigen and PCA shapes reproduce the performance appears here: "
            "open a rig and a performance."
        )
        self.origin_label = DimLabel("", theme.TABLE_PX)
        self._mask, self._frames, self._origin = "", 0, ""
        self._arrange()
        self.table.bounds_chosen.connect(self._bounds_chosen)
        self.statistic.chosen.connect(self._statistic_chosen)
        self.set_alpha(None)
        self.set_figures(None)

    def _arrange(self) -> None:
        self.empty.setWordWrap(True)
        self.empty.setContentsMargins(8, 8, 8, 8)
        self.origin_label.setWordWrap(True)
        self.origin_label.setContentsMargins(8, 4, 8, 6)
        self._inside = QWidget()
        column = QVBoxLayout(self._inside)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.empty)
        column.addWidget(self.table)
        column.addWidget(self.checks)
        self._switch = QWidget()
        row = QHBoxLayout(self._switch)
        row.setContentsMargins(8, 6, 8, 0)
        row.addWidget(self.statistic)
        column.addWidget(self._switch)
        column.addWidget(self.origin_label)
        column.addStretch(1)
        self._area = area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setWidget(self._inside)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(area)

    @property
    def note(self) -> str:
        """What stands beside the dock's name: mask, statistic and frames; failed checks where those are out of view."""
        if not self._frames or self.table.isHidden():
            return ""
        failed = sum(row.verdict == "warn" for row in self.checks.rows)
        second_check = self.checks.y() + theme.px(22 + 2 * 20)
        if failed and self.isVisible() and self._area.viewport().height() < second_check:
            return f"{failed} of {len(self.checks.rows)} checks fail"
        return f"{self._mask}, {self.statistic.current} of {count(self._frames)}"

    @property
    def bounds(self) -> str:
        """Key of the bounds in use."""
        return self.table.bounds

    def set_alpha(self, alpha: AlphaTable | None) -> None:
        """Show errors in %, or that there are none yet."""
        self.table.set_alpha(alpha)
        for widget in (self.table, self._switch, self.origin_label):
            widget.setVisible(alpha is not None)
        self.empty.setVisible(alpha is None)

    def set_bounds(self, bounds: str) -> None:
        """Mark the bounds in use without telling anybody."""
        self.table.set_bounds(bounds)

    def set_statistic(self, statistic: str) -> None:
        """Show ``mean`` or ``pooled`` without telling anybody."""
        self.statistic.set_current(statistic)
        self.table.set_statistic(statistic)

    def set_measure(self, mask: str, frames: int, origin: str = "centroid of the neutral face") -> None:
        """Name the vertices and frames that are measured, and the origin of |v*|."""
        self._mask, self._frames, self._origin = mask, frames, origin
        self.origin_label.setText(f"Over {mask}; |v*| from the {origin}. PCA: 1 unit = 1 std. dev.")

    def set_figures(self, figures: BasisFigures | None) -> None:
        """Judge the basis."""
        self.checks.set_rows([] if figures is None else check_rows(figures))
        self.checks.setVisible(figures is not None)

    def _bounds_chosen(self, bounds: str) -> None:
        self.bounds_chosen.emit(bounds)

    def _statistic_chosen(self, statistic: str) -> None:
        self.table.set_statistic(statistic)
        self.statistic_chosen.emit(statistic)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(theme.px(296), theme.px(216))

    def minimumSizeHint(self) -> QSize:
        """Return the room for two lines: the rest scrolls."""
        return QSize(theme.px(232), theme.px(2 * 22))
