"""What can be done with one fiducial, as a menu."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from PySide6.QtWidgets import QMenu, QWidget

from engine.landmarks import Landmark, LandmarkState


def fiducial_menu(parent: QWidget, point: Landmark, orders: Mapping[str, Callable[..., Any]]) -> QMenu:
    """Return the menu of a fiducial; what makes no sense in its state is grey.

    Parameters
    ----------
    parent : QWidget
        Owner of the menu.
    point : Landmark
        The fiducial as it is.
    orders : mapping
        What ``confirm``, ``skip`` and ``unset`` call, and ``lock``, which is given whether to lock.
    """
    state, free = point.state, not point.locked
    menu = QMenu(parent)
    for text, order, allowed in (
        ("Confirm", "confirm", state is LandmarkState.PROPOSED),
        ("Skip", "skip", free and state is not LandmarkState.SKIPPED),
        ("Unset", "unset", free and state is not LandmarkState.UNSET),
    ):
        action = menu.addAction(text)
        action.triggered.connect(lambda _=False, order=order: orders[order]())
        action.setEnabled(allowed)
    lock = menu.addAction("Lock" if free else "Unlock")
    lock.triggered.connect(lambda _=False: orders["lock"](free))
    lock.setEnabled(point.locked or state is LandmarkState.PLACED)
    return menu
