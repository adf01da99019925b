"""The performance: what it is, what the axes are trained on, and how weights are solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import QComboBox, QDoubleSpinBox, QHBoxLayout, QSpinBox, QVBoxLayout, QWidget

from widgets import theme
from widgets.basis.words import BOUNDS, count
from widgets.parts.buttons import KeyButton
from widgets.parts.empty import EmptyState
from widgets.parts.frame_field import FrameField
from widgets.parts.section import DimLabel, Section, ShyLabel
from widgets.parts.segments import Segments


@dataclass(frozen=True)
class MotionFacts:
    """A performance as it is read.

    Parameters
    ----------
    name : str
        File name.
    frames : int
    fps : float
        Hz.
    kind : str
        ``markers``, ``weights`` or ``mesh``.
    face_markers, head_markers : int
        0 for a performance without markers.
    notes : tuple of str
        What was assumed or repaired, a line each.
    needs_driver : bool
        Whether a rig must be named that its curves drive.
    """

    name: str
    frames: int
    fps: float
    kind: str = "markers"
    face_markers: int = 0
    head_markers: int = 0
    notes: tuple[str, ...] = ()
    needs_driver: bool = False


@dataclass(frozen=True)
class BasisChoices:
    """What the user chooses for the basis.

    Parameters
    ----------
    train : (int, int), optional
        First frame and the one after the last, from 0; all without.
    coverage : float
        Share of the variance, 0..1, that decides the number of axes while ``count`` is None.
    count : int, optional
        Number of axes.
    bounds : str
        Key of ``words.BOUNDS``.
    affine : bool
        Whether the mean is kept apart.
    ridge : float
        Weight of the ridge, >= 0.
    """

    train: tuple[int, int] | None = None
    coverage: float = 0.995
    count: int | None = None
    bounds: str = "-1..2"
    affine: bool = False
    ridge: float = 0.0


class MotionPanel(QWidget):
    """Facts of the performance and the choices that make a basis of it.

    Signals
    -------
    train_changed(int, int)
        First frame and the one after the last, from 0.
    coverage_changed(float), count_changed(int)
        The one the user wants the axes by.
    driver_chosen(str)
        Id of the rig that weight curves drive.
    bounds_chosen(str), affine_chosen(bool), ridge_changed(float)
        How weights are solved.
    open_requested(), settings_requested()
        Another file; unit, axes and marker binding of this one.
    """

    train_changed = Signal(int, int)
    coverage_changed = Signal(float)
    count_changed = Signal(int)
    driver_chosen = Signal(str)
    bounds_chosen = Signal(str)
    affine_chosen = Signal(bool)
    ridge_changed = Signal(float)
    open_requested = Signal()
    settings_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAutoFillBackground(True)
        self._facts: MotionFacts | None = None
        self._choices = BasisChoices()
        self._axes: int | None = None
        self._covered: float | None = None
        self.section = Section("Motion")
        self.frames_value = self.section.add_value("Frames")
        self.markers_value = self.section.add_value("Markers")
        self.notes_value = self.section.add_value("Notes")
        self.notes_value.make_link()
        self.first = FrameField(
            "First frame of the training range", "First frame the axes are trained on", strong=False
        )
        self.last = FrameField("Last frame of the training range", "Last frame the axes are trained on", strong=False)
        self.by = Segments([("coverage", "coverage"), ("count", "count")], stretch=True, name="Axes by")
        self.coverage = _number(4, 0.5, 1.0, 0.001, "Share of the variance that the axes hold, 0.5 to 1")
        self.count = QSpinBox()
        self.axes_note = ShyLabel("")
        self.driver = QComboBox()
        self.bounds = Segments(list(BOUNDS.items()), name="Weights in")
        self.affine = Segments([("linear", "linear"), ("affine", "affine")], stretch=True, name="Basis")
        self.ridge = _number(4, 0.0, 1e4, 0.01, "Draws weights towards 0 where shapes resemble each other; 0 is none")
        self.open_button = KeyButton("Open…")
        self.settings_button = KeyButton("Import…")
        self.empty = EmptyState(
            "No performance yet",
            "What the shapes should be able to say: markers (C3D, TRC, CSV), weight curves of a rig, or a moving mesh.",
            (("Open performance…", "", False),),
        )
        self._arrange()
        self._connect()
        self.set_motion(None)
        self.set_choices(self._choices)

    def _arrange(self) -> None:
        section = self.section
        section.add_input("Trained on", _row(self.first, 2, DimLabel("–", role="text"), 2, self.last, None))
        section.add_input("Axes by", self.by)
        self.count.setRange(1, 999)
        self.count.setKeyboardTracking(False)
        for box in (self.coverage, self.count):
            box.setAlignment(Qt.AlignmentFlag.AlignRight)
            theme.fix(box, width=56)
        self._axes_row = _row(self.coverage, self.count, 8, self.axes_note, None)
        section.add_input("Coverage", self._axes_row)
        section.add_input("Driver rig", self.driver)
        section.add_input("Weights in", self.bounds)
        section.add_input("Basis", self.affine)
        theme.fix(self.ridge, width=56)
        section.add_input("Ridge", _row(self.ridge, None))
        self.by.set_tip("coverage", "As many axes as hold this share of the variance")
        self.by.set_tip("count", "A number of axes")
        self.bounds.set_tip("0..1", "Weights as an animator moves them")
        self.bounds.set_tip("-1..2", "Weights with room on both sides")
        self.bounds.set_tip("free", "No bounds: weights may become very large")
        self.affine.set_tip("linear", "v = neutral + Σ w e: shapes for sliders (Kim & Ko 2007)")
        self.affine.set_tip("affine", "v = neutral + mean + Σ w (e − mean): equals PCA when W has full rank")
        self.open_button.setToolTip("Open another performance")
        self.settings_button.setToolTip("Unit, axes and the binding of the markers of this performance")
        self._buttons = _row(self.open_button, 4, self.settings_button, None)
        self._buttons.setContentsMargins(0, 8, 0, 0)
        section.add_widget(self._buttons)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(section)
        column.addWidget(self.empty)
        column.addStretch(1)

    def _connect(self) -> None:
        for field in (self.first, self.last):
            field.valueChanged.connect(self._train)
        self.by.chosen.connect(self._by)
        self.coverage.valueChanged.connect(self.coverage_changed)
        self.count.valueChanged.connect(self.count_changed)
        self.driver.activated.connect(lambda _k: self.driver_chosen.emit(str(self.driver.currentData())))
        self.bounds.chosen.connect(self.bounds_chosen)
        self.affine.chosen.connect(lambda key: self.affine_chosen.emit(key == "affine"))
        self.ridge.valueChanged.connect(self.ridge_changed)
        self.open_button.clicked.connect(self.open_requested)
        self.settings_button.clicked.connect(self.settings_requested)
        self.notes_value.clicked.connect(self.settings_requested)
        self.empty.buttons[0].clicked.connect(self.open_requested)

    def set_motion(self, facts: MotionFacts | None) -> None:
        """Show a performance; ``None`` while there is none."""
        self._facts = facts
        self.section.setVisible(facts is not None)
        self.empty.setVisible(facts is None)
        if facts is None:
            return
        self.section.set_note(facts.name)
        self.frames_value.set_text(f"{count(facts.frames)} at {facts.fps:g} fps")
        markers = [f"{n} {word}" for n, word in ((facts.face_markers, "face"), (facts.head_markers, "head")) if n]
        self.section.show_row("Markers", bool(markers))
        self.markers_value.set_text(", ".join(markers))
        self.section.show_row("Notes", bool(facts.notes))
        self.notes_value.set_text(f"{len(facts.notes)} assumed", "\n".join(facts.notes))
        self.section.show_row("Driver rig", facts.needs_driver or facts.kind == "weights")
        self._show_choices()

    def set_choices(self, choices: BasisChoices) -> None:
        """Show what is chosen without telling anybody."""
        self._choices = choices
        self._show_choices()

    def set_axes(self, axes: int | None, coverage: float | None = None) -> None:
        """Show how many axes there are and the share of the variance they cover."""
        self._axes, self._covered = axes, coverage
        self._show_axes()

    def set_rigs(self, rigs: Sequence[tuple[str, str]], driver: str | None = None) -> None:
        """Offer rigs (id, name) that weight curves may drive, and mark the one in use."""
        self.driver.blockSignals(True)
        self.driver.clear()
        for rig_id, name in rigs:
            self.driver.addItem(name, rig_id)
        self.driver.setCurrentIndex(self.driver.findData(driver))
        self.driver.setPlaceholderText("choose one")
        self.driver.blockSignals(False)

    def _show_choices(self) -> None:
        made, frames = self._choices, max(2, self._facts.frames if self._facts else 2)
        start, stop = made.train or (0, frames)
        for field in (self.first, self.last):
            field.blockSignals(True)
        self.first.setRange(1, min(max(1, stop - 1), frames))
        self.last.setRange(min(start + 2, frames), frames)
        self.first.setValue(start + 1)
        self.last.setValue(stop)
        self.first.fit(start + 1)
        self.last.fit(stop)
        for field in (self.first, self.last):
            field.blockSignals(False)
        by_count = made.count is not None
        self.by.set_current("count" if by_count else "coverage")
        self.bounds.set_current(made.bounds)
        self.affine.set_current("affine" if made.affine else "linear")
        for box, value in ((self.coverage, made.coverage), (self.ridge, made.ridge)):
            box.blockSignals(True)
            box.setValue(value)
            box.blockSignals(False)
        self._show_axes()

    def _show_axes(self) -> None:
        by_count = self.by.current == "count"
        self.coverage.setVisible(not by_count)
        self.count.setVisible(by_count)
        self.section.rename_row("Coverage", "Axes" if by_count else "Coverage")
        wanted = self._choices.count or self._axes or 1
        self.count.blockSignals(True)
        self.count.setValue(wanted)
        self.count.blockSignals(False)
        axes = "" if self._axes is None else f"{self._axes} axes" if self._axes != 1 else "1 axis"
        self.axes_note.setText(f"{self._covered:.4f}" if by_count and self._covered is not None else axes)
        self.axes_note.setToolTip("Share of the variance they hold" if by_count else "Axes that hold this share")

    def _by(self, key: str) -> None:
        self._show_axes()
        if key == "count":
            self.count_changed.emit(self.count.value())
        else:
            self.coverage_changed.emit(self.coverage.value())

    def _train(self, _value: int) -> None:
        self.first.setMaximum(max(1, self.last.value() - 1))
        self.last.setMinimum(self.first.value() + 1)
        self.first.fit(self.first.value())
        self.last.fit(self.last.value())
        self.train_changed.emit(self.first.value() - 1, self.last.value())

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(232, super().sizeHint().height())


def _row(*things: QWidget | int | None) -> QWidget:
    made = QWidget()
    line = QHBoxLayout(made)
    line.setContentsMargins(0, 0, 0, 0)
    line.setSpacing(0)
    for thing in things:
        if thing is None:
            line.addStretch(1)
        elif isinstance(thing, int):
            line.addSpacing(thing)
        else:
            line.addWidget(thing)
    return made


def _number(digits: int, least: float, largest: float, step: float, tip: str) -> QDoubleSpinBox:
    box = ShortNumber()
    box.setDecimals(digits)
    box.setRange(least, largest)
    box.setSingleStep(step)
    box.setKeyboardTracking(False)
    box.setAlignment(Qt.AlignmentFlag.AlignRight)
    box.setToolTip(tip)
    return box


class ShortNumber(QDoubleSpinBox):
    """A number that is written with no more decimals than it has."""

    def textFromValue(self, value: float) -> str:
        """Return the number without zeros at its end."""
        return f"{value:.{self.decimals()}f}".rstrip("0").rstrip(".")
