"""How a performance is read and laid onto the rig, chosen over a preview: unit, axes, rate, head markers, pairs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QVBoxLayout

from engine.errors import InputError
from engine.progress import Progress, part
from studio import dialogs
from studio.basis.files import PAIRS_FILTER
from studio.basis.loading import motion_of
from studio.basis.motions import prepare
from studio.basis.options import MotionOptions
from studio.project.basis_items import MotionItem
from studio.tasks import describe
from widgets import theme
from widgets.basis.motion_import_panel import HEIGHT, WIDTH, MotionImportPanel
from widgets.basis.motion_import_values import MotionChoice, MotionImportFacts

if TYPE_CHECKING:
    from engine.files.motion_file import MotionFile
    from engine.shapes import Rig
    from studio.basis.controller import BasisStage
    from studio.basis.motions import PreparedMotion

KEY = "basis settings"
Read = tuple["MotionFile", "PreparedMotion | None", str]


class MotionSettings:
    """Shows the settings of the performance in use, and sets up what was chosen."""

    def __init__(self, stage: BasisStage) -> None:
        self._stage = stage

    def open(self) -> MotionDialog:
        """Show them over the window.

        Raises
        ------
        InputError
            Without a performance.
        """
        item = self._stage.context.motion
        if item is None:
            raise InputError("settings", "need a performance", "open one first")
        dialog = MotionDialog(self._stage, item)
        dialog.open()
        return dialog


class MotionDialog(QDialog):
    """Reads the file under every choice beside the window, and shows what comes of it; Import pushes one step."""

    def __init__(self, stage: BasisStage, item: MotionItem) -> None:
        super().__init__(stage.window)
        self.setObjectName("motion_settings")
        self.setWindowTitle(f"Performance {item.name}")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._stage, self._item = stage, item
        self._path = item.link.path if item.link is not None else Path(item.source)
        self.options = item.options
        self.panel = MotionImportPanel("Use performance", self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        self.panel.changed.connect(self._on_choice)
        self.panel.pairs_requested.connect(self._ask_pairs)
        self.panel.pairs_dropped.connect(lambda: self._read(self._with(pairs=None)))
        self.panel.accepted.connect(self._accept)
        self.panel.rejected.connect(self.reject)
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))
        self._show_present()

    def _rig(self) -> Rig | None:
        """Return the rig that markers lie on."""
        basis = self._stage.context.basis
        driver = basis.driver
        return None if driver is None else basis.rig(driver)

    def _show_present(self) -> None:
        """Show what is there, then read the file, which says what it states itself."""
        data = self._stage.context.basis.motion_data(self._item.content)
        if data is not None:
            self._show(data, self._item.unit, self._item.assumed, self._stage.follower.prepared, ())
        self._read(self.options)

    def _on_choice(self, choice: MotionChoice) -> None:
        self._read(self._with(**vars(choice)))

    def _with(self, **values: object) -> MotionOptions:
        return MotionOptions.checked(**{**self.options.model_dump(), **values})

    def _read(self, options: MotionOptions) -> None:
        """Read and bind beside the window; the latest choice wins."""
        self.options = options
        rig, path = self._rig(), self._path
        self.panel.show_pending("reading ...", busy=True)

        def work(progress: Progress) -> Read:
            file = motion_of(path, options)
            if rig is None:
                return file, None, ""
            try:
                return file, prepare(file.data, rig, options, None, part(progress, 0.3, 1.0)), ""
            except InputError as error:
                return file, None, str(error)

        def done(found: Read) -> None:
            file, prepared, problem = found
            self.panel.show_pending("")
            self._show(file.data, file.unit, file.assumed, prepared, file.guessed, file, problem)

        self._stage.window.session.tasks.submit(
            f"Reading {path.name}", work, done, failed=self._on_failed, key=KEY, quiet=True
        )

    def _on_failed(self, error: BaseException) -> None:
        self.panel.show_pending(describe(error))

    def _show(
        self,
        data: object,
        unit: str,
        assumed: str,
        prepared: PreparedMotion | None,
        guessed: tuple[str, ...],
        file: MotionFile | None = None,
        problem: str = "",
    ) -> None:
        rig, options = self._rig(), self.options
        bound = None if prepared is None else prepared.bound
        found_head = () if bound is None else bound.head_labels
        facts = MotionImportFacts(
            self._path.name,
            data,  # type: ignore[arg-type]
            unit,
            options.up or (file.up if file is not None else "y"),
            options.forward or (file.forward if file is not None else "z"),
            guessed,
            assumed,
            found_head if options.head is None else options.head,
            bound,
            None if rig is None else rig.mesh,
            len(options.pairs or {}),
            (*(() if file is None else file.warnings), *(() if prepared is None else prepared.notes)),
            problem,
        )
        kept = ("unit", "up", "forward", "fps", "head", "rest_frame", "scale")
        self.panel.show_facts(facts, MotionChoice(**{name: getattr(options, name) for name in kept}))

    def _ask_pairs(self) -> None:
        path = dialogs.open_file(self, self._stage.window.settings, "Marker pairs", PAIRS_FILTER)
        if path is None:
            return
        from engine.files.marker_pairs import read_marker_pairs

        try:
            pairs = {pair.label: pair.target for pair in read_marker_pairs(path)}
            self._read(self._with(pairs=pairs))
        except InputError as error:
            self.panel.show_pending(str(error))

    def _accept(self, choice: MotionChoice) -> None:
        options = self._with(**vars(choice))
        self.accept()
        if options != self._item.options:
            self._stage.window.attempt(self._stage.files.read_again, self._item, options)

    def done(self, result: int) -> None:
        """Stop what is being read for the preview."""
        tasks = self._stage.window.session.tasks
        for task in [task for task in tasks.tasks if task.key == KEY and task.active]:
            tasks.cancel(task)
        super().done(result)
