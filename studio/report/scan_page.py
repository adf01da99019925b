"""The page of one scan: what went in, the face, its distance to the scan region by region, and where it is from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.scan.limits import Limits, Verdict
from engine.scan.quality import Check, overall, verdicts
from engine.scan.regions import FaceRegions
from studio.report.drawing import DIM, Picture, colour_bar, depth_picture, face_box, face_depths, marks, show
from studio.report.entry import ReportEntry
from studio.report.layout import (
    BODY,
    HEAD,
    HEADLINE,
    LEFT,
    NOTE,
    PAGE,
    TOP,
    WIDE,
    WORDS,
    Place,
    Sheet,
    facts,
    figure,
    limit,
)
from studio.report.region_chart import region_map, region_table
from widgets.scene.calm import SMOOTHED
from widgets.scene.face import Look
from widgets.scene.heatmap import HeatRange, share_text
from widgets.scene.stills import Stills

STILL = (420, 500)
"""Size of a picture of the face in pixels."""

_SHOTS: tuple[tuple[Look, str], ...] = (
    ("textured", "front"),
    ("textured", "three_quarter"),
    ("textured", "left"),
    ("shaded", "front"),
    ("shaded", "three_quarter"),
    ("shaded", "left"),
    ("heat", "front"),
    ("heat", "left"),
)
_VIEWS = {"front": "front", "three_quarter": "three-quarter", "left": "left side"}


@dataclass(frozen=True)
class FacePictures:
    """The pictures of one face by (look, view)."""

    pictures: dict[tuple[str, str], Picture]

    def __getitem__(self, key: tuple[str, str]) -> Picture:
        return self.pictures[key]


def face_pictures(stills: Stills, entry: ReportEntry, heat: HeatRange) -> FacePictures:
    """Return every picture of a face that the report needs."""
    taken = stills.album(entry.fit, _SHOTS, picture=entry.scan.colour, heat=heat)
    return FacePictures(dict(zip(_SHOTS, taken, strict=True)))


def entry_verdict(entry: ReportEntry, limits: Limits) -> Verdict:
    """Return the worst verdict on a scan: its own figures and those of its regions."""
    return overall(verdicts(entry.quality, limits), entry.regions)


def scan_page(
    entry: ReportEntry, pictures: FacePictures, regions: FaceRegions, limits: Limits, heat: HeatRange
) -> Sheet:
    """Return the page of one scan."""
    sheet = Sheet()
    y = _head(sheet, entry, limits)
    y = _inputs(sheet, y, entry, regions)
    y = _faces(sheet, y, pictures)
    y = _distance(sheet, y, entry, pictures, limits, heat)
    y = region_table(sheet, y, entry.regions) - 0.12
    _origin(sheet, y, entry)
    return sheet


def _head(sheet: Sheet, entry: ReportEntry, limits: Limits) -> float:
    y = PAGE[1] - TOP
    sheet.write(LEFT, y, entry.title, HEADLINE, weight=600)
    sheet.verdict(LEFT + WIDE - 0.62, y - 0.03, entry_verdict(entry, limits), 12)
    y -= 0.30
    sheet.write(LEFT, y, story(entry), BODY, color=DIM)
    if entry.note:
        sheet.write(LEFT + WIDE, y, entry.note, BODY, ha="right", weight=600)
    return y - 0.24


def story(entry: ReportEntry) -> str:
    """Return what a scan is in a line: word, scheme, size, level."""
    said = f'held at "{entry.held}" of "{entry.word}", ' if entry.word and entry.held else ""
    return f"{said}scheme {entry.scheme}, {entry.scan.width} x {entry.scan.height} px, level {entry.fit.levels}"


def _inputs(sheet: Sheet, y: float, entry: ReportEntry, regions: FaceRegions) -> float:
    gap, tall = 0.08, 2.42
    wide = (WIDE - 2 * gap) / 3
    places = [(LEFT + k * (wide + gap), y - tall, wide, tall) for k in range(3)]
    near, far = face_depths(entry.fit.mesh.vertices)
    depth = depth_picture(entry.scan, near, far)
    photo(sheet, places[0], entry, depth if entry.scan.colour is None else entry.scan.colour, 2.6)
    photo(sheet, places[1], entry, depth)
    region_map(sheet, places[2], entry.fit.pixels, regions, entry.regions)
    seen = "picture" if entry.scan.colour is not None else "depth, as there is no picture,"
    sheet.caption(places[0], f"{seen} with {len(entry.landmarks)} fiducials")
    sheet.caption(places[1], f"range image, {near:.0f} to {far:.0f} mm, missing dark blue")
    sheet.caption(places[2], "regions; hatched: warn, crossed: fail")
    return y - tall - 0.27


def photo(sheet: Sheet, place: Place, entry: ReportEntry, picture: Picture, size: float = 0.0) -> None:
    """Draw the part of a scan's picture around the face, with fiducials ``size`` points wide (0: without)."""
    axes = sheet.axes(place)
    box = face_box(entry.fit.pixels, place[2] / place[3], picture.shape[:2])
    show(axes, _part(picture, box), None)
    left, top = np.floor([box[0], box[3]])
    axes.set_xlim(box[0] - max(left, 0), box[1] - max(left, 0))
    axes.set_ylim(box[2] - max(top, 0), box[3] - max(top, 0))
    if size:
        shift = (max(left, 0), max(top, 0))
        marks(axes, {name: (x - shift[0], y - shift[1]) for name, (x, y) in entry.landmarks.items()}, size)


def _part(picture: Picture, box: tuple[float, float, float, float]) -> Picture:
    """Return the pixels inside a box, so that no more of the picture is stored than is seen."""
    left, top = max(int(np.floor(box[0])), 0), max(int(np.floor(box[3])), 0)
    return picture[top : int(np.ceil(box[2])) + 2, left : int(np.ceil(box[1])) + 2]


def _faces(sheet: Sheet, y: float, pictures: FacePictures) -> float:
    gap, wide = 0.05, (WIDE - 0.25) / 6
    tall = wide * STILL[1] / STILL[0]
    for k, shot in enumerate(_SHOTS[:6]):
        place = (LEFT + k * (wide + gap), y - tall, wide, tall)
        sheet.picture(place, pictures[shot])
        sheet.caption(place, f"{shot[0]}, {_VIEWS[shot[1]]}" if k % 3 == 0 else _VIEWS[shot[1]])
    return y - tall - 0.27


def _distance(
    sheet: Sheet, y: float, entry: ReportEntry, pictures: FacePictures, limits: Limits, heat: HeatRange
) -> float:
    wide = 1.72
    tall = wide * STILL[1] / STILL[0]
    for k, view in enumerate(("front", "left")):
        sheet.picture((LEFT + k * (wide + 0.05), y - tall, wide, tall), pictures["heat", view])
    bar = (LEFT + 0.1, y - tall - 0.09, 2 * wide - 0.15, 0.075)
    colour_bar(sheet.figure, sheet.share(bar), heat, NOTE)
    left = LEFT + 2 * wide + 0.3
    sheet.write(left, y, "Distance to the scan", HEAD, weight=600)
    hollow = "; filled vertices grey" if entry.fit.filled.any() else ""
    share = share_text(entry.fit.deviation_mm, heat)
    sheet.write(
        left, y - 0.19, f"{share} mm; colours {SMOOTHED}{hollow}" if share else "nothing was measured", NOTE, color=DIM
    )
    _checks(sheet, left, y - 0.40, verdicts(entry.quality, limits), limits)
    return y - tall - 0.36


def _checks(sheet: Sheet, left: float, y: float, checks: Sequence[Check], limits: Limits) -> None:
    right, value, bound = left + 2.45, left + 1.62, left + 2.22
    sheet.write(left, y, "whole face", NOTE, color=DIM)
    sheet.write(value, y, "figure", NOTE, color=DIM, ha="right")
    sheet.write(bound, y, "warn | fail", NOTE, color=DIM, ha="right")
    y -= 0.135
    sheet.rule(y, 0.8, left, LEFT + WIDE - left)
    y -= 0.035
    for check in checks:
        unit = {"count": "", "degrees": "deg"}.get(check.unit, check.unit)
        sheet.write(left, y, f"{check.name}, {unit}" if unit else check.name, NOTE)
        bold = check.verdict in (Verdict.WARN, Verdict.FAIL)
        number = f"{check.value:.1f}" if check.unit in ("%", "degrees") else figure(check.value, check.unit)
        sheet.write(value, y, number, NOTE, ha="right", weight=700 if bold else 400)
        if check.limit is not None:
            text = f"{limit(check.limit)} | {limit(check.limit * limits.tolerance)}"
            sheet.write(bound, y, text, NOTE - 0.8, ha="right", color=DIM)
        if check.verdict is not None:
            sheet.verdict(right, y, check.verdict, NOTE)
        y -= 0.152


def _origin(sheet: Sheet, y: float, entry: ReportEntry) -> None:
    repair = entry.fit.repair
    column = WIDE / 3
    done = [
        ("missing pixels", f"{100 * repair.missing_fraction:.1f} %"),
        ("spikes removed", f"{repair.spikes}"),
        ("pixels filled", f"{repair.filled_pixels}"),
        ("vertices", f"{entry.quality.vertices}, filled {entry.quality.filled_vertices}"),
        ("folded triangles", _folds(entry)),
        ("fiducials met", f"within {entry.quality.fiducial_residual_px:.0e} px"),
    ]
    origin = entry.origin
    for k, (title, rows, indent) in enumerate(
        (
            ("Inputs", list(origin.inputs), 0.62),
            ("Repair and mesh", done, 0.92),
            ("Options and proof", [*origin.options, *origin.proof], 0.92),
        )
    ):
        x = LEFT + k * column + (0.12 if k else 0.0)
        sheet.write(x, y, title, BODY, weight=600)
        facts(sheet, x, y - 0.16, rows, indent, 0.13)


def _folds(entry: ReportEntry) -> str:
    names = entry.fit.folded_fiducials
    count = f"{entry.quality.folded_faces}"
    return f"{count}, beside {', '.join(names[:2])}" if names else count


def verdict_words(entry: ReportEntry, limits: Limits) -> str:
    """Return the verdict on a scan as one word."""
    return WORDS[entry_verdict(entry, limits)]
