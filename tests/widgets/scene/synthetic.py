"""A made-up face: an egg with a nose, two cheeks of colour and a hole in the scan, fitted with the real template."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

import resources
from engine.files.template import read_template
from engine.scan.fit import FaceFit, fit_template
from engine.scan.range_image import Camera, RangeImage
from engine.scan.template import FaceTemplate

WIDTH, HEIGHT = 240, 240
CAMERA = Camera(760.0, 760.0, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)


@lru_cache(maxsize=1)
def template() -> FaceTemplate:
    return read_template(resources.template_path())


def fiducials(scheme: str = "closed") -> dict[str, tuple[float, float]]:
    layout = template().layout(scheme)
    low, high = layout.vertices.min(axis=0), layout.vertices.max(axis=0)
    scale = 0.74 * HEIGHT / (high - low)[1]
    flat = (layout.vertices - (low + high) / 2) * scale + [WIDTH / 2, HEIGHT / 2]
    return {name: (float(flat[k, 0]), float(flat[k, 1])) for name, k in layout.fiducials.items()}


@lru_cache(maxsize=4)
def scan(colour: bool = True, seed: int = 0) -> RangeImage:
    rows, columns = np.indices((HEIGHT, WIDTH))
    x, y = (columns - CAMERA.cx) / WIDTH, (rows - CAMERA.cy) / HEIGHT
    depth = 650.0 + 220.0 * x**2 + 120.0 * y**2 - 18.0 * np.exp(-((x / 0.05) ** 2) - ((y - 0.05) / 0.12) ** 2)
    depth += np.random.default_rng(seed).normal(0.0, 0.1, depth.shape)
    depth[150:170, 150:170] = np.nan
    depth[np.hypot(x, y) > 0.62] = np.nan
    picture = np.empty((HEIGHT, WIDTH, 3), dtype=np.uint8)
    picture[...] = (205, 160, 138)
    picture[:, : WIDTH // 2] = (40, 160, 60)
    return RangeImage(CAMERA.points(depth), picture if colour else None, CAMERA)


@lru_cache(maxsize=8)
def fit(scheme: str = "closed", levels: int = 1, seed: int = 0) -> FaceFit:
    return fit_template(scan(seed=seed), fiducials(scheme), template(), scheme, levels=levels)
