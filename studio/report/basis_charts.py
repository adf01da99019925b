"""The charts of a basis' report, told apart by dashes and not by colour alone."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from engine.mesh import FloatArray
from studio.basis.job import BASES
from studio.report.basis_entry import BasisEntry
from studio.report.drawing import INK, RULE
from studio.report.layout import NOTE, Place, Sheet

COLOURS = {"hand": "#16181b", "quasi_eigen": "#2563eb", "pca": "#6b717a"}
DASHES: dict[str, Any] = {"hand": "-", "quasi_eigen": (0, (4, 1.2)), "pca": (0, (1, 1.4))}
_SHOWN_AXES = 60


def chart_scree(sheet: Sheet, entry: BasisEntry, place: Place) -> None:
    """Draw the variance of each axis as bars, what they explain together as a line, and how many are kept."""
    axes = sheet.figure.add_axes(sheet.share(place))
    shares = entry.eigenvalues / entry.total_variance
    count = min(len(shares), max(_SHOWN_AXES // 2, min(2 * entry.axes, _SHOWN_AXES)))
    numbers = np.arange(1, count + 1)
    axes.bar(numbers, shares[:count], color="#a9aeb6", width=0.8)
    axes.plot(numbers, np.cumsum(shares)[:count], color=INK, linewidth=1.0)
    axes.axvline(entry.axes, color=INK, linewidth=0.8, linestyle=(0, (3, 2)))
    label = f"{entry.axes} axes, {entry.coverage:.4f}"
    axes.annotate(label, (entry.axes, 0.5), (4, 0), textcoords="offset points", fontsize=NOTE)
    axes.set_ylim(0, 1.02)
    axes.set_xlim(0.3, count + 0.7)
    _dress(axes, "axis", "share of variance")


def chart_weights(sheet: Sheet, entry: BasisEntry, place: Place) -> None:
    """Draw W as a matrix: area of a square for the size, filled for positive, hollow for negative."""
    axes = sheet.figure.add_axes(sheet.share(place))
    matrix = entry.quasi.projection / np.sqrt(np.maximum(entry.eigenvalues[: entry.axes], 1e-30))
    rows, columns = matrix.shape
    largest = float(np.abs(matrix).max(initial=0.0)) or 1.0
    y, x = np.mgrid[0:rows, 0:columns]
    dot = 72 * min(place[2] / columns, place[3] / rows)
    sizes = np.abs(matrix) / largest * dot**2
    plus = matrix >= 0
    axes.scatter(x[plus] + 1, y[plus] + 1, s=sizes[plus], marker="s", color=INK, linewidths=0)
    axes.scatter(
        x[~plus] + 1, y[~plus] + 1, s=sizes[~plus], marker="s", facecolors="none", edgecolors=INK, linewidths=0.5
    )
    axes.set_xlim(0.3, columns + 0.7)
    axes.set_ylim(rows + 0.7, 0.3)
    _dress(axes, f"axis (largest square: {largest:.1f}; hollow: negative)", "shape")


def chart_curves(sheet: Sheet, entry: BasisEntry, which: int, label: str, place: Place) -> None:
    """Draw a figure of every frame by the three bases; ``which`` is 0 for alpha and 1 for RMS."""
    axes = sheet.figure.add_axes(sheet.share(place))
    for basis, title in BASES.items():
        frames, values = envelope(entry.curves[basis][which])
        axes.plot(frames, values, color=COLOURS[basis], linestyle=DASHES[basis], linewidth=0.8, label=title)
    heights = entry.curves["quasi_eigen"][which][entry.worst]
    axes.plot(entry.worst + 1, heights, marker="v", markersize=4, linestyle="none", color=INK, markeredgewidth=0)
    axes.set_xlim(1, entry.frames)
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper right", fontsize=NOTE, frameon=False, ncols=3)
    _dress(axes, "frame", label)


def _dress(axes: Any, across: str, up: str) -> None:
    axes.set_xlabel(across, fontsize=NOTE, labelpad=2)
    axes.set_ylabel(up, fontsize=NOTE, labelpad=3)
    axes.tick_params(labelsize=NOTE, length=2, width=0.6, pad=1.5)
    axes.grid(visible=True, color=RULE, linewidth=0.3)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def envelope(values: FloatArray, most: int = 900) -> tuple[FloatArray, FloatArray]:
    """Return frames from 1 and values for a line of at most ``most`` points that keeps every peak."""
    length = len(values)
    if length <= most:
        return np.arange(1.0, length + 1), values
    edges = np.linspace(0, length, most + 1).astype(int)
    peaks = np.array([start + int(np.argmax(values[start:stop])) for start, stop in pairwise(edges)])
    return peaks + 1.0, values[peaks]
