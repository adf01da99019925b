"""Colours of what a 3-D view shows besides the subject, dark and light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class ViewColours:
    """Colour roles of a 3-D view, as ``#rrggbb``.

    ``window`` is the gap between views; ``top`` and ``bottom`` the ends of the gradient behind the subject;
    ``plate`` with ``plate_opacity`` (0..1) the ground of everything written over it; ``wire_opacity`` 0..1.
    """

    name: str
    window: str
    top: str
    bottom: str
    plate: str
    plate_opacity: float
    text: str
    dim: str
    line: str
    accent: str
    points: str
    missing: str
    wire: str
    wire_opacity: float


DARK = ViewColours(
    name="dark",
    window="#1e1f22",
    top="#212327",
    bottom="#191a1d",
    plate="#191a1d",
    plate_opacity=0.80,
    text="#d7dae0",
    dim="#979da7",
    line="#3a3d42",
    accent="#e8912d",
    points="#a3a9b3",
    missing="#6b717a",
    wire="#ffffff",
    wire_opacity=0.30,
)
LIGHT = ViewColours(
    name="light",
    window="#dcdee2",
    top="#d8dade",
    bottom="#c9ccd1",
    plate="#eff0f2",
    plate_opacity=0.84,
    text="#212429",
    dim="#5a616b",
    line="#c3c7cd",
    accent="#e8912d",
    points="#4d545e",
    missing="#8a9099",
    wire="#ffffff",
    wire_opacity=0.34,
)
PAPER = ViewColours(
    name="paper",
    window="#ffffff",
    top="#ffffff",
    bottom="#ffffff",
    plate="#ffffff",
    plate_opacity=0.90,
    text="#16181b",
    dim="#4a4f57",
    line="#c3c7cd",
    accent="#c46a10",
    points="#5a616b",
    missing="#8a9099",
    wire="#1d2024",
    wire_opacity=0.55,
)


def view_colours(name: str) -> ViewColours:
    """Return the colours of the theme ``name``: dark, light, or paper (for print)."""
    return {"dark": DARK, "light": LIGHT, "paper": PAPER}[name]


def rgb(colour: str) -> tuple[float, float, float]:
    """Return ``#rrggbb`` as three numbers 0..1."""
    return (int(colour[1:3], 16) / 255.0, int(colour[3:5], 16) / 255.0, int(colour[5:7], 16) / 255.0)


def apply_background(renderer: Any, colours: ViewColours) -> None:
    """Give a renderer the vertical gradient of ``colours``."""
    renderer.SetBackground(*rgb(colours.bottom))
    renderer.SetBackground2(*rgb(colours.top))
    renderer.SetGradientBackground(colours.top != colours.bottom)
