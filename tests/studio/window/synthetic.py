"""A smooth made-up face of 320 x 240 pixels with all its fiducials: enough to drive the window quickly."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np

from studio.scan.job import template_of

WIDTH, HEIGHT, FOCAL = 320, 240, 620.0


def fiducials(scheme: str = "closed") -> dict[str, tuple[float, float]]:
    """Return where the fiducials lie, in pixels: the template's own layout, centred."""
    layout = template_of().layout(scheme)
    low, high = layout.vertices.min(axis=0), layout.vertices.max(axis=0)
    scale = 0.72 * HEIGHT / (high - low)[1]
    centre = np.array([WIDTH / 2, HEIGHT / 2])
    return {
        name: tuple(map(float, (layout.vertices[k] - (low + high) / 2) * scale + centre))
        for name, k in layout.fiducials.items()
    }


def write_scan(folder: Path, name: str = "made", seed: int = 0) -> Path:
    """Write an ellipsoid with skin-coloured texture as depth and colour PNG with JSON; return the JSON."""
    random = np.random.default_rng(seed)
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    x, y = (columns - WIDTH / 2) / 110.0, (rows - HEIGHT / 2) / 115.0
    height = np.sqrt(np.clip(1.0 - x**2 - y**2, 0.0, None))
    depth = np.where(height > 0.05, 700.0 - 90.0 * height, 0.0)
    depth[depth > 0] += random.normal(0, 0.05, np.count_nonzero(depth > 0))
    skin = np.array([196, 148, 122]) * (0.55 + 0.45 * height[..., None])
    skin += 10 * np.sin(columns / 5.0)[..., None]
    colour = np.clip(np.where(depth[..., None] > 0, skin, 40), 0, 255).astype(np.uint8)
    cv2.imwrite(str(folder / f"{name}_depth.png"), np.rint(depth / 0.02).astype(np.uint16))
    cv2.imwrite(str(folder / f"{name}_colour.png"), colour[..., ::-1])
    header = {
        "depth": f"{name}_depth.png", "colour": f"{name}_colour.png", "unit_mm": 0.02,
        "fx": FOCAL, "fy": FOCAL, "cx": WIDTH / 2, "cy": HEIGHT / 2,
    }  # fmt: skip
    path = folder / f"{name}.json"
    path.write_text(json.dumps(header))
    return path
