"""Runs a function in a process of its own, so that no window stutters while pages are drawn. No Qt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from engine.errors import InputError
from engine.progress import Progress

_POLL = 0.1


def apart(work: Callable[..., Any], values: Sequence[Any], progress: Progress) -> Any:
    """Return ``work(progress, *values)``, done in another process; all of it must be fit to be sent there.

    Raises
    ------
    InputError
        As ``work`` does.
    Cancelled
        From ``progress``; the process is then stopped.
    RuntimeError
        When the process failed by a fault of the program, or was stopped by the system.
    """
    context = get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(there, work, tuple(values)), daemon=True)
    progress(0.0, "starting")
    process.start()
    there.close()
    last = (0.0, "starting")
    try:
        while True:
            progress(*last)  # also while nothing comes: it may have been cancelled
            if not here.poll(_POLL):
                continue
            kind, value = here.recv()
            if kind == "progress":
                last = value
            elif kind == "done":
                return value
            elif kind == "input":
                raise InputError(*value)
            else:
                raise RuntimeError(value)
    except EOFError:
        raise RuntimeError("the process that wrote the report was stopped by the system") from None
    finally:
        here.close()
        process.terminate()
        process.join()


def _work(there: Connection, work: Callable[..., Any], values: tuple[Any, ...]) -> None:
    def told(kind: str, value: Any) -> None:
        there.send((kind, value))

    try:
        told("done", work(lambda fraction, text: told("progress", (fraction, text)), *values))
    except InputError as error:
        told("input", (error.subject, error.problem, error.remedy))
    except Exception as error:
        told("fault", f"{type(error).__name__}: {error}")
