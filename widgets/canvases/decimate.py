"""Curves of any length as at most a few points per pixel that look the same: least and largest of every column."""

from __future__ import annotations

import numpy as np

from engine.mesh import FloatArray


def polyline(values: FloatArray, low: float, high: float, columns: int) -> tuple[FloatArray, FloatArray]:
    """Return frames and values (P,) of a line that draws ``values`` between frames ``low`` and ``high``.

    Parameters
    ----------
    values : (L,) float
        One a frame.
    low, high : float
        Frames at the left and right end, from 0; they may lie outside.
    columns : int
        Pixels between them.

    Returns
    -------
    frames, values : (P,) float
        Every frame where there are fewer than two a pixel; else the least and the largest of each column, in the order
        in which the column rises or falls. A gap (NaN) breaks the line where it is as wide as a column.
    """
    first = max(0, int(np.floor(low)) - 1)
    last = min(len(values), int(np.ceil(high)) + 2)
    if last <= first:
        return np.zeros(0), np.zeros(0)
    part = np.asarray(values[first:last], dtype=np.float64)
    frames = np.arange(first, last, dtype=np.float64)
    if len(part) <= 2 * max(1, columns):
        return frames, part
    per = max(2, int(len(part) / columns))
    # Columns are counted from frame 0, so that a view that is shifted shows the same peaks and does not flicker.
    edge = -(-first // per) * per - first
    starts = np.concatenate([[0] if edge else [], np.arange(edge, len(part), per)]).astype(np.intp)
    least, largest = np.fmin.reduceat(part, starts), np.fmax.reduceat(part, starts)
    stops = np.append(starts[1:], len(part))
    rising = ~(part[starts] > part[stops - 1])
    out = np.column_stack([np.where(rising, least, largest), np.where(rising, largest, least)])
    at = frames[starts][:, None] + (stops - starts)[:, None] * np.array([0.0, 0.5])
    return at.ravel(), out.ravel()
