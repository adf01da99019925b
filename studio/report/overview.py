"""The first page: every scan in a line with its verdicts by region, and all of them side by side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from engine.scan.limits import Limits, Verdict
from engine.scan.quality import RegionQuality
from studio.report.drawing import DIM, Picture, colour_bar, depth_picture, face_depths
from studio.report.entry import Absent, ReportEntry
from studio.report.layout import (
    BODY,
    BOTTOM,
    HEAD,
    HEADLINE,
    LEFT,
    NOTE,
    PAGE,
    TOP,
    WIDE,
    WORDS,
    Sheet,
    figure,
    limit,
)
from studio.report.region_chart import HEADS, UNITS
from studio.report.scan_page import STILL, FacePictures, entry_verdict, photo
from widgets.scene.heatmap import HeatRange

ROWS = 11
"""Scans in the table of one page."""
_ROW = 0.45
_NAME, _WORST, _FIGURES, _DOTS, _STEP, _VERDICT = 0.58, 1.72, (3.45, 3.94, 4.3), 4.5, 0.2, 6.38


def worst_region(entry: ReportEntry) -> RegionQuality | None:
    """Return the region that lies highest against its limits."""
    return max(entry.regions, key=lambda region: region.rank, default=None)


def overview_pages(
    entries: Sequence[ReportEntry],
    absent: Sequence[Absent],
    pictures: Sequence[FacePictures],
    title: str,
    facts_line: str,
    limits: Limits,
    heat: HeatRange,
) -> list[Sheet]:
    """Return the pages that come first: tables of at most ``ROWS`` scans, then what is absent, then all faces."""
    pages: list[Sheet] = []
    y = 0.0
    for start in range(0, len(entries), ROWS):
        sheet = Sheet()
        pages.append(sheet)
        y = _head(sheet, entries, absent, title if not start else f"{title}, continued", facts_line, limits)
        y = _table(sheet, y, entries[start : start + ROWS], limits)
    if absent:
        y = _absent(pages[-1], y - 0.1, absent)
    sheet, y = pages[-1], y - 0.12
    at = 0
    while at < len(entries):
        columns = 6
        count = min(columns, len(entries) - at)
        needed = 0.22 + 3 * (WIDE / columns * STILL[1] / STILL[0] + 0.05) + 0.32
        if y - needed < BOTTOM + 0.25:
            sheet = Sheet()
            pages.append(sheet)
            y = PAGE[1] - TOP
        y = _strip(sheet, y, entries[at : at + count], pictures[at : at + count], columns, limits, heat)
        at += count
    return pages


def _head(
    sheet: Sheet, entries: Sequence[ReportEntry], absent: Sequence[Absent], title: str, line: str, limits: Limits
) -> float:
    y = PAGE[1] - TOP
    sheet.write(LEFT, y, title, HEADLINE, weight=600)
    sheet.write(LEFT, y - 0.31, line, BODY, color=DIM)
    y -= 0.60
    found = [entry_verdict(entry, limits) for entry in entries]
    x = LEFT + 0.06
    for verdict in (Verdict.OK, Verdict.WARN, Verdict.FAIL):
        count = found.count(verdict)
        sheet.mark(x, y - 0.085, verdict, 7)
        sheet.write(x + 0.12, y, f"{count} {WORDS[verdict]}", 11, weight=600)
        x += 0.95
    if absent:
        sheet.write(x, y, f"{len(absent)} without a fit", 11, weight=600)
    return y - 0.40


def _table(sheet: Sheet, y: float, entries: Sequence[ReportEntry], limits: Limits) -> float:
    names = [region.name for region in entries[0].regions]
    for x, text in ((0.0, "scan"), (_WORST, "worst region")):
        sheet.write(LEFT + x, y, text, NOTE, color=DIM, va="bottom")
    for x, text in zip(_FIGURES, ("median\nmm", "99th pct.\nmm", "filled\n%"), strict=True):
        sheet.write(LEFT + x, y, text, NOTE, color=DIM, ha="right", va="bottom", linespacing=1.15)
    for k, name in enumerate(names):
        sheet.write(LEFT + _DOTS + 0.06 + k * _STEP, y, name, NOTE, color=DIM, rotation=55, va="bottom", ha="left")
    sheet.write(LEFT + _VERDICT, y, "verdict", NOTE, color=DIM, va="bottom")
    y -= 0.05
    sheet.rule(y, 0.8)
    for entry in entries:
        _line(sheet, y, entry, limits)
        y -= _ROW
        sheet.rule(y, 0.3)
    bounds = f"limit {limit(limits.median_mm)}", f"{limit(limits.p99_mm)}", f"{limit(100 * limits.filled_fraction)}"
    for x, words in zip(_FIGURES, bounds, strict=True):
        sheet.write(LEFT + x, y - 0.04, words, NOTE, color=DIM, ha="right")
    sheet.write(LEFT, y - 0.04, "Distances to the scan as measured; left and right are the subject's.", NOTE, color=DIM)
    return y - 0.20


def _line(sheet: Sheet, y: float, entry: ReportEntry, limits: Limits) -> None:
    photo(sheet, (LEFT, y - _ROW + 0.035, 0.46, _ROW - 0.07), entry, _picture(entry))
    upper = y - 0.10
    sheet.write(LEFT + _NAME, upper, entry.title, BODY + 1, weight=600)
    about = entry.note or f"{entry.scheme}, level {entry.fit.levels}"
    sheet.write(LEFT + _NAME, upper - 0.155, about, NOTE, color=DIM, weight=600 if entry.note else 400)
    worst = worst_region(entry)
    if worst is not None:
        unit = UNITS[worst.figure]
        share = 100 if unit == "%" else 1
        bound = getattr(worst.limits, worst.figure).warn * share
        sheet.write(LEFT + _WORST, upper, worst.name, BODY, weight=600 if worst.verdict is not Verdict.OK else 400)
        value = figure(getattr(worst, worst.figure), unit)
        text = f"{HEADS[worst.figure]} {value} {unit}, limit {limit(bound)}"
        sheet.write(LEFT + _WORST, upper - 0.155, text, NOTE - 0.5, color=DIM)
    quality = entry.quality
    cells = figure(quality.median_mm), figure(quality.p99_mm), figure(quality.filled_fraction, "%")
    for x, cell in zip(_FIGURES, cells, strict=True):
        sheet.write(LEFT + x, upper - 0.04, cell, BODY, ha="right")
    for k, region in enumerate(entry.regions):
        sheet.mark(LEFT + _DOTS + 0.06 + k * _STEP, upper - 0.09, region.verdict, 5.5)
    sheet.verdict(LEFT + _VERDICT, upper - 0.03, entry_verdict(entry, limits), BODY)


def _absent(sheet: Sheet, y: float, absent: Sequence[Absent]) -> float:
    sheet.write(LEFT, y, "Without a fit", HEAD, weight=600)
    y -= 0.2
    for scan in absent[:12]:
        sheet.write(LEFT, y, scan.name, BODY, weight=600)
        sheet.write(LEFT + 1.3, y, scan.reason, BODY, color=DIM)
        y -= 0.16
    if len(absent) > 12:
        sheet.write(LEFT, y, f"and {len(absent) - 12} more", BODY, color=DIM)
        y -= 0.16
    return y - 0.05


def _strip(
    sheet: Sheet,
    y: float,
    entries: Sequence[ReportEntry],
    pictures: Sequence[FacePictures],
    columns: int,
    limits: Limits,
    heat: HeatRange,
) -> float:
    wide = WIDE / columns
    tall = (wide - 0.05) * STILL[1] / STILL[0]
    for k, (entry, seen) in enumerate(zip(entries, pictures, strict=True)):
        x = LEFT + k * wide
        sheet.verdict(x, y, entry_verdict(entry, limits), NOTE)
        sheet.write(x + wide - 0.05, y, entry.title, NOTE, weight=600, ha="right")
        photo(sheet, (x, y - 0.16 - tall, wide - 0.05, tall), entry, _picture(entry), 1.5)
        sheet.picture((x, y - 0.21 - 2 * tall, wide - 0.05, tall), seen["textured", "three_quarter"])
        sheet.picture((x, y - 0.24 - 3 * tall, wide - 0.05, tall), seen["heat", "front"])
    y -= 0.24 + 3 * tall
    colour_bar(sheet.figure, sheet.share((LEFT + WIDE - 2.2, y - 0.09, 2.15, 0.07)), heat, NOTE)
    hollow = any(np.any(entry.fit.filled) for entry in entries)
    text = "Below each face its distance to the scan, mm" + ("; filled vertices are grey." if hollow else ".")
    sheet.write(LEFT, y - 0.05, text, NOTE, color=DIM)
    return y - 0.40


def _picture(entry: ReportEntry) -> Picture:
    if entry.scan.colour is not None:
        return entry.scan.colour
    return depth_picture(entry.scan, *face_depths(entry.fit.mesh.vertices))
