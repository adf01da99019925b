"""A virtual range scanner: any triangle mesh becomes a scan, and what the scan ought to say is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from engine.errors import InputError
from engine.mesh import BoolArray, FloatArray, IntArray, TriangleMesh
from engine.scan.range_image import Camera, ColourImage, RangeImage
from engine.scan.raster import Raster, cast_rays, rasterise

VISIBLE_WITHIN_MM = 0.05


@dataclass(frozen=True)
class VirtualScan:
    """A scan together with the truth it was made from.

    Attributes
    ----------
    scan : RangeImage
        What the scanner delivers: noisy points, spikes, lost pixels, colour.
    truth_points : (H, W, 3) float
        Noise-free points of every pixel that sees the mesh, lost ones included, mm; NaN elsewhere.
    spikes : (H, W) bool
        Pixels whose depth is a spike.
    lost : (H, W) bool
        Pixels that see the mesh but were not measured.
    face_index : (H, W) int
        Face of the mesh that each pixel sees; -1 where none.
    barycentric : (H, W, 3) float
        Where on that face, as weights of its corners.
    """

    scan: RangeImage
    truth_points: FloatArray
    spikes: BoolArray
    lost: BoolArray
    face_index: IntArray
    barycentric: FloatArray


@dataclass(frozen=True)
class VirtualScanner:
    """A range scanner with a colour camera in one place.

    Attributes
    ----------
    camera : Camera
        Pinhole that sees both range and colour, pixels.
    width, height : int
        Size of the images in pixels.
    noise_mm : float
        Standard deviation of the range noise **along the ray**, mm.
    spike_fraction : float
        Share of the measured pixels that are spikes, 0..1.
    spike_range_mm : (float, float)
        Smallest and largest size of a spike along the ray, mm; its sign is random.
    grazing_limit_deg : float
        Angle between ray and surface normal above which nothing is measured, degrees.
    supersampling : int
        Odd number s; the colour of a pixel is the mean of s x s samples.
    background : (int, int, int)
        sRGB colour where no surface is seen.
    """

    camera: Camera
    width: int = 640
    height: int = 480
    noise_mm: float = 0.15
    spike_fraction: float = 0.003
    spike_range_mm: tuple[float, float] = (4.0, 30.0)
    grazing_limit_deg: float = 80.0
    supersampling: int = 3
    background: tuple[int, int, int] = (0, 0, 0)

    def __post_init__(self) -> None:
        if min(self.width, self.height) < 2:
            size = f"an image of {self.width} x {self.height} pixels"
            raise InputError("virtual scanner", size, "give at least 2 x 2")
        if self.supersampling < 1 or self.supersampling % 2 == 0:
            raise InputError("supersampling", f"is {self.supersampling}", "give an odd number: 1, 3, 5")
        if not 0.0 <= self.spike_fraction < 1.0:
            raise InputError("spike fraction", f"is {self.spike_fraction}", "give a share from 0 to below 1")
        if self.noise_mm < 0 or not 0 <= self.spike_range_mm[0] <= self.spike_range_mm[1]:
            raise InputError("virtual scanner", "a negative noise or spike size", "give sizes in mm, smallest first")

    def scan(
        self,
        mesh: TriangleMesh,
        *,
        colours: ArrayLike | None = None,
        texture: ColourImage | None = None,
        lost: ArrayLike | None = None,
        lost_texture: ArrayLike | None = None,
        seed: int = 0,
    ) -> VirtualScan:
        """Scan a mesh that stands in the camera's frame.

        Parameters
        ----------
        mesh : TriangleMesh
            Positions in mm, camera at the origin looking along -Z (``frontal_camera`` places it).
        colours : (N, 3) array, optional
            sRGB colour per vertex, 0..255. Together with a texture it is a factor, 255 meaning 1.
        texture : (h, w, 3) uint8, optional
            sRGB picture that ``mesh.uv`` points into. Without colours and texture the mesh is light grey.
        lost : (N,) or (F,) array, optional
            Per vertex or face, how surely nothing is measured there; a pixel above 0.5 is lost.
        lost_texture : (h, w) array, optional
            The same as a picture that ``mesh.uv`` points into, read at the nearest texel.
        seed : int
            The same seed gives the same scan.

        Raises
        ------
        InputError
            On a texture without uv, arrays of another size, a mesh behind the camera, or one that no pixel sees.
        """
        fine = rasterise(mesh, self.camera, self.width, self.height, self.supersampling)
        middle = slice(self.supersampling // 2, None, self.supersampling)
        seen = Raster(fine.face_index[middle, middle], fine.barycentric[middle, middle], fine.points[middle, middle])
        hit = seen.face_index >= 0
        if not hit.any():
            raise InputError("mesh", "is not seen by any pixel", "use frontal_camera to place it")
        unseen = _lost_pixels(mesh, seen, lost) | _lost_texels(mesh, seen, lost_texture)
        gone = hit & (unseen | self._grazing(mesh, seen))
        measured = hit & ~gone
        rng = np.random.default_rng(seed)
        error = self.noise_mm * rng.standard_normal(hit.shape)
        spikes = measured & (rng.random(hit.shape) < self.spike_fraction)
        size = rng.uniform(*self.spike_range_mm, hit.shape) * rng.choice([-1.0, 1.0], hit.shape)
        error = error + np.where(spikes, size, 0.0)
        distance = np.linalg.norm(seen.points, axis=2, keepdims=True)
        points = np.where(measured[..., None], seen.points * (1 + error[..., None] / distance), np.nan)
        picture = self._picture(mesh, fine, colours, texture)
        return VirtualScan(
            RangeImage(points, picture, self.camera), seen.points, spikes, gone, seen.face_index, seen.barycentric
        )

    def _grazing(self, mesh: TriangleMesh, seen: Raster) -> BoolArray:
        corners = mesh.vertices[mesh.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        distance = np.linalg.norm(seen.points, axis=2)
        cosine = np.abs(np.einsum("hwi,hwi->hw", normals[seen.face_index], seen.points)) / distance
        grazing: BoolArray = (seen.face_index >= 0) & (cosine < np.cos(np.deg2rad(self.grazing_limit_deg)))
        return grazing

    def _picture(
        self, mesh: TriangleMesh, fine: Raster, colours: ArrayLike | None, texture: ColourImage | None
    ) -> ColourImage:
        shade = np.full((len(mesh.vertices), 3), 255.0 if texture is not None else 200.0)
        if colours is not None:
            shade = np.asarray(colours, dtype=np.float64)
            if shade.shape != (len(mesh.vertices), 3):
                raise InputError("colours", f"have shape {shade.shape}", f"give {len(mesh.vertices)} rows of 3")
        samples = fine.interpolate(mesh.faces, shade)
        hit = fine.face_index >= 0
        if texture is not None:
            samples[hit] *= _bilinear(texture, _texture_coordinates(mesh, fine)) / 255.0
        samples[~hit] = self.background
        s = self.supersampling
        mean = samples.reshape(self.height, s, self.width, s, 3).mean(axis=(1, 3))
        picture: ColourImage = np.clip(np.rint(mean), 0, 255).astype(np.uint8)
        return picture


def frontal_camera(
    mesh: TriangleMesh | ArrayLike, width: int = 640, height: int = 480, distance_mm: float = 650.0, fill: float = 0.9
) -> tuple[Camera, FloatArray]:
    """Return a camera that a mesh fills, and the translation (3,) in mm that puts the mesh before it.

    The middle of the mesh's bounding box comes to lie at ``distance_mm`` on the optical axis; its height takes up
    ``fill`` of the picture's, or its width where that is the tighter one.

    Parameters
    ----------
    mesh : TriangleMesh or (2, 3) array
        The mesh, +Z towards the camera, or its lowest and highest corner, mm.

    Raises
    ------
    InputError
        Where the mesh is so deep that it reaches the camera.
    """
    if isinstance(mesh, TriangleMesh):
        bounds = np.stack([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])
    else:
        bounds = np.asarray(mesh, dtype=np.float64).reshape(2, 3)
    middle, size = bounds.mean(axis=0), bounds[1] - bounds[0]
    front = distance_mm - size[2] / 2
    if front <= 0:
        raise InputError("distance", f"{distance_mm} mm is inside the mesh", f"give more than {size[2] / 2:.0f} mm")
    focal = fill * distance_mm * float(np.min(np.array([width, height]) / np.maximum(size[:2], 1e-9)))
    camera = Camera(focal, focal, (width - 1) / 2, (height - 1) / 2)
    return camera, np.array([0.0, 0.0, -distance_mm]) - middle


def visible_points(
    mesh: TriangleMesh, camera: Camera, points: ArrayLike, tolerance_mm: float = VISIBLE_WITHIN_MM
) -> tuple[FloatArray, BoolArray]:
    """Return the exact pixels (k, 2) of points (k, 3) on a mesh, and whether nothing hides them (k,).

    A point counts as visible when the ray through it first meets the mesh within ``tolerance_mm`` of it.
    """
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    pixels = camera.project(points)
    hits = cast_rays(mesh, camera, pixels)
    distance = np.linalg.norm(hits.points - points, axis=1)
    return pixels, np.nan_to_num(distance, nan=np.inf) <= tolerance_mm


def _lost_pixels(mesh: TriangleMesh, seen: Raster, lost: ArrayLike | None) -> BoolArray:
    if lost is None:
        return np.zeros(seen.face_index.shape, dtype=bool)
    amount = np.asarray(lost, dtype=np.float64)
    if amount.shape == (len(mesh.vertices),):
        return seen.interpolate(mesh.faces, amount[:, None])[..., 0] > 0.5
    if amount.shape == (len(mesh.faces),):
        return (seen.face_index >= 0) & (amount[seen.face_index] > 0.5)
    wanted = f"give {len(mesh.vertices)} values, one per vertex, or {len(mesh.faces)}, one per face"
    raise InputError("lost", f"has shape {amount.shape}", wanted)


def _lost_texels(mesh: TriangleMesh, seen: Raster, lost: ArrayLike | None) -> BoolArray:
    gone = np.zeros(seen.face_index.shape, dtype=bool)
    if lost is not None:
        amount = np.asarray(lost, dtype=np.float64)
        size = np.array(amount.shape[::-1])
        texel = np.clip((_texture_coordinates(mesh, seen) * size).astype(np.int64), 0, size - 1)
        gone[seen.face_index >= 0] = amount[texel[:, 1], texel[:, 0]] > 0.5
    return gone


def _texture_coordinates(mesh: TriangleMesh, seen: Raster) -> FloatArray:
    if mesh.uv is None or mesh.uv_faces is None:
        raise InputError("texture", "the mesh has no texture coordinates", "give uv, or values per vertex")
    return seen.interpolate(mesh.uv_faces, mesh.uv)[seen.face_index >= 0]


def _bilinear(image: ColourImage, uv: FloatArray) -> FloatArray:
    """Colours (k, 3) of an image at uv (k, 2), origin top left, clamped to its border."""
    height, width = image.shape[:2]
    x = np.clip(uv[:, 0] * width - 0.5, 0, width - 1)
    y = np.clip(uv[:, 1] * height - 0.5, 0, height - 1)
    left, top = np.minimum(x.astype(np.int64), width - 2), np.minimum(y.astype(np.int64), height - 2)
    x, y = (x - left)[:, None], (y - top)[:, None]
    upper = image[top, left] * (1 - x) + image[top, left + 1] * x
    lower = image[top + 1, left] * (1 - x) + image[top + 1, left + 1] * x
    result: FloatArray = upper * (1 - y) + lower * y
    return result
