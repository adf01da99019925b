"""Fiducials come in from and go out to files of any format: asked for here, mapped in a dialog where they need it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtWidgets import QDialog, QWidget

from engine.errors import InputError
from studio import dialogs
from studio.project.document import ScanItem
from studio.scan import edits
from studio.scan.context import ScanContext
from studio.scan.editor import FiducialEditor
from studio.scan.job import item_scheme

IMPORT_FILTER = "Fiducials and landmarks (*.json *.pts *.ljson *.csv *.tsv *.txt)"
EXPORT_FILTER = "Fiducials (*.json);;menpo landmarks (*.ljson);;Table (*.csv);;iBUG points (*.pts)"


class FiducialFiles(QObject):
    """What File > Import fiducials and Export fiducials do.

    Signals
    -------
    told(str, str)
        A message: kind and text.
    """

    told = Signal(str, str)

    def __init__(self, window: QWidget, context: ScanContext, editor: FiducialEditor) -> None:
        super().__init__(window)
        self._window, self._context, self._editor = window, context, editor

    def ask_import(self) -> None:
        """Ask for a file of landmarks and bring it to the scan in view."""
        settings, scan_id = self._context.session.settings, self._context.scan_id
        path = dialogs.open_file(self._window, settings, "Import fiducials", IMPORT_FILTER)
        if path is not None:
            if scan_id is not None:
                self._in_view(scan_id, str(path))
            self.place(path)

    def place(self, path: Path) -> None:
        """Bring a file's landmarks to the scan in view: our own at once, others through the mapping dialog.

        The dialog is for that scan to its end, also where another comes into view behind it.

        Raises
        ------
        InputError
            When there is no scan, or the file cannot be read.
        """
        item, image = self._context.item, self._context.image
        if item is None or image is None:
            raise InputError(str(path), "there is no scan to place fiducials on", "add the scan first")
        from engine.files.landmarks import read_landmarks

        file = read_landmarks(path)
        scheme = item_scheme(item)
        if file.format == "json" and file.image_size == (image.width, image.height):
            positions = {name: (x, y) for name, (x, y) in zip(file.labels, file.points.tolist(), strict=True)}
            self._editor.take(positions, str(path))
            return
        from studio.scan.fiducial_import import FiducialImportDialog

        dialog = FiducialImportDialog(path, item, image, scheme, self._context.session.settings, self._window)
        dialog.taken.connect(lambda found, state: self._take(item, found, state, path))
        _open(dialog)

    def _in_view(self, scan_id: str, subject: str, image_key: str = "") -> ScanItem:
        """Bring a scan back into view where another came there meanwhile; ``image_key``: only with that picture."""
        if scan_id not in self._context.project:
            raise InputError(subject, "its scan is not in the project any more", "import it to another scan")
        item = self._context.project.scan(scan_id)
        if image_key and item.image_key != image_key:
            raise InputError(subject, f"the picture of {item.name} has changed meanwhile", "import it again")
        self._context.select_scan(scan_id)
        return item

    def _take(self, shown: ScanItem, positions: Mapping[str, tuple[float, float]], state: str, path: Path) -> None:
        try:
            item = self._in_view(shown.id, str(path), shown.image_key)
            locked = [name for name in positions if item.landmarks[name].locked]
            if state == "proposed":
                self._editor.propose(positions, f"Import fiducials to {item.name}")
            else:
                self._editor.take(positions, str(path))
        except InputError as error:
            self.told.emit("error", str(error))
            return
        stayed = f"; {len(locked)} locked stayed" if locked else ""
        self.told.emit("info", f"{len(positions) - len(locked)} fiducials from {path.name} {state}{stayed}")

    def ask_export(self) -> None:
        """Ask for a name and write the placed fiducials: our JSON at once, other formats through a dialog."""
        item, image = self._context.item, self._context.image
        if item is None or image is None:
            return
        from engine.files.landmarks import format_of

        positions = edits.placed(item.landmarks, item_scheme(item))
        settings = self._context.session.settings
        name = f"{item.name}_fiducials.json"
        path = dialogs.save_file(self._window, settings, "Export fiducials", name, EXPORT_FILTER)
        if path is None:
            return
        size = (image.width, image.height)
        if format_of(path) == "json":
            from numpy import array

            from engine.files.landmarks import write_landmarks

            write_landmarks(path, array(list(positions.values())), tuple(positions), size)
            self.told.emit("info", f"Wrote {len(positions)} fiducials to {path}")
            return
        from studio.scan.fiducial_export import FiducialExportDialog

        dialog = FiducialExportDialog(path, item, positions, item_scheme(item), settings, self._window)
        dialog.written.connect(lambda text: self.told.emit("info", text))
        _open(dialog)


def _open(dialog: QDialog) -> None:
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.open()
