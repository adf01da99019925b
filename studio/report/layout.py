"""A sheet of A4 in inches: text, rules, pictures and verdicts at their places, the same on every page."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from engine.scan.limits import Verdict
from studio.report.drawing import DIM, INK, RULE, Picture, picture_axes, show

PAGE = (8.27, 11.69)
"""A4 upright, inches."""
LEFT, RIGHT, TOP, BOTTOM = 0.7, 0.7, 0.6, 0.6
WIDE = PAGE[0] - LEFT - RIGHT
HEADLINE, HEAD, BODY, NOTE = 16.0, 9.5, 7.5, 6.5

WORDS = {Verdict.OK: "pass", Verdict.WARN: "warn", Verdict.FAIL: "fail", None: "not judged"}
"""Every verdict as a word; it never stands as a colour alone."""
_MARKS = {Verdict.OK: "o", Verdict.WARN: "^", Verdict.FAIL: "X", None: "_"}
INKS = {Verdict.OK: "#2c8a53", Verdict.WARN: "#b98207", Verdict.FAIL: "#c0242b", None: "#8a9099"}
"""Colours of the verdicts; in grey print ok is the lightest and told apart by its shape."""

Place = tuple[float, float, float, float]
"""Left, bottom, width, height in inches from the lower left of the page."""


class Sheet:
    """One page; all places are inches from its lower left corner."""

    def __init__(self) -> None:
        self.figure = Figure(figsize=PAGE)

    def write(self, x: float, y: float, text: str, size: float = BODY, **style: Any) -> None:
        """Write text whose upper left (or with ``ha``, right or middle) is at (x, y)."""
        style.setdefault("va", "top")
        self.figure.text(x / PAGE[0], y / PAGE[1], text, fontsize=size, **style)

    def rule(self, y: float, width: float = 0.5, x: float = LEFT, wide: float = WIDE, colour: str = RULE) -> None:
        """Draw a horizontal line."""
        self.line((x, y), (x + wide, y), width, colour)

    def line(self, start: tuple[float, float], end: tuple[float, float], width: float, colour: str = INK) -> None:
        """Draw a straight line."""
        xs, ys = (start[0] / PAGE[0], end[0] / PAGE[0]), (start[1] / PAGE[1], end[1] / PAGE[1])
        self.figure.add_artist(Line2D(xs, ys, color=colour, linewidth=width, solid_capstyle="butt"))

    def bar(self, place: Place, colour: str, **style: Any) -> None:
        """Fill a rectangle."""
        left, bottom, width, height = self.share(place)
        style.setdefault("linewidth", 0)
        patch = Rectangle((left, bottom), width, height, facecolor=colour, transform=self.figure.transFigure, **style)
        self.figure.add_artist(patch)

    def mark(self, x: float, y: float, verdict: Verdict | None, size: float = 5.0) -> None:
        """Draw the sign of a verdict: disc, triangle or cross, ``size`` points wide."""
        colour = INKS[verdict]
        hollow = verdict is Verdict.OK
        self.figure.add_artist(
            Line2D(
                [x / PAGE[0]], [y / PAGE[1]], marker=_MARKS[verdict], markersize=size, color=colour, linestyle="none",
                markerfacecolor="white" if hollow else colour, markeredgewidth=0.9 if hollow else 0.4,
            )
        )  # fmt: skip

    def spot(self, x: float, y: float, shape: str, size: float, colour: str) -> None:
        """Draw a small filled sign of matplotlib's shapes, ``size`` points wide."""
        spot = Line2D([x / PAGE[0]], [y / PAGE[1]], marker=shape, markersize=size, color=colour, markeredgewidth=0)
        spot.set_linestyle("none")
        self.figure.add_artist(spot)

    def verdict(self, x: float, y: float, verdict: Verdict | None, size: float = BODY) -> None:
        """Write a verdict as sign and word; (x, y) is the upper left."""
        height = size / 72
        self.mark(x + 0.4 * height, y - 0.6 * height, verdict, 0.72 * size)
        weight = 400 if verdict in (Verdict.OK, None) else 600
        self.write(x + 1.25 * height, y, WORDS[verdict], size, weight=weight)

    def axes(self, place: Place) -> Any:
        """Return axes without ticks or frame."""
        return picture_axes(self.figure, self.share(place))

    def picture(self, place: Place, picture: Picture) -> None:
        """Draw a picture as large as it fits."""
        show(self.axes(place), picture)

    def share(self, place: Place) -> Place:
        """Return a place in parts of the page, as matplotlib wants it."""
        return (place[0] / PAGE[0], place[1] / PAGE[1], place[2] / PAGE[0], place[3] / PAGE[1])

    def caption(self, place: Place, text: str) -> None:
        """Write a line below a place."""
        self.write(place[0], place[1] - 0.035, text, NOTE, color=DIM)

    def foot(self, left: str, number: int, count: int) -> None:
        """Write what stands at the foot of every page."""
        self.rule(0.47, 0.4)
        self.write(LEFT, 0.42, left, NOTE, color=DIM)
        self.write(LEFT + WIDE, 0.42, f"{number} / {count}", NOTE, ha="right", color=DIM)


FACT_LETTERS = 32
"""A value of more letters goes on in the next line, so that it keeps to its column."""


def facts(
    sheet: Sheet, x: float, y: float, rows: Sequence[tuple[str, str]], indent: float, step: float = 0.145
) -> float:
    """Write names with their values below each other, long ones on several lines; return the height below them."""
    for name, whole in rows:
        value = "\n".join(textwrap.wrap(whole, FACT_LETTERS)) or whole
        sheet.write(x, y, name, NOTE, color=DIM)
        sheet.write(x + indent, y, value, NOTE)
        y -= step * (1 + value.count("\n"))
    return y


def figure(value: float, unit: str = "mm") -> str:
    """Return a figure as pages have it: mm to a hundredth, small ones to a thousandth; ``none`` where there is none."""
    if not np.isfinite(value):
        return "none"
    if unit == "%":
        return f"{100 * value:.1f}"
    if unit == "count":
        return f"{value:.0f}"
    return f"{value:.3f}" if value < 0.0995 else f"{value:.2f}"


def limit(value: float) -> str:
    """Return a limit without needless zeros."""
    return f"{value:.3g}"
