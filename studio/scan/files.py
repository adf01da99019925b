"""Files of the scan stage: range images and fiducials come in, fiducials and faces go out."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from engine.errors import InputError
from engine.files.mesh_unit import mm_per_unit
from engine.progress import Progress, part
from studio import dialogs
from studio.project.document import ScanItem
from studio.scan.commands import AddScan, SetSource
from studio.scan.context import ScanContext
from studio.scan.dropped import Dropped, ScanToRead, fiducials_beside, sort_files
from studio.scan.editor import FiducialEditor
from studio.scan.fiducial_window import FiducialFiles
from studio.scan.loading import LoadedScan, load_scan
from studio.scan.placing import MeshPlacing
from studio.scan.sample import sample_scans
from studio.tasks import describe

MOST_REMARKS = 4
"""So many remarks on scans that were read are told at once."""


class ScanFiles(QObject):
    """Asks for files, reads and writes them beside the window, and pushes what came of it."""

    told = Signal(str, str)
    """A message: kind and text."""
    kept = Signal()
    """A scan could not be read again and is as before."""

    def __init__(self, window: QWidget, context: ScanContext, editor: FiducialEditor) -> None:
        super().__init__(window)
        self._window = window
        self._context = context
        self.fiducials = FiducialFiles(window, context, editor)
        self.fiducials.told.connect(self.told)
        self.placing = MeshPlacing(window, context)
        self.placing.told.connect(self.told)

    def add(self) -> None:
        """Ask for scans and add them, with the fiducials that lie beside them."""
        paths = dialogs.open_files(self._window, self._context.session.settings, "Add scans", dialogs.SCAN_FILTER)
        if paths:  # chosen by name: read as scans, whatever their endings
            chosen = list(paths)
            self._read(_title(chosen), lambda: Dropped(tuple(ScanToRead(p, fiducials_beside(p)) for p in chosen)))

    def add_folder(self) -> None:
        """Ask for a folder and add its scans, with the fiducials that lie beside them."""
        folder = dialogs.open_folder(self._window, self._context.session.settings, "Add a folder of scans")
        if folder is not None:
            self.drop([folder])

    def drop(self, paths: Sequence[Path]) -> None:
        """Take in files and folders: scans are added as one step, fiducials are placed on the scan in view."""
        dropped = list(paths)
        self._read(_title(dropped), lambda: sort_files(dropped))

    def open_sample(self) -> None:
        """Add the scans of the bundled sample as one step."""
        scans = sample_scans()
        self._read("Reading the sample", lambda: Dropped(scans), "Open sample")

    def read_again(self, unit: str) -> None:
        """Read the scan in view from its file again, in another unit."""
        item, session = self._context.item, self._context.session
        if item is None or unit == item.source.unit:
            return
        path, project = Path(item.source.depth_file), self._context.project

        def work(progress: Progress) -> LoadedScan:
            view = item.source.view
            if view is None:
                return load_scan(ScanToRead(path), progress, unit)
            # The picture of a mesh stays as it is; its millimetres are others.
            view = view.scaled(mm_per_unit(unit) / mm_per_unit(item.source.unit))
            loaded = load_scan(ScanToRead(path), progress, unit, view)
            source = replace(loaded.item.source, view_asked=item.source.view_asked)
            return replace(loaded, item=replace(loaded.item, source=source))

        def done(loaded: LoadedScan) -> None:
            try:
                session.stack.push(SetSource(project, item.id, loaded.item.source, loaded.image))
            except InputError as error:
                failed(error)
                return
            if loaded.remarks:
                self.told.emit("info", f"{item.name}: {'. '.join(loaded.remarks)}")

        def failed(error: BaseException) -> None:
            self.told.emit("error", describe(error))
            self.kept.emit()

        session.tasks.submit(f"Reading {path.name} in {unit}", work, done, failed=failed, key=f"unit {item.id}")

    def _read(self, title: str, find: Callable[[], Dropped], text: str = "") -> None:
        """Find out beside the window what there is to read, read it, and add it as one step."""

        def work(progress: Progress) -> tuple[Dropped, list[LoadedScan], list[str]]:
            dropped = find()
            loaded, failures = [], []
            for k, scan in enumerate(dropped.scans):
                share = 1.0 / len(dropped.scans)
                try:
                    loaded.append(load_scan(scan, part(progress, share * k, share * (k + 1))))
                except InputError as error:
                    failures.append(str(error))
            return dropped, loaded, failures

        def done(result: tuple[Dropped, list[LoadedScan], list[str]]) -> None:
            dropped, loaded, failures = result
            try:
                if loaded:
                    self._add(loaded, text, dropped.left_out)
            except InputError as error:
                failures = [*failures, str(error)]
            wanted = len(dropped.scans)
            for failure in failures:  # all of them stand in the log; the message has room for a few
                logging.getLogger(__name__).warning(failure)
            if failures:
                lost = f"{len(failures)} of {wanted} scans could not be read: " if wanted > 1 else ""
                self.told.emit("error", lost + ". ".join(failures[:3]) + (" ..." if len(failures) > 3 else ""))
            elif not wanted and dropped.left_out:
                self.told.emit("error", ". ".join(dropped.left_out[:3]))
            if dropped.fiducials and not wanted:
                self._place(dropped.fiducials)

        self._context.session.tasks.submit(title, work, done)

    def _add(self, loaded: list[LoadedScan], text: str, further: Sequence[str] = ()) -> None:
        stack, project = self._context.session.stack, self._context.project
        several = len(loaded) > 1
        if several:
            stack.beginMacro(text or f"Add {len(loaded)} scans")
        try:
            for scan in loaded:
                name = project.unique_name(scan.item.name)
                stack.push(AddScan(project, _renamed(scan.item, name), scan.image))
        finally:
            if several:
                stack.endMacro()
        self._context.select_scan(project.scans[-len(loaded)].id)
        remarks = [*further, *(f"{scan.item.name}: {remark}" for scan in loaded for remark in scan.remarks)]
        came_along = 0 if text else sum(bool(scan.item.landmarks.points) for scan in loaded)
        if came_along:
            what = f"{came_along} of {len(loaded)} scans have" if several else f"{loaded[0].item.name} has"
            remarks.insert(0, f"{what} fiducials from the files beside")
        if remarks:
            more = f" and {len(remarks) - MOST_REMARKS} more remarks" if len(remarks) > MOST_REMARKS else ""
            self.told.emit("info", ". ".join(remarks[:MOST_REMARKS]) + more)

    def _place(self, files: Sequence[Path]) -> None:
        if len(files) > 1:
            self.told.emit("error", "Drop the fiducials of one scan at a time, or together with their scans")
            return
        try:
            self.fiducials.place(files[0])
        except InputError as error:
            self.told.emit("error", str(error))

    def _ask(self, title: str, file_filter: str) -> Path | None:
        return dialogs.open_file(self._window, self._context.session.settings, title, file_filter)


def _title(paths: Sequence[Path]) -> str:
    return f"Reading {paths[0].name}" if len(paths) == 1 else f"Reading {len(paths)} files"


def _renamed(item: ScanItem, name: str) -> ScanItem:
    return item if item.name == name else replace(item, name=name)
