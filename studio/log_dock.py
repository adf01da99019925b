"""Brings the log into the window: tasks, messages and Qt's own remarks become lines, and the dock shows them."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QMessageLogContext, QObject, QtMsgType, Signal, qInstallMessageHandler

from engine.files.atomic import atomic_write
from studio import dialogs, log
from studio.log import LogLine, studio_log
from studio.tasks import Task, TaskState
from widgets.window.log_view import LogView

if TYPE_CHECKING:
    from studio.main_window import MainWindow

LOG_FILTER = "Text (*.txt)"
_QT_LEVELS = {
    QtMsgType.QtDebugMsg: logging.DEBUG,
    QtMsgType.QtInfoMsg: logging.INFO,
    QtMsgType.QtWarningMsg: logging.WARNING,
    QtMsgType.QtCriticalMsg: logging.ERROR,
    QtMsgType.QtFatalMsg: logging.CRITICAL,
}


class LogDock(QObject):
    """Listens to a window and shows the lines of this process.

    Attributes
    ----------
    view : LogView
        What the dock holds.
    """

    _said = Signal(object)

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._begun: dict[Task, float] = {}
        self.view = LogView()
        log.attach()
        self.view.set_lines(log.ring.lines)
        log.ring.listener = self._hear
        self._said.connect(self._show)
        self.view.save_requested.connect(self._save)
        self.view.clear_requested.connect(self._clear)
        window.session.tasks.changed.connect(self._on_task)
        window.message.told.connect(self._on_message)

    def close(self) -> None:
        """Stop listening."""
        if log.ring.listener == self._hear:
            log.ring.listener = None
            log.detach()

    def _hear(self, line: LogLine) -> None:
        self._said.emit(line)  # by a signal, for a line may come from any thread

    def _show(self, line: LogLine) -> None:
        self.view.add(line)

    def _clear(self) -> None:
        log.ring.clear()
        self.view.set_lines(())

    def _save(self) -> None:
        path = dialogs.save_file(self._window, self._window.settings, "Save log", "studio-log.txt", LOG_FILTER)
        if path is not None:
            self._window.attempt(self.write, path)

    def write(self, path: Path) -> None:
        """Write every line that is kept to a text file.

        Raises
        ------
        OSError
            When it cannot be written; a file that was there is as before.
        """
        text = "".join(f"{line.time:%Y-%m-%d} {line}\n" for line in log.ring.lines)
        with atomic_write(path) as stream:
            stream.write(text.encode("utf-8"))

    def _on_message(self, kind: str, text: str) -> None:
        studio_log.log(logging.ERROR if kind == "error" else logging.INFO, "%s", text)

    def _on_task(self, task: Task) -> None:
        if task.quiet:
            return
        if task.active:
            if task not in self._begun:
                self._begun[task] = time.monotonic()
                studio_log.info("%s: started", task.title)
            return
        begun = self._begun.pop(task, None)
        seconds = "" if begun is None else f" after {time.monotonic() - begun:.1f} s"
        if task.state is TaskState.FAILED:
            studio_log.error("%s: failed%s: %s", task.title, seconds, task.error)
        else:
            studio_log.info("%s: %s%s", task.title, task.state.value, seconds)


def hear_qt() -> None:
    """Send what Qt remarks to the log, under the name ``qt``."""
    qInstallMessageHandler(_on_qt)


def _on_qt(kind: QtMsgType, context: QMessageLogContext, text: str) -> None:
    category = getattr(context, "category", None) or "default"
    logging.getLogger("qt").log(_QT_LEVELS.get(kind, logging.INFO), "%s (%s)", text, category)
