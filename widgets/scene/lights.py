"""The studio light that every face is seen in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pyvista as pv


@dataclass(frozen=True)
class StudioLight:
    """One directional light: where it stands as seen from the head (+Y up, +Z out of the face), colour, strength."""

    name: str
    direction: tuple[float, float, float]
    colour: str
    intensity: float


STUDIO = (
    StudioLight("key", (-3.2, 2.8, 6.4), "#fff5ea", 0.78),
    StudioLight("fill", (4.2, -0.2, 5.4), "#cfe0ff", 0.34),
    StudioLight("front", (0.0, -1.6, 7.4), "#fff2ea", 0.20),
    StudioLight("rim left", (3.6, 2.0, -5.6), "#eaf4ff", 0.55),
    StudioLight("rim right", (-4.2, 1.0, -5.1), "#fff4ea", 0.42),
)


def add_studio_light(renderer: Any, strength: float = 1.0) -> None:
    """Replace a pyvista renderer's lights by key, fill, front and two rims.

    The lights stay with the head, not with the camera, so that shading tells the shape while the view turns.
    """
    renderer.remove_all_lights()
    for spec in STUDIO:
        light = pv.Light(
            position=spec.direction,
            focal_point=(0.0, 0.0, 0.0),
            color=spec.colour,
            intensity=spec.intensity * strength,
            light_type="scene light",
            positional=False,
        )
        renderer.add_light(light)
