"""All faces on one PNG: picture, face, distance, name and verdict of every scan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from engine.files.atomic import atomic_write
from engine.scan.limits import Limits
from studio.report.drawing import DIM, colour_bar, depth_picture, face_box, face_depths, picture_axes, show
from studio.report.entry import ReportEntry
from studio.report.layout import INKS, WORDS
from studio.report.overview import worst_region
from studio.report.scan_page import STILL, FacePictures, entry_verdict
from widgets.scene.heatmap import HeatRange

COLUMNS = 6
_DPI, _WIDE, _SPACE = 160, 1.7, 0.06


def write_contact_sheet(
    path: str | Path,
    entries: Sequence[ReportEntry],
    pictures: Sequence[FacePictures],
    limits: Limits,
    heat: HeatRange,
) -> Path:
    """Write the sheet and return its path; at most ``COLUMNS`` scans stand beside each other.

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    columns = min(COLUMNS, len(entries))
    rows = -(-len(entries) // columns)
    tall = _WIDE * STILL[1] / STILL[0]
    block = 3 * (tall + _SPACE) + 0.62
    size = (columns * (_WIDE + _SPACE) + 0.3, rows * block + 0.45)
    page = Figure(figsize=size)
    for index, (entry, seen) in enumerate(zip(entries, pictures, strict=True)):
        left = 0.15 + (index % columns) * (_WIDE + _SPACE)
        top = size[1] - 0.12 - (index // columns) * block
        verdict, worst = entry_verdict(entry, limits), worst_region(entry)
        _write(page, size, left, top, entry.title, 10, weight=600)
        _write(page, size, left + _WIDE, top, WORDS[verdict], 10, ha="right", weight=600, color=INKS[verdict])
        about = "" if worst is None else f"worst: {worst.name}"
        _write(page, size, left, top - 0.19, f"median {entry.quality.median_mm:.3f} mm, {about}", 7, color=DIM)
        picture = entry.scan.colour
        if picture is None:
            picture = depth_picture(entry.scan, *face_depths(entry.fit.mesh.vertices))
        for k in range(3):
            bottom = top - 0.40 - (k + 1) * tall - k * _SPACE
            axes = picture_axes(page, (left / size[0], bottom / size[1], _WIDE / size[0], tall / size[1]))
            if k == 0:
                show(axes, picture, face_box(entry.fit.pixels, _WIDE / tall, picture.shape[:2]))
            else:
                show(axes, seen["textured", "three_quarter"] if k == 1 else seen["heat", "front"])
    colour_bar(page, (0.15 / size[0], 0.26 / size[1], min(3.0, size[0] - 0.4) / size[0], 0.09 / size[1]), heat, 7)
    with atomic_write(path) as handle:
        page.savefig(handle, format="png", dpi=_DPI, metadata={"Software": None})
    return Path(path)


def _write(page: Figure, size: tuple[float, float], x: float, y: float, text: str, points: float, **style: Any) -> None:
    page.text(x / size[0], y / size[1], text, fontsize=points, va="top", **style)
