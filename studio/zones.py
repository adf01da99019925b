"""Keyboard zones: work zone and docks, entered one after the other with F6, each where the keys were last."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QPoint, Qt
from PySide6.QtWidgets import QAbstractItemView, QAbstractScrollArea, QApplication, QWidget
from shiboken6 import isValid

if TYPE_CHECKING:
    from studio.main_window import MainWindow


class Zones(QObject):
    """Moves the keys between the parts of a window, from left to right and down."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._last: dict[QWidget, QWidget] = {}
        app = QApplication.instance()
        if isinstance(app, QApplication):
            app.focusChanged.connect(self._note)

    def zones(self) -> list[QWidget]:
        """Return the parts that are in sight, in the order in which the keys visit them."""
        window = self._window
        docks = [dock for dock in window.docks.values() if dock.isVisible() and not dock.visibleRegion().isEmpty()]
        parts = [*window.stage.zones, *docks]
        if window.message.offers:
            parts.append(window.message)
        seen = [part for part in parts if part.isVisible() and first_stop(part) is not None]
        return sorted(seen, key=self._place)

    def go(self, step: int) -> None:
        """Give the keys to the next zone (1) or the one before (-1), to what had them there last."""
        zones = self.zones()
        if not zones:
            return
        focus = QApplication.focusWidget()
        here = next((k for k, zone in enumerate(zones) if focus is not None and zone.isAncestorOf(focus)), None)
        at = (0 if step > 0 else len(zones) - 1) if here is None else (here + step) % len(zones)
        zone = zones[at]
        last = self._last.get(zone)
        there = last is not None and isValid(last) and stops(last) and zone.isAncestorOf(last)
        target = last if there else first_stop(zone)
        if target is not None:
            target.setFocus(Qt.FocusReason.TabFocusReason)

    def _place(self, part: QWidget) -> tuple[int, int]:
        corner = part.mapTo(self._window, QPoint(0, 0)) if self._window.isAncestorOf(part) else QPoint(10**6, 0)
        return corner.x(), corner.y()

    def _note(self, _old: QWidget | None, now: QWidget | None) -> None:
        if now is None or not self._window.isAncestorOf(now):
            return
        for zone in (*self._window.stage.zones, *self._window.docks.values()):
            if zone.isAncestorOf(now):
                self._last[zone] = _lasting(now)


def stops(widget: QWidget) -> bool:
    """Return whether the Tab key can stop at a widget just now."""
    return widget.isVisible() and widget.isEnabled() and bool(widget.focusPolicy() & Qt.FocusPolicy.TabFocus)


def _lasting(widget: QWidget) -> QWidget:
    """Return the list or table that an editor is in, which goes when the editing ends; else the widget itself."""
    parent = widget.parentWidget()
    while parent is not None and not parent.isWindow():
        if isinstance(parent, QAbstractItemView):
            return parent
        parent = parent.parentWidget()
    return widget


def first_stop(zone: QWidget) -> QWidget | None:
    """Return what gets the keys of a zone: its list or picture, else the first control."""
    found: Sequence[QWidget] = [widget for widget in zone.findChildren(QWidget) if stops(widget)]
    for kind in (QAbstractItemView, QAbstractScrollArea):
        for widget in found:
            if isinstance(widget, kind):
                return widget
    return found[0] if found else (zone if stops(zone) else None)
