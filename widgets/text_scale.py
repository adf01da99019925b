"""How large everything is that is read: one factor over fonts, rows and icons, which fixed sizes follow at once."""

from __future__ import annotations

import re

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QAbstractButton, QApplication, QWidget

SMALLEST, LARGEST = 0.8, 2.0
_SIZE, _ICON = "size_at_100_percent", "icon_at_100_percent"
_state = {"factor": 1.0}


def factor() -> float:
    """Return the text scale, 0.8..2; 1 is 100 %."""
    return _state["factor"]


def set_factor(value: float) -> None:
    """Set the text scale, kept within its limits; `refit` makes what is there already follow."""
    _state["factor"] = min(max(float(value), SMALLEST), LARGEST)


def px(pixels: float) -> int:
    """Return a size that is meant for 100 % in pixels of the present text scale."""
    return round(pixels * factor())


def fix(widget: QWidget, width: int = 0, height: int = 0) -> None:
    """Fix width, height or both, in pixels of 100 %; 0 leaves one free. It follows the text scale from now on."""
    widget.setProperty(_SIZE, [width, height])
    _fit_size(widget, width, height)


def fix_icon(button: QAbstractButton, edge: int) -> None:
    """Fix the edge of a button's icon, in pixels of 100 %; it follows the text scale from now on."""
    button.setProperty(_ICON, edge)
    button.setIconSize(QSize(px(edge), px(edge)))


def refit() -> None:
    """Give every widget whose size was fixed here the size of the present text scale."""
    for widget in QApplication.allWidgets():
        size = widget.property(_SIZE)
        if size is not None:
            _fit_size(widget, *size)
        if isinstance(widget, QAbstractButton) and (edge := widget.property(_ICON)) is not None:
            widget.setIconSize(QSize(px(edge), px(edge)))


def scaled_sheet(sheet: str) -> str:
    """Return a style sheet with its lengths at the present text scale; hairlines stay one pixel."""
    if factor() == 1.0:
        return sheet
    return re.sub(r"\b(\d+)px", lambda found: f"{int(found[1]) if int(found[1]) < 2 else px(int(found[1]))}px", sheet)


def _fit_size(widget: QWidget, width: int, height: int) -> None:
    if width:
        widget.setFixedWidth(px(width))
    if height:
        widget.setFixedHeight(px(height))
