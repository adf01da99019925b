"""How a figure is taken and printed."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

RUNS = 5


def fastest(work: Callable[[], Any], runs: int = RUNS) -> float:
    """Return the smallest time of some runs after one to warm up, ms."""
    work()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(1e3 * (time.perf_counter() - start))
    return min(times)


def line(name: str, value: float, unit: str, limit: float | None = None, peer: str = "") -> None:
    """Print one figure, its limit and its peer."""
    bound = "" if limit is None else f"limit {limit:g}"
    print(f"{name:<52} {value:9.2f} {unit:<5} {bound:<12} {peer}", flush=True)


def peak_mb() -> float:
    """Return the most memory this process has had resident since it began, MB."""
    status = Path("/proc/self/status")
    if status.exists():
        # Unlike getrusage, this does not remember the process that started us.
        found = [row.split()[1] for row in status.read_text().splitlines() if row.startswith("VmHWM")]
        return float(found[0]) / 1024
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
