"""Bilinear sampling of images with missing pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.mesh import BoolArray, FloatArray, IntArray


def sample_bilinear(
    image: NDArray[Any],
    positions: FloatArray,
    valid: BoolArray | None = None,
    least: float = 0.25,
    step: float | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return values at sub-pixel ``positions``, weighted by validity.

    Unweighted, a hole beside a point at 900 mm would read some 675 mm; here missing neighbours have no weight and the
    others share it.

    Parameters
    ----------
    image : (H, W, C) float
        NaN or anything else where ``valid`` is false.
    positions : (n, 2) float
        x, y in pixels, centres at integers.
    valid : (H, W) bool, optional
        The pixels that count; where left out, those without NaN.
    least : float
        Below this share of valid weight a position counts as missing and reads NaN.
    step : float, optional
        Neighbours whose last channel differs by more than this from the nearest valid one lie on another surface and
        have no weight, so that nothing is read halfway between a lip and the chin behind it.

    Returns
    -------
    values : (n, C) float
        NaN outside the image and on missing data.
    weight : (n,) float
        Share of the four neighbours' weight that was valid, 0..1.
    """
    if valid is None:
        valid = ~np.isnan(image).any(axis=2)
    index, share, inside = _neighbours(valid.shape, positions)
    share *= valid.reshape(-1)[index]
    pixels = image.reshape(-1, image.shape[2])
    if step is not None:
        depth = pixels[index, -1]
        nearest = depth[share.argmax(axis=0), np.arange(len(positions))]
        share *= ~(np.abs(depth - nearest) > step)
    total = share.sum(axis=0)
    values = np.zeros((len(positions), image.shape[2]))
    for corner, weight in zip(index, share, strict=True):
        values += np.where(weight[:, None] > 0, weight[:, None] * pixels[corner], 0.0)
    found = inside & (total >= least)
    values /= np.where(total > 0, total, 1.0)[:, None]
    values[~found] = np.nan
    return values, np.where(inside, total, 0.0)


def valid_share(valid: BoolArray, positions: FloatArray) -> FloatArray:
    """Return how much of the bilinear weight (n,) at ``positions`` (n, 2) falls on valid pixels of (H, W), 0..1."""
    index, share, inside = _neighbours(valid.shape, positions)
    return np.where(inside, (share * valid.reshape(-1)[index]).sum(axis=0), 0.0)


def _neighbours(shape: tuple[int, ...], positions: FloatArray) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return flat indices and weights (4, n) of the pixels around ``positions``, and which (n,) lie in the image."""
    height, width = shape
    x, y = positions.T
    inside = (x >= 0) & (y >= 0) & (x <= width - 1) & (y <= height - 1)
    x, y = np.where(inside, x, 0.0), np.where(inside, y, 0.0)
    column, row = np.minimum(x.astype(np.int64), width - 2), np.minimum(y.astype(np.int64), height - 2)
    right, down = x - column, y - row
    first = row * width + column
    index = np.stack([first, first + 1, first + width, first + width + 1])
    share = np.stack([(1 - right) * (1 - down), right * (1 - down), (1 - right) * down, right * down])
    return index, share, inside
