"""The row of tools over the basis stage's views: how shapes are compared, switches, standard views, camera."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from PySide6.QtCore import QPoint, Qt, Signal, SignalInstance
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QMenu, QWidget

from widgets import theme
from widgets.parts.buttons import IconButton, KeyButton
from widgets.parts.section import ShyLabel
from widgets.parts.segments import Segments

_TIPS = {
    "side": "Hand and quasi-eigen shape beside each other",
    "overlay": "Both shapes in one place, the quasi-eigen shape shining through in blue",
    "wipe": "Both shapes in one place, parted by a line that is dragged",
    "grid": "All shapes at once",
}


_SHORT = {"side": "Side", "overlay": "Over", "wipe": "Wipe", "grid": "Grid"}


class ViewTools(QWidget):
    """A tool row 32 px high; it says what was chosen and shows what it is told.

    Parameters
    ----------
    modes : mapping of str to str
        Ways to compare: what ``mode_chosen`` sends, and what is read.
    views : mapping of str to str
        Standard views: what ``view_chosen`` sends, and what the menu reads.

    Signals
    -------
    mode_chosen(str)
    flip_held(bool)
        The mouse holds the flip button, or has let it go.
    wire_toggled(bool), heatmap_toggled(bool), markers_toggled(bool), clip_toggled(bool), pca_toggled(bool)
    maximise_toggled(bool)
    view_chosen(str)
    frame_chosen(), save_chosen(), copy_chosen()
    """

    mode_chosen = Signal(str)
    flip_held = Signal(bool)
    wire_toggled = Signal(bool)
    heatmap_toggled = Signal(bool)
    markers_toggled = Signal(bool)
    clip_toggled = Signal(bool)
    pca_toggled = Signal(bool)
    maximise_toggled = Signal(bool)
    view_chosen = Signal(str)
    frame_chosen = Signal()
    save_chosen = Signal()
    copy_chosen = Signal()

    def __init__(self, modes: Mapping[str, str], views: Mapping[str, str], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        theme.fix(self, height=32)
        self.setAutoFillBackground(True)
        self.buttons: dict[str, IconButton] = {}
        self._dividers: list[QFrame] = []
        self._line = QHBoxLayout(self)
        self._line.setContentsMargins(8, 0, 8, 0)
        self._line.setSpacing(4)
        self._modes, self._narrow = dict(modes), False
        self.modes = Segments(list(modes.items()), name="How shapes are compared")
        for key in modes:
            self.modes.set_tip(key, _TIPS[key])
        self.modes.chosen.connect(self.mode_chosen)
        self._line.addWidget(self.modes)
        self._line.addSpacing(4)
        self.flip = KeyButton("flip", "Space")
        self.flip.setToolTip("Quasi-eigen in place of the hand shape while this or the space bar is held")
        self.flip.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.flip.pressed.connect(partial(self.flip_held.emit, True))
        self.flip.released.connect(partial(self.flip_held.emit, False))
        self._line.addWidget(self.flip)
        self._divide()
        self._add_switch("wire", "wire", "Edges of the mesh (W)", self.wire_toggled, False)
        self._add_switch("heatmap", "heatmap", "Change from hand to quasi-eigen, in mm (H)", self.heatmap_toggled)
        self._add_switch("markers", "dots", "Captured and reconstructed markers (P)", self.markers_toggled)
        self._divide()
        self._add_switch(
            "clip", "clip-heat", "Error over the whole clip on the reconstructions", self.clip_toggled, False
        )
        self._add_switch("pca", "axes", "Reconstruction by the PCA axes too", self.pca_toggled, False)
        self._line.addStretch(1)
        note = ShyLabel("one camera")
        note.setToolTip("Turning one view turns all of them")
        self._line.addWidget(note)
        self._line.addSpacing(4)
        self._add_menu("views", "four-views", "Look from a standard side", self._view_menu(views))
        self._add_menu("camera", "camera", "Save this picture, or copy it", self._camera_menu())
        self._add_switch(
            "maximise", "fit-view", "Let the views fill the window, or go back", self.maximise_toggled, False
        )
        theme.signals.changed.connect(self._dress)
        self._dress()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Use shorter words, and leave out the key's name, where the row is narrow."""
        super().resizeEvent(event)
        narrow = self.width() < theme.px(620)
        if narrow == self._narrow:
            return
        self._narrow = narrow
        for key, text in self._modes.items():
            self.modes.set_text(key, _SHORT.get(key, text) if narrow else text)
        self.flip.show_key("" if narrow else "Space")

    def set_mode(self, mode: str) -> None:
        """Show how shapes are compared."""
        self.modes.set_current(mode)

    def set_down(self, key: str, down: bool) -> None:
        """Show whether a switch (``wire``, ``heatmap``, ``markers``, ``clip``, ``pca``, ``maximise``) is on."""
        self.buttons[key].setChecked(down)

    def set_available(self, key: str, available: bool, reason: str = "") -> None:
        """Allow a switch, or grey it and say why."""
        self.buttons[key].set_available(available, reason)

    def _divide(self) -> None:
        line = QFrame(self)
        line.setFixedSize(1, 16)
        self._dividers.append(line)
        self._line.addSpacing(4)
        self._line.addWidget(line)
        self._line.addSpacing(4)

    def _add_switch(self, key: str, icon: str, tip: str, signal: SignalInstance, down: bool = True) -> None:
        button = IconButton(icon, tip, checkable=True)
        button.setChecked(down)
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
        for line in self._dividers:
            line.setStyleSheet(f"background: {theme.current().line}")
