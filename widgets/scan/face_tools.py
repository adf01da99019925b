"""The row of tools over the fitted face: surface, switches, level, views, camera, maximise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from PySide6.QtCore import QPoint, Signal, SignalInstance
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QFrame, QHBoxLayout, QMenu, QWidget

from widgets import theme
from widgets.parts.buttons import IconButton
from widgets.parts.section import ShyLabel
from widgets.parts.segments import Segments


class FaceTools(QWidget):
    """A tool row 32 px high; it says what was chosen and shows what it is told.

    Parameters
    ----------
    views : mapping of str to str
        Standard views: what ``view_chosen`` sends, and what the menu reads.

    Signals
    -------
    mode_chosen(str)
        ``shaded`` or ``textured``.
    wire_toggled(bool), points_toggled(bool), heatmap_toggled(bool), maximise_toggled(bool)
    view_chosen(str)
    frame_chosen(), save_chosen(), copy_chosen()
    """

    mode_chosen = Signal(str)
    wire_toggled = Signal(bool)
    points_toggled = Signal(bool)
    heatmap_toggled = Signal(bool)
    maximise_toggled = Signal(bool)
    view_chosen = Signal(str)
    frame_chosen = Signal()
    save_chosen = Signal()
    copy_chosen = Signal()

    def __init__(self, views: Mapping[str, str], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        theme.fix(self, height=32)
        self.setAutoFillBackground(True)
        self.buttons: dict[str, IconButton] = {}
        self._line = QHBoxLayout(self)
        self._line.setContentsMargins(8, 0, 8, 0)
        self._line.setSpacing(4)
        self.modes = Segments([("shaded", "Shaded"), ("textured", "Textured")], name="Surface of the face")
        self.modes.set_tip("shaded", "Clay under studio light")
        self.modes.set_tip("textured", "The scan's colour picture")
        self.modes.set_current("textured")
        self.modes.chosen.connect(self.mode_chosen)
        self._line.addWidget(self.modes)
        self._divider = QFrame(self)
        self._divider.setFixedSize(1, 16)
        self._line.addSpacing(4)
        self._line.addWidget(self._divider)
        self._line.addSpacing(4)
        self._add_switch("wire", "wire", "Template wire over the face (W)", self.wire_toggled)
        self._add_switch("points", "dots", "Points of the scan (P)", self.points_toggled)
        self._add_switch("heatmap", "heatmap", "Distance to the scan (H)", self.heatmap_toggled)
        self._line.addStretch(1)
        self._level = ShyLabel("")
        self._level.setToolTip("How often the template was subdivided")
        self._line.addWidget(self._level)
        self._line.addSpacing(4)
        self._add_menu("views", "four-views", "Look from a standard side", self._view_menu(views))
        self._add_menu("camera", "camera", "Save this picture, or copy it", self._camera_menu())
        self._add_switch("maximise", "fit-view", "Let the views fill the window, or go back", self.maximise_toggled)
        self.buttons["maximise"].setChecked(False)
        theme.signals.changed.connect(self._dress)
        self._dress()

    def set_mode(self, mode: str) -> None:
        """Show which surface is on."""
        self.modes.set_current(mode)

    def set_down(self, key: str, down: bool) -> None:
        """Show whether a switch (``wire``, ``points``, ``heatmap``, ``maximise``) is on."""
        self.buttons[key].setChecked(down)

    def set_level(self, text: str) -> None:
        """Show the level of subdivision."""
        self._level.setText(text)

    def allow_texture(self, allowed: bool, reason: str) -> None:
        """Allow the textured surface, or grey it and say why."""
        self.modes.set_available("textured", allowed, reason)

    def _add_switch(self, key: str, icon: str, tip: str, signal: SignalInstance) -> None:
        button = IconButton(icon, tip, checkable=True)
        button.setChecked(True)
        button.clicked.connect(signal)
        self.buttons[key] = button
        self._line.addWidget(button)

    def _add_menu(self, key: str, icon: str, tip: str, menu: QMenu) -> None:
        button = IconButton(icon, tip)
        button.clicked.connect(lambda: self._drop(button, menu))
        self.buttons[key] = button
        self._line.addWidget(button)

    def _view_menu(self, views: Mapping[str, str]) -> QMenu:
        menu = QMenu(self)
        for key, text in views.items():
            self._add_action(menu, text, partial(self.view_chosen.emit, key))
        menu.addSeparator()
        self._add_action(menu, "Frame the face\tF", self.frame_chosen.emit)
        return menu

    def _camera_menu(self) -> QMenu:
        menu = QMenu(self)
        self._add_action(menu, "Save picture\u2026", self.save_chosen.emit)
        self._add_action(menu, "Copy picture", self.copy_chosen.emit)
        return menu

    def _add_action(self, menu: QMenu, text: str, run: Callable[[], object]) -> None:
        action = QAction(text, menu)
        action.triggered.connect(lambda _=False: run())
        menu.addAction(action)

    def _drop(self, button: IconButton, menu: QMenu) -> None:
        corner = button.mapToGlobal(QPoint(button.width(), button.height()))
        menu.popup(corner - QPoint(menu.sizeHint().width(), 0))

    def _dress(self) -> None:
        current = theme.current()
        self._divider.setStyleSheet(f"background: {current.line}")
