"""Exports the face of the scan in view: the dialog, the job behind it, and the command that does the same."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from engine.errors import InputError
from engine.progress import Progress
from engine.scan.range_image import RangeImage
from studio.project.document import ScanItem
from studio.scan.job import as_command, check_overwrites, export_face, face_files
from widgets.scan.export_dialog import ExportDialog, FaceContents

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit
    from studio.main_window import MainWindow


class FaceExport(QObject):
    """Opens the dialog over a window and writes what it asks for beside it, as a task."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window

    def ask(self, item: ScanItem, image: RangeImage, fit: FaceFit) -> ExportDialog:
        """Open the dialog for the face of a scan, and return it."""
        from engine.files.obj import obj_files  # with OpenCV, which the first paint need not wait for

        texture = None if image.colour is None else (image.width, image.height)
        contents = FaceContents(len(fit.mesh.vertices), len(fit.mesh.faces), texture)

        def files(path: Path) -> tuple[Path, ...]:
            return (path,) if path.suffix.lower() == ".glb" else tuple(obj_files(path, texture is not None))

        name = f"{item.name}_fiducials.json"
        note = f"The command reads {name} beside the face; Export fiducials writes it."
        dialog = ExportDialog(
            contents,
            self._proposed(item),
            lambda path: as_command(item, item.options, str(path.with_name(name)), str(path)),
            files,
            note,
            self._window,
        )
        dialog.export_requested.connect(lambda path: self._export(dialog, image, fit, path))
        dialog.open()
        return dialog

    def _proposed(self, item: ScanItem) -> Path:
        kept = Path(self._window.settings["files/folder"])
        project = self._window.session.project.path
        usual = Path.home() if project is None else project.parent
        return (kept if self._window.settings["files/folder"] and kept.is_dir() else usual) / f"{item.name}.glb"

    def _export(self, dialog: ExportDialog, image: RangeImage, fit: FaceFit, path: Path) -> None:
        from studio.batch.sources import project_sources

        try:
            sources = project_sources(self._window.session.project)
            check_overwrites(face_files(path, image.colour is not None), sources)
        except (InputError, OSError) as error:
            dialog.tell(str(error))
            return
        self._window.settings["files/folder"] = str(path.parent)

        def work(progress: Progress) -> tuple[Path, ...]:
            return export_face(fit, image, path, progress, sources=sources)

        def done(written: tuple[Path, ...]) -> None:
            self._window.message.tell("info", f"Wrote {', '.join(str(file) for file in written)}")

        self._window.session.tasks.submit(f"Exporting {path.name}", work, done)
        dialog.accept()
