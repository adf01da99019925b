"""What pages and plates are drawn with: one font, pictures at their pixels, marks, captions, colour bars."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib import font_manager, patheffects
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from engine.mesh import FloatArray, IntArray
from engine.scan.range_image import RangeImage
from widgets.scene.fiducials import side_colour
from widgets.scene.heatmap import HeatRange, cividis, number, ticks

INK, DIM, RULE = "#16181b", "#4a4f57", "#b9bec6"
CHOSEN = "#e5192d"
"""Red of chosen points, as in the paper's figures."""

Picture = NDArray[np.uint8]
Box = tuple[float, float, float, float]
"""Left, right, bottom, top in pixels (y downwards: bottom > top)."""


def family() -> str:
    """Return Inter where it is installed, else the font that comes with matplotlib."""
    known = {font.name for font in font_manager.fontManager.ttflist}
    return "Inter" if "Inter" in known else "DejaVu Sans"


def settings() -> Any:
    """Return matplotlib settings for a page or plate: text stays text, one font, thin lines."""
    return {
        "font.family": family(),
        "text.color": INK,
        "axes.edgecolor": RULE,
        "axes.linewidth": 0.6,
        "xtick.color": INK,
        "ytick.color": INK,
        "pdf.fonttype": 3,
        "figure.facecolor": "white",
        "axes.unicode_minus": True,
    }


def picture_axes(figure: Figure, place: tuple[float, float, float, float]) -> Any:
    """Return axes without ticks or frame at (left, bottom, width, height) in parts of the figure."""
    axes = figure.add_axes(place)
    axes.set_axis_off()
    return axes


def show(axes: Any, picture: Picture, box: Box | None = None) -> None:
    """Draw a picture (H, W, 3) or (H, W), pixel centres at integers, or the part of it inside ``box``."""
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="antialiased", aspect="equal")
    if box is not None:
        axes.set_xlim(box[0], box[1])
        axes.set_ylim(box[2], box[3])


def wire(axes: Any, points: FloatArray, edges: IntArray, colour: str, width: float, opacity: float = 1.0) -> None:
    """Draw edges (E, 2) between flat points (N, 2)."""
    axes.add_collection(LineCollection(list(points[edges]), colors=colour, linewidths=width, alpha=opacity))


def marks(axes: Any, points: Mapping[str, tuple[float, float]], size: float, colour: str | None = None) -> None:
    """Draw fiducials as discs with a dark rim, in one colour or in those of their sides; ``size`` in points."""
    places = np.array([points[name] for name in points], dtype=np.float64).reshape(-1, 2)
    colours = [colour or side_colour(name) for name in points]
    rim = min(0.6, 0.16 * size)
    axes.scatter(places[:, 0], places[:, 1], s=size**2, c=colours, edgecolors="#1e1f22", linewidths=rim, zorder=5)


def numbers(axes: Any, points: Mapping[str, tuple[float, float]], size: float, offset: float) -> None:
    """Write the numbers 1, 2, ... of fiducials beside them, ``offset`` data units to the upper right."""
    halo = [patheffects.withStroke(linewidth=2.2, foreground="white")]
    for index, (x, y) in enumerate(points.values(), start=1):
        label = axes.text(x + offset, y - offset, str(index), fontsize=size, weight=600, color=INK, zorder=6)
        label.set_path_effects(halo)


def face_box(points: FloatArray, aspect: float, shape: tuple[int, int], margin: float = 0.10) -> Box:
    """Return the part of an image of ``shape`` (H, W) that shows points (N, 2) px with room around, width / height."""
    low, high = points.min(axis=0), points.max(axis=0)
    centre, span = (low + high) / 2, (high - low) * (1 + 2 * margin)
    width, height = max(span[0], span[1] * aspect), max(span[1], span[0] / aspect)
    shrink = min(1.0, shape[1] / width, shape[0] / height)
    width, height = width * shrink, height * shrink
    x = float(np.clip(centre[0], width / 2 - 0.5, shape[1] - 0.5 - width / 2))
    y = float(np.clip(centre[1], height / 2 - 0.5, shape[0] - 0.5 - height / 2))
    return (x - width / 2, x + width / 2, y + height / 2, y - height / 2)


def depth_picture(scan: RangeImage, near_mm: float, far_mm: float) -> Picture:
    """Return the range image as grey (H, W, 3), near bright; missing pixels are blue-black, unlike any depth."""
    depth = -scan.points[..., 2]
    unit = np.clip((far_mm - depth) / (far_mm - near_mm), 0.0, 1.0)
    grey = np.where(np.isnan(depth), 0.0, 40.0 + 215.0 * np.nan_to_num(unit))
    picture = np.repeat(grey[..., None], 3, axis=2)
    picture[np.isnan(depth)] = (24, 27, 38)
    return np.asarray(np.clip(picture + 0.5, 0, 255), dtype=np.uint8)


def face_depths(vertices: FloatArray) -> tuple[float, float]:
    """Return a near and far depth in mm that show a face's relief well."""
    low, high = np.percentile(-vertices[:, 2], [0.0, 100.0])
    room = 0.1 * (high - low)
    return float(low - room), float(high + 3 * room)


def colour_bar(figure: Figure, place: tuple[float, float, float, float], heat: HeatRange, size: float) -> None:
    """Draw a cividis bar with ticks in mm, ``size`` points high letters."""
    axes = figure.add_axes(place)
    axes.imshow(cividis()[None, :, :], aspect="auto", extent=(heat.low, heat.high, 0, 1))
    axes.set_yticks([])
    axes.set_xticks(list(ticks(heat)))
    labels = [number(value) for value in ticks(heat)]
    labels[-1] += " mm"
    written = axes.set_xticklabels(labels, fontsize=size)
    written[0].set_horizontalalignment("left")
    written[-1].set_horizontalalignment("right")
    axes.tick_params(length=2, width=0.6, pad=1.5)
