"""Magnitudes in mm as colours: cividis over a range that stays where it was put."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from widgets.scene.background import rgb

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class HeatRange:
    """The values, in mm, at the two ends of the colour bar.

    Raises
    ------
    ValueError
        Where ``low`` is not below ``high`` or one of them is not finite.
    """

    low: float = 0.0
    high: float = 0.2

    def __post_init__(self) -> None:
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise ValueError(f"a colour range needs low < high, not {self.low:g} .. {self.high:g}")


@lru_cache(maxsize=1)
def cividis() -> NDArray[np.uint8]:
    """Return the cividis table (256, 3), uint8 sRGB."""
    import matplotlib

    table = matplotlib.colormaps["cividis"](np.linspace(0.0, 1.0, 256))[:, :3]
    result = np.round(table * 255.0).astype(np.uint8)
    result.flags.writeable = False
    return result


def heat_colours(values: FloatArray, heat: HeatRange, missing: str) -> NDArray[np.uint8]:
    """Return colours (N, 3) uint8 of values (N,) in mm; NaN becomes ``missing``, values out of range clamp."""
    values = np.asarray(values, dtype=np.float64)
    unit = (values - heat.low) / (heat.high - heat.low)
    index = np.clip(np.nan_to_num(unit, nan=0.0, posinf=1.0, neginf=0.0) * 255.0 + 0.5, 0, 255).astype(np.intp)
    colours = cividis()[index]
    colours[np.isnan(values)] = np.round(np.array(rgb(missing)) * 255.0).astype(np.uint8)
    return colours


def share_above(values: FloatArray, heat: HeatRange) -> float:
    """Return the share 0..1 of the known values that lie above the range; 0 where nothing is known."""
    known = values[~np.isnan(values)]
    return float((known > heat.high).mean()) if len(known) else 0.0


def share_text(values: FloatArray, heat: HeatRange) -> str:
    """Return what leaves the range in words, such as ``0.4 % above 0.2``; empty where nothing is known."""
    known = values[~np.isnan(values)]
    if not len(known):
        return ""
    percent = 100.0 * share_above(values, heat)
    shown = f"{percent:.1f}" if percent >= 0.05 or percent == 0 else "< 0.1"
    text = f"{shown} % above {number(heat.high)}"
    below = 100.0 * float((known < heat.low).mean())
    return f"{below:.1f} % below {number(heat.low)}, {text}" if below > 0 else text


def ticks(heat: HeatRange) -> tuple[float, ...]:
    """Return the values written under a colour bar: both ends and the middle."""
    return (heat.low, 0.5 * (heat.low + heat.high), heat.high)


def number(value: float) -> str:
    """Return a value in mm as it is written at a tick: no more figures than it needs, at most three."""
    return f"{float(f'{value:.3g}'):g}"
