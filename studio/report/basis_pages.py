"""The pages of a basis' report: figures, shapes side by side, errors over time and over the face."""

from __future__ import annotations

import textwrap

import numpy as np

from engine.progress import Progress
from engine.scan.limits import Verdict
from studio.basis.job import BASES, LEAST_COSINE
from studio.basis.options import BOUNDS
from studio.report.basis_charts import chart_curves, chart_scree, chart_weights
from studio.report.basis_entry import BasisEntry, FrameShot
from studio.report.drawing import DIM, Picture, colour_bar
from studio.report.layout import BODY, HEAD, HEADLINE, LEFT, NOTE, PAGE, RIGHT, TOP, WIDE, Sheet
from widgets.scene.basis_content import counted, error_range, rounded_up
from widgets.scene.basis_rig import RigLook
from widgets.scene.basis_state import START_RANGE_MM
from widgets.scene.basis_stills import RigStills
from widgets.scene.heatmap import HeatRange

STILL = (300, 340)
COLUMNS, ROWS = 2, 6
"""Shapes of one page."""
_STEP = 0.165
CHANGE_MM = HeatRange(*START_RANGE_MM)
"""The one range of all changes, that of window and plates."""


def pages_of(entry: BasisEntry, progress: Progress) -> list[Sheet]:
    """Return every page in order, but for what stands at its foot."""
    look = RigLook(entry.mesh, entry.skin, entry.texture)
    heat = CHANGE_MM
    with RigStills(*STILL) as stage:
        stage.look(look, "three_quarter")
        trios: list[tuple[Picture, ...]] = []
        for index, name in enumerate(entry.names):
            progress(0.6 * index / len(entry.names), f"picturing {name}")
            quasi = entry.shape(index)
            change = np.linalg.norm(quasi - entry.hand[index], axis=1)
            trios.append(
                (
                    stage.picture(look, look.moved(entry.hand[index])),
                    stage.picture(look, look.moved(quasi)),
                    stage.picture(look, look.moved(quasi), values=change, heat=heat, bar=False),
                )
            )
        progress(0.6, "picturing the worst frames")
        largest = [np.linalg.norm(p - s.original, axis=1)[entry.skin] for s in entry.shots for p in s.built]
        frames_mm = HeatRange(0.0, rounded_up(float(np.percentile(largest, 99.5)) if largest else 0.0))
        shots = [_frame_pictures(stage, look, shot, frames_mm) for shot in entry.shots]
        spread = error_range(entry.heat["hand"])
        stage.look(look, "front")
        faces = {
            basis: stage.picture(look, look.neutral, values=values, heat=spread, bar=False)
            for basis, values in entry.heat.items()
        }
    pages = [_summary(entry)]
    per = COLUMNS * ROWS
    pages += [_shapes(entry, trios, start, heat) for start in range(0, len(entry.names), per)]
    return [*pages, _errors(entry, faces, spread), _frames(entry, shots, frames_mm)]


def _frame_pictures(stage: RigStills, look: RigLook, shot: FrameShot, heat: HeatRange) -> tuple[Picture, ...]:
    """Return original, by hand and its error, by quasi-eigen and its error."""
    pictures: list[Picture] = [stage.picture(look, look.pose(shot.original), look="textured")]
    for placed in shot.built:
        pose = look.pose(placed)
        error = np.where(look.skin, np.linalg.norm(placed - shot.original, axis=1), np.nan)
        pictures += [
            stage.picture(look, pose, look="textured"),
            stage.picture(look, pose, values=error, heat=heat, bar=False),
        ]
    return tuple(pictures)


def _summary(entry: BasisEntry) -> Sheet:
    sheet = Sheet()
    y = PAGE[1] - TOP
    sheet.write(LEFT, y, entry.title, HEADLINE, weight=600)
    first, stop = entry.trained
    facts = (
        f"{counted(entry.frames)} frames at {entry.fps:g} fps, trained on {counted(first + 1)} to {counted(stop)}    "
        f"{len(entry.names)} shapes"
    )
    sheet.write(LEFT, y - 0.34, f"{facts}, {entry.axes} axes    lengths in mm", BODY, color=DIM)
    x, z, height = entry.origin
    origin = (
        f"alpha is measured on {entry.skin_name}, about the neutral face's centroid ({x:.1f}, {z:.1f}, {height:.1f})"
    )
    sheet.write(LEFT, y - 0.52, origin, BODY, color=DIM)
    y = _alphas(sheet, entry, y - 0.95)
    y = _checks(sheet, entry, y - 0.35)
    sheet.write(LEFT, y - 0.3, "Variance explained", HEAD, weight=600)
    chart_scree(sheet, entry, (LEFT + 0.4, y - 2.45, WIDE / 2 - 0.75, 1.75))
    middle = LEFT + WIDE / 2
    sheet.write(middle + 0.15, y - 0.3, "Projection W, in standard deviations of each axis", HEAD, weight=600)
    chart_weights(sheet, entry, (middle + 0.55, y - 2.45, WIDE / 2 - 1.0, 1.75))
    y -= 2.95
    if entry.quasi.warnings:
        sheet.write(LEFT, y, "To look at", HEAD, weight=600)
        y -= 0.22
        for warning in entry.quasi.warnings[:8]:
            lines = textwrap.wrap(warning, 128) or [""]
            sheet.write(LEFT, y, "\n".join(lines), BODY)
            y -= _STEP * len(lines)
        y -= 0.12
    sheet.write(LEFT, y, "Made from", HEAD, weight=600)
    y -= 0.22
    for name, value in entry.facts:
        sheet.write(LEFT, y, name, NOTE, color=DIM)
        sheet.write(LEFT + 1.3, y, value, NOTE)
        y -= 0.145
    return sheet


def _alphas(sheet: Sheet, entry: BasisEntry, y: float) -> float:
    sheet.write(LEFT, y, "Error alpha, % of the face's size: mean over frames (pooled)", HEAD, weight=600)
    y -= 0.26
    columns = [LEFT + 2.6 + 1.35 * k for k in range(3)]
    for at, key in zip(columns, BOUNDS, strict=True):
        sheet.write(at, y, f"weights {key.replace('..', ' to ')}", NOTE, color=DIM, ha="right")
    sheet.write(LEFT + WIDE, y, "99th percentile |w|", NOTE, color=DIM, ha="right")
    sheet.rule(y - 0.14, 0.5)
    for basis, title in BASES.items():
        y -= 0.21
        sheet.write(LEFT, y, title, BODY)
        for at, key in zip(columns, BOUNDS, strict=True):
            bold = key == (entry.bounds if basis != "pca" else "free")
            value = f"{entry.alpha[basis][key]:.3f} ({entry.pooled[basis][key]:.3f})"
            sheet.write(at, y, value, BODY, ha="right", weight=600 if bold else 400)
        shown = entry.bounds if basis != "pca" else "free"
        sheet.write(LEFT + WIDE, y, f"{entry.p99[basis][shown]:.2f}", BODY, ha="right")
    note = "Bold: the weights that curves and pictures use. One unit of weight of an axis is one standard deviation."
    sheet.write(LEFT, y - 0.2, note, NOTE, color=DIM)
    return y - 0.25


def _checks(sheet: Sheet, entry: BasisEntry, y: float) -> float:
    sheet.write(LEFT, y, "Checks", HEAD, weight=600)
    y -= 0.08
    for check in entry.checks:
        y -= 0.19
        sheet.write(LEFT, y, check.name, BODY)
        sheet.write(LEFT + 2.6, y, f"{check.value:.3g}", BODY, ha="right")
        sheet.write(LEFT + 3.3, y, f"{check.sign} {check.limit:.3g}", BODY, ha="right", color=DIM)
        sheet.verdict(LEFT + 3.6, y, Verdict.OK if check.passes else Verdict.FAIL)
    return y - 0.15


def _shapes(entry: BasisEntry, trios: list[tuple[Picture, ...]], start: int, heat: HeatRange) -> Sheet:
    sheet = Sheet()
    y = PAGE[1] - TOP
    sheet.write(LEFT, y, "Hand, quasi-eigen, change", HEADLINE, weight=600)
    about = "mm: RMS change over the skin; %: of the shape; cosine between both"
    sheet.write(LEFT, y - 0.32, about, BODY, color=DIM)
    colour_bar(sheet.figure, sheet.share((PAGE[0] - RIGHT - 2.0, y - 0.26, 2.0, 0.09)), heat, NOTE)
    wide = (WIDE - 0.25) / COLUMNS
    small = wide / 3
    tall = small * STILL[1] / STILL[0]
    room = (y - 0.72 - 0.62) / ROWS
    quasi = entry.quasi
    for place, index in enumerate(range(start, min(start + COLUMNS * ROWS, len(entry.names)))):
        left = LEFT + (place % COLUMNS) * (wide + 0.25)
        top = y - 0.62 - (place // COLUMNS) * room
        cosine = quasi.cosine[index]
        drifts = not cosine >= LEAST_COSINE
        sheet.write(left, top, entry.names[index], BODY, weight=600)
        figures = f"{quasi.residual_mm[index]:.2f} mm   {100 * quasi.residual_fraction[index]:.0f} %   "
        sheet.write(left + wide, top, figures + f"cosine {cosine:.2f}" + (" !" if drifts else ""), BODY, ha="right")
        for k, picture in enumerate(trios[index]):
            sheet.picture((left + k * small, top - 0.2 - tall, small, tall), picture)
    if any(not cosine >= LEAST_COSINE for cosine in quasi.cosine[start : start + COLUMNS * ROWS]):
        sheet.write(LEFT, 0.62, f"!: below {LEAST_COSINE:g}, the shape no longer looks like itself", NOTE, color=DIM)
    return sheet


def _errors(entry: BasisEntry, faces: dict[str, Picture], heat: HeatRange) -> Sheet:
    sheet = Sheet()
    y = PAGE[1] - TOP
    sheet.write(LEFT, y, "Error over time and over the face", HEADLINE, weight=600)
    key = entry.bounds.replace("..", " to ")
    about = (
        f"hand and quasi-eigen with weights {key}, PCA free; triangles: the frames that are worst by quasi-eigen shapes"
    )
    sheet.write(LEFT, y - 0.32, about, BODY, color=DIM)
    chart_curves(sheet, entry, 0, "alpha, %", (LEFT + 0.45, y - 2.6, WIDE - 0.45, 1.9))
    chart_curves(sheet, entry, 1, "RMS, mm", (LEFT + 0.45, y - 5.05, WIDE - 0.45, 1.9))
    y -= 5.75
    sheet.write(LEFT, y, "RMS error of every vertex over the whole performance", HEAD, weight=600)
    wide = (WIDE - 0.3) / 3
    tall = wide * STILL[1] / STILL[0]
    for k, (basis, title) in enumerate(BASES.items()):
        left = LEFT + k * (wide + 0.15)
        bounds = entry.bounds if basis != "pca" else "free"
        sheet.write(left, y - 0.3, f"{title}: {entry.rms[basis][bounds]:.2f} mm", BODY)
        sheet.picture((left, y - 0.5 - tall, wide, tall), faces[basis])
    colour_bar(sheet.figure, sheet.share((LEFT, y - 0.78 - tall, 2.4, 0.09)), heat, NOTE)
    return sheet


def _frames(entry: BasisEntry, shots: list[tuple[Picture, ...]], heat: HeatRange) -> Sheet:
    sheet = Sheet()
    y = PAGE[1] - TOP
    sheet.write(LEFT, y, "The worst frames by quasi-eigen shapes", HEADLINE, weight=600)
    about = "heat: distance of every vertex from the original, mm"
    sheet.write(LEFT, y - 0.32, about, BODY, color=DIM)
    colour_bar(sheet.figure, sheet.share((PAGE[0] - RIGHT - 2.0, y - 0.26, 2.0, 0.09)), heat, NOTE)
    y -= 0.8
    tall = (y - 0.8) / max(len(shots), 1) - 0.28
    wide = min(tall * STILL[0] / STILL[1], (WIDE - 0.3) / 5)
    step = (WIDE - wide) / 4
    for shot, pictures in zip(entry.shots, shots, strict=True):
        high = wide * STILL[1] / STILL[0]
        notes = (f"frame {counted(shot.frame + 1)}, {shot.frame / entry.fps:.2f} s", *_notes(shot.rms_mm))
        for k, picture in enumerate(pictures):
            if k in (0, 1, 3):
                sheet.write(LEFT + k * step, y, notes[(k + 1) // 2], BODY)
            sheet.picture((LEFT + k * step, y - 0.18 - high, wide, high), picture)
        y -= high + 0.42
    return sheet


def _notes(rms_mm: tuple[float, float]) -> tuple[str, str]:
    return f"by hand, RMS {rms_mm[0]:.2f} mm", f"by quasi-eigen, RMS {rms_mm[1]:.2f} mm"
