"""Spikes removed, small gaps filled, noise calmed: what a scan needs before it is sampled.

Every step says what it changed; nothing is repaired silently.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.mesh import BoolArray, FloatArray
from engine.scan.range_image import RangeImage
from engine.scan.rays import Rays

SURFACE_STEP_MM = 3.0


@dataclass(frozen=True)
class RepairOptions:
    """What to repair, and how far.

    Parameters
    ----------
    remove_spikes, fill_gaps, smooth : bool
        The three steps.
    spike_mm : float
        A pixel is a spike when at most one neighbour lies within this much of its depth.
    largest_gap_px : int
        Gaps up to this width are filled; wider ones stay missing.
    smooth_px : float
        Radius (standard deviation) of the neighbourhood whose plane replaces a noisy depth, pixels.
    matte_threshold : float
        Blurred matte above which a gap's pixel takes its neighbours' value, 0..1 (Williams 1990, step 3).
    matte_kernel_px : int
        Width of the blurring kernel, odd pixels (step 2).
    """

    remove_spikes: bool = True
    spike_mm: float = 2.5
    fill_gaps: bool = True
    largest_gap_px: int = 12
    smooth: bool = True
    smooth_px: float = 1.2
    matte_threshold: float = 0.2
    matte_kernel_px: int = 3

    def __post_init__(self) -> None:
        for name, value, low, high in (
            ("spike_mm", self.spike_mm, 0.1, 1000.0),
            ("largest_gap_px", self.largest_gap_px, 0, 200),
            ("smooth_px", self.smooth_px, 0.3, 3.0),
            ("matte_threshold", self.matte_threshold, 0.01, 0.9),
            ("matte_kernel_px", self.matte_kernel_px, 3, 15),
        ):
            if not low <= value <= high:
                raise InputError(name, f"is {value}", f"give {low:g} to {high:g}")
        if self.matte_kernel_px % 2 == 0:
            raise InputError("matte_kernel_px", f"is {self.matte_kernel_px}", "give an odd number")


@dataclass(frozen=True)
class RepairReport:
    """What was found and changed.

    ``missing_fraction`` is the share of pixels without a point before anything was done, ``spikes`` the pixels taken
    out, ``filled_pixels`` those given a depth again, ``unfilled_fraction`` the share still missing. ``noise_mm`` is the
    standard deviation of the measured depth on the face; 0 until a face was fitted. ``grid`` says how x and y of a
    repaired pixel were found: by the ``camera``, a ``grid`` estimated from the points, or, where the points follow
    none, ``irregular``: x and y stay as measured and are inferred from their neighbours in gaps.
    """

    missing_fraction: float
    spikes: int
    filled_pixels: int
    unfilled_fraction: float
    noise_mm: float = 0.0
    grid: str = "camera"


@dataclass(frozen=True, eq=False)
class RepairedScan:
    """A scan ready to be sampled, with what happened to every pixel.

    ``scan`` is the repaired one, ``measured`` (H, W) the pixels whose point was measured and kept, ``spikes`` and
    ``filled`` (H, W) what was taken out and what was put in, ``raw`` the points (H, W, 3) without spikes as measured,
    ``surfaces`` (H, W) a number for every connected surface, 0 where missing.
    """

    scan: RangeImage
    raw: FloatArray
    measured: BoolArray
    spikes: BoolArray
    filled: BoolArray
    surfaces: NDArray[np.int32]
    rays: Rays
    report: RepairReport


def repair(scan: RangeImage, options: RepairOptions | None = None) -> RepairedScan:
    """Return ``scan`` without spikes, with small gaps filled and noise calmed, as ``options`` say.

    Raises
    ------
    InputError
        When no pixel is left.
    """
    options = options or RepairOptions()
    clean, spikes = remove_spikes(scan, options.spike_mm) if options.remove_spikes else (scan, _nothing(scan))
    rays = Rays.of(clean)
    smoothed = smooth_depth(clean, options.smooth_px, rays=rays) if options.smooth else clean
    whole, filled = smoothed, _nothing(scan)
    if options.fill_gaps:
        whole, filled = fill_gaps(
            smoothed,
            options.largest_gap_px,
            threshold=options.matte_threshold,
            kernel=options.matte_kernel_px,
            rays=rays,
        )
    report = RepairReport(
        missing_fraction=scan.missing_fraction,
        spikes=int(spikes.sum()),
        filled_pixels=int(filled.sum()),
        unfilled_fraction=whole.missing_fraction,
        grid=rays.source,
    )
    return RepairedScan(whole, clean.points, clean.valid, spikes, filled, _surfaces(whole), rays, report)


def find_spikes(scan: RangeImage, threshold: float = 2.5) -> BoolArray:
    """Return the mask (H, W) of pixels that hardly any neighbour agrees with.

    A pixel is a spike when at most one of its measured neighbours lies within ``threshold`` mm of its depth and at
    least three neighbours were measured. A step edge has neighbours on its own side and is left alone, whatever its
    height; so is a steep slope, whose neighbours across it agree.
    """
    depth = np.where(scan.valid, scan.points[..., 2], np.inf)
    padded = np.pad(depth, 1, constant_values=np.inf)
    agreeing = np.zeros(depth.shape, dtype=np.int8)
    measured = np.zeros(depth.shape, dtype=np.int8)
    for dy, dx in _neighbours(1):
        other = padded[1 + dy : 1 + dy + scan.height, 1 + dx : 1 + dx + scan.width]
        present = np.isfinite(other)
        measured += present
        with np.errstate(invalid="ignore"):
            agreeing += present & (np.abs(other - depth) <= threshold)
    return scan.valid & (agreeing <= 1) & (measured >= 3)


def remove_spikes(scan: RangeImage, threshold: float = 2.5) -> tuple[RangeImage, BoolArray]:
    """Return ``scan`` with its spikes missing, and their mask (H, W).

    Raises
    ------
    InputError
        When every pixel is a spike.
    """
    spikes = find_spikes(scan, threshold)
    if spikes.sum() == scan.valid.sum():
        raise InputError("range image", "every pixel stands alone", "check the unit and the spike threshold")
    return replace(scan, points=np.where(spikes[..., None], np.nan, scan.points)), spikes


def fill_gaps(
    scan: RangeImage, largest_gap: int = 12, *, threshold: float = 0.2, kernel: int = 3, rays: Rays | None = None
) -> tuple[RangeImage, BoolArray]:
    """Return ``scan`` with gaps up to ``largest_gap`` pixels wide filled, and the mask (H, W) of what was filled.

    Matte filling: matte and surface are blurred by a kernel of ``kernel`` pixels; where the blurred matte exceeds
    ``threshold`` the surface becomes blurred surface / blurred matte; again until the gap is closed. What is blurred
    is the depth relative to a plane fitted around every pixel, and x, y follow from the pixel's ray: blurring x, y, z
    themselves bends the grid by millimetres.

    Raises
    ------
    InputError
        With a threshold outside (0, 1).

    Notes
    -----
    Williams 1990, steps 0-4, as used by Yano & Harada 2009, section 3.1; the limit on the width is ours (taken
    literally, step 4 fills everything).
    """
    if not 0 < threshold < 1:
        raise InputError("matte threshold", f"is {threshold}", "give a share between 0 and 1")
    gaps = _narrow_gaps(scan.valid, largest_gap)
    if not gaps.any():
        return scan, gaps
    rays = rays or Rays.of(scan)
    points = np.array(scan.points)
    rows, columns = _bounding_box(gaps, margin=3 * largest_gap + 2)
    # Where a pixel's ray is not known, x and y have a local plane of their own, as the depth has.
    for axis in (2,) if rays.regular else (0, 1, 2):
        _fill_window(points[rows, columns, axis], gaps[rows, columns], largest_gap, threshold, kernel)
    filled = gaps & ~np.isnan(points[..., 2])
    if rays.regular:
        points[filled] = rays.points_at(filled, -points[filled, 2])
    return replace(scan, points=points), filled


def smooth_depth(
    scan: RangeImage, radius: float = 1.2, edge_mm: float = 1.0, *, rays: Rays | None = None
) -> RangeImage:
    """Return ``scan`` with every depth replaced by the plane through its neighbourhood, edges kept.

    Weights fall with the distance in the picture (standard deviation ``radius`` pixels) and with the height above the
    local slope (``edge_mm``), so that noise goes and lids and lips stay. Nothing is added where nothing was measured.
    This step is ours.
    """
    rays = rays or Rays.of(scan)
    valid = scan.valid
    depth = np.where(valid, -scan.points[..., 2], 0.0)
    rows, columns = _bounding_box(valid)
    window, present = depth[rows, columns], valid[rows, columns]
    _, slope_x, slope_y = _local_planes(window, present, radius)
    reach = max(round(2 * radius), 1)
    height, width = window.shape
    padded, padded_present = np.pad(window, reach), np.pad(present, reach).astype(np.float32)
    left = np.zeros((6, height, width), dtype=np.float32)
    right = np.zeros((3, height, width), dtype=np.float32)
    tilt_x, tilt_y = (slope_x / edge_mm).astype(np.float32), (slope_y / edge_mm).astype(np.float32)
    for dy, dx in [(0, 0), *_neighbours(reach)]:
        other = padded[reach + dy : reach + dy + height, reach + dx : reach + dx + width]
        step = (other - window).astype(np.float32)
        weight = step / np.float32(edge_mm) - tilt_x * dx - tilt_y * dy
        weight *= weight
        weight += 1
        np.divide(np.exp(-0.5 * (dx * dx + dy * dy) / radius**2), weight * weight, out=weight)
        weight *= padded_present[reach + dy : reach + dy + height, reach + dx : reach + dx + width]
        for row, term in enumerate((1, dx, dy, dx * dx, dx * dy, dy * dy)):
            if term:
                left[row] += np.float32(term) * weight
        step *= weight
        for row, term in enumerate((1, dx, dy)):
            if term:
                right[row] += np.float32(term) * step
    level = _solve_planes(left.astype(np.float64), right.astype(np.float64), 1e-3)[0]
    points = np.array(scan.points)
    full = np.full(depth.shape, np.nan)
    full[rows, columns] = np.where(present, window + level, np.nan)
    if rays.regular:
        points[valid] = rays.points_at(valid, full[valid])
    else:
        points[valid, 2] = -full[valid]
    return replace(scan, points=points)


def _surfaces(scan: RangeImage) -> NDArray[np.int32]:
    """Return a number (H, W) for every surface that no step in depth divides: face, wall, shoulder.

    Steps are those of the median of 3 x 3 pixels: a lone spike is not a surface of its own.
    """
    valid = scan.valid
    depth = cv2.medianBlur(np.where(valid, scan.points[..., 2], -1e6).astype(np.float32), 3)
    across = np.abs(np.diff(depth, axis=1)) > SURFACE_STEP_MM
    down = np.abs(np.diff(depth, axis=0)) > SURFACE_STEP_MM
    smooth = valid.copy()
    smooth[:, 1:] &= ~across
    smooth[:, :-1] &= ~across
    smooth[1:] &= ~down
    smooth[:-1] &= ~down
    labels = cv2.connectedComponents(smooth.astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)[1]
    # The pixels beside a step were left out to part the surfaces; each now joins the one on its own side.
    for left, right, step in (
        (labels[:, :-1], labels[:, 1:], across),
        (labels[:-1], labels[1:], down),
    ):
        for own, other in ((left, right), (right, left)):
            joins = (own == 0) & (other > 0) & ~step
            own[joins] = other[joins]
    # The median rounds corners off: what stands off it there belongs to the other surface, unless it is a lone spike.
    cut = np.abs(scan.points[..., 2] - depth) > SURFACE_STEP_MM
    labels[~valid | (cut & ~find_spikes(scan))] = 0
    return np.asarray(labels, dtype=np.int32)


def _solve_planes(left: FloatArray, right: FloatArray, ridge: float) -> FloatArray:
    """Return level and slopes (3, H, W) of weighted planes with moments ``left`` (1, x, y, xx, xy, yy).

    ``right`` holds the moments of the depth (z, xz, yz); ``ridge`` is the share of the total weight that keeps the
    slopes quiet where hardly any neighbour counts. NaN without support.
    """
    s, sx, sy, sxx, sxy, syy = left
    sxx, syy = sxx + ridge * s, syy + ridge * s
    # Cramer's rule on the symmetric 3 x 3 system: cheaper than a batched solve by an order of magnitude.
    c00, c01, c02 = sxx * syy - sxy * sxy, sxy * sy - sx * syy, sx * sxy - sxx * sy
    c11, c12, c22 = s * syy - sy * sy, sx * sy - s * sxy, s * sxx - sx * sx
    determinant = s * c00 + sx * c01 + sy * c02
    supported = (s > 1e-6) & (determinant > 1e-12 * s**3)
    inverse = np.where(supported, 1.0 / np.where(supported, determinant, 1.0), np.nan)
    z, xz, yz = right
    solution = np.stack([c00 * z + c01 * xz + c02 * yz, c01 * z + c11 * xz + c12 * yz, c02 * z + c12 * xz + c22 * yz])
    return np.asarray(inverse * solution, dtype=np.float64)


def _local_planes(depth: FloatArray, valid: BoolArray, radius: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value and slopes (H, W) of the Gaussian-weighted plane around every pixel; NaN without support."""
    height, width = depth.shape
    y, x = np.mgrid[0:height, 0:width].astype(np.float64)
    x, y = x - width / 2, y - height / 2
    weight = valid.astype(np.float64)
    base = float(depth[valid].mean()) if valid.any() else 0.0
    surface = np.where(valid, depth - base, 0.0)

    def blur(image: FloatArray) -> FloatArray:
        return np.asarray(cv2.GaussianBlur(image, (0, 0), radius, borderType=cv2.BORDER_CONSTANT), dtype=np.float64)

    s, sx, sy = blur(weight), blur(weight * x), blur(weight * y)
    sxx, sxy, syy = blur(weight * x * x), blur(weight * x * y), blur(weight * y * y)
    sz, sxz, syz = blur(surface), blur(surface * x), blur(surface * y)
    # Moments about the pixel itself.
    mx, my = sx - x * s, sy - y * s
    mxx, myy = sxx - 2 * x * sx + x * x * s, syy - 2 * y * sy + y * y * s
    mxy = sxy - x * sy - y * sx + x * y * s
    mxz, myz = sxz - x * sz, syz - y * sz
    level, slope_x, slope_y = _solve_planes(
        np.stack([s, mx, my, mxx, mxy, myy]), np.stack([sz, mxz, myz]), 1e-2 * radius**2
    )
    return level + base, slope_x, slope_y


def _fill_window(depth: FloatArray, gaps: BoolArray, largest_gap: int, threshold: float, kernel: int) -> None:
    """Fill the gaps of one window in place."""
    valid = ~np.isnan(depth)
    plane, _, _ = _local_planes(np.where(valid, depth, 0.0), valid, max(largest_gap / 2, 1.5))
    relative = np.where(valid, depth - plane, 0.0)
    matte = (valid & ~np.isnan(relative)).astype(np.float64)
    relative = np.nan_to_num(relative)
    open_ = gaps & ~np.isnan(plane)
    for _ in range(2 * largest_gap + 2):
        if not open_.any():
            break
        blurred_matte = cv2.GaussianBlur(matte, (kernel, kernel), 0, borderType=cv2.BORDER_CONSTANT)
        blurred = cv2.GaussianBlur(relative * matte, (kernel, kernel), 0, borderType=cv2.BORDER_CONSTANT)
        ready = open_ & (blurred_matte > threshold)
        if not ready.any():
            break
        relative[ready] = blurred[ready] / blurred_matte[ready]
        matte[ready] = 1.0
        open_ &= ~ready
    done = gaps & (matte > 0) & ~valid
    depth[done] = relative[done] + plane[done]


def _narrow_gaps(valid: BoolArray, largest: int) -> BoolArray:
    """Return the missing pixels that a disc of ``largest`` pixels across cannot reach without touching valid ones."""
    if largest <= 0 or valid.all():
        return np.zeros_like(valid)
    radius = largest / 2 + 0.5
    padded = np.pad(valid, largest)
    away = cv2.distanceTransform((~padded).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    grown = (away <= radius).astype(np.uint8)
    back = cv2.distanceTransform(grown, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    closed = (back > radius)[largest:-largest, largest:-largest]
    return np.asarray(closed & ~valid, dtype=np.bool_)


def _bounding_box(mask: BoolArray, margin: int = 0) -> tuple[slice, slice]:
    """Return the rows and columns that hold all of ``mask``, with a margin around it; everything for an empty mask."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return slice(0, mask.shape[0]), slice(0, mask.shape[1])
    return (
        slice(max(int(rows[0]) - margin, 0), int(rows[-1]) + 1 + margin),
        slice(max(int(columns[0]) - margin, 0), int(columns[-1]) + 1 + margin),
    )


def _neighbours(reach: int) -> list[tuple[int, int]]:
    span = range(-reach, reach + 1)
    return [(dy, dx) for dy in span for dx in span if (dy, dx) != (0, 0)]


def _nothing(scan: RangeImage) -> BoolArray:
    return np.zeros((scan.height, scan.width), dtype=np.bool_)
