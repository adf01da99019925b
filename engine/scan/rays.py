"""Where a pixel's depth lies in space: the ray of every pixel, known or estimated from the scan itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.mesh import BoolArray, FloatArray
from engine.scan.range_image import RangeImage

REGULAR_GRID_PX = 0.5


@dataclass(frozen=True, eq=False)
class Rays:
    """Lateral position as a line over depth, for every pixel (u, v).

    x = a0 + a1 u + a2 v + (a3 + a4 u + a5 v) depth, and y likewise: a pinhole and a parallel scanner alike, rolled or
    not. ``coefficients`` is (2, 6). ``source`` says where they come from: ``camera``; ``grid``, estimated from the
    points; or ``irregular``, where the points do not follow such rays and x, y stay as measured.
    """

    coefficients: FloatArray
    source: str

    @classmethod
    def of(cls, scan: RangeImage) -> Rays:
        """Return the rays of ``scan``: from its camera, else the least-squares lines through its valid pixels."""
        camera = scan.camera
        if camera is not None:
            across = [0.0, 0.0, 0.0, -camera.cx / camera.fx, 1 / camera.fx, 0.0]
            down = [0.0, 0.0, 0.0, camera.cy / camera.fy, 0.0, -1 / camera.fy]
            return cls(np.array([across, down]), "camera")
        rows, columns = np.nonzero(scan.valid)
        points = scan.points[scan.valid]
        terms = _terms(columns.astype(np.float64), rows.astype(np.float64), -points[:, 2])
        scale = np.maximum(np.abs(terms).max(axis=0), 1e-12)
        lines = np.linalg.lstsq(terms / scale, points[:, :2], rcond=1e-10)[0] / scale[:, None]
        off = np.linalg.norm(terms @ lines - points[:, :2], axis=1)
        steps = np.linalg.norm(np.diff(scan.points[..., :2], axis=1), axis=2)
        pitch = float(np.nanmedian(steps)) if np.isfinite(steps).any() else np.inf
        regular = np.quantile(off, 0.95) <= REGULAR_GRID_PX * pitch
        return cls(lines.T, "grid" if regular else "irregular")

    @property
    def regular(self) -> bool:
        """Whether a pixel and its depth tell x and y."""
        return self.source != "irregular"

    def points_at(self, mask: BoolArray, depth: FloatArray) -> FloatArray:
        """Return the points (k, 3) of the pixels of ``mask`` (H, W), at ``depth`` (k,) mm."""
        rows, columns = np.nonzero(mask)
        return self.points(np.stack([columns, rows], axis=1).astype(np.float64), depth)

    def points(self, pixels: FloatArray, depth: FloatArray) -> FloatArray:
        """Return the points (k, 3) at sub-pixel positions (k, 2) and ``depth`` (k,) mm."""
        lateral = _terms(pixels[:, 0], pixels[:, 1], depth) @ self.coefficients.T
        return np.column_stack([lateral, -depth])


def _terms(u: FloatArray, v: FloatArray, depth: FloatArray) -> FloatArray:
    return np.stack([np.ones(len(u)), u, v, depth, depth * u, depth * v], axis=1)
