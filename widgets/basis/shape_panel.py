"""One shape between its hand shape and its quasi-eigen form."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from widgets import theme
from widgets.basis.shapes_table import COSINE_LIMIT
from widgets.basis.words import DASH, figure, judged
from widgets.canvases.plot import advance
from widgets.parts.section import DimLabel
from widgets.parts.tables import CheckRow, CheckTable
from widgets.parts.value_slider import ValueSlider


@dataclass(frozen=True)
class ShapeFacts:
    """Figures of a shape.

    Parameters
    ----------
    name : str
    amount : float
        0 the hand shape, 1 the quasi-eigen one.
    change_mm : float, optional
        RMS distance from the hand shape in mm, at this amount.
    residual_mm : float, optional
        RMS of what the axes cannot show of the hand shape, mm.
    residual_fraction : float, optional
        The same as a share of the shape's size, 0..1.
    cosine : float, optional
        Between the hand shape and the one in use.
    """

    name: str
    amount: float = 1.0
    change_mm: float | None = None
    residual_mm: float | None = None
    residual_fraction: float | None = None
    cosine: float | None = None


class ShapePanel(QWidget):
    """Slider hand .. quasi-eigen and the figures of a shape.

    Signals
    -------
    amount_dragged(float)
        While the slider moves.
    amount_set(float)
        When it is let go, or moved by keys or typed.
    """

    amount_dragged = Signal(float)
    amount_set = Signal(float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self._facts: ShapeFacts | None = None
        self._count = 1
        self._limit = COSINE_LIMIT
        self.slider = ValueSlider(0.0, 1.0, 0.0, 0.05, "Amount of the quasi-eigen shape", reset=1.0)
        self.slider.setToolTip(_TIP)
        self.number = DimLabel("", role="text")
        self._alpha: tuple[float, float | None] | None = None
        self.table = CheckTable("to hand", "value")
        self.empty = DimLabel("Choose a shape at the left to see how far its quasi-eigen form goes from it.")
        self._arrange()
        self.slider.dragged.connect(self._dragged)
        self.slider.released.connect(self._released)
        theme.signals.changed.connect(self._fit)
        self.set_shape(None)

    def _arrange(self) -> None:
        self.empty.setWordWrap(True)
        self.empty.setContentsMargins(8, 8, 8, 8)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self._line = QWidget()
        row = QHBoxLayout(self._line)
        row.setContentsMargins(8, 8, 8, 2)
        row.setSpacing(8)
        row.addWidget(DimLabel("hand"))
        row.addWidget(self.slider, 1)
        row.addWidget(DimLabel("quasi-eigen"))
        row.addWidget(self.number)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.empty)
        column.addWidget(self._line)
        column.addWidget(self.table)
        column.addStretch(1)
        self._fit()

    def _fit(self) -> None:
        self.number.setMinimumWidth(advance("0.00", theme.CONTROL_PX) + 2)

    @property
    def note(self) -> str:
        """What stands beside the dock's name: the shape, or how many are meant."""
        if self._facts is None:
            return ""
        return self._facts.name if self._count == 1 else f"{self._facts.name} and {self._count - 1} more"

    @property
    def amount(self) -> float:
        """Where the slider stands."""
        return self.slider.value

    def set_shape(self, facts: ShapeFacts | None, count: int = 1) -> None:
        """Show a shape; ``count`` says how many marked shapes the slider moves together."""
        self._facts, self._count = facts, max(1, count)
        for widget in (self._line, self.table):
            widget.setVisible(facts is not None)
        self.empty.setVisible(facts is None)
        if facts is not None:
            self.slider.set_value(facts.amount)
            self._show_amount(self.slider.value)
            self._judge()

    def set_cosine_limit(self, limit: float) -> None:
        """Judge the cosine by another limit."""
        self._limit = limit
        self._judge()

    def set_live_alpha(self, mean: float | None, pooled: float | None = None) -> None:
        """Show the reproduction error in % that the slider's place would give; ``None`` when it is not known."""
        self._alpha = None if mean is None else (mean, pooled)
        self._judge()

    def set_available(self, available: bool, reason: str = "") -> None:
        """Allow to move the slider, or say why not."""
        self.slider.setEnabled(available)
        self.slider.setToolTip(_TIP if available or not reason else reason)
        self._show_amount(self.slider.value)

    def _show_amount(self, amount: float) -> None:
        """Show the amount; none while the slider cannot be moved, for there is no quasi-eigen shape yet."""
        self.number.setText(f"{amount:.2f}" if self.slider.isEnabled() else DASH)

    def _judge(self) -> None:
        facts = self._facts
        if facts is None:
            return
        rows: list[CheckRow] = []
        if self._alpha is not None:
            mean, pooled = self._alpha
            tip = "Reproduction error of the performance with the shapes as they are, mean of the frames"
            tip += "" if pooled is None else f"; pooled {figure(pooled)} %"
            rows.append(CheckRow("α with this amount, %", figure(mean), tip=tip))
        rows.append(CheckRow("change, RMS mm", figure(facts.change_mm), tip=_TIPS["change"]))
        if facts.residual_fraction is not None:
            tip = _TIPS["residual"]
            if facts.residual_mm is not None:
                tip += f": {figure(facts.residual_mm)} mm RMS"
            rows.append(CheckRow("residual, %", figure(100 * facts.residual_fraction, 1), tip=tip))
        verdict, known = "", facts.cosine is not None and facts.cosine == facts.cosine
        if known:
            verdict = "ok" if facts.cosine >= self._limit else "warn"  # type: ignore[operator]
        rows.append(
            CheckRow("cosine", judged(facts.cosine, self._limit), f"≥ {self._limit:.2f}", verdict, _TIPS["cosine"])
        )
        self.table.set_rows(rows)

    def _dragged(self, amount: float) -> None:
        self.number.setText(f"{amount:.2f}")
        self.amount_dragged.emit(amount)

    def _released(self, amount: float) -> None:
        self.number.setText(f"{amount:.2f}")
        self.amount_set.emit(amount)

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900, below a title of 28."""
        return QSize(theme.px(296), theme.px(36 + 22 + 4 * 20 + 2))

    def minimumSizeHint(self) -> QSize:
        """Return the room for the slider and a header: the rest scrolls."""
        return QSize(theme.px(200), theme.px(36) + theme.px(22))


_TIP = "0 is the hand shape, 1 the quasi-eigen one; double click goes back to 1"
_TIPS = {
    "change": "RMS distance over the skin between the hand shape and the shape in use",
    "residual": "What of the hand shape no axis of the performance can show",
    "cosine": "Direction of motion against the hand shape: 1 is the same, 0 has nothing to do with it",
}
