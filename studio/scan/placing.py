"""Placing the virtual camera before a mesh: the dialog, and what comes of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QSize, Qt, Signal
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from engine.errors import InputError
from engine.progress import Progress
from studio.project.document import ScanItem
from studio.scan.context import ScanContext
from studio.scan.view_command import SetView
from studio.scan.view_job import MeshToPlace, Seen, carried, read_to_place, see
from studio.tasks import describe
from widgets import theme

if TYPE_CHECKING:
    from engine.scan.mesh_view import MeshView
    from widgets.scan.placing_panel import Placing

_SIZE = QSize(1120, 720)


class PlacingDialog(QDialog):
    """Asks where the camera stands; ``panel.view`` and ``panel.unit`` are the answer."""

    def __init__(self, name: str, placing: Placing, parent: QWidget) -> None:
        from widgets.scan.placing_panel import PlacingPanel

        super().__init__(parent)
        self.setWindowTitle(f"Place the camera before {name}")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.panel = PlacingPanel(placing, self)
        self.trouble = QLabel("")
        self.trouble.setWordWrap(True)
        self.panel.told.connect(self._tell)
        self.use = QPushButton("&Use this view")
        self.use.setProperty("primary", True)
        self.use.setDefault(True)
        self.use.clicked.connect(self.accept)
        self.cancel = QPushButton("Cancel")
        self.cancel.setAutoDefault(False)
        self.cancel.clicked.connect(self.reject)
        hint = QLabel("Drag a ring to turn the mesh, an arrow to shift it; drag elsewhere to look around")
        hint.setProperty("dim", True)
        buttons = QHBoxLayout()
        buttons.setSpacing(8)
        buttons.addWidget(hint)
        buttons.addStretch(1)
        buttons.addWidget(self.cancel)
        buttons.addWidget(self.use)
        column = QVBoxLayout(self)
        column.setContentsMargins(16, 16, 16, 16)
        column.setSpacing(8)
        column.addWidget(self.panel, 1)
        column.addWidget(self.trouble)
        column.addLayout(buttons)
        self.resize(_SIZE.boundedTo(parent.size() * 0.95))
        theme.signals.changed.connect(self._tint)
        self._tint()

    def done(self, result: int) -> None:
        """Let go of the 3-D view before the window goes."""
        self.panel.release()
        super().done(result)

    def _tell(self, problem: str) -> None:
        self.trouble.setText(problem)
        self.use.setEnabled(not problem)
        self.use.setToolTip(problem)

    def _tint(self) -> None:
        self.trouble.setStyleSheet(f"color: {theme.current().captured}")


class MeshPlacing(QObject):
    """What Scan > Place camera does.

    Signals
    -------
    told(str, str)
        A message: kind and text.
    """

    told = Signal(str, str)

    def __init__(self, window: QWidget, context: ScanContext) -> None:
        super().__init__(window)
        self._window, self._context = window, context
        self.dialog: PlacingDialog | None = None

    def reason(self) -> str:
        """Say why the camera cannot be placed just now; empty when it can."""
        item = self._context.item
        if item is None:
            return "add a scan first"
        return "" if item.source.view is not None else "the scan in view is a range image, not a mesh"

    def open(self) -> None:
        """Read the mesh of the scan in view and ask where its camera stands."""
        item = self._context.item
        if item is None or item.source.view is None or self.dialog is not None:
            return

        def work(progress: Progress) -> MeshToPlace:
            return read_to_place(item, progress)

        def failed(error: BaseException) -> None:
            self.told.emit("error", describe(error))

        self._context.session.tasks.submit(
            f"Reading the mesh of {item.name}", work, lambda mesh: self._ask(item, mesh), failed=failed, key="placing"
        )

    def _ask(self, item: ScanItem, mesh: MeshToPlace) -> None:
        from widgets.scan.placing_panel import Placing

        if self.dialog is not None or item.id not in self._context.project or item.source.view is None:
            return
        placed = mesh.automatic
        said = f"Automatic: {placed.reason}, confidence {placed.confidence:.2f}."
        placing = Placing(mesh.light, item.source.unit, item.source.view, placed.view, said)
        dialog = PlacingDialog(item.name, placing, self._window)
        self.dialog = dialog
        dialog.accepted.connect(lambda: self._use(item, mesh, dialog.panel.view, dialog.panel.unit))
        dialog.finished.connect(self._forget)
        dialog.open()

    def _forget(self) -> None:
        self.dialog = None

    def _use(self, item: ScanItem, mesh: MeshToPlace, view: MeshView, unit: str) -> None:
        session, project = self._context.session, self._context.project
        if item.id not in project or (view == item.source.view and unit == item.source.unit):
            return
        item, image = project.scan(item.id), project.range_image(item.id)

        def work(progress: Progress) -> Seen:
            return see(item, image, mesh.file, view, unit, progress)

        def done(seen: Seen) -> None:
            landmarks, lost = seen.landmarks, seen.lost
            if item.id in project:
                now = project.scan(item.id)
                if (now.image_key, now.source) != (item.image_key, item.source):
                    problem = "has another picture since its mesh was looked at"
                    failed(InputError(f"scan {item.name}", problem, "place its camera again"))
                    return
                if now.landmarks != item.landmarks and item.source.view is not None:
                    landmarks, lost = carried(now.landmarks, (image, item.source.view), (seen.scan, view), seen.scale)
            try:
                session.stack.push(SetView(project, item.id, seen.source, seen.scan, landmarks))
            except InputError as error:
                failed(error)
                return
            if lost:
                self.told.emit("info", f"{item.name}: {lost}")

        def failed(error: BaseException) -> None:
            self.told.emit("error", describe(error))

        session.tasks.submit(f"Looking at {item.name}", work, done, failed=failed, key=f"view {item.id}")
