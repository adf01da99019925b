"""A user of the real window: moves the mouse over the picture, presses keys, and waits until the window is at rest."""

from __future__ import annotations

import json
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog

import resources
from engine.files.landmarks_json import read_fiducials
from studio.main_window import MainWindow
from widgets.canvases.image_canvas import ImageCanvas
from widgets.scan.export_dialog import ExportDialog

NO_KEY = Qt.KeyboardModifier.NoModifier
LEFT = Qt.MouseButton.LeftButton


def truth(name: str = "base") -> dict[str, tuple[float, float]]:
    """Return the true fiducials of a scan of the sample, pixels."""
    return read_fiducials(resources.sample_path("subject", f"{name}_fiducials.json")).positions


@cache
def _bare_folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory()


def bare_scan(name: str = "base") -> Path:
    """Return a scan of the sample in a folder where no fiducials lie beside it."""
    folder, source = Path(_bare_folder().name), resources.sample_path("subject", f"{name}.json")
    document = json.loads(source.read_text())
    for file in (source.name, document["depth"], document["colour"]):
        if not (folder / file).exists():
            shutil.copy(source.with_name(file), folder)
    return folder / source.name


class Hand:
    """Drives one window as a hand would; every wait ends with an error when it lasts too long."""

    def __init__(self, window: MainWindow, qtbot: Any, monkeypatch: Any) -> None:
        self.window, self.qtbot, self._patch = window, qtbot, monkeypatch

    @property
    def stage(self) -> Any:
        return self.window.stage

    @property
    def canvas(self) -> ImageCanvas:
        return self.stage.centre.canvas_panel.canvas

    @property
    def landmarks(self) -> Any:
        return self.stage.context.landmarks

    def show(self) -> None:
        """Show the window and wait for its 3-D."""
        self.window.resize(1440, 900)
        self.window.show()
        with self.qtbot.waitExposed(self.window):
            pass
        self.window.activateWindow()
        # The window, or a dialog over it that is there from the start.
        self.qtbot.waitUntil(lambda: QApplication.activeWindow() is not None, timeout=10_000)
        self.qtbot.waitUntil(lambda: self.stage.centre.views.scene is not None, timeout=60_000)
        self.rest()

    def rest(self) -> None:
        """Wait until no task is left and all events are done."""
        self.qtbot.waitUntil(lambda: not self.window.session.tasks.busy, timeout=60_000)
        QTest.qWait(30)
        self.qtbot.waitUntil(lambda: not self.window.session.tasks.busy, timeout=60_000)

    def choose(self, action_id: str, path: Path) -> None:
        """Use an action whose file dialog answers with ``path``."""
        answer = lambda *_args, **_kwargs: (str(path), "")  # noqa: E731
        several = lambda *_args, **_kwargs: ([str(path)], "")  # noqa: E731
        self._patch.setattr(QFileDialog, "getOpenFileName", answer)
        self._patch.setattr(QFileDialog, "getOpenFileNames", several)
        self._patch.setattr(QFileDialog, "getSaveFileName", answer)
        self.act(action_id)
        self.rest()

    def export(self, path: Path) -> None:
        """Export the face of the scan in view to ``path`` through its dialog."""
        self.act("scan.export_face")
        (dialog,) = self.window.findChildren(ExportDialog)
        dialog.path.field.selectAll()
        QTest.keyClicks(dialog.path.field, str(path))
        QTest.keyClick(dialog.path.field, Qt.Key.Key_Return)
        self.rest()

    def act(self, action_id: str) -> None:
        """Trigger an action of a menu."""
        action = self.window.actions_[action_id]
        assert action.isEnabled(), action.toolTip()
        action.trigger()

    def at(self, x: float, y: float) -> QPoint:
        """Return the pixel of the canvas that shows the image position nearest."""
        place = self.canvas.to_view(QPointF(x, y))
        return QPoint(round(place.x()), round(place.y()))

    def click(self, x: float, y: float) -> None:
        """Click at an image position with the mouse."""
        viewport, point = self.canvas.viewport(), self.at(x, y)
        assert viewport.rect().contains(point), f"({x}, {y}) is out of sight"
        QTest.mouseMove(viewport, point)
        QTest.mouseClick(viewport, LEFT, NO_KEY, point)

    def press_move(self, start: tuple[float, float], end: tuple[float, float], steps: int = 8) -> None:
        """Press at an image position and move to another, without letting go."""
        viewport = self.canvas.viewport()
        QTest.mousePress(viewport, LEFT, NO_KEY, self.at(*start))
        for k in range(1, steps + 1):
            share = k / steps
            self.move((start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])))

    def move(self, place: tuple[float, float]) -> None:
        """Move the pressed mouse to an image position."""
        send_move(self.canvas.viewport(), QPointF(self.at(*place)), LEFT)

    def release(self, place: tuple[float, float]) -> None:
        """Let the mouse go at an image position."""
        QTest.mouseRelease(self.canvas.viewport(), LEFT, NO_KEY, self.at(*place))

    def key(self, key: Qt.Key, modifier: Qt.KeyboardModifier = NO_KEY) -> None:
        """Press a key with the picture in focus."""
        self.canvas.setFocus()
        QTest.keyClick(self.canvas, key, modifier)

    def drop(self, *paths: Path) -> None:
        """Drop files and folders on the middle of the window."""
        data = QMimeData()
        data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
        place, copy = QPointF(self.window.rect().center()), Qt.DropAction.CopyAction
        enter = QDragEnterEvent(place.toPoint(), copy, data, LEFT, NO_KEY)
        QApplication.sendEvent(self.window, enter)
        assert enter.isAccepted()
        QApplication.sendEvent(self.window, QDropEvent(place, copy, data, LEFT, NO_KEY))
        self.rest()

    def template(self) -> np.ndarray:
        """Return the template's vertices as they are drawn, image pixels; empty while there is none."""
        return np.array(self.canvas.template_vertices)

    def picture(self) -> np.ndarray:
        """Return what the 3-D views show, (H, W, 3) uint8."""
        return self.stage.centre.views.picture()

    def skin_share(self) -> float:
        """Return the share of pixels of the upper view that have the colour of skin."""
        picture = self.picture().astype(int)
        red, green, blue = np.moveaxis(picture[: picture.shape[0] // 2], -1, 0)
        return float(((red > 90) & (red > green + 15) & (green > blue)).mean())


def send_move(widget: Any, place: QPointF, button: Qt.MouseButton) -> None:
    """Send a mouse move with a button held down, which `QTest.mouseMove` cannot."""
    from PySide6.QtCore import QCoreApplication, QEvent
    from PySide6.QtGui import QMouseEvent

    event = QMouseEvent(
        QEvent.Type.MouseMove, place, widget.mapToGlobal(place), Qt.MouseButton.NoButton, button, NO_KEY
    )
    QCoreApplication.sendEvent(widget, event)
