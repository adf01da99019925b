"""What a stage gives the window, and the list of stages: one line each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

if TYPE_CHECKING:
    from studio.main_window import MainWindow


@dataclass(frozen=True)
class DockSpec:
    """One dock of a stage.

    Attributes
    ----------
    id, title : str
        The id is kept in saved layouts.
    widget : QWidget
        What it holds.
    area : Qt.DockWidgetArea
        Where it stands at first.
    size : int
        Its share of the area in pixels at 1440 x 900: height at the sides, width at the bottom.
    buttons : tuple of (str, str)
        Icon and action of the buttons in its title bar, before float and close.
    tab : str
        Id of the dock it lies behind at first, as a tab; a place of its own where empty.
    """

    id: str
    title: str
    widget: QWidget
    area: Qt.DockWidgetArea
    size: int
    buttons: tuple[tuple[str, str], ...] = ()
    tab: str = ""


class StageView(Protocol):
    """A stage as the window sees it: its work zone, its docks, and how far it is."""

    @property
    def centre(self) -> QWidget:
        """The work zone."""

    @property
    def docks(self) -> tuple[DockSpec, ...]:
        """What stands beside it at first."""

    @property
    def zones(self) -> tuple[QWidget, ...]:
        """The parts of the work zone that the keys go to one by one."""

    @property
    def empty_place(self) -> QWidget | None:
        """What the welcome page covers while the project is empty; None in a stage that has none."""

    @property
    def usual_view(self) -> QWidget:
        """What is pictured where neither the mouse nor the keys are in another view."""

    @property
    def subject(self) -> str:
        """Name of what is in view, such as a scan's; empty without one."""

    def drop(self, paths: Sequence[Path]) -> None:
        """Take in files and folders that were dropped on the window."""

    def came_into_view(self) -> None:
        """The stage has come into view: say in the status line what comes next."""

    def reset_layout(self) -> None:
        """Share the room of the work zone as at first."""

    def close(self) -> None:
        """Note the layout in the settings; let go of 3-D views, timers and the project."""


@dataclass(frozen=True)
class Stage:
    """A stage's id, the text of its tab, and what makes its view."""

    id: str
    title: str
    create: Callable[[MainWindow], StageView]


def _scan(window: MainWindow) -> StageView:
    from studio.scan.controller import ScanStage

    return ScanStage(window)


def _basis(window: MainWindow) -> StageView:
    from studio.basis.controller import BasisStage

    return BasisStage(window)


STAGES: tuple[Stage, ...] = (Stage("scan", "Scan", _scan), Stage("basis", "Basis", _basis))
"""In the order of the tabs; the first is there when the window opens, the others are made when they are first shown."""
