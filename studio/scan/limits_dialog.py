"""The dialog of the limits: edited beside what they make of the present scan, applied as one step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from engine.errors import InputError
from engine.files.limits import read_limits, write_limits
from engine.scan.limits import Limits
from engine.scan.regions import regions_of
from studio import dialogs
from studio.scan.job import template_of
from studio.settings import Settings, config_folder
from widgets import theme
from widgets.scan.limits_panel import LimitsPanel

LIMITS_FILTER = "Limits (*.toml)"
WIDTH, HEIGHT = 880, 560

Judge = Callable[[Limits], tuple[dict[str, str], str]]
"""Returns what limits make of the present scan: the verdict of every region, and a line on all of it."""


def default_path() -> Path:
    """Return the file that the user's own limits are kept in."""
    return config_folder() / "limits.toml"


def my_limits() -> Limits:
    """Return the limits that new projects begin with: the user's own, or those shipped.

    Raises
    ------
    InputError
        When the user's file cannot be read.
    """
    path = default_path()
    return read_limits(path) if path.is_file() else Limits()


class LimitsDialog(QDialog):
    """Edits limits; ``accepted`` is emitted when `limits` are to be taken over.

    Parameters
    ----------
    limits : Limits
        What is judged by at present.
    judge : callable
        What limits make of the present scan.
    settings : Settings
        Where file dialogs start.
    """

    def __init__(self, limits: Limits, judge: Judge, settings: Settings, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("limits")
        self.setWindowTitle("Limits")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._judge, self._settings = judge, settings
        self.limits = limits
        self.names = regions_of(template_of()).names
        self.panel = LimitsPanel(self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        self.panel.changed.connect(self._refresh)
        self.panel.accepted.connect(self._accept)
        self.panel.rejected.connect(self.reject)
        self.panel.import_requested.connect(self._import)
        self.panel.export_requested.connect(self._export)
        self.panel.default_requested.connect(self._keep)
        theme.signals.changed.connect(self._refresh)
        self.panel.set_limits(limits, self.names, tell=True)
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))

    def _refresh(self) -> None:
        try:
            self.limits = self.panel.limits()
        except InputError as error:
            self.panel.show_trouble(str(error))
            return
        self.panel.show_trouble("")
        self.panel.show_verdicts(*self._judge(self.limits))

    def _accept(self) -> None:
        self._refresh()
        if self.panel.apply_button.isEnabled():
            self.accept()

    def _import(self) -> None:
        path = dialogs.open_file(self, self._settings, "Import limits", LIMITS_FILTER)
        if path is None:
            return
        try:
            limits = read_limits(path)
        except InputError as error:
            self.panel.trouble.setText(str(error))
            return
        self.panel.set_limits(limits, self.names, tell=True)

    def _export(self) -> None:
        path = dialogs.save_file(self, self._settings, "Export limits", "limits.toml", LIMITS_FILTER)
        if path is not None:
            self._write(path, f"Wrote {path.name}")

    def _keep(self) -> None:
        path = default_path()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            problem = f"its folder cannot be made ({error.strerror})"
            self.panel.trouble.setText(str(InputError(str(path), problem, "export them to another place")))
            return
        self._write(path, "New projects begin with these limits")

    def _write(self, path: Path, told: str) -> None:
        try:
            write_limits(path, self.limits)
        except InputError as error:
            self.panel.trouble.setText(str(error))
            return
        self.panel.overall.setText(told)
