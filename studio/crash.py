"""Our own faults: written to a report file, shown to the user, never swallowed."""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from engine.errors import InputError
from studio.crash_report import write_report


class CrashHandler:
    """Takes the place of `sys.excepthook`: input errors become a message, anything else a report and a dialog.

    Parameters
    ----------
    show : callable
        ``show(title, text, path)`` tells the user; ``path`` is the report, None for an input error.
    folder : Path, optional
        Where reports go.
    """

    def __init__(self, show: Callable[[str, str, Path | None], None], folder: Path | None = None) -> None:
        self._show = show
        self._folder = folder
        self._previous = sys.excepthook
        self._inside = False

    def install(self) -> None:
        """Handle what nothing else has caught from now on."""
        self._previous = sys.excepthook
        sys.excepthook = self._hook

    def uninstall(self) -> None:
        """Put the former handler back."""
        sys.excepthook = self._previous

    def handle(self, error: BaseException) -> None:
        """Report one error; a second one while the dialog is open is written but not shown."""
        if isinstance(error, InputError):
            path, title, text = None, error.subject, str(error)
        else:
            path = write_report(error, self._folder)
            title = "Something went wrong in the studio"
            text = (
                f"{traceback.format_exception_only(error)[-1].strip()}\n\n"
                f"Your project is still open: save it under a new name. The report is in\n{path}"
            )
            self._previous(type(error), error, error.__traceback__)
        if self._inside or threading.current_thread() is not threading.main_thread():
            return
        self._inside = True
        try:
            self._show(title, text, path)
        finally:
            self._inside = False

    def _hook(self, kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if issubclass(kind, KeyboardInterrupt):
            self._previous(kind, error, trace)
        else:
            self.handle(error.with_traceback(trace))
