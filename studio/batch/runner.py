"""Runs the items of a batch in worker processes, as many as memory allows, and tells their results as they come."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

from engine.progress import Progress, silent
from engine.scan.limits import Limits
from studio.batch.job import ItemResult, ScanItem, attempt
from studio.batch.options import FileItem

if TYPE_CHECKING:
    from engine.scan.fit import FaceFit

WORKER_BYTES = 600 << 20
"""What one worker takes at its peak with a scan of about a megapixel, libraries included."""

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")

Told = Callable[[int, ItemResult], None]
"""Called with the number of an item and its result as soon as it is there."""

Keep = Callable[[int, "FaceFit"], None]
"""Called with the number of an item and the fit that was made for it."""


def free_bytes() -> int | None:
    """Return how much memory programs can have, in bytes, or None where the system does not say.

    What the system only keeps in memory to read it faster counts as free: it gives that up when memory is asked for.
    """
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text("ascii").splitlines()
        return 1024 * int(next(line for line in lines if line.startswith("MemAvailable:")).split()[1])
    with contextlib.suppress(ValueError, OSError, AttributeError):
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return None


def workers_for(asked: int, items: int) -> int:
    """Return how many workers to start: as asked, but no more than items, and than free memory has room for."""
    free = free_bytes()
    return max(1, min(asked, items, asked if free is None else free // WORKER_BYTES))


def run_items(
    items: Sequence[FileItem | ScanItem],
    limits: Limits,
    *,
    workers: int = 1,
    told: Told = lambda _number, _result: None,
    progress: Progress = silent,
    keep: Keep | None = None,
) -> list[ItemResult]:
    """Run all items and return their results in order; a failure of one does not stop the others.

    With one worker everything runs in this process. With more, each has a process and one thread of its own, and no
    more items are handed out than there are workers, so that no scan waits in memory.

    Raises
    ------
    Cancelled, KeyboardInterrupt
        From ``progress`` or the user; workers are then stopped, and every file that exists is whole.
    """
    results: list[ItemResult | None] = [None] * len(items)

    def take(number: int, outcome: Outcome) -> None:
        result, fit = outcome
        results[number] = result
        if keep is not None and fit is not None:
            keep(number, fit)
        told(number, result)
        progress(sum(r is not None for r in results) / max(len(items), 1), items[number].name)

    progress(0.0, "starting")
    if workers <= 1 or len(items) <= 1:
        for number, item in enumerate(items):

            def step(fraction: float, text: str, number: int = number, name: str = item.name) -> None:
                progress((number + fraction) / len(items), f"{name}: {text}" if text else name)

            take(number, _outcome(item, limits, keep is not None, step))
    else:
        _in_processes(items, limits, workers, keep is not None, take, progress)
    return [result for result in results if result is not None]


Outcome = tuple[ItemResult, "FaceFit | None"]


def _in_processes(
    items: Sequence[FileItem | ScanItem],
    limits: Limits,
    workers: int,
    with_fit: bool,
    take: Callable[[int, Outcome], None],
    progress: Progress,
) -> None:
    # One thread each: two pools of BLAS threads on the same cores only get in each other's way.
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    pool = _pool(workers)
    waiting = list(range(len(items)))[::-1]
    running: dict[Future[Outcome], int] = {}
    try:
        while waiting or running:
            broken = False
            try:
                while waiting and len(running) < workers:
                    running[pool.submit(_work, items[waiting[-1]], limits, with_fit)] = waiting[-1]
                    waiting.pop()
            except BrokenProcessPool:  # a worker died between two items: this one has not begun
                broken = True
            done, _ = wait(running, timeout=0.0 if broken else 0.2, return_when=FIRST_COMPLETED)
            progress(1.0 - (len(waiting) + len(running)) / len(items), "")
            lost = []
            for future in sorted(done, key=running.__getitem__):
                number = running.pop(future)
                if isinstance(future.exception(), BrokenProcessPool):
                    lost.append(number)
                else:
                    take(number, future.result())
            if broken or lost:
                # One worker's death ends its pool; who it was is not known, so what ran is done again one by one.
                lost = sorted([*lost, *running.values()])
                running.clear()
                _stop(pool)
                pool = _pool(workers)
                _alone(items, limits, lost, with_fit, take)
        pool.shutdown()
    except BaseException:
        _stop(pool)
        raise
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _pool(workers: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin)


def _alone(
    items: Sequence[FileItem | ScanItem],
    limits: Limits,
    numbers: Sequence[int],
    with_fit: bool,
    take: Callable[[int, Outcome], None],
) -> None:
    for number in numbers:
        with _pool(1) as pool:
            try:
                outcome = pool.submit(_work, items[number], limits, with_fit).result()
            except BrokenProcessPool:
                text = "its worker was stopped by the system (out of memory?); run it with fewer workers"
                outcome = ItemResult(items[number].name, "failed", error=text, own_fault=True), None
        take(number, outcome)


def _stop(pool: ProcessPoolExecutor) -> None:
    processes = list((getattr(pool, "_processes", None) or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.terminate()
    for process in processes:
        process.join(5)


def _begin() -> None:
    import signal
    import threading
    from multiprocessing import connection, parent_process

    import cv2

    parent = parent_process()
    if parent is not None:
        # A worker whose batch was killed would wait for work for ever.
        def follow() -> None:
            connection.wait([parent.sentinel])
            os._exit(1)

        threading.Thread(target=follow, daemon=True).start()

    cv2.setNumThreads(1)
    # Ctrl-C reaches every process of a terminal; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(item: FileItem | ScanItem, limits: Limits, with_fit: bool) -> Outcome:
    return _outcome(item, limits, with_fit)


def _outcome(item: FileItem | ScanItem, limits: Limits, with_fit: bool, progress: Progress = silent) -> Outcome:
    """Return result and fit of an item; the fit only where it is asked for and was not there before."""
    result, fit = attempt(item, limits, progress)
    known = isinstance(item, ScanItem) and item.fit is not None
    return result, fit if with_fit and not known else None
