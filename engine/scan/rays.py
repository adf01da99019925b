"""Where a pixel's depth lies in space: the ray of every pixel, known or estimated from the scan itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.mesh import BoolArray, FloatArray
from engine.scan.range_image import RangeImage


@dataclass(frozen=True, eq=False)
class Rays:
    """Lateral position as a line over depth: x = x0 + x1 * depth, y = y0 + y1 * depth, for every pixel.

    Holds for a pinhole (x0 = y0 = 0) and for a parallel scanner (x1 = y1 = 0) alike. ``coefficients`` (2, 4) gives
    (a, b, c, d) for x and y with x = a + b * u + (c + d * u) * depth, u the column; for y, u is the row.
    """

    coefficients: FloatArray

    @classmethod
    def of(cls, scan: RangeImage) -> Rays:
        """Return the rays of ``scan``: from its camera, else the least-squares line over its valid pixels."""
        camera = scan.camera
        if camera is not None:
            return cls(
                np.array(
                    [
                        [0.0, 0.0, -camera.cx / camera.fx, 1 / camera.fx],
                        [0.0, 0.0, camera.cy / camera.fy, -1 / camera.fy],
                    ]
                )
            )
        rows, columns = np.nonzero(scan.valid)
        points = scan.points[scan.valid]
        lines = []
        for axis, pixel in ((0, columns.astype(np.float64)), (1, rows.astype(np.float64))):
            terms = np.stack([np.ones(len(pixel)), pixel, -points[:, 2], -points[:, 2] * pixel], axis=1)
            scale = np.maximum(np.abs(terms).max(axis=0), 1e-12)
            lines.append(np.linalg.lstsq(terms / scale, points[:, axis], rcond=1e-10)[0] / scale)
        return cls(np.array(lines))

    def points_at(self, mask: BoolArray, depth: FloatArray) -> FloatArray:
        """Return the points (k, 3) of the pixels of ``mask`` (H, W), at ``depth`` (k,) mm."""
        rows, columns = np.nonzero(mask)
        return self.points(np.stack([columns, rows], axis=1).astype(np.float64), depth)

    def points(self, pixels: FloatArray, depth: FloatArray) -> FloatArray:
        """Return the points (k, 3) at sub-pixel positions (k, 2) and ``depth`` (k,) mm."""
        lateral = [
            a + b * pixels[:, k] + (c + d * pixels[:, k]) * depth for k, (a, b, c, d) in enumerate(self.coefficients)
        ]
        return np.stack([*lateral, -depth], axis=1)
