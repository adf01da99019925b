"""Sorted numbers written as runs: first, count, first, count, ..."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from engine.mesh import IntArray


def to_runs(numbers: IntArray) -> list[int]:
    """Return the runs of ascending numbers."""
    starts = np.flatnonzero(np.diff(numbers, prepend=-2) != 1)
    counts = np.diff(np.append(starts, len(numbers)))
    runs: list[int] = np.stack([numbers[starts], counts], axis=1).ravel().tolist()
    return runs


def from_runs(runs: Sequence[int], largest: int) -> IntArray:
    """Return the numbers of runs, those of 0 to ``largest`` - 1; empty where they are more than ``largest``."""
    firsts, counts = np.array(runs[: len(runs) // 2 * 2], dtype=np.int64).reshape(-1, 2).T
    if not len(counts) or counts.min() < 0 or counts.sum() > largest:
        return np.zeros(0, dtype=np.int64)
    ends = np.cumsum(counts)
    numbers = np.arange(int(ends[-1])) + np.repeat(firsts - (ends - counts), counts)
    kept: IntArray = numbers[(numbers >= 0) & (numbers < largest)]
    return kept
