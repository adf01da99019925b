"""Starts the studio: theme, window, crash handler, and the project that was asked for."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from studio import dialogs
from studio.crash import CrashHandler
from studio.main_window import MainWindow
from studio.settings import Settings
from studio.theme import wear


def application() -> QApplication:
    """Return the application object, made on first use."""
    existing = QApplication.instance()
    if isinstance(existing, QApplication):
        return existing
    if sys.platform.startswith("linux") and not os.environ.get("QT_QPA_PLATFORM"):
        os.environ["QT_QPA_PLATFORM"] = "xcb"  # VTK draws into X windows; under Wayland that goes through XWayland
    QApplication.setHighDpiScaleFactorRoundingPolicy(Qt.HighDpiScaleFactorRoundingPolicy.PassThrough)
    app = QApplication(sys.argv[:1])
    app.setApplicationName("Quasiface Studio")
    app.setOrganizationName("quasiface")
    return app


def make_window(settings: Settings | None = None) -> MainWindow:
    """Return a window in the remembered theme, not yet shown."""
    settings = settings or Settings()
    wear(application(), settings)
    return MainWindow(settings)


def run(project_path: Path | None = None) -> int:
    """Open the studio, with a project where one is named, and return the exit code when its window is closed."""
    app = application()
    window = make_window()
    crashes = CrashHandler(lambda title, text, path: dialogs.show_crash(window, title, text, path))
    crashes.install()
    window.session.tasks.on_crash = crashes.handle
    if project_path is not None:
        window.painted.connect(lambda: window.open_project(Path(project_path)))
    window.show()
    try:
        return app.exec()
    finally:
        crashes.uninstall()
