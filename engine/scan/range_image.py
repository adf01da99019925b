"""A scan: one 3-D point per pixel, with a colour picture of the same pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.mesh import BoolArray, FloatArray, frozen

ColourImage = NDArray[np.uint8]


@dataclass(frozen=True)
class Camera:
    """A pinhole camera, in pixels: x_image = cx + fx * X / depth, y_image = cy - fy * Y / depth.

    The camera stands at the origin and looks along -Z (the scanner's +Z comes out of the face towards it).
    """

    fx: float
    fy: float
    cx: float
    cy: float

    def points(self, depth: FloatArray) -> FloatArray:
        """Return the points (H, W, 3) of a depth image (H, W), mm along the optical axis; NaN stays NaN."""
        rows, columns = np.indices(depth.shape)
        x = (columns - self.cx) / self.fx * depth
        y = -(rows - self.cy) / self.fy * depth
        return np.stack([x, y, -depth], axis=-1)

    def project(self, points: FloatArray) -> FloatArray:
        """Return pixel positions (k, 2) of points (k, 3), mm."""
        depth = -points[..., 2]
        x = self.cx + self.fx * points[..., 0] / depth
        y = self.cy - self.fy * points[..., 1] / depth
        return np.stack([x, y], axis=-1)


@dataclass(frozen=True)
class RangeImage:
    """An organised scan.

    Parameters
    ----------
    points : (H, W, 3) float
        Position per pixel in mm, +Y up, +Z towards the scanner; NaN where nothing was measured.
    colour : (H, W, 3) uint8, optional
        sRGB picture of the same pixels.
    camera : Camera, optional
        The pinhole that made it. Where it is unknown, a pixel's ray is estimated from its neighbours.

    Raises
    ------
    InputError
        On wrong shapes, a colour image of another size, or no valid pixel at all.
    """

    points: FloatArray
    colour: ColourImage | None = None
    camera: Camera | None = None

    def __post_init__(self) -> None:
        points = frozen(self.points, np.float64)
        if points.ndim != 3 or points.shape[2] != 3 or min(points.shape[:2]) < 2:
            raise InputError("range image", f"has shape {points.shape}", "give H x W x 3 points, H and W at least 2")
        incomplete = ~np.isfinite(points).all(axis=2)
        if incomplete.all():
            raise InputError("range image", "has no valid pixel", "check the file and its unit")
        if not np.isnan(points[incomplete]).all():
            points = np.where(incomplete[..., None], np.nan, points)
            points.flags.writeable = False
        object.__setattr__(self, "points", points)
        if self.colour is not None:
            colour = frozen(self.colour, np.uint8)
            if colour.ndim != 3 or colour.shape[2] != 3:
                raise InputError("colour image", f"has shape {colour.shape}", "give H x W x 3 bytes")
            if colour.shape[:2] != points.shape[:2]:
                sizes = f"{colour.shape[1]} x {colour.shape[0]}, the range image {points.shape[1]} x {points.shape[0]}"
                raise InputError("colour image", f"is {sizes}", "give images with the same pixels")
            object.__setattr__(self, "colour", colour)

    @property
    def height(self) -> int:
        """Rows of the image."""
        return int(self.points.shape[0])

    @property
    def width(self) -> int:
        """Columns of the image."""
        return int(self.points.shape[1])

    @property
    def valid(self) -> BoolArray:
        """Mask (H, W) of the pixels that were measured."""
        return ~np.isnan(self.points[..., 2])

    @property
    def missing_fraction(self) -> float:
        """Share of pixels without a point, 0..1."""
        return float(1.0 - self.valid.mean())
