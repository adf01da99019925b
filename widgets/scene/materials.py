"""How surfaces answer to the studio light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Material:
    """Phong coefficients of a surface; ``colour`` is what it has without picture or heat."""

    colour: str
    diffuse: float
    ambient: float
    specular: float
    power: float

    def apply(self, surface: Any) -> None:
        """Set a VTK property to this material, Phong shaded."""
        surface.SetInterpolationToPhong()
        surface.SetDiffuse(self.diffuse)
        surface.SetAmbient(self.ambient)
        surface.SetSpecular(self.specular)
        surface.SetSpecularPower(self.power)
        surface.SetSpecularColor(1.0, 1.0, 1.0)


SKIN = Material("#ffffff", diffuse=0.92, ambient=0.13, specular=0.14, power=14)
CLAY = Material("#d6ac94", diffuse=0.92, ambient=0.13, specular=0.14, power=14)
EYE = Material("#efece6", diffuse=0.90, ambient=0.16, specular=0.90, power=90)
TEETH = Material("#d9cfbc", diffuse=0.80, ambient=0.10, specular=0.45, power=40)
TONGUE = Material("#a8625a", diffuse=0.85, ambient=0.10, specular=0.30, power=24)
MOUTH = Material("#8f4a43", diffuse=0.80, ambient=0.08, specular=0.20, power=20)
"""The inside of the mouth."""
HAIR = Material("#3a2f2a", diffuse=0.80, ambient=0.12, specular=0.20, power=20)
"""Lashes and brows too."""
PICTURE = Material("#ffffff", diffuse=0.36, ambient=0.56, specular=0.04, power=14)
"""For a photographed texture, which already carries the light it was taken in."""
PAINTED = Material("#ffffff", diffuse=0.86, ambient=0.20, specular=0.10, power=14)
"""For a texture of plain colour that carries no light."""
HEAT = Material("#ffffff", diffuse=0.66, ambient=0.42, specular=0.05, power=14)
BLANK = Material("#ffffff", diffuse=0.0, ambient=1.0, specular=0.0, power=1)
"""Shows its own colour and no shape."""
