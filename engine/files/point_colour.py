"""Colours that are stored beside points: packed into one number, or one number for each of red, green and blue."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.scan.range_image import ColourImage


def from_channels(channels: NDArray[Any]) -> tuple[ColourImage | None, tuple[str, ...]]:
    """Return bytes (n, 3) and warnings from columns (n, 3) of 0..255, or of 0..1 where a fraction is among them.

    None, and a warning, where a number fits neither; NaN is black.
    """
    known = np.isfinite(channels).all(axis=1)
    values = channels[known]
    if len(values) == 0 or values.min() < 0 or values.max() > 255:
        return None, ("its colours are neither 0..255 nor 0..1: left out",)
    scale = 1.0
    if values.dtype.kind == "f" and values.max() <= 1 and (values != np.rint(values)).any():
        scale = 255.0
    result = np.zeros(channels.shape, dtype=np.uint8)
    result[known] = np.rint(values * scale)
    lost = int((~known).sum())
    return result, (f"{lost} points have no colour: black",) if lost else ()


def from_packed(packed: NDArray[Any]) -> ColourImage:
    """Return bytes (n, 3) from numbers (n,) that hold 0x00RRGGBB, as an integer or as the bits of a 4-byte float.

    Numbers that were printed (float64) may be either: whole ones are the integer itself.
    """
    if packed.dtype == np.float64:
        known = np.isfinite(packed)
        whole = known & (packed == np.rint(packed)) & (packed >= 0) & (packed < 2**32)
        if whole[known].all():
            packed = np.where(whole, packed, 0).astype(np.uint32)
        else:
            with np.errstate(over="ignore", under="ignore"):
                packed = np.where(known, packed, 0).astype(np.float32)
    bits = packed.view(np.uint32) if packed.dtype == np.float32 else packed.astype(np.uint32)
    return np.stack([(bits >> shift & 255).astype(np.uint8) for shift in (16, 8, 0)], axis=1)
