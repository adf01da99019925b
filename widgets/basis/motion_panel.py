"""The performance: what it is, what the axes are trained on, and how weights are solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QWidget


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
        self._facts: MotionFacts | None = None
        self._choices = BasisChoices()
        self._axes: int | None = None

    def set_motion(self, facts: MotionFacts | None) -> None:
        """Show a performance; ``None`` while there is none."""
        self._facts = facts

    def set_choices(self, choices: BasisChoices) -> None:
        """Show what is chosen without telling anybody."""
        self._choices = choices

    def set_axes(self, axes: int | None, coverage: float | None = None) -> None:
        """Show how many axes there are and the share of the variance they cover."""
        self._axes = axes

    def set_rigs(self, rigs: Sequence[tuple[str, str]], driver: str | None = None) -> None:
        """Offer rigs (id, name) that weight curves may drive, and mark the one in use."""

    def sizeHint(self) -> QSize:
        """Return the size at 1440 x 900."""
        return QSize(232, 250)
