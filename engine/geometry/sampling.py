"""Bilinear sampling of images with missing pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.mesh import BoolArray, FloatArray


def sample_bilinear(
    image: NDArray[Any], positions: FloatArray, valid: BoolArray | None = None, least: float = 0.25
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

    Returns
    -------
    values : (n, C) float
        NaN outside the image and on missing data.
    weight : (n,) float
        Share of the four neighbours' weight that was valid, 0..1.
    """
    height, width = image.shape[:2]
    if valid is None:
        valid = ~np.isnan(image).any(axis=2)
    inside = (positions >= 0).all(axis=1) & (positions[:, 0] <= width - 1) & (positions[:, 1] <= height - 1)
    place = np.where(inside[:, None], positions, 0.0)
    corner = np.minimum(np.floor(place).astype(np.int64), [width - 2, height - 2])
    fraction = place - corner
    total = np.zeros(len(positions))
    values = np.zeros((len(positions), image.shape[2]))
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        column, row = corner[:, 0] + dx, corner[:, 1] + dy
        share = np.where(dx, fraction[:, 0], 1 - fraction[:, 0]) * np.where(dy, fraction[:, 1], 1 - fraction[:, 1])
        share = np.where(valid[row, column], share, 0.0)
        values += np.where(share[:, None] > 0, share[:, None] * image[row, column], 0.0)
        total += share
    found = inside & (total >= least)
    values = np.where(found[:, None], values / np.where(total > 0, total, 1.0)[:, None], np.nan)
    return values, np.where(inside, total, 0.0)
