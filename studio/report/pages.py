"""A PDF report of fitted scans: one page to judge by, then every scan large enough to look at."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from engine.errors import InputError
from engine.scan.quality import Check, Limits, verdicts
from studio.report.drawing import (
    DIM,
    INK,
    RULE,
    Picture,
    colour_bar,
    depth_picture,
    face_box,
    face_depths,
    marks,
    picture_axes,
    settings,
    show,
)
from studio.report.entry import ReportEntry
from widgets.scene.heatmap import HeatRange, share_text
from widgets.scene.stills import Stills

_PAGE = (8.27, 11.69)
"""A4 upright, inches."""
_LEFT, _RIGHT, _TOP, _BOTTOM = 0.7, 0.7, 0.7, 0.6
_WIDE = _PAGE[0] - _LEFT - _RIGHT
_HEADLINE, _HEAD, _BODY, _NOTE = 15.0, 9.5, 7.5, 6.5
_ROWS = 3
_STILL = (600, 700)
_WORDS = {"ok": "ok", "warn": "over limit", "fail": "FAIL", None: ""}


def write_report(
    path: str | Path,
    entries: Sequence[ReportEntry],
    *,
    title: str = "Scans fitted to the template",
    limits: Limits | None = None,
    heat: HeatRange | None = None,
) -> Path:
    """Write a PDF report and return its path.

    The first page has the figures of all scans with limits and verdicts in words, and a strip of pictures; the
    pages after it show per scan the colour image with its fiducials, the textured face and its distance to the scan.
    Text is text, pictures are embedded, and everything reads in grey.

    Parameters
    ----------
    path : path
        The PDF.
    entries : sequence of ReportEntry
    title : str
        Headline of the first page.
    limits : Limits, optional
        What the figures are judged by.
    heat : HeatRange, optional
        Range of the distance pictures in mm, the same for all of them.

    Raises
    ------
    InputError
        Without entries, or where the file cannot be written.
    """
    if not entries:
        raise InputError("report", "there is no fitted scan", "fit one first")
    heat, limits = heat or HeatRange(), limits or Limits()
    path = Path(path)
    with Stills(*_STILL) as stills:
        textured = [stills.face(e.fit, "textured", picture=e.scan.colour) for e in entries]
        distance = [stills.face(e.fit, "heat", heat=heat) for e in entries]
    with mpl.rc_context(settings()):
        pages = [_summary(entries, title, limits, heat, textured, distance)]
        for start in range(0, len(entries), _ROWS):
            part = slice(start, start + _ROWS)
            pages.append(_scans(entries[part], limits, heat, textured[part], distance[part]))
        for number, page in enumerate(pages, start=1):
            _foot(page, number, len(pages))
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with PdfPages(path, metadata={"Title": title, "Creator": program(), "CreationDate": None}) as pdf:
                for page in pages:
                    pdf.savefig(page, dpi=220)
        except OSError as error:
            raise InputError(str(path), f"cannot be written ({error.strerror})", "choose another place") from None
    return path


def program() -> str:
    """Return the program's name and version."""
    try:
        return f"Quasiface Studio {version('quasiface-studio')}"
    except PackageNotFoundError:
        return "Quasiface Studio"


def _summary(
    entries: Sequence[ReportEntry],
    title: str,
    limits: Limits,
    heat: HeatRange,
    textured: Sequence[Picture],
    distance: Sequence[Picture],
) -> Figure:
    page = Figure(figsize=_PAGE)
    y = _PAGE[1] - _TOP
    _write(page, _LEFT, y, title, _HEADLINE, weight=600)
    y -= 0.30
    _write(page, _LEFT, y, _facts(entries), _BODY, color=DIM)
    y -= 0.42
    y = _table(page, y, entries, limits)
    y -= 0.16
    note = (
        "Distances run from the vertices that were measured to the scan as it was measured, noise included; filled "
        f"vertices are counted apart.\nA figure up to {limits.tolerance:g} times its limit is over limit, beyond it a "
        "failure. Left and right are the subject's."
    )
    _write(page, _LEFT, y, note, _NOTE, color=DIM, linespacing=1.4)
    y -= 0.52
    y = _strip(page, y, "Scans and fiducials", entries, None)
    for heading, pictures in (("Fitted faces", textured), (f"Distance to the scan, {_range(heat)}", distance)):
        y = _strip(page, y, heading, entries, pictures)
    colour_bar(page, _place(_LEFT + _WIDE - 2.2, y - 0.02, 2.2, 0.09), heat, _NOTE)
    _write(page, _LEFT, y + 0.08, "Filled vertices are grey.", _NOTE, color=DIM)
    return page


def _facts(entries: Sequence[ReportEntry]) -> str:
    levels = sorted({entry.fit.levels for entry in entries})
    schemes = sorted({entry.scheme for entry in entries})
    sizes = sorted({f"{entry.scan.width} x {entry.scan.height}" for entry in entries})
    return (
        f"{program()}    {len(entries)} scan{'s' if len(entries) > 1 else ''}, {', '.join(sizes)} px    "
        f"level {', '.join(map(str, levels))}    scheme {', '.join(schemes)}    lengths in mm, fiducials in px"
    )


def _table(page: Figure, y: float, entries: Sequence[ReportEntry], limits: Limits) -> float:
    checks = [verdicts(entry.quality, limits) for entry in entries]
    columns = checks[0]
    first = 1.28
    step = (_WIDE - first) / (len(columns) + 1)
    rights = [_LEFT + first + step * (k + 1) for k in range(len(columns) + 1)]
    _write(page, _LEFT, y, "scan", _NOTE, color=DIM)
    for right, check in zip(rights, columns, strict=False):
        _write(page, right, y, _heading(check), _NOTE, color=DIM, ha="right", linespacing=1.25)
    _write(page, rights[-1], y, "fiducials\nmet\npx", _NOTE, color=DIM, ha="right", linespacing=1.25)
    y -= 0.47
    _rule(page, y + 0.06, 0.8)
    for entry, row in zip(entries, checks, strict=True):
        _write(page, _LEFT, y, entry.title, _BODY, weight=600)
        for right, check in zip(rights, row, strict=False):
            _write(page, right, y, _figure(check), _BODY, ha="right", weight=_weight(check))
            word = _WORDS[None if check.verdict is None else str(check.verdict)]
            _write(page, right, y - 0.135, word, _NOTE, ha="right", color=DIM, weight=_weight(check))
        _write(page, rights[-1], y, f"{entry.quality.fiducial_residual_px:.0e}", _BODY, ha="right")
        y -= 0.33
        _rule(page, y + 0.05, 0.3)
    _write(page, _LEFT, y, "limit", _BODY, color=DIM)
    for right, check in zip(rights, columns, strict=False):
        if check.limit is not None:
            _write(page, right, y, _number(check.limit, check.unit), _BODY, ha="right", color=DIM)
    _rule(page, y - 0.16, 0.8)
    return y - 0.16


def _strip(
    page: Figure, y: float, heading: str, entries: Sequence[ReportEntry], pictures: Sequence[Picture] | None
) -> float:
    _write(page, _LEFT, y, heading, _HEAD, weight=600)
    y -= 0.20
    columns = max(min(len(entries), 7), 6)
    width = _WIDE / columns
    height = width * _STILL[1] / _STILL[0]
    for index, entry in enumerate(entries[:columns]):
        left = _LEFT + index * width
        place = (left + 0.03, y - height, width - 0.06, height)
        if pictures is None:
            _photo(page, place, entry, 1.6)
        else:
            show(picture_axes(page, _place(*place)), pictures[index])
        _write(page, left + width / 2, y - height, entry.title, _NOTE, ha="center")
    return y - height - 0.34


def _scans(
    entries: Sequence[ReportEntry],
    limits: Limits,
    heat: HeatRange,
    textured: Sequence[Picture],
    distance: Sequence[Picture],
) -> Figure:
    page = Figure(figsize=_PAGE)
    block = (_PAGE[1] - _TOP - _BOTTOM) / _ROWS
    for row, (entry, face, heatmap) in enumerate(zip(entries, textured, distance, strict=True)):
        top = _PAGE[1] - _TOP - row * block
        _write(page, _LEFT, top, entry.title, _HEAD, weight=600)
        _write(page, _LEFT + 1.3, top - 0.015, _story(entry), _BODY, color=DIM)
        height = block - 0.72
        width = min((_WIDE - 1.75 - 0.2) / 3, height * _STILL[0] / _STILL[1])
        bottom = top - 0.26 - height
        _photo(page, (_LEFT, bottom, width, height), entry, 3.0)
        for column, still in ((1, face), (2, heatmap)):
            left = _LEFT + column * (width + 0.1)
            show(picture_axes(page, _place(left, bottom, width, height)), still)
        bar_left = _LEFT + 2 * (width + 0.1) + 0.15 * width
        colour_bar(page, _place(bar_left, bottom - 0.02, 0.7 * width, 0.08), heat, _NOTE)
        _write(page, bar_left + 0.7 * width, bottom + 0.18, share_text(entry.fit.deviation_mm, heat) + " mm", _NOTE,
               ha="right", color=DIM)  # fmt: skip
        _write(page, _LEFT, bottom - 0.04, f"{len(entry.landmarks)} fiducials", _NOTE, color=DIM)
        _write(page, _LEFT + width + 0.1, bottom - 0.04, "textured, level " + str(entry.fit.levels), _NOTE, color=DIM)
        _list(page, _LEFT + 3 * (width + 0.1) + 0.1, top - 0.26, entry, limits)
    return page


def _photo(page: Figure, place: tuple[float, float, float, float], entry: ReportEntry, size: float) -> None:
    """Draw the colour image (grey depth without one) around the face, with its fiducials."""
    axes = picture_axes(page, _place(*place))
    picture = entry.scan.colour
    if picture is None:
        picture = depth_picture(entry.scan, *face_depths(entry.fit.mesh.vertices))
    show(axes, picture, face_box(entry.fit.pixels, place[2] / place[3], picture.shape[:2]))
    marks(axes, dict(entry.landmarks), size)


def _list(page: Figure, left: float, top: float, entry: ReportEntry, limits: Limits) -> None:
    right = _LEFT + _WIDE
    y = top
    for check in verdicts(entry.quality, limits):
        unit = f", {_unit(check)}" if _unit(check) else ""
        _write(page, left, y, f"{check.name}{unit}", _NOTE, color=DIM)
        _write(page, right - 0.42, y, _figure(check), _NOTE, ha="right", weight=_weight(check))
        word = _WORDS[None if check.verdict is None else str(check.verdict)]
        _write(page, right, y, word, _NOTE, ha="right", color=INK if word not in ("", "ok") else DIM)
        y -= 0.165
    repair = entry.fit.repair
    for name, value in (
        ("missing pixels, %", f"{100 * repair.missing_fraction:.1f}"),
        ("spikes removed", f"{repair.spikes}"),
        ("pixels filled", f"{repair.filled_pixels}"),
        ("triangles", f"{entry.quality.faces}"),
    ):
        _write(page, left, y, name, _NOTE, color=DIM)
        _write(page, right - 0.42, y, value, _NOTE, ha="right")
        y -= 0.165
    if entry.fit.folded_fiducials:
        _write(page, left, y, "folds beside:\n" + "\n".join(entry.fit.folded_fiducials[:4]), _NOTE, linespacing=1.3)


def _story(entry: ReportEntry) -> str:
    said = f'held at "{entry.held}" of "{entry.word}", ' if entry.word else ""
    return f"{said}scheme {entry.scheme}, {entry.scan.width} x {entry.scan.height} px"


def _heading(check: Check) -> str:
    name = {"95th percentile": "95th\npercentile", "99th percentile": "99th\npercentile", "scan noise": "scan\nnoise",
            "filled vertices": "filled\nvertices", "folded triangles": "folded\ntriangles",
            "smallest angle": "smallest\nangle"}.get(check.name, check.name)  # fmt: skip
    lines = [*name.split("\n"), _unit(check)]
    return "\n".join(lines + [""] * (3 - len(lines)))


def _unit(check: Check) -> str:
    return {"count": "", "degrees": "deg"}.get(check.unit, check.unit)


def _figure(check: Check) -> str:
    return _number(check.value, check.unit)


def _number(value: float, unit: str) -> str:
    if not np.isfinite(value):
        return "none"
    return f"{value:.0f}" if unit == "count" else f"{value:.3f}" if unit == "mm" else f"{value:.1f}"


def _weight(check: Check) -> int:
    return 400 if check.verdict is None or str(check.verdict) == "ok" else 600


def _range(heat: HeatRange) -> str:
    return f"{heat.low:g} to {heat.high:g} mm"


def _foot(page: Figure, number: int, count: int) -> None:
    _write(page, _LEFT, 0.42, program(), _NOTE, color=DIM)
    _write(page, _LEFT + _WIDE, 0.42, f"{number} / {count}", _NOTE, ha="right", color=DIM)


def _place(left: float, bottom: float, width: float, height: float) -> tuple[float, float, float, float]:
    return (left / _PAGE[0], bottom / _PAGE[1], width / _PAGE[0], height / _PAGE[1])


def _write(page: Figure, x: float, y: float, text: str, size: float, **style: Any) -> None:
    page.text(x / _PAGE[0], y / _PAGE[1], text, fontsize=size, va="top", **style)


def _rule(page: Figure, y: float, width: float) -> None:
    from matplotlib.lines import Line2D

    ends = (_LEFT / _PAGE[0], (_LEFT + _WIDE) / _PAGE[0])
    page.add_artist(Line2D(ends, (y / _PAGE[1], y / _PAGE[1]), color=RULE, linewidth=width))
