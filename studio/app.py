"""Starts the studio: theme, window, crash handler, and the project that was asked for."""

from __future__ import annotations

import os
import sys
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from studio import log
from studio.crash import CrashHandler
from studio.crash_dialog import graphics_of, show_crash, tell_native
from studio.log_dock import hear_qt
from studio.main_window import MainWindow
from studio.native_crash import NativeWatch
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
    watch = NativeWatch()
    watch.start()
    hear_qt()
    with log.to_file() as log_file:
        window = make_window()
        log.studio_log.info("the studio starts; its log is kept in %s", log_file)
        facts: dict[str, str] = {}
        crashes = CrashHandler(partial(show_crash, window), keep=window.recovery.secure, facts=facts)
        crashes.install()
        window.session.tasks.on_crash = crashes.handle
        window.views_ready.connect(lambda: facts.update(graphics_of(window)))
        window.painted.connect(lambda: tell_native(window, watch.left_behind()))
        if project_path is not None:
            window.painted.connect(lambda: window.open_project(Path(project_path)))
        window.show()
        try:
            return app.exec()
        finally:
            crashes.uninstall()
            watch.stop()
            log.studio_log.info("the studio ends")
