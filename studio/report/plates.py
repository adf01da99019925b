"""Figures 1 to 4 of Yano & Harada 2009, made again from our own scans."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import resources
from engine.errors import InputError
from engine.files.scheme import read_scheme
from engine.mesh import FloatArray
from engine.scan.template import FaceTemplate
from studio.report.drawing import (
    CHOSEN,
    DIM,
    Picture,
    colour_bar,
    depth_picture,
    face_box,
    face_depths,
    marks,
    numbers,
    picture_axes,
    settings,
    show,
    wire,
)
from studio.report.entry import ReportEntry
from widgets.scene.calm import SMOOTHED
from widgets.scene.heatmap import HeatRange, share_text
from widgets.scene.stills import Stills
from widgets.scene.wire import coarse_edges

WIDTH_PX = 1600
_DPI = 200
_WIDTH = WIDTH_PX / _DPI
_TITLE, _TEXT = 9.0, 7.0
_HEAD, _FOOT, _SIDE, _GAP = 0.36, 0.62, 0.10, 0.06
"""Room in inches above the panels, below them, beside and between them."""

Panel = tuple[str, Callable[[Figure, tuple[float, float, float, float]], None]]


def write_plates(folder: str | Path, entries: Sequence[ReportEntry], template: FaceTemplate) -> tuple[Path, ...]:
    """Write ``figure_1.png`` .. ``figure_4.png``, each 1600 px wide, and return their paths.

    Figures 1 to 3 show the first entry with closed lips, Figure 4 the one whose mouth is open widest.

    Parameters
    ----------
    folder : path
        Made where it does not exist.
    entries : sequence of ReportEntry
    template : FaceTemplate

    Raises
    ------
    InputError
        Without an entry of either scheme, or where the folder cannot be written to.
    """
    closed = next((entry for entry in entries if entry.scheme == "closed"), None)
    opened = max((entry for entry in entries if entry.scheme == "open"), key=_opening, default=None)
    if closed is None or opened is None:
        missing = "closed" if closed is None else "open"
        raise InputError("plates", f"no scan with the scheme {missing!r}", "fit one with either scheme first")
    place = Path(folder)
    plates: tuple[tuple[str, Callable[[], Figure]], ...] = (
        ("figure_1.png", lambda: _figure_1(closed, template)),
        ("figure_2.png", lambda: _figure_2(closed, template)),
        ("figure_3.png", lambda: _figure_3(closed)),
        ("figure_4.png", lambda: _figure_4(opened, template)),
    )
    written = []
    with mpl.rc_context(settings()):
        for name, draw in plates:
            path = place / name
            figure = draw()
            try:
                place.mkdir(parents=True, exist_ok=True)
                figure.savefig(path, dpi=_DPI, metadata={"Software": None})
            except OSError as error:
                raise InputError(str(path), f"cannot be written ({error.strerror})", "choose another folder") from None
            written.append(path)
    return tuple(written)


def _figure_1(entry: ReportEntry, template: FaceTemplate) -> Figure:
    layout = template.layout(entry.scheme)
    scheme = read_scheme(resources.scheme_path(entry.scheme))
    names = [name for name in scheme.names if name in layout.fiducials and name in entry.landmarks]
    points = {name: (float(x), float(y)) for name, (x, y) in zip(names, _places(layout, names), strict=True)}
    picked = {name: entry.landmarks[name] for name in names}

    def flat(figure: Figure, place: tuple[float, float, float, float]) -> None:
        axes = picture_axes(figure, place)
        span = float(np.ptp(layout.vertices[:, 1]))
        wire(axes, layout.vertices, template.edges, "#3a3f47", 0.45)
        marks(axes, points, 5.0)
        numbers(axes, points, _TEXT, 0.012 * span)
        middle = (layout.vertices.min(axis=0) + layout.vertices.max(axis=0)) / 2
        half = 0.53 * span
        aspect = place[2] * _WIDTH / (place[3] * figure.get_figheight())
        axes.set_xlim(middle[0] - half * aspect, middle[0] + half * aspect)
        axes.set_ylim(middle[1] + half, middle[1] - half)

    def photo(figure: Figure, place: tuple[float, float, float, float]) -> None:
        axes = _image(figure, place, entry, _colour(entry))
        marks(axes, picked, 4.5, CHOSEN)
        numbers(axes, picked, _TEXT, 4.0)

    text = (
        f"(a) The flat template, {len(layout.vertices)} vertices and {len(template.faces)} triangles, with its "
        f"{len(names)} fiducials: teal on the subject's left, violet on the right. "
        "(b) The same points chosen on the colour image, in red; equal numbers belong together."
    )
    return _plate("Figure 1", f"Template and fiducials, scan {entry.title}", text, (("a", flat), ("b", photo)), 4.6)


def _figure_2(entry: ReportEntry, template: FaceTemplate) -> Figure:
    near, far = face_depths(entry.fit.mesh.vertices)

    def range_image(figure: Figure, place: tuple[float, float, float, float]) -> None:
        _image(figure, place, entry, depth_picture(entry.scan, near, far))

    text = (
        f"(a) Range image as grey depth, {near:.0f} mm bright to {far:.0f} mm dark, missing pixels blue-grey. "
        f"(b) The template warped onto the face, {len(template.mirror)} vertices. "
        f"(c) After {_levels(entry)}, {len(entry.fit.pixels)} vertices. "
        f"The fiducials are met within {entry.fit.fiducial_residual_px:.0e} px."
    )
    panels = (
        ("a", range_image),
        ("b", _warped(entry, template, fine=False)),
        ("c", _warped(entry, template, fine=True)),
    )
    return _plate("Figure 2", f"Template fitted to the image, scan {entry.title}", text, panels, 3.3)


def _figure_3(entry: ReportEntry) -> Figure:
    fit, heat = entry.fit, HeatRange()
    with Stills(576, 720) as stills:
        shaded = stills.face(fit, "shaded")
        textured = stills.face(fit, "textured", picture=entry.scan.colour)
        lines = stills.face(fit, "blank", wire=0.8, levels=0)
        distance = stills.face(fit, "heat", heat=heat)

    def panel(picture: Picture) -> Callable[[Figure, tuple[float, float, float, float]], None]:
        return lambda figure, place: show(picture_axes(figure, place), picture)

    def heatmap(figure: Figure, place: tuple[float, float, float, float]) -> None:
        show(picture_axes(figure, place), distance)
        x, y, w, _ = place
        tall = figure.get_figheight()
        colour_bar(figure, (x + 0.15 * w, y - 0.16 / tall, 0.7 * w, 0.07 / tall), heat, _TEXT)

    text = (
        f"(a) Shaded. (b) With the colour image as texture. (c) Wire frame, {len(fit.mesh.vertices)} vertices, "
        f"{len(fit.mesh.faces)} triangles. (d) Distance to the scan in mm, colours {SMOOTHED}, filled vertices grey, "
        f"{share_text(fit.deviation_mm, heat)} mm; median {entry.quality.median_mm:.3f} mm."
    )
    panels = (("a", panel(shaded)), ("b", panel(textured)), ("c", panel(lines)), ("d", heatmap))
    return _plate("Figure 3", f"The 3-D face, scan {entry.title}", text, panels, 2.4, room=0.34)


def _figure_4(entry: ReportEntry, template: FaceTemplate) -> Figure:
    def photo(figure: Figure, place: tuple[float, float, float, float]) -> None:
        axes = _image(figure, place, entry, _colour(entry))
        marks(axes, dict(entry.landmarks), 3.6, CHOSEN)

    text = (
        f"(a) Colour image with the {len(entry.landmarks)} fiducials of the open mouth: the inner lip lines have "
        f"points of their own. (b) Warped template, {len(template.mirror)} vertices; the lips part at the slit. "
        f"(c) After {_levels(entry)}, {len(entry.fit.pixels)} vertices."
    )
    coarse, fine = _warped(entry, template, fine=False), _warped(entry, template, fine=True)
    panels = (("a", photo), ("b", coarse), ("c", fine))
    return _plate("Figure 4", f"Template fitted to an open mouth, scan {entry.title}", text, panels, 3.3)


def _plate(name: str, title: str, caption: str, panels: Sequence[Panel], height: float, room: float = 0.0) -> Figure:
    """Lay panels of one width side by side, ``height`` inches high, under a title and over a caption.

    ``room`` inches stay free between panels and caption.
    """
    foot = _FOOT + room
    total = _HEAD + height + foot
    figure = Figure(figsize=(_WIDTH, total))
    figure.text(_SIDE / _WIDTH, 1 - 0.10 / total, name, fontsize=_TITLE, weight=600, va="top")
    figure.text((_SIDE + 0.72) / _WIDTH, 1 - 0.10 / total, title, fontsize=_TITLE, color=DIM, va="top")
    width = (_WIDTH - 2 * _SIDE - _GAP * (len(panels) - 1)) / len(panels)
    for index, (letter, draw) in enumerate(panels):
        left = _SIDE + index * (width + _GAP)
        draw(figure, (left / _WIDTH, foot / total, width / _WIDTH, height / total))
        figure.text(
            (left + 0.05) / _WIDTH, (foot + height - 0.06) / total, f"({letter})", fontsize=_TITLE, weight=600,
            va="top", bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5},
        )  # fmt: skip
    figure.text(_SIDE / _WIDTH, (_FOOT - 0.10) / total, _wrapped(caption), fontsize=_TEXT, va="top", linespacing=1.35)
    return figure


def _wrapped(text: str, letters: int = 172) -> str:
    import textwrap

    return "\n".join(textwrap.wrap(text, letters))


def _image(figure: Figure, place: tuple[float, float, float, float], entry: ReportEntry, picture: Picture) -> object:
    axes = picture_axes(figure, place)
    aspect = place[2] * _WIDTH / (place[3] * figure.get_figheight())
    show(axes, picture, face_box(entry.fit.pixels, aspect, picture.shape[:2], 0.06))
    return axes


def _warped(
    entry: ReportEntry, template: FaceTemplate, *, fine: bool
) -> Callable[[Figure, tuple[float, float, float, float]], None]:
    edges = coarse_edges(entry.fit.mesh.faces, 0) if fine else template.edges

    def draw(figure: Figure, place: tuple[float, float, float, float]) -> None:
        axes = _image(figure, place, entry, _colour(entry))
        wire(axes, entry.fit.pixels, edges, "#0d2f8a" if fine else "#0b2a7a", 0.22 if fine else 0.5, 0.85)

    return draw


def _places(layout: object, names: Sequence[str]) -> FloatArray:
    vertices, fiducials = layout.vertices, layout.fiducials  # type: ignore[attr-defined]
    return np.asarray(vertices[[fiducials[name] for name in names]])


def _colour(entry: ReportEntry) -> Picture:
    if entry.scan.colour is not None:
        return entry.scan.colour
    return depth_picture(entry.scan, *face_depths(entry.fit.mesh.vertices))


def _levels(entry: ReportEntry) -> str:
    count = entry.fit.levels
    return "no subdivision" if count == 0 else f"{count} one-to-four subdivision{'s' if count > 1 else ''}"


def _opening(entry: ReportEntry) -> float:
    """Return how far the lips are apart, in pixels."""
    upper, lower = entry.landmarks.get("lip_upper_inner"), entry.landmarks.get("lip_lower_inner")
    return 0.0 if upper is None or lower is None else lower[1] - upper[1]
