"""Scans as a JSON file beside its depth (or disparity) and colour images."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.images import image_size, read_grey, read_image, write_image
from engine.files.json_text import checked, load_json
from engine.files.scan_file import ScanFile, make_scan, reprojection_px
from engine.files.source import beside
from engine.mesh import FloatArray
from engine.scan.range_image import Camera, ColourImage, RangeImage

_FILM_DIAGONAL_MM = 43.2666
_USUAL_FOCAL_35MM = 30.0
_FAR_END = np.float32(1e10)


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="ignore", allow_inf_nan=False)


class DepthFields(_Strict):
    """The depth form: depth x ``unit_mm`` is mm along the optical axis, 0 is missing; fx fy cx cy in pixels."""

    depth: str
    colour: str | None = None
    unit_mm: float = Field(gt=0, le=1e4)
    fx: float = Field(ge=1e-3, le=1e7)
    fy: float = Field(ge=1e-3, le=1e7)
    cx: float = Field(ge=-1e7, le=1e7)
    cy: float = Field(ge=-1e7, le=1e7)


class DisparityFields(_Strict):
    """The disparity form: 1 / depth in 1/m runs from ``disparity_min`` (stored 0) to ``disparity_max`` (full scale).

    ``focal_35mm`` is the focal length on 36 x 24 mm film; fx fy cx cy in pixels win over it.
    """

    disparity: str
    colour: str | None = None
    disparity_min: float = Field(ge=-1e3, le=1e3)
    disparity_max: float = Field(gt=0, le=1e3)
    focal_35mm: float | None = Field(default=None, ge=1, le=2000)
    fx: float | None = Field(default=None, ge=1e-3, le=1e7)
    fy: float | None = Field(default=None, ge=1e-3, le=1e7)
    cx: float | None = Field(default=None, ge=-1e7, le=1e7)
    cy: float | None = Field(default=None, ge=-1e7, le=1e7)

    @model_validator(mode="after")
    def _ordered(self) -> DisparityFields:
        if self.disparity_max <= self.disparity_min:
            raise ValueError("disparity_max is not above disparity_min")
        if (self.fx is None) != (self.fy is None):
            raise ValueError("fx and fy are only useful together")
        return self


def read_depth_json(path: str | Path, unit: str | None = None) -> ScanFile:
    """Read a scan from a JSON file that names its images.

    Parameters
    ----------
    path : str or Path
        The JSON file; its images lie in the same folder or below.
    unit : str, optional
        Has no effect: the file states the unit itself. A wish that differs is answered by a warning.

    Raises
    ------
    InputError
        On anything wrong with the JSON (the field is named), the images, or their sizes.
    """
    path = Path(path)
    value = load_json(path)
    if "depth" not in value and "disparity" not in value:
        raise InputError(f"{path}, depth", "neither 'depth' nor 'disparity' is there", "name the depth image")
    result = _read_depth(path, value) if "depth" in value else _read_disparity(path, value)
    if unit not in (None, "mm"):
        note = f"the unit {unit} was not applied: this file states its own"
        return replace(result, warnings=(*result.warnings, note))
    return result


def write_depth_scan(path: str | Path, scan: RangeImage, unit_mm: float = 0.02) -> None:
    """Write a scan as ``NAME.json``, ``NAME_depth.png`` (16 bits) and ``NAME_colour.png``.

    Depth is rounded to ``unit_mm``; points come back within half of it along the ray.

    Raises
    ------
    InputError
        When the scan has no camera or its points are not on the camera's rays (the form cannot hold it),
        when a depth does not fit 16 bits, or when a file cannot be written.
    """
    path = Path(path)
    if scan.camera is None:
        raise InputError("scan", "has no camera, which a depth image needs", "write .npz or .ply")
    if reprojection_px(scan) > 0.01:
        raise InputError("scan", "its points do not lie on its camera's rays", "write .npz or .ply")
    if not 0 < unit_mm < float("inf"):
        raise InputError("unit_mm", f"is {unit_mm}", "give a positive step in mm")
    steps = np.rint(np.where(scan.valid, -scan.points[..., 2], 0.0) / unit_mm)
    if steps[scan.valid].min() < 1:
        raise InputError("scan", f"has points nearer than one step of {unit_mm} mm", "write .npz or .ply")
    if steps.max() > 65535:
        least = math.ceil(float(steps.max()) * unit_mm / 65535 * 1e4) / 1e4
        raise InputError("unit_mm", f"{unit_mm} cannot hold these depths in 16 bits", f"give at least {least:.4f}")
    depth_name, colour_name = f"{path.stem}_depth.png", f"{path.stem}_colour.png"
    fields: dict[str, Any] = {"depth": depth_name}
    write_image(path.with_name(depth_name), steps.astype(np.uint16))
    if scan.colour is not None:
        write_image(path.with_name(colour_name), scan.colour)
        fields["colour"] = colour_name
    camera = scan.camera
    fields |= {"unit_mm": unit_mm, "fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy}
    with atomic_write(path) as handle:
        handle.write((json.dumps(fields, indent=1) + "\n").encode())


def _read_depth(path: Path, value: dict[str, Any]) -> ScanFile:
    fields = checked(DepthFields, value, path)
    depth_path = beside(path, fields.depth, "depth")
    colour_path = beside(path, fields.colour, "colour") if fields.colour is not None else None
    size = image_size(depth_path)
    if colour_path is not None and image_size(colour_path) != size:
        raise _other_size(colour_path, depth_path)
    stored = read_grey(depth_path)
    if not (stored > 0).any():
        raise _nothing_measured(depth_path)
    warnings: tuple[str, ...] = ()
    if stored.dtype == np.uint8:
        warnings = (f"depth has only 8 bits: one step is {fields.unit_mm:g} mm",)
    stored, dropped = _without_nonsense(stored)
    warnings += dropped
    with np.errstate(over="ignore", invalid="ignore"):
        depth = stored.astype(np.float64) * fields.unit_mm
    colour = read_image(colour_path) if colour_path is not None else None
    camera = Camera(fields.fx, fields.fy, fields.cx, fields.cy)
    scan, more = make_scan(str(path), _points(camera, depth, depth_path), colour, camera)
    sources = tuple(p for p in (path, depth_path, colour_path) if p is not None)
    return ScanFile(scan, "mm", f"unit_mm {fields.unit_mm:g}, as in the file", sources, "depth", warnings + more)


def _read_disparity(path: Path, value: dict[str, Any]) -> ScanFile:
    fields = checked(DisparityFields, value, path)
    disparity_path = beside(path, fields.disparity, "disparity")
    colour_path = beside(path, fields.colour, "colour") if fields.colour is not None else None
    width, height = image_size(disparity_path)
    if colour_path is not None:
        colour_width, colour_height = image_size(colour_path)
        if abs(colour_width * height - colour_height * width) > max(colour_width, colour_height):
            raise _other_size(colour_path, disparity_path)
    stored = read_grey(disparity_path)
    if stored.dtype not in (np.uint8, np.uint16):
        raise InputError(str(disparity_path), f"stores {stored.dtype}", "give 8 or 16-bit disparity")
    full = float(np.iinfo(stored.dtype).max)
    step = (fields.disparity_max - fields.disparity_min) / full
    per_metre = fields.disparity_min + stored * step
    depth = np.full(per_metre.shape, np.nan)
    np.divide(1000.0, per_metre, out=depth, where=per_metre > 1e-3)
    camera, assumed = _disparity_camera(fields, width, height)
    colour: ColourImage | None = None
    warnings: tuple[str, ...] = ()
    if colour_path is not None:
        colour, warnings = _resampled(read_image(colour_path), width, height)
    near = float(np.nanpercentile(depth, 25)) if np.isfinite(depth).any() else 0.0
    coarse = near * near * step / 1000.0
    if coarse > 0.2:
        warnings += (f"disparity is coarse: one step is {coarse:.1f} mm at a distance of {near:.0f} mm",)
    scan, more = make_scan(str(path), _points(camera, depth, disparity_path), colour, camera)
    sources = tuple(p for p in (path, disparity_path, colour_path) if p is not None)
    return ScanFile(scan, "m", f"disparity in 1/m, as in the file; {assumed}", sources, "disparity", warnings + more)


def _disparity_camera(fields: DisparityFields, width: int, height: int) -> tuple[Camera, str]:
    cx = (width - 1) / 2 if fields.cx is None else fields.cx
    cy = (height - 1) / 2 if fields.cy is None else fields.cy
    if fields.fx is not None and fields.fy is not None:
        return Camera(fields.fx, fields.fy, cx, cy), "focal length as in the file"
    equivalent = _USUAL_FOCAL_35MM if fields.focal_35mm is None else fields.focal_35mm
    focal = equivalent * float(np.hypot(width, height)) / _FILM_DIAGONAL_MM
    source = "assumed: the file names none" if fields.focal_35mm is None else "as in the file"
    return Camera(focal, focal, cx, cy), f"focal length {equivalent:g} mm on 35 mm film ({focal:.0f} px), {source}"


def _points(camera: Camera, depth: FloatArray, path: Path) -> FloatArray:
    depth = np.where(np.isfinite(depth) & (depth > 0), depth, np.nan)
    if np.isnan(depth).all():
        raise _nothing_measured(path)
    return camera.points(depth)


def _resampled(colour: ColourImage, width: int, height: int) -> tuple[ColourImage, tuple[str, ...]]:
    if colour.shape[:2] == (height, width):
        return colour, ()
    note = f"colour was scaled from {colour.shape[1]} x {colour.shape[0]} to the disparity's {width} x {height} pixels"
    scaled = cv2.resize(colour, (width, height), interpolation=cv2.INTER_AREA)
    return np.asarray(scaled, dtype=np.uint8), (note,)


def _without_nonsense(stored: NDArray[Any]) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Return floats without what no sensor measures, and how many of each kind went; 0 and NaN mean missing."""
    if stored.dtype.kind != "f":
        return stored, ()
    with np.errstate(invalid="ignore"):
        kinds = {"negative": stored < 0, "infinite": np.isinf(stored), "at a renderer's far end": stored == _FAR_END}
    wrong = [f"{int(mask.sum())} depths are {kind}: taken as missing" for kind, mask in kinds.items() if mask.any()]
    if not wrong:
        return stored, ()
    return np.where(np.logical_or.reduce(list(kinds.values())), np.nan, stored), tuple(wrong)


def _nothing_measured(path: Path) -> InputError:
    return InputError(str(path), "has no valid pixel (all are missing)", "check that it is the depth image")


def _other_size(colour: Path, depth: Path) -> InputError:
    sizes = [" x ".join(map(str, image_size(path))) for path in (colour, depth)]
    problem = f"is {sizes[0]} pixels, the depth image {sizes[1]}"
    return InputError(str(colour), problem, "give images with the same pixels")
