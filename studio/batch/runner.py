"""Runs the items of a batch in worker processes, as many as memory allows, and tells their results as they come."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

from engine.progress import Progress, silent
from engine.scan.limits import Limits
from studio.batch.job import ItemResult, ScanItem, attempt
from studio.batch.options import FileItem

WORKER_BYTES = 600 << 20
"""What one worker takes at its peak with a scan of about a megapixel, libraries included."""

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")

Told = Callable[[int, ItemResult], None]
"""Called with the number of an item and its result as soon as it is there."""


def workers_for(asked: int, items: int) -> int:
    """Return how many workers to start: as asked, but no more than items, and than free memory has room for."""
    room = asked
    with contextlib.suppress(ValueError, OSError, AttributeError):
        free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        room = int(free // WORKER_BYTES)
    return max(1, min(asked, items, room))


def run_items(
    items: Sequence[FileItem | ScanItem],
    limits: Limits,
    *,
    workers: int = 1,
    told: Told = lambda _number, _result: None,
    progress: Progress = silent,
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

    def take(number: int, result: ItemResult) -> None:
        results[number] = result
        told(number, result)
        progress(sum(r is not None for r in results) / max(len(items), 1), items[number].name)

    progress(0.0, "starting")
    if workers <= 1 or len(items) <= 1:
        for number, item in enumerate(items):

            def step(fraction: float, text: str, number: int = number, name: str = item.name) -> None:
                progress((number + fraction) / len(items), f"{name}: {text}" if text else name)

            take(number, attempt(item, limits, step)[0])
    else:
        _in_processes(items, limits, workers, take, progress)
    return [result for result in results if result is not None]


def _in_processes(
    items: Sequence[FileItem | ScanItem],
    limits: Limits,
    workers: int,
    take: Callable[[int, ItemResult], None],
    progress: Progress,
) -> None:
    # One thread each: two pools of BLAS threads on the same cores only get in each other's way.
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin)
    waiting: list[tuple[int, FileItem | ScanItem]] = []
    for number, item in enumerate(items):
        if isinstance(item, ScanItem) and item.fit is not None:
            take(number, attempt(item, limits)[0])  # only to be written: not worth sending it to another process
        else:
            waiting.insert(0, (number, item))
    running: dict[Future[ItemResult], int] = {}
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                number, item = waiting.pop()
                running[pool.submit(_work, item, limits)] = number
            done, _ = wait(running, timeout=0.2, return_when=FIRST_COMPLETED)
            progress(1.0 - (len(waiting) + len(running)) / len(items), "")
            for future in done:
                number = running.pop(future)
                try:
                    take(number, future.result())
                except BrokenProcessPool:
                    # One worker's death ends its pool; who it was is not known, so what ran is done again one by one.
                    lost = sorted([number, *running.values()])
                    running.clear()
                    _alone(items, limits, lost, take)
                    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin)
                    break
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


def _alone(
    items: Sequence[FileItem | ScanItem],
    limits: Limits,
    numbers: Sequence[int],
    take: Callable[[int, ItemResult], None],
) -> None:
    for number in numbers:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_begin) as pool:
            try:
                result = pool.submit(_work, items[number], limits).result()
            except BrokenProcessPool:
                text = "its worker was stopped by the system (out of memory?); run it with fewer workers"
                result = ItemResult(items[number].name, "failed", error=text, own_fault=True)
        take(number, result)


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


def _work(item: FileItem | ScanItem, limits: Limits) -> ItemResult:
    return attempt(item, limits)[0]
