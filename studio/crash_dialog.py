"""The dialog of a fault of the studio: the work is safe first, then the user reads what happened."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QTimer, QUrl
from PySide6.QtGui import QDesktopServices, QGuiApplication
from PySide6.QtWidgets import QDialog, QVBoxLayout

from studio import log
from studio.crash_report import LONGEST
from widgets import theme
from widgets.viewers.mesh_viewer import MeshViewer
from widgets.window.crash_panel import HEIGHT, WIDTH, CrashPanel

if TYPE_CHECKING:
    from studio.main_window import MainWindow


class CrashDialog(QDialog):
    """Says what failed and offers what can be done: go on, save under a name, look at the report, quit.

    Parameters
    ----------
    window : MainWindow
        Whose project is kept.
    what : str
        The fault; its first line is shown by itself.
    report : Path, optional
        The report file.
    """

    def __init__(self, window: MainWindow, what: str, report: Path | None) -> None:
        super().__init__(window)
        self.setObjectName("crash")
        self.setWindowTitle("Something went wrong")
        self.setWindowModality(Qt.WindowModality.WindowModal)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._window, self._report = window, report
        self._text = _read(report) or "\n".join((what, *log.tail()))
        first = what.splitlines()[0] if what else ""
        self.panel = CrashPanel(first, _kept(window), str(report or ""), self._text, self)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.panel)
        self.panel.continued.connect(self.accept)
        self.panel.copy_requested.connect(self._copy)
        self.panel.folder_requested.connect(self._open_folder)
        self.panel.save_requested.connect(self._save)
        self.panel.quit_requested.connect(self._quit)
        room = self.screen().availableSize()
        self.resize(min(theme.px(WIDTH), room.width() - 80), min(theme.px(HEIGHT), room.height() - 80))
        self.panel.continue_button.setFocus()

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self._text)
        self.panel.tell("Copied the report.")

    def _open_folder(self) -> None:
        if self._report is not None and not QDesktopServices.openUrl(QUrl.fromLocalFile(str(self._report.parent))):
            self.panel.tell(f"No program shows folders here; the report is {self._report}")

    def _save(self) -> None:
        if self._window.files.save_as():
            self.panel.tell(f"Saved as {self._window.session.name}.")

    def _quit(self) -> None:
        self.accept()
        QTimer.singleShot(0, self._window.close)


def show_crash(window: MainWindow, title: str, text: str, report: Path | None) -> None:
    """Show a fault once the event it happened in is over: a dialog inside a paint event would only fail again.

    What is wrong with an input stands in the message bar instead; a second fault waits in the log.
    """
    if not title.startswith("Something"):
        window.message.tell("error", text)
        return

    def open_dialog() -> None:
        if window.isVisible() and window.findChild(CrashDialog) is None:
            CrashDialog(window, text, report).open()

    QTimer.singleShot(0, window, open_dialog)


def _kept(window: MainWindow) -> str:
    if not window.session.is_dirty:
        return "Nothing is unsaved."
    if not window.recovery.secure():
        return "Your unsaved work could not be written down: save it now."
    return "Your unsaved work is written down and would be offered again at the next start."


def _read(report: Path | None) -> str:
    try:
        return "" if report is None else report.read_text(encoding="utf-8")[:LONGEST]
    except OSError:
        return ""


def tell_native(window: MainWindow, reports: Sequence[Path]) -> None:
    """Say that the last session ended in a crash that nothing could catch, and where its report is."""
    if reports:
        log.studio_log.error("the studio ended abruptly; the report is %s", reports[-1].name)
        window.message.tell("info", f"The studio ended abruptly the last time. A report is in {reports[-1]}")


def graphics_of(window: MainWindow) -> dict[str, str]:
    """Return what draws the 3-D views, for reports: vendor, renderer and version of OpenGL."""
    viewer = window.stage.centre.findChild(MeshViewer)
    plotter = None if viewer is None else viewer.plotter
    lines = [] if plotter is None else str(plotter.render_window.ReportCapabilities() or "").splitlines()
    found = {}
    for line in lines:
        name, _, value = line.partition(":")
        if name.startswith("OpenGL") and name.endswith("string") and value.strip():
            found[name.removesuffix(" string")] = value.strip()
    return found
