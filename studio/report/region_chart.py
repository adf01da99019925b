"""How far every region lies from the scan: a row each with its bar against its limits, figures, verdict."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patheffects import withStroke

from engine.mesh import FloatArray, IntArray
from engine.scan.limits import FIGURES, Verdict
from engine.scan.quality import RegionQuality
from engine.scan.regions import FaceRegions
from studio.report.drawing import DIM, INK
from studio.report.layout import INKS, LEFT, NOTE, Place, Sheet, figure, limit

ROW = 0.172
HEADS = {"median_mm": "median", "p95_mm": "95th pct.", "max_mm": "largest", "filled_fraction": "filled"}
UNITS = {"median_mm": "mm", "p95_mm": "mm", "max_mm": "mm", "filled_fraction": "%"}
_CHART = (0.78, 2.2)
"""Left end and width of the bars in inches from the table's left."""
_RIGHTS = (3.76, 4.58, 5.40, 6.20)
_VERDICT = 6.42
_TINTS = {Verdict.OK: "#e7eee9", Verdict.WARN: "#e9c877", Verdict.FAIL: "#b8484d"}
_HATCH = {Verdict.OK: "", Verdict.WARN: "/////", Verdict.FAIL: "xxxxx"}


def region_table(sheet: Sheet, top: float, regions: Sequence[RegionQuality]) -> float:
    """Draw the table and return the height below it.

    The bar ends at the 95th percentile, the white line in it is the median, the dot is the largest distance; the two
    marks are where the 95th percentile warns and fails. Beside every figure stand its two limits.
    """
    sheet.write(LEFT, top, "region", NOTE, color=DIM)
    sheet.write(LEFT + _CHART[0], top, "distance to the scan, mm", NOTE, color=DIM)
    for right, name in zip(_RIGHTS, FIGURES, strict=True):
        sheet.write(LEFT + right, top, f"{HEADS[name]}, {UNITS[name]}", NOTE, color=DIM, ha="right")
    sheet.write(LEFT + _VERDICT, top, "verdict", NOTE, color=DIM)
    y = top - 0.15
    sheet.rule(y, 0.8)
    reach = _reach(regions)
    for region in regions:
        y -= ROW
        _row(sheet, y, region, reach)
        sheet.rule(y - 0.026, 0.25)
    _scale(sheet, y - 0.026, reach)
    return y - 0.30


def _reach(regions: Sequence[RegionQuality]) -> float:
    """Return where the scale ends, mm: it shows every limit and 95th percentile, and most of the largest."""
    ends = [region.limits.p95_mm.fail for region in regions] + [r.p95_mm for r in regions if np.isfinite(r.p95_mm)]
    return 0.1 * float(np.ceil(11.0 * max(ends, default=0.5)))


def _row(sheet: Sheet, y: float, region: RegionQuality, reach: float) -> None:
    base, tall = y + 0.02, 0.085
    sheet.write(LEFT, y + ROW - 0.045, region.name, NOTE, weight=600)

    def at(value: float) -> float:
        return LEFT + _CHART[0] + _CHART[1] * min(value / reach, 1.0)

    bounds = region.limits.p95_mm
    sheet.bar((at(0), base, at(bounds.warn) - at(0), tall), "#eef0f2")
    if np.isfinite(region.p95_mm):
        verdict = region.judge("p95_mm")
        colour = "#5b6675" if verdict is Verdict.OK else INKS[verdict]
        sheet.bar((at(0), base + 0.015, at(region.p95_mm) - at(0), tall - 0.03), colour)
        middle = at(region.median_mm)
        sheet.line((middle, base + 0.015), (middle, base + tall - 0.015), 1.1, "white")
        beyond = region.max_mm > reach
        sheet.spot(at(region.max_mm), base + tall / 2, ">" if beyond else "o", 2.6, INK)
    for value, width in ((bounds.warn, 0.7), (bounds.fail, 1.5)):
        sheet.line((at(value), base - 0.012), (at(value), base + tall + 0.012), width)
    for right, name in zip(_RIGHTS, FIGURES, strict=True):
        _figure(sheet, LEFT + right, y + ROW - 0.045, region, name)
    sheet.verdict(LEFT + _VERDICT, y + ROW - 0.045, region.verdict, NOTE)


def _figure(sheet: Sheet, right: float, y: float, region: RegionQuality, name: str) -> None:
    unit, bounds, verdict = UNITS[name], getattr(region.limits, name), region.judge(name)
    share = 100 if unit == "%" else 1
    text = f"{limit(share * bounds.warn)} | {limit(share * bounds.fail)}"
    sheet.write(right, y, text, NOTE - 1.2, ha="right", color=DIM)
    value = figure(getattr(region, name), unit)
    weight = 400 if verdict is Verdict.OK else 700
    sheet.write(right - 0.44, y, value, NOTE, ha="right", weight=weight)


def _scale(sheet: Sheet, y: float, reach: float) -> None:
    left, wide = LEFT + _CHART[0], _CHART[1]
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        x = left + share * wide
        sheet.line((x, y), (x, y - 0.03), 0.5, DIM)
        sheet.write(x, y - 0.04, f"{share * reach:.3g}", NOTE - 1, ha="center", color=DIM)
    sheet.write(LEFT + _RIGHTS[-1], y - 0.04, "small: limits, warn | fail", NOTE - 1, ha="right", color=DIM)
    text = "bar: to the 95th percentile, white line: median, dot: largest; marks: limits of the 95th percentile"
    sheet.write(LEFT, y - 0.145, text, NOTE - 1, color=DIM)


def region_map(
    sheet: Sheet, place: Place, pixels: FloatArray, regions: FaceRegions, quality: Sequence[RegionQuality]
) -> None:
    """Draw the regions where they lie on the picture, plain when they pass, hatched when they do not, with names.

    Parameters
    ----------
    pixels : (N, 2) float
        Where the template's vertices lie; a subdivided face's first ones.
    """
    axes = sheet.axes(place)
    faces = regions.template.faces
    points = pixels[: len(regions.template.mirror)]
    verdict = {region.name: region.verdict for region in quality}
    for index, name in enumerate(regions.names):
        mine = faces[regions.faces == index]
        found = verdict.get(name, Verdict.OK)
        patch = PolyCollection(points[mine], facecolors=_TINTS[found], edgecolors=_TINTS[found], linewidths=0.4)
        axes.add_collection(patch)
        if _HATCH[found]:
            axes.add_collection(
                PolyCollection(points[mine], facecolors="none", edgecolors=INK, linewidths=0, hatch=_HATCH[found])
            )
    axes.add_collection(LineCollection(list(points[_borders(faces, regions.faces)]), colors=INK, linewidths=0.6))
    for index, name in enumerate(regions.names):
        x, y = _label(points, faces[regions.faces == index])
        bold = verdict.get(name) not in (Verdict.OK, None)
        text = axes.text(x, y, name, fontsize=5.4, ha="center", va="center", weight=700 if bold else 500, color=INK)
        text.set_path_effects([withStroke(linewidth=1.6, foreground="white")])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, span = (low + high) / 2, (high - low) * 1.04
    half = max(span[1], span[0] * place[3] / place[2]) / 2
    axes.set_xlim(middle[0] - half * place[2] / place[3], middle[0] + half * place[2] / place[3])
    axes.set_ylim(middle[1] + half, middle[1] - half)


def _borders(faces: IntArray, region: IntArray) -> IntArray:
    """Return the edges (k, 2) between two regions and at the rim of the mesh."""
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    edges, which = np.unique(sides, axis=0, return_inverse=True)
    of_side = np.repeat(region, 3)
    low, high = np.full(len(edges), len(region)), np.full(len(edges), -1)
    np.minimum.at(low, which.ravel(), of_side)
    np.maximum.at(high, which.ravel(), of_side)
    rim = np.bincount(which.ravel(), minlength=len(edges)) == 1
    found: IntArray = edges[rim | (low != high)]
    return found


def _label(points: FloatArray, faces: IntArray) -> tuple[float, float]:
    """Return where a region's name stands: on the triangle farthest from its border, at the picture's right."""
    middle, centre = points[faces].mean(axis=1), points.mean(axis=0)
    border = points[_borders(faces, np.zeros(len(faces), dtype=np.int64))].mean(axis=1)
    room = np.linalg.norm(middle[:, None] - border[None], axis=2).min(axis=1)
    # A little to the right, so that of two equal places always the same is taken.
    best = (room + 0.02 * (middle[:, 0] - centre[0])).argmax()
    return float(middle[best, 0]), float(middle[best, 1])
