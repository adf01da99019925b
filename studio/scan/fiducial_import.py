"""The dialog that brings landmarks of other tools to the scan in view, as one undoable step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from engine.errors import InputError
from engine.files.landmarks import LandmarkFile, read_landmarks
from engine.files.mapping import read_mapping, write_mapping
from engine.landmark_mapping import BY_NAME, LandmarkMapping, index_of
from engine.landmark_sources import parse_sources, sources_text
from engine.landmarks import LandmarkScheme
from engine.scan.range_image import RangeImage
from studio import dialogs
from studio.project.document import ScanItem
from studio.scan.fiducial_files import (
    MIRRORED,
    FoundFiducials,
    find_fiducials,
    mapping_for,
    shipped_mappings,
    summary,
)
from studio.scan.fiducial_options import FiducialOptions, as_convert_command
from studio.scan.view_options import ViewOptions
from studio.settings import Settings
from widgets import theme
from widgets.scan.mapping_panel import HEIGHT, OWN, WIDTH, MappingChoice, MappingPanel, MappingReport
from widgets.scan.mapping_table import MappingRow

MAPPING_FILTER = "Landmark mapping (*.toml *.json)"


class FiducialImportDialog(QDialog):
    """A file's points over the scan's picture, and the table that says which is which.

    Parameters
    ----------
    path : Path
        The file of landmarks.
    item, image, scheme
        The scan they are for, its picture and its fiducials.
    settings : Settings
        Where file dialogs start.

    Signals
    -------
    taken(object, str)
        Positions by name, in pixels, and ``placed`` or ``proposed``.
    """

    taken = Signal(object, str)

    def __init__(
        self,
        path: Path,
        item: ScanItem,
        image: RangeImage,
        scheme: LandmarkScheme,
        settings: Settings,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("fiducial_import")
        self.setWindowTitle(f"Import fiducials from {path.name}")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self._path, self._item, self._image, self._scheme, self._settings = path, item, image, scheme, settings
        self._options = FiducialOptions()
        self._file: LandmarkFile = read_landmarks(path)
        self._presets: dict[str, LandmarkMapping] = {mapping.name: mapping for mapping in shipped_mappings()}
        self._mapping, self._why = mapping_for("", self._file.labels, scheme.names)
        self._preset, self._saved_as, self._changed = self._mapping.name, "", False
        self._found: FoundFiducials | None = None
        self._problem = ""
        self.panel = MappingPanel(self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        self._connect()
        self._show_picture()
        self._refresh(points=True)
        if self._file.present:
            self.panel.table.choose(next(iter(self._mapping.entries), scheme.names[0]))
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))
        self.panel.table.setFocus()

    def _connect(self) -> None:
        panel = self.panel
        panel.edited.connect(lambda name, text: self._attempt(lambda: self._edit(name, text)))
        panel.point_clicked.connect(self._assign)
        panel.chosen.connect(lambda _name: self._show_chosen())
        panel.mapping_chosen.connect(self._take_preset)
        panel.group_chosen.connect(lambda group: self._attempt(lambda: self._read(group=group)))
        panel.origin_chosen.connect(lambda origin: self._attempt(lambda: self._read(origin=origin)))
        panel.scale_chosen.connect(self._take_scale)
        panel.open_requested.connect(lambda: self._attempt(self._open))
        panel.save_requested.connect(lambda: self._attempt(self._save))
        panel.accepted.connect(self._accept)
        panel.rejected.connect(self.reject)

    # What the user wants ------------------------------------------------------------------------------------------

    def _attempt(self, deed: Callable[[], None]) -> None:
        """Do something that may be refused; then the reason stands in the dialog, and all is as before."""
        try:
            deed()
        except InputError as error:
            self._problem = str(error)
            self._refresh()
            self._problem = ""

    def _edit(self, name: str, text: str) -> None:
        self._set_entry(name, text)

    def _set_entry(self, name: str, text: str) -> None:
        sources = parse_sources(text, self._file.labels)
        if sources != self._mapping.entries.get(name, ()):
            known = self._mapping
            # A layout's own count says nothing about another file, and must not refuse its points.
            own = LandmarkMapping(known.name, known.entries, known.title, None, {}, known.note)
            self._mapping, self._changed = own.with_entry(name, sources), True
        self._refresh()

    def _assign(self, index: int) -> None:
        name = self.panel.table.current
        if name is not None and 0 <= index < len(self._file.labels):
            self._set_entry(name, str(index) if not self._file.named else self._file.labels[index])
            self._show_chosen()

    def _take_preset(self, key: str) -> None:
        if key == OWN:
            return
        chosen: str | LandmarkMapping = self._presets.get(key, key)
        self._mapping, self._why = mapping_for(chosen, self._file.labels, self._scheme.names)
        self._preset, self._changed, self._saved_as = key, False, ""
        self._refresh()

    def _read(self, group: str | None = None, origin: float | None = None) -> None:
        changes = {k: v for k, v in (("group", group), ("origin", origin)) if v is not None}
        options = self._options.model_copy(update=changes)
        self._file = read_landmarks(self._path, options.group, options.origin)
        self._options = options
        self._refresh(points=True)

    def _take_scale(self, scale: bool, width: int, height: int) -> None:
        known = self._file.image_size
        size = (known or (width, height)) if scale else None
        self._options = self._options.model_copy(update={"scale": scale, "image_size": size})
        self._refresh(points=True)

    def _open(self) -> None:
        path = dialogs.open_file(self, self._settings, "Open mapping", MAPPING_FILTER)
        if path is not None:
            mapping = read_mapping(path)
            self._mapping, self._why = mapping, ""
            self._preset, self._saved_as, self._changed = OWN, str(path), False
            self._refresh()

    def _save(self) -> None:
        path = dialogs.save_file(
            self, self._settings, "Save mapping", f"{self._path.stem}_mapping.toml", MAPPING_FILTER
        )
        if path is None:
            return
        layout = self._mapping.layout
        count = None if self._file.named else len(self._file.labels)
        named = LandmarkMapping(path.stem, self._mapping.entries, path.stem, count, layout if not count else {})
        write_mapping(path, named)
        self._mapping, self._preset, self._saved_as, self._changed = named, OWN, str(path), False
        self._refresh()

    def _accept(self, state: str) -> None:
        if self._found is not None and self._found.usable:
            self.accept()
            self.taken.emit(self._found.usable, state)

    # What is shown ------------------------------------------------------------------------------------------------

    def _show_picture(self) -> None:
        image = self._image
        self.panel.canvas.set_pictures(image.colour, -image.points[..., 2], image.valid)

    def _refresh(self, points: bool = False) -> None:
        """Find the fiducials anew and show everything; ``points``: the file's points may have moved."""
        problem = self._problem
        source, options = self._item.source, self._options
        try:
            self._found = find_fiducials(
                self._file, str(self._path), self._scheme, self._image, options, self._mapping,
                source.view, source.unit or "mm",
            )  # fmt: skip
        except InputError as error:
            self._found, problem = None, problem or str(error)
        found = self._found
        if points or found is None:
            pixels = np.full((len(self._file.points), 2), np.nan) if found is None else found.pixels
            self.panel.canvas.set_points(pixels, self._file.labels)
            self.panel.table.set_labels(self._file.labels)
        self.panel.show_rows(self._rows(), "" if self._changed else self._mapping.note)
        self._show_used()
        self.panel.show_choice(self._choice())
        told = [] if found is None else [*summary(found), *self._file.remarks]
        warning = MIRRORED if found is not None and found.mirrored else ""
        count = 0 if found is None else len(found.usable)
        self.panel.show_report(MappingReport(count, told, warning, problem))
        command, missing = self._command()
        self.panel.command.set_command(command, missing)

    def _rows(self) -> list[MappingRow]:
        rows = []
        for entry in self._scheme:
            sources = self._mapping.entries.get(entry.name, ())
            rows.append(MappingRow(entry.name, entry.side, sources_text(sources), self._state(entry.name), entry.hint))
        return rows

    def _state(self, name: str) -> str:
        found = self._found
        if found is None:
            return ""
        if name in found.places:
            return str(found.places[name])
        if name not in found.absent:
            return ""
        index = index_of(found.absent[name], self._file.labels)
        index = int(found.absent[name]) if index is None and found.absent[name].isdigit() else index
        if index is None or index >= len(found.hidden):
            return "not in file"
        return "hidden" if found.hidden[index] else "no place"

    def _indices(self, name: str) -> list[int]:
        found = (index_of(source, self._file.labels) for source in self._mapping.entries.get(name, ()))
        return [index for index in found if index is not None]

    def _show_used(self) -> None:
        used = {index: (entry.side, entry.name) for entry in self._scheme for index in self._indices(entry.name)}
        self.panel.canvas.set_used(used)
        self._show_chosen()

    def _show_chosen(self) -> None:
        name = self.panel.table.current
        self.panel.canvas.set_chosen([] if name is None else self._indices(name))

    def _choice(self) -> MappingChoice:
        file, options = self._file, self._options
        presets = [(key, mapping.title or key) for key, mapping in self._presets.items()]
        presets.append((BY_NAME, "By name"))
        preset = OWN if self._changed else self._preset
        if preset == OWN:
            name = Path(self._saved_as).name if self._saved_as else self._mapping.title or self._mapping.name
            presets.append((OWN, f"{name}, changed" if self._changed else name))
        size = file.image_size or options.image_size or (self._image.width, self._image.height)
        flat = file.dimension == 2
        return MappingChoice(
            presets, preset, file.groups, file.group, file.origin if flat else None, options.scale, size,
            file.image_size is not None,
        )  # fmt: skip

    def _command(self) -> tuple[str, str]:
        if self._changed:
            return "", "save the mapping to copy the command"
        source = self._item.source
        if not source.depth_file:
            return "", "the scan has no file"
        placing = ["--unit", source.unit] if source.unit_asked else []
        if source.view is not None and source.view_asked:
            placing += ViewOptions.of(source.view).words()
        scheme = self._scheme.name if self._item.custom is None else f"{self._scheme.name}.toml"
        mapping, out = self._saved_as or self._mapping.name, f"{self._item.name}_fiducials.json"
        command = as_convert_command(self._path, out, source.depth_file, scheme, self._options, mapping, placing)
        return command, ""
