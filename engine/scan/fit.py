"""A template on a scan becomes a face: warp, subdivide, sample, fill, and say how well it went."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from engine.errors import InputError
from engine.geometry.harmonic import harmonic_fill
from engine.geometry.normals import face_normals, incidence, vertex_normals
from engine.geometry.sampling import sample_bilinear, valid_share
from engine.mesh import BoolArray, FloatArray, IntArray, TriangleMesh, frozen
from engine.progress import Progress, silent
from engine.scan.range_image import RangeImage
from engine.scan.repair import SURFACE_STEP_MM, RepairedScan, RepairOptions, RepairReport
from engine.scan.repair import repair as repair_scan
from engine.scan.template import FaceTemplate
from engine.scan.warp import Positions, check_inside, mirror_proposals, propose_fiducials, warp_template

__all__ = ["FaceFit", "fit_template", "mirror_proposals", "propose_fiducials", "warp_template"]

LEAST_SHARE = 0.2
"""A surface with fewer than this share of the fiducials is not the face: a click beside the jaw hits the wall."""


@dataclass(frozen=True, eq=False)
class FaceFit:
    """A fitted face and what is known about it.

    Parameters
    ----------
    mesh : TriangleMesh
        Positions in mm in the scanner's frame; uv are the pixels the vertices were sampled at.
    normals : (N, 3) float
        Unit vertex normals.
    pixels : (N, 2) float
        Where each vertex lies on the picture.
    filled : (N,) bool
        Vertices on missing data, whose position was inferred.
    deviation_mm : (N,) float
        Distance to the scan as measured, averaged over the triangles around a vertex; NaN where filled.
    fiducial_residual_px : float
        Largest distance of a template fiducial from its click.
    folded_faces : (k,) int
        Triangles of the template (level 0) that turned over.
    folded_fiducials : tuple of str
        The fiducials beside them, most likely culprit first.
    repair : RepairReport
        What was done to the scan first.
    levels : int
        How many times the template was subdivided.
    scheme : str
        The layout that was fitted.
    """

    mesh: TriangleMesh
    normals: FloatArray
    pixels: FloatArray
    filled: BoolArray
    deviation_mm: FloatArray
    fiducial_residual_px: float
    folded_faces: IntArray
    folded_fiducials: tuple[str, ...]
    repair: RepairReport
    levels: int
    scheme: str

    def __post_init__(self) -> None:
        for name, kind in (("normals", "float64"), ("pixels", "float64"), ("filled", "bool")):
            object.__setattr__(self, name, frozen(getattr(self, name), kind))
        object.__setattr__(self, "deviation_mm", frozen(self.deviation_mm, "float64"))
        object.__setattr__(self, "folded_faces", frozen(self.folded_faces, "int64"))


def fit_template(
    scan: RangeImage | RepairedScan,
    fiducials: Positions,
    template: FaceTemplate,
    scheme: str = "closed",
    *,
    levels: int = 2,
    repair: RepairOptions | None = None,
    progress: Progress = silent,
) -> FaceFit:
    """Return the face that ``template`` becomes on ``scan``.

    Parameters
    ----------
    scan : RangeImage or RepairedScan
        A scan, or one that was repaired before (then ``repair`` is not looked at; a refit takes a few milliseconds).
    fiducials : mapping of str to (x, y)
        Pixel positions by name.
    template : FaceTemplate
        The flat face.
    scheme : str
        Its layout, ``closed`` or ``open``.
    levels : int
        1-to-4 subdivisions of the warped template, 0 to 4.
    repair : RepairOptions, optional
        What to repair first.
    progress : callable
        ``progress(fraction, text)``; raising ``Cancelled`` in it stops the fit.

    Raises
    ------
    InputError
        On fiducials that are unknown, too few, outside, at one place or on a line, and when the face lies on
        missing data altogether.

    Notes
    -----
    Yano & Harada 2009, section 3.1. Weighted sampling, the fill over the mesh and the figures are ours.
    """
    if not 0 <= levels <= 4:
        raise InputError("levels", f"is {levels}", "give 0 to 4")
    given = scan.scan if isinstance(scan, RepairedScan) else scan
    check_inside(fiducials, given.width, given.height)
    progress(0.0, "warping the template")
    warp = warp_template(template, scheme, fiducials)
    fine = template.refine(levels)
    pixels = fine.apply(warp.vertices)
    if not isinstance(scan, RepairedScan):
        progress(0.1, "repairing the scan")
        scan = repair_scan(scan, repair)
    progress(0.7, "sampling the scan")
    face = _face_surface(fiducials, scan)
    sampled, _ = sample_bilinear(scan.scan.points, pixels, face, step=SURFACE_STEP_MM)
    measured = valid_share(scan.measured & face, pixels)
    known = ~np.isnan(sampled[:, 2])
    if known.mean() < 0.2:
        raise InputError("fiducials", "most of the face lies where the scan is missing", "check fiducials and scan")
    progress(0.8, "filling what is missing")
    vertices = _completed(sampled, known, pixels, fine.faces, scan)
    # Pixels run downwards, space upwards: turning every face over keeps its outside outside.
    faces = fine.faces[:, [0, 2, 1]]
    uv = (pixels + 0.5) / [given.width, given.height]
    progress(0.9, "measuring the fit")
    filled = measured < 0.5
    return FaceFit(
        mesh=TriangleMesh(vertices, faces, uv),
        normals=vertex_normals(vertices, faces),
        pixels=pixels,
        filled=filled,
        deviation_mm=np.where(filled, np.nan, _deviation(vertices, faces, pixels, scan, face)),
        fiducial_residual_px=warp.residual_px,
        folded_faces=warp.folded,
        folded_fiducials=warp.suspects,
        repair=replace(scan.report, noise_mm=_noise(pixels, scan, face)),
        levels=levels,
        scheme=scheme,
    )


def _face_surface(fiducials: Positions, scan: RepairedScan) -> BoolArray:
    """Return the pixels (H, W) of the surfaces that the fiducials lie on: the outline may overlap the wall behind."""
    x, y = np.rint(np.array(list(fiducials.values()))).astype(np.int64).T
    row, column = np.clip(y, 0, scan.scan.height - 1), np.clip(x, 0, scan.scan.width - 1)
    found, count = np.unique(scan.surfaces[row, column], return_counts=True)
    kept = found[(found > 0) & (count >= LEAST_SHARE * count[found > 0].sum())]
    return np.isin(scan.surfaces, kept) if len(kept) else scan.scan.valid


def _noise(pixels: FloatArray, scan: RepairedScan, face: BoolArray) -> float:
    """Return the standard deviation of the measured depth below the mesh, mm.

    A pixel against the mean of its four neighbours scatters by sqrt(5/4) of the noise; the 68th percentile of the
    amount keeps edges out of it.
    """
    inner = np.array([[1, 1], [scan.scan.width - 2, scan.scan.height - 2]])
    column, row = np.clip(np.rint(pixels), *inner).astype(np.int64).T
    depth = np.where(scan.measured & face, scan.raw[..., 2], np.nan)
    around = depth[row, column + 1] + depth[row, column - 1] + depth[row + 1, column] + depth[row - 1, column]
    step = np.abs(depth[row, column] - around / 4)
    return float(np.nanquantile(step, 0.6827) / np.sqrt(1.25)) if np.isfinite(step).any() else 0.0


def _completed(
    sampled: FloatArray, known: BoolArray, pixels: FloatArray, faces: IntArray, scan: RepairedScan
) -> FloatArray:
    """Return positions (N, 3): unknown depths continued over the mesh, x and y from the pixel's ray."""
    if known.all():
        return sampled
    vertices, reached = harmonic_fill(sampled, known, faces, pixels)
    if not reached.all():
        raise InputError("fiducials", "a part of the face has no measured point", "check fiducials and scan")
    if scan.rays.regular:
        vertices[~known] = scan.rays.points(pixels[~known], -vertices[~known, 2])
    return vertices


def _deviation(
    vertices: FloatArray, faces: IntArray, pixels: FloatArray, scan: RepairedScan, face: BoolArray
) -> FloatArray:
    """Return the distance (N,) in mm between mesh and measured points around every vertex; NaN without any.

    The scan as measured is read at the middle of every triangle; signed distances to the triangle's plane are averaged
    over the triangles around a vertex, so that sensor noise averages out and what the mesh misses stays.
    """
    corner = vertices[faces]
    normal = face_normals(vertices, faces)
    area = np.linalg.norm(normal, axis=1)
    measured, share = sample_bilinear(scan.raw, pixels[faces].mean(axis=1), scan.measured & face, step=SURFACE_STEP_MM)
    usable = (share >= 0.99) & (area > 0)
    offset = measured - corner.mean(axis=1)
    signed = np.where(usable, np.einsum("fk,fk->f", offset, normal) / np.where(area > 0, area, 1.0), 0.0)
    around = incidence(faces, len(vertices))
    count = around @ usable.astype(np.float64)
    total = np.abs(around @ signed)
    return np.where(count > 0, total / np.where(count > 0, count, 1.0), np.nan)
