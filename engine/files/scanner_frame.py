"""Which way a scan's axes and rows run, found out from its points, and the camera behind it.

Files of other programs come in the frame of their sensor: often +Y down and +Z away from it, sometimes with rows from
the bottom. What was turned is always said.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engine.mesh import FloatArray
from engine.scan.range_image import Camera, ColourImage

_MOST_SAMPLES = 20_000
_CAMERA_TOLERANCE_PX = 0.5
_PARALLEL_IS_BETTER = 0.5


@dataclass(frozen=True)
class FacingScan:
    """A scan turned into the studio's frame: +Y up, +Z towards the scanner, rows from the top, columns to the right.

    Parameters
    ----------
    points : (H, W, 3) float
        As given, axes and pixels turned; NaN where missing.
    colour : (H, W, 3) uint8, optional
        Turned with the points.
    camera : Camera, optional
        Where the points lie on the rays of a pinhole at the origin, to half a pixel.
    said : tuple of str
        What was assumed, for ``ScanFile.assumed``.
    warnings : tuple of str
        What may have been turned wrongly.
    """

    points: FloatArray
    colour: ColourImage | None
    camera: Camera | None
    said: tuple[str, ...]
    warnings: tuple[str, ...]


def face_scanner(points: FloatArray, colour: ColourImage | None) -> FacingScan:
    """Turn points (H, W, 3) of an unknown frame, NaN where missing, so that they face the scanner.

    Where they lie on the rays of a pinhole at the origin, they are in the frame of the sensor, and z > 0 means that
    it looks along +Z: then Y is taken to point down (or X to the left) if the rows (columns) bear that out, and else
    Z alone is turned. Without such a pinhole +Z is taken to point towards the scanner. Y and X are trusted from then
    on: rows that run upwards and columns that run to the left are turned.
    """
    said: list[str] = []
    warnings: list[str] = []
    pinhole = pinhole_scatter(points) < np.inf
    flips = np.ones(3)
    if pinhole and np.nanmedian(points[..., 2]) > 0:
        flips[2] = -1
        if _share_growing(points, 1, 0) >= 0.5:
            flips[1] = -1
            said.append("+Y down and +Z away from the scanner: turned")
        elif _share_growing(points, 0, 1) < 0.5:
            flips[0] = -1
            said.append("+X to the left and +Z away from the scanner: turned")
        else:
            said.append("+Z away from the scanner: Z turned")
            warnings.append("its frame is taken to be left-handed: check that the face is not mirrored")
    elif not pinhole and np.nanmin(points[..., 2]) > 0:
        warnings.append("no pinhole at the origin sees its points: +Z is taken to point towards the scanner")
    turned = points * flips if (flips < 0).any() else points
    upwards, leftwards = _share_growing(turned, 1, 0) > 0.75, _share_growing(turned, 0, 1) < 0.25
    for wrong, image_axis, what in ((upwards, 0, "rows run upwards"), (leftwards, 1, "columns run to the left")):
        if wrong:
            turned = np.flip(turned, image_axis)
            colour = None if colour is None else np.flip(colour, image_axis)
            said.append(f"its {what}: turned")
    camera = _camera(turned) if pinhole else None
    if camera is not None:
        said.append(f"camera found from the points (focal length {camera.fx:.0f} px)")
    colour = None if colour is None else np.ascontiguousarray(colour)
    return FacingScan(np.ascontiguousarray(turned), colour, camera, tuple(said), tuple(warnings))


def pinhole_scatter(points: FloatArray) -> float:
    """Return by how many pixels points (H, W, 3) miss the rays of the best pinhole at the origin, the median.

    Infinite where there is none: parallel rays explain better where they stand in the image.
    """
    columns, rows, sample = _sample(points)
    if len(sample) < 10 or (np.sign(sample[:, 2]) != np.sign(sample[0, 2])).mean() > 0.01:
        return float("inf")
    worst = 0.0
    for axis, places in ((0, columns), (1, rows)):
        with np.errstate(all="ignore"):
            central = _line(places, sample[:, axis] / sample[:, 2])[2]
        if not central <= max(_PARALLEL_IS_BETTER * _line(places, sample[:, axis])[2], 0.05):
            return float("inf")
        worst = max(worst, central)
    return worst


def _camera(points: FloatArray) -> Camera | None:
    columns, rows, sample = _sample(points)
    sample, keep = sample[sample[:, 2] < 0], sample[:, 2] < 0
    if keep.mean() < 0.99 or len(sample) < 10:
        return None
    slope_x, offset_x, error_x = _line(columns[keep], -sample[:, 0] / sample[:, 2])
    slope_y, offset_y, error_y = _line(rows[keep], sample[:, 1] / sample[:, 2])
    if not (slope_x > 0 and slope_y > 0 and max(error_x, error_y) <= _CAMERA_TOLERANCE_PX):
        return None
    return Camera(1 / slope_x, 1 / slope_y, -offset_x / slope_x, -offset_y / slope_y)


def _line(places: FloatArray, values: FloatArray) -> tuple[float, float, float]:
    """Return slope, offset and median distance in pixels of values (n,) along places (n,), spikes set aside."""
    keep = np.isfinite(values)
    slope = offset = 0.0
    error = float("inf")
    for _ in range(4):
        if keep.sum() < 10 or np.ptp(places[keep]) == 0:
            return 0.0, 0.0, float("inf")
        slope, offset = np.polynomial.polynomial.polyfit(places[keep], values[keep], 1)[::-1]
        residual = np.abs(values - (offset + slope * places))
        error = float(np.median(residual[np.isfinite(residual)]))
        keep = np.isfinite(values) & (residual <= max(4 * error, 1e-12))
    return float(slope), float(offset), error / abs(slope) if slope else float("inf")


def _sample(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    rows, columns = np.nonzero(~np.isnan(points[..., 2]))
    step = max(1, len(rows) // _MOST_SAMPLES)
    # An even step over a regular grid would meet the same columns again and again.
    step += step > 1 and points.shape[1] % step == 0
    rows, columns = rows[::step], columns[::step]
    return columns.astype(np.float64), rows.astype(np.float64), points[rows, columns]


def _share_growing(points: FloatArray, axis: int, image_axis: int) -> float:
    """Share of neighbouring samples along ``image_axis`` (0 rows, 1 columns) whose coordinate grows; 0.5 of none."""
    step = max(1, points.shape[0] // 64), max(1, points.shape[1] // 64)
    change = np.diff(points[:: step[0], :: step[1], axis], axis=image_axis)
    change = change[np.isfinite(change) & (change != 0)]
    return float(np.mean(change > 0)) if change.size else 0.5
