"""Point clouds without rows put back on the pixels that saw them.

A pinhole at the origin sees all points of a column at one x / z and all of a row at one y / z, so the values of either
lie on a comb of constant pitch, whatever is missing. Parallel rays give the same combs in x and y.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from engine.errors import InputError
from engine.files.scan_file import ScanFile, make_scan
from engine.files.scanner_frame import face_scanner
from engine.files.source import MAX_PIXELS
from engine.mesh import BoolArray, FloatArray, IntArray
from engine.scan.range_image import ColourImage

LEAST_POINTS = 100
"""Fewer points do not show on which grid they lie."""

_BINS = 1 << 16
_MOST_SAMPLES = 20_000
_LOWEST_CYCLES = 3
_WEAKEST_PEAK = 0.3
_OFF_GRID = 0.15
_LEAST_FILLED = {"central": 0.02, "parallel": 0.2}


@dataclass(frozen=True)
class Comb:
    """Teeth at ``offset + pitch * k``, and the median distance of the values from their tooth in pitches."""

    pitch: float
    offset: float
    scatter: float


@dataclass(frozen=True)
class PixelGrid:
    """Where points stand in an image of the order in which they were written.

    Parameters
    ----------
    rows, columns : (n,) int
        The pixel of every point, -1 where it has none.
    height, width : int
        Size of the image, in pixels.
    is_central : bool
        Whether rays meet at the origin; else they are parallel.
    strays : int
        Points far outside the grid of the others.
    """

    rows: IntArray
    columns: IntArray
    height: int
    width: int
    is_central: bool
    strays: int


def scan_of_cloud(
    path: Path, points: FloatArray, colour: ColourImage | None, kind: str, unit: tuple[str, str, tuple[str, ...]]
) -> ScanFile:
    """Return the scan that a cloud is, put on its pixels.

    Parameters
    ----------
    path : Path
        The file.
    points : (n, 3) float
        In mm, in the order of the file; what is not finite is left out.
    colour : (n, 3) uint8, optional
        Of the same points.
    kind : str
        For ``ScanFile.format``.
    unit : tuple
        Unit, what was assumed and warnings, as of ``choose_unit``.

    Raises
    ------
    InputError
        When the points lie on no grid.
    """
    chosen, assumed, warnings = unit
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        points, colour = points[finite], None if colour is None else colour[finite]
        warnings += (f"{int((~finite).sum())} points are no numbers: left out",)
    grid = find_grid(points, str(path))
    image, picture, hidden = _image(points, colour, grid)
    if hidden:
        warnings += (f"{hidden} points fell on a pixel that another one has: the nearest was kept",)
    if grid.strays:
        warnings += (f"{grid.strays} points lie far outside the grid of the others: left out",)
    facing = face_scanner(image, picture)
    rays = "pixels found from x / z and y / z" if grid.is_central else "pixels found from x and y (parallel rays)"
    scan, more = make_scan(str(path), facing.points, facing.colour, facing.camera, chosen)
    assumed = "; ".join((assumed, rays, *facing.said))
    return ScanFile(scan, chosen, assumed, (path,), kind, warnings + facing.warnings + more)


def find_grid(points: FloatArray, subject: str) -> PixelGrid:
    """Find the pixels of finite points (n, 3), first with rays from the origin, then with parallel ones.

    Columns and rows are numbered in the direction in which the file was written, where it has one.

    Raises
    ------
    InputError
        On fewer than `LEAST_POINTS` points, or points on neither kind of grid.
    """
    if len(points) < LEAST_POINTS:
        problem = f"holds {len(points)} points, too few to find their pixels"
        raise InputError(subject, problem, f"give at least {LEAST_POINTS} points of a scan")
    depth = points[:, 2]
    for kind in ("central", "parallel"):
        if kind == "central":
            with np.errstate(all="ignore"):
                across = np.where(depth != 0, points[:, 0] / depth, np.nan), points[:, 1] / depth
        else:
            across = points[:, 0], points[:, 1]
        grid = _grid(across, kind)
        if grid is not None:
            return grid
    raise InputError(
        subject,
        "its points lie on no grid of pixels (neither x / z and y / z nor x and y have a constant pitch)",
        "export it with rows and columns, in the frame of the scanner, or with more digits",
    )


def find_comb(values: FloatArray) -> Comb | None:
    """Return the comb that values (n,) lie on, None where there is none.

    The pitch is a peak of the spectrum of their histogram, the lowest one that bears out, and is then refined on all
    values; noise of up to a fifth of the pitch, gaps and whole missing teeth do not matter.
    """
    sample = values[:: max(1, len(values) // (16 * _MOST_SAMPLES))]
    low, high = np.percentile(sample, [0.5, 99.5])
    extent = float(high - low)
    if not 0 < extent < np.inf:
        return None
    inner = sample[(sample >= low) & (sample <= high)]
    counts = np.histogram(inner, _BINS, (low, high))[0]
    strength = np.abs(np.fft.rfft(counts / counts.sum()))[: _BINS // 4]
    strength[:_LOWEST_CYCLES] = 0
    top = strength.max()
    if top < _WEAKEST_PEAK:
        return None
    is_peak = np.zeros(len(strength), dtype=bool)
    is_peak[1:-1] = (strength[1:-1] >= strength[:-2]) & (strength[1:-1] >= strength[2:])
    for cycles in np.flatnonzero(is_peak & (strength > max(0.5 * top, _WEAKEST_PEAK)))[:50]:
        comb = _refined(inner, float(low), extent, int(cycles))
        if comb.scatter < _OFF_GRID:
            return comb
    return None


def _refined(values: FloatArray, low: float, extent: float, cycles: int) -> Comb:
    near = values[:: max(1, len(values) // _MOST_SAMPLES)] - low
    tried = cycles + np.linspace(-1, 1, 81)
    sums = np.array([np.exp(2j * np.pi * near * (rate / extent)).mean() for rate in tried])
    best = int(np.abs(sums).argmax())
    pitch = extent / tried[best]
    offset = low + pitch * float(np.angle(sums[best])) / (2 * np.pi)
    for _ in range(3):
        teeth = np.rint((values - offset) / pitch)
        residual = values - (offset + pitch * teeth)
        keep = np.abs(residual) <= max(3 * float(np.median(np.abs(residual))), 1e-9 * pitch)
        centre = teeth[keep].mean()
        spread = teeth[keep] - centre
        if (total := float(spread @ spread)) == 0:
            break
        change = float(spread @ residual[keep]) / total
        offset += float(residual[keep].mean()) - change * centre
        pitch += change
    residual = (values - offset) / pitch
    return Comb(pitch, offset, float(np.median(np.abs(residual - np.rint(residual)))))


def _grid(across: tuple[FloatArray, FloatArray], kind: str) -> PixelGrid | None:
    known = np.isfinite(across[0]) & np.isfinite(across[1])
    if known.sum() < LEAST_POINTS:
        return None
    inside = known.copy()
    teeth: list[FloatArray] = []
    for values in across:
        comb = find_comb(values[known])
        if comb is None:
            return None
        with np.errstate(invalid="ignore"):
            tooth = np.rint((values - comb.offset) / comb.pitch)
        low, high = np.percentile(tooth[known][:: max(1, len(tooth) // _MOST_SAMPLES)], [1, 99])
        with np.errstate(invalid="ignore"):
            inside &= (tooth >= low - (high - low)) & (tooth <= high + (high - low))
        teeth.append(tooth)
    columns, rows = (np.where(inside, tooth, 0).astype(np.int64) for tooth in teeth)
    columns, width = _numbered(columns, inside, _runs_back(columns[inside], rows[inside]))
    rows, height = _numbered(rows, inside, _runs_back(rows[inside], columns[inside]))
    if width * height > MAX_PIXELS or inside.sum() < _LEAST_FILLED[kind] * width * height or min(width, height) < 4:
        return None
    return PixelGrid(rows, columns, height, width, kind == "central", int((~inside).sum()))


def _numbered(teeth: IntArray, inside: BoolArray, backwards: bool) -> tuple[IntArray, int]:
    low, high = int(teeth[inside].min()), int(teeth[inside].max())
    return np.where(inside, high - teeth if backwards else teeth - low, -1), high - low + 1


def _runs_back(teeth: IntArray, others: IntArray) -> bool:
    """Whether the teeth fall in the order of the file: from point to point in a line, or from line to line."""
    step = np.diff(teeth)
    along = step[(np.diff(others) == 0) & (np.abs(step) == 1)]
    if len(along) > len(teeth) // 3:
        return bool((along < 0).mean() > 0.5)
    place = np.linspace(-1, 1, len(teeth))
    return bool(place @ (teeth - teeth.mean()) < 0)


def _image(
    points: FloatArray, colour: ColourImage | None, grid: PixelGrid
) -> tuple[FloatArray, ColourImage | None, int]:
    """Return points and colours as images, and how many points were hidden by nearer ones."""
    kept = np.flatnonzero(grid.rows >= 0)
    place = grid.rows[kept] * grid.width + grid.columns[kept]
    shared = np.bincount(place, minlength=grid.width * grid.height)[place] > 1
    hidden = 0
    if shared.any():
        rivals, spot = kept[shared], place[shared]
        order = np.lexsort((np.abs(points[rivals, 2]), spot))
        first = np.ones(len(order), dtype=bool)
        first[1:] = spot[order][1:] != spot[order][:-1]
        winners = rivals[order[first]]
        hidden = len(rivals) - len(winners)
        kept = np.concatenate([kept[~shared], winners])
        place = grid.rows[kept] * grid.width + grid.columns[kept]
    image = np.full((grid.height * grid.width, 3), np.nan)
    image[place] = points[kept]
    picture: ColourImage | None = None
    if colour is not None:
        shades = np.zeros((grid.height * grid.width, 3), dtype=np.uint8)
        shades[place] = colour[kept]
        picture = shades.reshape(grid.height, grid.width, 3)
    return image.reshape(grid.height, grid.width, 3), picture, hidden
