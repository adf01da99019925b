"""Our own faults: written to a report file, shown to the user, never swallowed."""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from engine.errors import InputError
from studio import log
from studio.crash_report import write_report

UNWRITTEN = "The report could not be written"


class CrashHandler:
    """Takes the place of `sys.excepthook`: input errors become a message, anything else a report and a dialog.

    Exceptions of slots, events and VTK's callbacks come here by Python's hook, those of threads by theirs, those of
    tasks by the runner. The same fault at the same place is shown once; after that it is only counted in the log.

    Parameters
    ----------
    show : callable
        ``show(title, text, path)`` tells the user; ``path`` is the report, None for an input error or where none could
        be written.
    folder : Path, optional
        Where reports go.
    keep : callable, optional
        Called before anything is shown: brings the user's work to safety.
    facts : mapping, optional
        What the report says besides, read when it is written.
    """

    def __init__(
        self,
        show: Callable[[str, str, Path | None], None],
        folder: Path | None = None,
        *,
        keep: Callable[[], object] | None = None,
        facts: Mapping[str, str] | None = None,
    ) -> None:
        self._show = show
        self._folder = folder
        self._keep = keep
        self._facts = facts
        self._previous = sys.excepthook
        self._previous_thread: Callable[[Any], Any] = threading.excepthook
        self._inside = False
        self._seen: set[tuple[str, str, int]] = set()

    def install(self) -> None:
        """Handle what nothing else has caught from now on."""
        self._previous, self._previous_thread = sys.excepthook, threading.excepthook
        sys.excepthook = self._hook
        threading.excepthook = self._thread_hook

    def uninstall(self) -> None:
        """Put the former handlers back."""
        sys.excepthook = self._previous
        threading.excepthook = self._previous_thread

    def handle(self, error: BaseException) -> None:
        """Report one error; a second one while the dialog is open is written but not shown."""
        if isinstance(error, InputError):
            self._tell(error.subject, str(error), None)
            return
        what = traceback.format_exception_only(error)[-1].strip()
        place = _place(error)
        if place in self._seen:
            log.studio_log.error("the same fault again: %s", what)
            return
        self._seen.add(place)
        if self._keep is not None and threading.current_thread() is threading.main_thread():
            self._secure()
        try:
            path: Path | None = write_report(error, self._folder, self._facts, log.tail())
            where = f"The report is in\n{path}"
        except OSError as failure:
            path, where = None, f"{UNWRITTEN} ({failure.strerror})."
        log.studio_log.error("fault of the studio: %s", what, exc_info=(type(error), error, error.__traceback__))
        self._previous(type(error), error, error.__traceback__)
        self._tell("Something went wrong in the studio", f"{what}\n\nYour project is still open. {where}", path)

    def _tell(self, title: str, text: str, path: Path | None) -> None:
        if self._inside or threading.current_thread() is not threading.main_thread():
            return
        self._inside = True
        try:
            self._show(title, text, path)
        finally:
            self._inside = False

    def _secure(self) -> None:
        assert self._keep is not None
        try:
            self._keep()
        except Exception:
            log.studio_log.exception("the work could not be written down")

    def _hook(self, kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if issubclass(kind, KeyboardInterrupt):
            self._previous(kind, error, trace)
        else:
            self.handle(error.with_traceback(trace))

    def _thread_hook(self, arguments: threading.ExceptHookArgs) -> None:
        if arguments.exc_value is not None and not issubclass(arguments.exc_type, SystemExit):
            self.handle(arguments.exc_value)


def _place(error: BaseException) -> tuple[str, str, int]:
    frames = traceback.extract_tb(error.__traceback__)
    last = frames[-1] if frames else None
    return type(error).__name__, last.filename if last else "", (last.lineno or 0) if last else 0
