"""Long work beside the window: it runs in a thread, reports, can be cancelled, and its result comes back as a call."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from enum import StrEnum
from typing import Any

from PySide6.QtCore import QObject, Signal

from engine.errors import Cancelled, InputError
from engine.progress import Progress

REPORT_INTERVAL = 0.05
"""Seconds between two reports of one task that reach the window."""

Work = Callable[[Progress], Any]


class TaskState(StrEnum):
    """Where a task is."""

    WAITING = "waiting"
    RUNNING = "running"
    DONE = "done"
    CANCELLED = "cancelled"
    FAILED = "failed"


class Task:
    """One piece of work and what is known about it; read by the window, changed by its `TaskRunner` alone.

    Attributes
    ----------
    title, text : str
        What is done, and the step it is at.
    fraction : float
        How far it is, 0 to 1.
    state : TaskState
        Where it is; ``error`` says in one sentence why it failed and what to do.
    quiet : bool
        True for work that follows the hand (previews) and is not listed.
    """

    def __init__(self, title: str, key: str, quiet: bool) -> None:
        self.title = title
        self.key = key
        self.quiet = quiet
        self.text = ""
        self.fraction = 0.0
        self.state = TaskState.WAITING
        self.error = ""
        self.started = time.monotonic()
        self._cancel = threading.Event()

    @property
    def active(self) -> bool:
        """Whether it waits or runs."""
        return self.state in (TaskState.WAITING, TaskState.RUNNING)

    @property
    def seconds_left(self) -> float | None:
        """How long it will take, in seconds, judged by what is done; None while that cannot be said."""
        if self.state is not TaskState.RUNNING or not 0.02 < self.fraction < 1.0:
            return None
        return (time.monotonic() - self.started) * (1.0 - self.fraction) / self.fraction


class TaskRunner(QObject):
    """Runs tasks off the GUI thread and tells about them by signals in the GUI thread.

    A task that is cancelled, or replaced by a newer one of the same key, never delivers: its late result is dropped.
    """

    changed = Signal(object)
    """A task was started, came forward or ended (`Task`)."""
    failed = Signal(object)
    """A task failed (`Task`); ``error`` says what to do."""

    _reported = Signal(object, float, str)
    _ended = Signal(object, object, object)

    def __init__(self, parent: QObject | None = None, threads: int = 2) -> None:
        super().__init__(parent)
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="task")
        self._closed = False
        self._done: dict[Task, tuple[Callable[[Any], None], Callable[[BaseException], None] | None]] = {}
        self.tasks: list[Task] = []
        self.on_crash: Callable[[BaseException], None] | None = None
        self._reported.connect(self._on_reported)
        self._ended.connect(self._on_ended)

    def submit(
        self,
        title: str,
        work: Work,
        done: Callable[[Any], None],
        *,
        failed: Callable[[BaseException], None] | None = None,
        key: str = "",
        quiet: bool = False,
    ) -> Task:
        """Run ``work(progress)`` in a thread, then ``done(result)`` in the GUI thread.

        Parameters
        ----------
        title : str
            What is done, for the user.
        work, done : callable
            ``work`` must touch neither widgets nor the project.
        failed : callable, optional
            Takes what ``work`` raised in place of the `failed` signal.
        key : str
            A newer task of the same key cancels the older one: the latest wins.
        quiet : bool
            Not listed; for previews.

        Notes
        -----
        After `shutdown` nothing is run any more; the task that is returned is cancelled.
        """
        if key:
            for other in [task for task in self._done if task.key == key]:
                self.cancel(other)
        task = Task(title, key, quiet)
        if self._closed:
            task.state = TaskState.CANCELLED
            return task
        self.tasks = [old for old in self.tasks if old.active or not old.quiet][-40:]
        self.tasks.append(task)
        self._done[task] = (done, failed)
        self._pool.submit(self._run, task, work)
        self.changed.emit(task)
        return task

    def cancel(self, task: Task) -> None:
        """Stop a task at its next report; from now on its result is not wanted."""
        if self._done.pop(task, None) is None:
            return
        task._cancel.set()
        task.state = TaskState.CANCELLED
        self.changed.emit(task)

    def cancel_all(self) -> None:
        """Cancel whatever waits or runs."""
        for task in list(self._done):
            self.cancel(task)

    @property
    def active(self) -> tuple[Task, ...]:
        """Tasks that wait or run, the oldest first, without the quiet ones."""
        return tuple(task for task in self._done if not task.quiet)

    @property
    def busy(self) -> bool:
        """Whether anything waits or runs, quiet tasks too."""
        return bool(self._done)

    def shutdown(self) -> None:
        """Cancel everything and wait until the threads have ended."""
        self._closed = True
        self.cancel_all()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _run(self, task: Task, work: Work) -> None:
        last = 0.0

        def progress(fraction: float, text: str) -> None:
            nonlocal last
            if task._cancel.is_set():
                raise Cancelled
            now = time.monotonic()
            if now - last >= REPORT_INTERVAL:
                last = now
                self._reported.emit(task, float(fraction), text)

        try:
            progress(0.0, "")
            result = work(progress)
        except BaseException as error:
            self._ended.emit(task, None, error)
        else:
            self._ended.emit(task, result, None)

    def _on_reported(self, task: Task, fraction: float, text: str) -> None:
        if task not in self._done:
            return
        if task.state is TaskState.WAITING:
            task.state, task.started = TaskState.RUNNING, time.monotonic()
        task.fraction, task.text = min(max(fraction, 0.0), 1.0), text
        self.changed.emit(task)

    def _on_ended(self, task: Task, result: Any, error: BaseException | None) -> None:
        callbacks = self._done.pop(task, None)
        if callbacks is None:
            return
        done, failed = callbacks
        if error is None:
            task.state, task.fraction = TaskState.DONE, 1.0
            self.changed.emit(task)
            done(result)
        elif isinstance(error, Cancelled):
            task.state = TaskState.CANCELLED
            self.changed.emit(task)
        else:
            task.state, task.error = TaskState.FAILED, describe(error)
            self.changed.emit(task)
            if not isinstance(error, (InputError, OSError)) and self.on_crash is not None:
                self.on_crash(error)
            elif failed is not None:
                failed(error)
            else:
                self.failed.emit(task)


def describe(error: BaseException) -> str:
    """Return one sentence for the user: what is wrong and what to do."""
    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, OSError):
        where = error.filename or "file"
        return f"{where}: {error.strerror or error}; check that it exists and that you may use it"
    return traceback.format_exception_only(error)[-1].strip()
