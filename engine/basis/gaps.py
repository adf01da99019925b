"""Gaps of markers: short ones closed in time, longer ones from the other markers, each of them counted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.errors import InputError
from engine.mesh import BoolArray, FloatArray, IntArray, frozen

_SLOPE_FRAMES = 6
_LEAST_SEEN = 0.1
_LEAST_OTHERS = 0.25
_ROUNDS = 8
_NOISE = 1e-4


@dataclass(frozen=True)
class FilledMarkers:
    """Markers without gaps.

    Parameters
    ----------
    positions : (L', K', 3) float
        mm, finite.
    frames : (L',) int
        Which frames they are of: those that show too few markers are left out.
    markers : (K',) int
        Which markers: those that are hardly ever seen are left out.
    short, long : int
        Positions that were filled between neighbouring frames, and from the other markers.
    longest : int
        Frames of the longest gap that was filled.
    """

    positions: FloatArray
    frames: IntArray
    markers: IntArray
    short: int
    long: int
    longest: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", frozen(self.positions, np.float64))
        object.__setattr__(self, "frames", frozen(self.frames, np.int64))
        object.__setattr__(self, "markers", frozen(self.markers, np.int64))


def fill_gaps(positions: FloatArray, longest: int) -> FilledMarkers:
    """Return markers (L, K, 3), NaN where not seen, with all gaps filled.

    Gaps of at most ``longest`` frames between two sights are closed by a cubic through both ends, with the slopes of
    the frames beside them. What remains is the most probable place given the markers that are seen, under the mean and
    covariance of the clip (a low-rank completion: noise-free markers of low rank come back exactly), shifted so that it
    meets both ends of the gap (ours). Markers seen in less than a tenth of the frames that show any, and frames that
    show less than a quarter of the markers after that, are left out.

    Parameters
    ----------
    positions : (L, K, 3) float
        mm.
    longest : int
        Frames.

    Raises
    ------
    InputError
        When nothing is left.
    """
    seen = _seen(positions)
    shown = seen.any(axis=1)
    often = np.asarray(seen[shown].mean(axis=0) >= _LEAST_SEEN if shown.any() else np.zeros(seen.shape[1], bool))
    markers = np.flatnonzero(often)
    if not len(markers):
        raise InputError("markers", "are hardly ever seen", "choose another clip")
    work = positions[:, markers].copy()
    short, longest_closed = _close_short(work, longest)
    full = _seen(work)
    frames = np.flatnonzero(full.mean(axis=1) >= min(_LEAST_OTHERS, 1.0))
    if not len(frames):
        raise InputError("markers", "are never seen together", "choose another clip")
    closed = _seen(work) & ~seen[:, markers]
    short = int(closed[frames].sum())
    work, full = work[frames], full[frames]
    long = int((~full).sum())
    longest_gap = max(longest_closed, _longest_run(~full))
    if long:
        work = _completed(work, full)
    return FilledMarkers(work, frames, markers, short, long, longest_gap)


def _close_short(positions: FloatArray, longest: int) -> tuple[int, int]:
    """Close gaps in place by cubics; return how many positions, and the frames of the longest one closed."""
    total = most = 0
    seen = _seen(positions)
    for k in range(positions.shape[1]):
        track = positions[:, k]
        good = seen[:, k]
        known = np.flatnonzero(good)
        for place in np.flatnonzero(np.diff(known) > 1):
            before, after = int(known[place]), int(known[place + 1])
            length = after - before - 1
            if length > longest:
                continue
            run_in = _slope(track, good, range(before, max(before - _SLOPE_FRAMES, -1), -1))
            run_out = _slope(track, good, range(after, min(after + _SLOPE_FRAMES, len(track))))
            track[before + 1 : after] = _hermite(track[before], track[after], run_in, run_out, length + 1)
            total += length
            most = max(most, length)
    return total, most


def _slope(track: FloatArray, good: BoolArray, frames: range) -> FloatArray | None:
    """Slope (3,) per frame of a line through the unbroken frames from the first; None with fewer than two."""
    used: list[int] = []
    for frame in frames:
        if not good[frame]:
            break
        used.append(frame)
    if len(used) < 2:
        return None
    time = np.array(used, dtype=np.float64)
    time -= time.mean()
    slope: FloatArray = time @ (track[used] - track[used].mean(axis=0)) / (time @ time)
    return slope


def _hermite(
    start: FloatArray, end: FloatArray, run_in: FloatArray | None, run_out: FloatArray | None, steps: int
) -> FloatArray:
    straight = (end - start) / steps
    first = (straight if run_in is None else run_in) * steps
    last = (straight if run_out is None else run_out) * steps
    s = np.arange(1, steps)[:, None] / steps
    cubic: FloatArray = (
        (2 * s**3 - 3 * s**2 + 1) * start
        + (s**3 - 2 * s**2 + s) * first
        + (3 * s**2 - 2 * s**3) * end
        + (s**3 - s**2) * last
    )
    return cubic


def _completed(positions: FloatArray, full: BoolArray) -> FloatArray:
    """Fill what is missing with its expectation given what is seen, under mean and covariance found by rounds of EM."""
    count = positions.shape[1]
    table = positions.reshape(len(positions), -1)
    known = np.repeat(full, 3, axis=1)
    mean = np.nanmean(table, axis=0)
    filled = np.where(known, table, mean)
    patterns, of = np.unique(full, axis=0, return_inverse=True)
    of = of.reshape(-1)
    complete = np.flatnonzero(full.all(axis=1))
    rounds = 1 if len(complete) >= 6 * count else _ROUNDS
    basis = filled[complete] if rounds == 1 else filled
    extra = np.zeros((3 * count, 3 * count))
    for _ in range(rounds):
        mean = basis.mean(axis=0)
        centred = basis - mean
        covariance = (centred.T @ centred + extra) / len(basis)
        ridge = _NOISE * float(np.trace(covariance)) / (3 * count)
        extra = np.zeros_like(covariance)
        for number, pattern in enumerate(patterns):
            missing = np.repeat(~pattern, 3)
            if not missing.any():
                continue
            rows = np.flatnonzero(of == number)
            seen = ~missing
            inner = covariance[np.ix_(seen, seen)] + ridge * np.eye(int(seen.sum()))
            gain = np.linalg.solve(inner, covariance[np.ix_(seen, missing)])
            filled[np.ix_(rows, missing)] = mean[missing] + (table[np.ix_(rows, seen)] - mean[seen]) @ gain
            if rounds > 1:
                rest = covariance[np.ix_(missing, missing)] - covariance[np.ix_(missing, seen)] @ gain
                extra[np.ix_(missing, missing)] += len(rows) * rest
    result = filled.reshape(positions.shape)
    _meet_ends(result, positions, full)
    return result


def _meet_ends(filled: FloatArray, positions: FloatArray, full: BoolArray) -> None:
    """Shift every filled run in place so that it goes on from the frames beside it."""
    guess = None
    for k in range(positions.shape[1]):
        missing = np.flatnonzero(~full[:, k])
        if not len(missing):
            continue
        if guess is None:
            guess = _off_at_ends(filled, positions, full)
        for run in np.split(missing, np.flatnonzero(np.diff(missing) > 1) + 1):
            before, after = int(run[0]) - 1, int(run[-1]) + 1
            ends = [guess[e, k] for e in (before, after) if 0 <= e < len(full)]
            if not ends:
                continue
            first = guess[before, k] if before >= 0 else ends[0]
            last = guess[after, k] if after < len(full) else ends[-1]
            share = ((np.arange(len(run)) + 1) / (len(run) + 1))[:, None]
            filled[run, k] += first * (1 - share) + last * share


def _off_at_ends(filled: FloatArray, positions: FloatArray, full: BoolArray) -> FloatArray:
    """By how much the seen markers beside gaps are off from what the others would have said of them (L, K, 3)."""
    count = positions.shape[1]
    table = filled.reshape(len(filled), -1)
    mean = table.mean(axis=0)
    centred = table - mean
    covariance = centred.T @ centred / len(table)
    ridge = _NOISE * float(np.trace(covariance)) / (3 * count)
    off = np.zeros_like(positions)
    for k in range(count):
        gap = ~full[:, k]
        beside = np.flatnonzero(full[:, k] & (np.roll(gap, 1) | np.roll(gap, -1)))
        if not gap.any() or not len(beside):
            continue
        own = np.zeros(3 * count, dtype=bool)
        own[3 * k : 3 * k + 3] = True
        inner = covariance[np.ix_(~own, ~own)] + ridge * np.eye(3 * count - 3)
        gain = np.linalg.solve(inner, covariance[np.ix_(~own, own)])
        said = mean[own] + centred[np.ix_(beside, ~own)] @ gain
        off[beside, k] = positions[beside, k] - said
    return off


def _longest_run(missing: BoolArray) -> int:
    most = 0
    for column in missing.T:
        edges = np.flatnonzero(np.diff(np.concatenate([[0], column.astype(np.int8), [0]])))
        if len(edges):
            most = max(most, int((edges[1::2] - edges[::2]).max()))
    return most


def _seen(positions: FloatArray) -> BoolArray:
    seen: BoolArray = np.asarray(np.isfinite(positions).all(axis=2), dtype=bool)
    return seen
