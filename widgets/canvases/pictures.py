"""What the image canvas shows, as arrays: grey depth, the missing and spike overlay, and the step to Qt."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QImage

from engine.mesh import BoolArray, FloatArray

Picture = NDArray[np.uint8]
SPIKE = (224, 168, 35)
CHECK = ((52, 54, 58), (86, 89, 95))
CHECK_PX = 2
WINDOW_PIXELS = 1_000_000
"""From so many pixels the contrast of a depth image is judged; larger ones are thinned."""
THUMB_SOURCE_PX = 800
"""Larger depth images are thinned to this side before a small picture is made of them."""


def depth_window(depth: FloatArray) -> tuple[float, float]:
    """Return near and far end (mm) of a good contrast for a depth image (H, W): the face, not what lies behind."""
    step = max(1, int(np.sqrt(depth.size / WINDOW_PIXELS)))
    valid = depth[::step, ::step]
    valid = valid[np.isfinite(valid)]
    if valid.size == 0:
        return 0.0, 1.0
    near, far = (float(v) for v in np.percentile(valid, (0.1, 88)))
    return near, max(far, near + 1.0)


def depth_picture(depth: FloatArray, near: float, far: float) -> Picture:
    """Return a grey picture (H, W, 3) of a depth image (H, W), mm: ``near`` bright, ``far`` dark, missing black."""
    share = (far - np.nan_to_num(depth, nan=far)) / max(far - near, 1e-9)
    grey = (24 + 231 * np.clip(share, 0, 1) ** 1.35).astype(np.uint8)
    grey[~np.isfinite(depth)] = 13
    return np.repeat(grey[..., None], 3, axis=2)


def with_missing(picture: Picture, valid: BoolArray, spikes: BoolArray | None, *, marked: bool = False) -> Picture:
    """Return a picture in which missing pixels are a small checkerboard and spikes amber.

    Parameters
    ----------
    picture : (H, W, 3) uint8
        What lies below.
    valid : (H, W) bool
        Where something was measured.
    spikes : (H, W) bool, optional
        Measured pixels that stand out; drawn one pixel wider and higher, so that a single one is seen.
    marked : bool
        Dims the rest, so that only what is wrong stands out.
    """
    result = (picture.astype(np.float32) * 0.45 + 12).astype(np.uint8) if marked else picture.copy()
    rows, columns = np.indices(valid.shape)
    odd = ((rows // CHECK_PX + columns // CHECK_PX) % 2).astype(bool)
    result[~valid & odd] = CHECK[0]
    result[~valid & ~odd] = CHECK[1]
    if spikes is not None and spikes.any():
        wider = spikes.copy()
        wider[:, 1:] |= spikes[:, :-1]
        wider[1:] |= wider[:-1].copy()
        result[wider & valid] = SPIKE
    return result


def depth_thumbnail(depth: FloatArray, width: int, height: int) -> Picture:
    """Return a small picture (height, width, 3) of a depth image (H, W): what was measured, missing checked."""
    step = max(1, max(depth.shape) // THUMB_SOURCE_PX)
    depth = depth[::step, ::step]
    valid = np.isfinite(depth)
    picture = depth_picture(depth, *depth_window(depth))
    inside = _filled_outline(valid)
    checked = with_missing(picture, valid | ~inside, None)
    top, bottom = _extent(np.atleast_1d(valid.any(axis=1)))
    left, right = _extent(np.atleast_1d(valid.any(axis=0)))
    middle = (left + right) / 2
    scale = max((bottom - top) / height, 1e-6)
    y = np.clip(top + (np.arange(height) + 0.5) * scale, 0, depth.shape[0] - 1).astype(int)
    x_at = middle + (np.arange(width) + 0.5 - width / 2) * scale
    x = np.clip(x_at, 0, depth.shape[1] - 1).astype(int)
    small = checked[np.ix_(y, x)]
    small[:, (x_at < 0) | (x_at >= depth.shape[1])] = 13
    return np.ascontiguousarray(small)


def _filled_outline(valid: BoolArray) -> BoolArray:
    along = np.maximum.accumulate(valid, axis=1) & np.maximum.accumulate(valid[:, ::-1], axis=1)[:, ::-1]
    down = np.maximum.accumulate(valid, axis=0) & np.maximum.accumulate(valid[::-1], axis=0)[::-1]
    return np.asarray(along & down)


def _extent(used: BoolArray) -> tuple[int, int]:
    found = np.flatnonzero(used)
    return (int(found[0]), int(found[-1]) + 1) if len(found) else (0, len(used))


def to_image(picture: Picture) -> QImage:
    """Return a Qt image with its own copy of a picture (H, W, 3) uint8."""
    data = np.ascontiguousarray(picture)
    height, width = data.shape[:2]
    return QImage(data.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()
