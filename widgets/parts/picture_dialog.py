"""The dialog that saves a picture: its size, what is in it, and where it goes."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QSize, Signal
from PySide6.QtWidgets import QCheckBox, QPushButton, QWidget

from widgets.parts.form_dialog import FormDialog
from widgets.parts.path_field import PathField
from widgets.parts.picture import SCALES, Offer, PictureOptions
from widgets.parts.section import DimLabel
from widgets.parts.segments import Segments

PNG_FILTER = "PNG picture (*.png)"


class PictureDialog(FormDialog):
    """Asks how a view is pictured and says when it shall be done; it closes when it is told that it went well.

    Signals
    -------
    save_requested(Path, PictureOptions)
        To be written there; a file of that name may be replaced.
    copy_requested(PictureOptions)
        To go to the clipboard.
    """

    save_requested = Signal(object, object)
    copy_requested = Signal(object)

    def __init__(self, made: Offer, path: Path, parent: QWidget | None = None) -> None:
        super().__init__(f"Save picture: {made.title}", "Save", parent)
        self.setObjectName("picture_dialog")
        self._offer = made
        self.path = PathField("Save picture", PNG_FILTER)
        self.path.set_path(path)
        self.scale = Segments([(str(k), f"{k}\u00d7") for k in SCALES], name="Scale")
        self.scale.set_current("1")
        self.size_label = DimLabel("")
        self.overlays = QCheckBox("&Labels, legend and marks over it")
        self.overlays.setChecked(True)
        self.transparent = QCheckBox("&Transparent background")
        self.add_row("&File", self.path)
        self.add_row("&Scale", self.scale)
        self.add_row("Size", self.size_label)
        if made.overlays:
            self.form.addRow("", self.overlays)
        if made.transparent:
            self.form.addRow("", self.transparent)
        self.copy = QPushButton("C&opy")
        self.copy.setToolTip("To the clipboard instead")
        self.copy.setAutoDefault(False)
        self.buttons.insertWidget(0, self.copy)
        self.copy.clicked.connect(lambda: self.copy_requested.emit(self.options))
        self.primary.clicked.connect(self._save)
        self.scale.chosen.connect(self._show_size)
        self.path.changed.connect(self.forget)
        self._show_size()
        self.path.field.setFocus()

    @property
    def options(self) -> PictureOptions:
        """What is chosen."""
        transparent = self._offer.transparent and self.transparent.isChecked()
        return PictureOptions(int(self.scale.current), self.overlays.isChecked(), transparent)

    def _show_size(self, _key: str = "") -> None:
        view = self._offer.widget
        size: QSize = view.size() * (view.devicePixelRatioF() * int(self.scale.current))
        self.size_label.setText(f"{size.width()} \u00d7 {size.height()} pixels")

    def _save(self) -> None:
        path = self.path.path(".png")
        if path is None:
            self.tell("Name the file first.")
        elif self.may_replace([path]):
            self.save_requested.emit(path, self.options)
