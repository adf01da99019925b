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
_UNEXPLAINED, _LEAST_NOISE = 2e-4, 1e-8
_FRAMES_PER_AXIS = 4


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
    covariance of the clip (probabilistic PCA: motion of few axes comes back), shifted so that it meets both ends of the
    gap (ours). Markers seen in less than a tenth of the frames that show any, and frames that
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
    table = positions.reshape(len(positions), -1)
    known = np.repeat(full, 3, axis=1)
    filled = np.where(known, table, np.nanmean(table, axis=0))
    patterns, of = np.unique(full, axis=0, return_inverse=True)
    of = of.reshape(-1)
    complete = full.all(axis=1)
    rounds = 1 if complete.sum() >= 6 * full.shape[1] else _ROUNDS
    doubt = np.zeros((table.shape[1], table.shape[1]))
    for _ in range(rounds):
        believed = _Believed(filled[complete] if rounds == 1 else filled, doubt)
        doubt = np.zeros_like(doubt)
        for number, pattern in enumerate(patterns):
            missing = np.repeat(~pattern, 3)
            if missing.any():
                rows = np.flatnonzero(of == number)
                filled[np.ix_(rows, missing)] = believed.expected(filled[rows], pattern)
                doubt[np.ix_(missing, missing)] += len(rows) * believed.doubt(pattern)
    result = filled.reshape(positions.shape)
    _meet_ends(result, full, believed)
    return result


class _Believed:
    """Mean and covariance of a clip's coordinates, and what they make of frames that show only some markers."""

    def __init__(self, table: FloatArray, doubt: FloatArray) -> None:
        self.mean: FloatArray = table.mean(axis=0)
        centred = table - self.mean
        values, axes = np.linalg.eigh((centred.T @ centred + doubt) / len(table))
        values, axes = np.maximum(values[::-1], 0.0), axes[:, ::-1]
        total = max(float(values.sum()), 1e-300)
        rank = int(np.searchsorted(np.cumsum(values), (1 - _UNEXPLAINED) * total)) + 1
        rank = max(1, min(rank, len(table) // _FRAMES_PER_AXIS, len(values)))
        # What lies beyond the clip's few axes is noise, alike in all directions (Tipping & Bishop 1999).
        noise = max(float(values[rank:].mean()) if rank < len(values) else 0.0, _LEAST_NOISE * total / len(values))
        main = axes[:, :rank]
        self.covariance: FloatArray = (main * (values[:rank] - noise).clip(0)) @ main.T + noise * np.eye(len(values))
        self._gains: dict[bytes, FloatArray] = {}

    def expected(self, rows: FloatArray, pattern: BoolArray) -> FloatArray:
        """Return the coordinates (r, missing) that a pattern of seen markers (K,) lacks, from rows (r, 3K)."""
        seen = np.repeat(pattern, 3)
        found: FloatArray = self.mean[~seen] + (rows[:, seen] - self.mean[seen]) @ self._gain(pattern)
        return found

    def doubt(self, pattern: BoolArray) -> FloatArray:
        """Return the covariance that remains of what a pattern lacks."""
        seen = np.repeat(pattern, 3)
        left: FloatArray = self.covariance[np.ix_(~seen, ~seen)] - self.covariance[np.ix_(~seen, seen)] @ self._gain(
            pattern
        )
        return left

    def _gain(self, pattern: BoolArray) -> FloatArray:
        key = pattern.tobytes()
        if key not in self._gains:
            seen = np.repeat(pattern, 3)
            inner = self.covariance[np.ix_(seen, seen)]
            self._gains[key] = np.asarray(np.linalg.solve(inner, self.covariance[np.ix_(seen, ~seen)]))
        return self._gains[key]


def _meet_ends(filled: FloatArray, full: BoolArray, believed: _Believed) -> None:
    """Shift every filled run in place so that it goes on from the frames beside it.

    By as much as the expectation is off there, if those frames lacked the same markers; from one end to the other the
    shift changes evenly.
    """
    rows = filled.reshape(len(filled), -1).copy()

    def off(marker: int, end: int, inside: int) -> FloatArray:
        pattern = full[inside]
        missing = np.flatnonzero(~pattern)
        place = 3 * int(np.searchsorted(missing, marker))
        said = believed.expected(rows[end : end + 1], pattern)[0, place : place + 3]
        return np.asarray(rows[end, 3 * marker : 3 * marker + 3] - said)

    for k in range(full.shape[1]):
        gaps = np.flatnonzero(~full[:, k])
        for run in np.split(gaps, np.flatnonzero(np.diff(gaps) > 1) + 1) if len(gaps) else []:
            before, after = int(run[0]) - 1, int(run[-1]) + 1
            first = off(k, before, before + 1) if before >= 0 else None
            last = off(k, after, after - 1) if after < len(full) else None
            if first is None and last is None:
                continue
            start, stop = (first if first is not None else last), (last if last is not None else first)
            share = ((np.arange(len(run)) + 1) / (len(run) + 1))[:, None]
            filled[run, k] += np.asarray(start) * (1 - share) + np.asarray(stop) * share


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
