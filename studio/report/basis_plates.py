"""Figures 1 to 4 of Kim & Ko 2007 and their table of alpha, made again from a basis of our own. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from engine.errors import InputError
from engine.mesh import FloatArray
from engine.progress import Progress, silent
from studio.basis.job import BASES
from studio.basis.options import BOUNDS
from studio.report.basis_charts import COLOURS
from studio.report.basis_entry import BasisEntry
from studio.report.drawing import DIM, INK, RULE, Picture, picture_axes, settings, show
from widgets.scene.basis_content import counted
from widgets.scene.basis_rig import RigLook
from widgets.scene.basis_stills import frame_triplet_image, marker_error_image, shape_pair_image
from widgets.scene.heatmap import HeatRange

if TYPE_CHECKING:
    from studio.basis.results import Analysis

WIDTH_PX = 1600
_DPI = 200
_WIDTH = WIDTH_PX / _DPI
_TITLE, _TEXT = 9.0, 7.0
_HAND, _QUASI, _PCA = COLOURS["hand"], COLOURS["quasi_eigen"], COLOURS["pca"]
_DASHED = (0, (3, 1.5))
_HEAD, _FOOT, _SIDE = 0.36, 0.62, 0.10

_SHARE = 0.5
"""How much of a shape the arrows of Figure 1 show: whole ones would dwarf the cloud."""

Draw = Callable[[], Figure]


def write_basis_plates(
    folder: str | Path, analysis: Analysis, entry: BasisEntry, *, progress: Progress = silent
) -> tuple[Path, ...]:
    """Write ``basis_figure_1.png`` .. ``_4.png`` and ``basis_alpha.png``, each 1600 px wide, and return their paths.

    Parameters
    ----------
    folder : path
        Made where it does not exist.
    analysis : Analysis
        Rig, performance, axes, bases and figures.
    entry : BasisEntry
        The same as the report shows it: the bounds that are pictured, the texture.

    Raises
    ------
    InputError
        Where the folder cannot be written to.
    """
    place, rig = Path(folder), RigLook(entry.mesh, entry.skin, entry.texture)
    frames = telling_frames(analysis, entry)
    plates: list[tuple[str, Draw]] = [
        ("basis_figure_1.png", lambda: _figure_1(analysis, entry)),
        ("basis_figure_2.png", lambda: _figure_2(entry, rig)),
        ("basis_figure_3.png", lambda: _figure_3(analysis, entry, rig, frames)),
    ]
    if analysis.prepared.bound is not None:
        plates.append(("basis_figure_4.png", lambda: _figure_4(analysis, entry, rig, frames[0])))
    plates.append(("basis_alpha.png", lambda: _alpha_table(entry)))
    written = []
    with mpl.rc_context(settings()):
        for step, (name, draw) in enumerate(plates):
            progress(step / len(plates), f"drawing {name}")
            path = place / name
            figure = draw()
            try:
                place.mkdir(parents=True, exist_ok=True)
                figure.savefig(path, dpi=_DPI, metadata={"Software": None})
            except OSError as error:
                raise InputError(str(path), f"cannot be written ({error.strerror})", "choose another folder") from None
            written.append(path)
    progress(1.0, "")
    return tuple(written)


def telling_frames(analysis: Analysis, entry: BasisEntry, count: int = 3) -> list[int]:
    """Return the frames that quasi-eigen shapes meet worst, as window and report name them: Figures 3 and 4."""
    error = analysis.result.comparison.errors["quasi_eigen"][entry.bounds]
    return [int(frame) for frame in error.worst_frames(count)] or [0]


def telling_shapes(entry: BasisEntry, count: int = 4) -> list[int]:
    """Return shapes across the range of likeness, largest motion first: the most alike, two between, the least."""
    cosine = np.nan_to_num(np.asarray(entry.quasi.cosine), nan=-1.0)
    order = np.argsort(-cosine)
    picked = np.unique(np.rint(np.linspace(0, len(order) - 1, min(count, len(order)))).astype(int))
    return [int(order[k]) for k in picked]


def _figure_1(analysis: Analysis, entry: BasisEntry) -> Figure:
    principal, skin = analysis.result.principal, entry.skin
    motion = analysis.prepared.motion
    step = max(1, len(motion) // 1500)
    frames = np.stack([motion.displacements(k, k + 1, skin)[0] for k in range(0, len(motion), step)])
    cloud = _along(principal.axes[:2, skin], frames - principal.mean[skin])
    zero = -principal.mean[skin]
    start = _along(principal.axes[:2, skin], zero[None])[0]
    hand = analysis.hand_shapes[:, skin]
    flat = _along(principal.axes[:2, skin], hand + zero) - start
    away = np.asarray(entry.quasi.residual_mm) * np.sqrt(len(skin))
    figure, axes = _canvas(
        "Figure 1",
        "The performance in the space of its first two axes",
        f"Dots: frames, as they lie along the first two of {entry.axes} axes (mm over all {counted(len(skin))} "
        f"vertices of the {entry.skin_name}). Dashed grey arrows: PCA axes, two standard deviations long. Dark lines "
        "with a triangle: hand-made shapes, raised by how far they stand off the plane of the axes. Blue arrows: "
        "quasi-eigen shapes, their shadows on it, joined by dotted lines; the six longest, at half their size. Square: "
        "the neutral face.",
        5.4,
    )
    tilt = np.array([0.0, 0.55])
    axes.scatter(*cloud.T, s=2.2, color="#9aa0a8", linewidths=0, zorder=1)
    for k in range(min(2, principal.count)):
        tip = np.eye(2)[k] * 2 * np.sqrt(principal.eigenvalues[k])
        axes.annotate(
            "", tip, (0, 0), arrowprops={"arrowstyle": "-|>", "color": _PCA, "lw": 1.8, "ls": _DASHED}, zorder=4
        )
        beside = {"xytext": (7, -3) if k == 0 else (0, 6), "ha": "left" if k == 0 else "center"}
        _label(axes, f"axis {k + 1}", tip, _TEXT, _PCA, beside)
    for k in np.argsort(-np.linalg.norm(flat, axis=1))[:6]:
        shadow = start + _SHARE * flat[k]
        raised = shadow + tilt * _SHARE * away[k]
        axes.plot(*np.stack([start, raised]).T, color=_HAND, lw=1.1, zorder=3)
        axes.plot(*raised, marker="^", ms=4, color=_HAND, zorder=3)
        axes.plot(*np.stack([raised, shadow]).T, color=DIM, lw=0.6, ls=":", zorder=2)
        axes.annotate("", shadow, start, arrowprops={"arrowstyle": "-|>", "color": _QUASI, "lw": 1.3}, zorder=4)
        # Outwards of the triangle: there no arrow of this shape runs.
        right = raised[0] >= start[0]
        beside = {"xytext": (6 if right else -6, 4), "ha": "left" if right else "right"}
        _label(axes, entry.names[k], raised, _TEXT - 1, INK, beside)
    axes.plot(*start, marker="s", ms=5, color=INK, zorder=6)
    axes.set_xlabel("axis 1, mm", fontsize=_TEXT)
    axes.set_ylabel("axis 2, mm", fontsize=_TEXT)
    axes.tick_params(labelsize=_TEXT - 1)
    axes.margins(0.09)
    return figure


def _label(axes: Any, text: str, place: FloatArray, size: float, colour: str, beside: dict[str, Any]) -> None:
    """Write a name beside a place, on a ground that lets no line run through it."""
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    axes.annotate(text, place, textcoords="offset points", fontsize=size, color=colour, bbox=ground, zorder=6, **beside)


def _figure_2(entry: BasisEntry, rig: RigLook) -> Figure:
    heat = HeatRange(0.0, 3.0)
    rows = []
    for k in telling_shapes(entry):
        picture = shape_pair_image(
            rig, entry.hand[k], entry.shape(k), skin=entry.skin, heat=heat, size=(500, 400), shape=entry.names[k]
        )
        rows.append(
            (picture, f"cosine {entry.quasi.cosine[k]:.2f}, changed by {entry.quasi.residual_mm[k]:.2f} mm RMS")
        )
    text = (
        "Shapes as they were made by hand, their quasi-eigen shapes, and the distance between the two in mm, in the "
        "order of their cosine: the most alike of all shapes first, the least alike last."
    )
    return _stack("Figure 2", "Hand-made and quasi-eigen shapes", text, rows)


def _figure_3(analysis: Analysis, entry: BasisEntry, rig: RigLook, frames: list[int]) -> Figure:
    rows = []
    for frame in frames:
        positions, rms = _placed(analysis, entry, frame)
        picture = frame_triplet_image(
            rig, *positions, rms_mm=rms, skin=entry.skin, texture=entry.texture, size=(500, 400), frame=frame
        )
        rows.append((picture, f"frame {counted(frame + 1)}, {frame / entry.fps:.2f} s, worst by quasi-eigen"))
    text = (
        f"Frames of the performance, and what the hand-made and the quasi-eigen shapes make of them with weights in "
        f"{entry.bounds}: those that the quasi-eigen shapes meet worst, at least half a second apart."
    )
    return _stack("Figure 3", "Original, by hand, by quasi-eigen shapes", text, rows)


def _figure_4(analysis: Analysis, entry: BasisEntry, rig: RigLook, frame: int) -> Figure:
    bound = analysis.prepared.bound
    assert bound is not None
    positions, rms = _placed(analysis, entry, frame)
    rest = analysis.prepared.motion.neutral
    rebuilt = [bound.binding.rest + bound.binding.on(place - rest, entry.mesh.faces) for place in positions[1:]]
    picture = marker_error_image(
        rig, positions, bound.captured[frame], rebuilt[0], rebuilt[1], rms_mm=rms, texture=entry.texture,
        size=(760, 700), view="front", frame=frame,
    )  # fmt: skip
    text = (
        f"Frame {counted(frame + 1)}, worst by quasi-eigen: captured markers red, where the reconstruction has them "
        "blue, the line between is the error. From the left: the frame itself, by the hand-made shapes, by the "
        "quasi-eigen shapes."
    )
    return _stack("Figure 4", "Captured and reconstructed markers", text, [(picture, "")])


def _alpha_table(entry: BasisEntry) -> Figure:
    ratios = f"hand / quasi-eigen {_ratio(entry, 'hand', 'quasi_eigen'):.2f}, quasi-eigen / PCA " + (
        f"{entry.alpha['quasi_eigen'][entry.bounds] / entry.alpha['pca']['free']:.3f}"
    )
    figure, axes = _canvas(
        "Alpha",
        "Reproduction error of three bases under three bounds",
        f"Mean over {counted(entry.frames)} frames of 100 |v* - v| / |v*| in %, on the {entry.skin_name}, about the "
        f"centroid of the neutral face; in brackets the RMS in mm. Bold: the bounds in use, and PCA with free "
        f"weights: {ratios}. PCA axes under bounds are scaled to one standard deviation.",
        1.9,
    )
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 4)
    for column, key in enumerate(BOUNDS):
        axes.text(0.40 + 0.24 * column, 3.5, f"weights {key}", ha="right", va="center", fontsize=_TITLE, color=DIM)
    axes.plot([0, 0.92], [3.05, 3.05], color=RULE, lw=0.8)
    for row, (basis, title) in enumerate(BASES.items()):
        y = 2.5 - row
        axes.text(0.0, y, title, va="center", fontsize=_TITLE)
        for column, key in enumerate(BOUNDS):
            bold = key == ("free" if basis == "pca" else entry.bounds)
            value, mm = entry.alpha[basis][key], entry.rms[basis][key]
            axes.text(
                0.40 + 0.24 * column, y, f"{value:.3f} ({mm:.2f})", ha="right", va="center", fontsize=_TITLE,
                weight=700 if bold else 400,
            )  # fmt: skip
        axes.plot([0, 0.92], [y - 0.5, y - 0.5], color=RULE, lw=0.4)
    return figure


def _ratio(entry: BasisEntry, above: str, below: str) -> float:
    return float(entry.alpha[above][entry.bounds] / entry.alpha[below][entry.bounds])


def _along(axes: FloatArray, displacements: FloatArray) -> FloatArray:
    """Return coordinates (k, m) of displacements (k, V, 3) along axes (m, V, 3), mm."""
    found: FloatArray = displacements.reshape(len(displacements), -1) @ axes.reshape(len(axes), -1).T
    return found


def _placed(
    analysis: Analysis, entry: BasisEntry, frame: int
) -> tuple[tuple[FloatArray, FloatArray, FloatArray], tuple[float, float]]:
    """Return original, by hand and by quasi-eigen shapes, positions (N, 3) in mm, and the RMS of the last two."""
    comparison = analysis.result.comparison
    built = [comparison.bases[key].evaluate(comparison.weights[key][entry.bounds][frame]) for key in _DRAWN]
    rms = [float(comparison.errors[key][entry.bounds].rms_frames[frame]) for key in _DRAWN]
    return (analysis.prepared.motion.frame(frame), built[0], built[1]), (rms[0], rms[1])


_DRAWN = ("hand", "quasi_eigen")


def _canvas(name: str, title: str, caption: str, height: float) -> tuple[Figure, Any]:
    """Return a figure with title and caption, and axes ``height`` inches high between them."""
    total = _HEAD + height + _FOOT + 0.45
    figure = _titled(name, title, caption, total)
    room = (0.62 / _WIDTH, (_FOOT + 0.40) / total, 1 - 0.78 / _WIDTH, height / total)
    return figure, figure.add_axes(room)


def _stack(name: str, title: str, caption: str, rows: list[tuple[Picture, str]]) -> Figure:
    """Lay pictures of one width under each other, each with a line beneath."""
    wide = _WIDTH - 2 * _SIDE
    heights = [wide * picture.shape[0] / picture.shape[1] for picture, _ in rows]
    line = 0.18
    total = _HEAD + sum(heights) + sum(line for _, note in rows if note) + _FOOT
    figure = _titled(name, title, caption, total)
    top = total - _HEAD
    for (picture, note), height in zip(rows, heights, strict=True):
        show(picture_axes(figure, (_SIDE / _WIDTH, (top - height) / total, wide / _WIDTH, height / total)), picture)
        top -= height
        if note:
            figure.text(_SIDE / _WIDTH, (top - 0.03) / total, note, fontsize=_TEXT, color=DIM, va="top")
            top -= line
    return figure


def _titled(name: str, title: str, caption: str, total: float) -> Figure:
    import textwrap

    figure = Figure(figsize=(_WIDTH, total))
    figure.text(_SIDE / _WIDTH, 1 - 0.10 / total, name, fontsize=_TITLE, weight=600, va="top")
    figure.text((_SIDE + 0.72) / _WIDTH, 1 - 0.10 / total, title, fontsize=_TITLE, color=DIM, va="top")
    text = "\n".join(textwrap.wrap(caption, 165))
    figure.text(_SIDE / _WIDTH, (_FOOT - 0.12) / total, text, fontsize=_TEXT, va="top", linespacing=1.35)
    return figure
