"""Round numbers for axes."""

from __future__ import annotations

import math


def step_for(low: float, high: float, most: int) -> float:
    """Return a step of 1, 2 or 5 times a power of ten that makes at most ``most`` intervals of ``low .. high``."""
    span = high - low
    if not (math.isfinite(span) and span > 0):
        return 1.0
    raw = span / max(1, most)
    power = 10.0 ** math.floor(math.log10(raw))
    return next(power * k for k in (1, 2, 5, 10) if power * k >= raw * (1 - 1e-9))


def ticks(low: float, high: float, most: int) -> tuple[tuple[float, ...], float]:
    """Return the multiples of a round step within ``low .. high``, and the step."""
    step = step_for(low, high, most)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return tuple(k * step for k in range(first, last + 1)), step


def tick_text(value: float, step: float) -> str:
    """Return a tick's number with as many decimals as its step needs."""
    if step >= 1e5 or step < 1e-4:
        return f"{value:g}".replace("-", "−")
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    return f"{value:.{digits}f}".replace("-", "−")


def ceiling(value: float, most: int) -> float:
    """Return the end of an axis from 0 that shows ``value`` with at most ``most`` intervals; 1 where there is none."""
    if not (math.isfinite(value) and value > 0):
        return 1.0
    step = step_for(0.0, value, most)
    return max(value * 1.06, step)
