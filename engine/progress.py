"""How a long computation tells its caller where it is."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float, str], None]
"""``progress(fraction, text)`` with fraction in 0..1; it raises ``engine.errors.Cancelled`` to stop."""


def silent(fraction: float, text: str) -> None:
    """Take a progress report and do nothing."""


def part(progress: Progress, start: float, stop: float) -> Progress:
    """Return a progress that reports 0..1 as the share ``start``..``stop`` of ``progress``."""

    def report(fraction: float, text: str) -> None:
        progress(start + (stop - start) * fraction, text)

    return report
