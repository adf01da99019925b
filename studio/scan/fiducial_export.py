"""The dialog that writes fiducials under the names and numbers of other tools."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from engine.errors import InputError, some
from engine.files.landmark_file import DEFAULT_ORIGIN
from engine.files.landmarks import format_of, write_landmarks
from engine.files.mapping import read_mapping
from engine.landmark_mapping import LandmarkMapping, Unmapped, invert_mapping
from engine.landmarks import LandmarkScheme
from studio import dialogs
from studio.project.document import ScanItem
from studio.scan.fiducial_files import shipped_mappings
from studio.scan.fiducial_import import MAPPING_FILTER
from studio.scan.fiducial_options import as_export_command
from studio.settings import Settings
from widgets import theme
from widgets.scan.landmark_export_panel import HEIGHT, WIDTH, ExportRow, LandmarkExportPanel

OURS = "ours"
"""The key of the fiducials' own names."""


class FiducialExportDialog(QDialog):
    """The placed fiducials as points of another tool, written once they can be.

    Parameters
    ----------
    path : Path
        The file to write: ``.pts``, ``.ljson`` or ``.csv``.
    item, positions, scheme
        The scan, its placed fiducials in pixels, and all that there are.
    settings : Settings
        Where file dialogs start.

    Signals
    -------
    written(str)
        The file is there; what is to be told.
    """

    written = Signal(str)

    def __init__(
        self,
        path: Path,
        item: ScanItem,
        positions: Mapping[str, tuple[float, float]],
        scheme: LandmarkScheme,
        settings: Settings,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("fiducial_export")
        self.setWindowTitle(f"Export fiducials to {path.name}")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self._path, self._item, self._positions, self._scheme, self._settings = path, item, positions, scheme, settings
        self._kind = format_of(path)
        self._origin = DEFAULT_ORIGIN[self._kind]
        self._mappings: dict[str, LandmarkMapping] = {mapping.name: mapping for mapping in shipped_mappings()}
        self._opened: Path | None = None
        self._key = OURS
        self.panel = LandmarkExportPanel(self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        self.panel.mapping_chosen.connect(self._take_mapping)
        self.panel.origin_chosen.connect(self._take_origin)
        self.panel.open_requested.connect(self._open)
        self.panel.accepted.connect(self._write)
        self.panel.rejected.connect(self.reject)
        self._refresh()
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))

    def _take_mapping(self, key: str) -> None:
        self._key = key
        self._refresh()

    def _take_origin(self, origin: float) -> None:
        self._origin = origin
        self._refresh()

    def _open(self) -> None:
        path = dialogs.open_file(self, self._settings, "Open mapping", MAPPING_FILTER)
        if path is None:
            return
        try:
            mapping = read_mapping(path)
        except InputError as error:
            self.panel.show_report((), 0, str(error))
            return
        self._opened, self._key = path, str(path)
        self._mappings[self._key] = mapping
        self._refresh()

    def _points(self) -> Unmapped:
        """Return what is written: the points of the layout, or the fiducials under their own names."""
        if self._key != OURS:
            return invert_mapping(self._mappings[self._key], self._positions)
        points = np.array([self._positions.get(name, (np.nan, np.nan)) for name in self._scheme.names])
        return Unmapped(points, self._scheme.names, ())

    def _refresh(self, problem: str = "") -> None:
        keys = [(OURS, "Fiducials by their own names")]
        keys += [(key, mapping.title or mapping.name) for key, mapping in self._mappings.items()]
        self.panel.show_choice(keys, self._key, self._origin)
        try:
            points = self._points()
        except InputError as error:
            self.panel.show_rows(())
            self.panel.show_report((), 0, str(error))
            self.panel.command.set_command("", str(error))
            return
        count = len(self._positions) - len(points.lost)
        lines = [f"{count} of {len(self._positions)} placed fiducials are written"]
        if points.lost:
            lines.append(f"{len(points.lost)} have no place there: {some(points.lost)}")
        if points.holes:
            lines.append(f"{points.holes} of {len(points.labels)} points stay empty")
            if self._kind == "pts":
                remedy = "choose .ljson or .csv" if self._key != OURS else "place them all, or choose .ljson or .csv"
                problem = problem or f"{self._path.name}: .pts cannot leave points out, and {lines[-1]}; {remedy}"
        self.panel.show_rows(self._rows(points))
        self.panel.show_report(lines, count, problem)
        self.panel.command.set_command(*self._command())

    def _rows(self, points: Unmapped) -> list[ExportRow]:
        names: dict[str, str] = {}
        if self._key == OURS:
            names = {name: name for name in self._positions}
        else:
            for target, sources in self._mappings[self._key].entries.items():
                names |= {} if target in points.lost else {str(source): target for source in set(sources)}
            single = {
                str(sources[0]): target
                for target, sources in self._mappings[self._key].entries.items()
                if len(sources) == 1
            }
            names |= single
        rows = []
        for k, (label, (x, y)) in enumerate(zip(points.labels, points.points.tolist(), strict=True)):
            there = x == x and y == y
            name = names.get(label, names.get(str(k), ""))
            shown = (f"{x + self._origin:.1f}", f"{y + self._origin:.1f}") if there else ("", "")
            rows.append(ExportRow(label, name if there else "", *shown))
        return rows

    def _command(self) -> tuple[str, str]:
        scheme = self._scheme.name if self._item.custom is None else f"{self._scheme.name}.toml"
        mapping = "" if self._key == OURS else self._key
        origin = None if self._origin == DEFAULT_ORIGIN[self._kind] else self._origin
        source = f"{self._item.name}_fiducials.json"
        return as_export_command(source, str(self._path), scheme, mapping, origin), ""

    def _write(self) -> None:
        try:
            points = self._points()
            write_landmarks(self._path, points.points, points.labels, None, self._origin)
        except InputError as error:
            self._refresh(str(error))
            return
        self.accept()
        self.written.emit(f"Wrote {len(self._positions) - len(points.lost)} fiducials to {self._path}")
