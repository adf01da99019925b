"""A virtual camera before a mesh: what it sees is a range image like any other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from engine.errors import InputError
from engine.mesh import FloatArray, IntArray, TriangleMesh
from engine.progress import Progress, part, silent
from engine.scan.orient import SURE, Orientation, orient
from engine.scan.range_image import Camera, ColourImage, RangeImage
from engine.scan.raster import NEAREST_MM, Raster, rasterise

MAX_SIDE_PX = 4000
NEAREST_DISTANCE_MM, FARTHEST_DISTANCE_MM = 10.0, 100_000.0
SMALLEST_FIELD_DEG, LARGEST_FIELD_DEG = 1.0, 120.0
GRAZING_DEG = 82.0
"""Angle between ray and surface normal, degrees, above which nothing is taken."""

DISTANCE_MM = 700.0
WIDTH, HEIGHT = 600, 800
_GREY = 200.0


class TexturedMesh(Protocol):
    """What is looked at: ``engine.files.mesh_file.MeshFile``, or anything with a mesh, a texture and colours."""

    @property
    def mesh(self) -> TriangleMesh:
        """The triangles, mm."""

    @property
    def texture(self) -> ColourImage | None:
        """A picture (h, w, 3) that ``mesh.uv`` points into."""

    @property
    def colours(self) -> NDArray[np.uint8] | None:
        """Colours (N, 3) of the vertices."""


@dataclass(frozen=True)
class MeshView:
    """A pinhole camera before a mesh.

    Attributes
    ----------
    rotation : (float, float, float)
        Rotation vector in radians that turns the mesh, so that it looks along +Z with +Y up.
    look_at_mm : (float, float, float)
        Point of the mesh in the middle of the picture, in its own frame.
    distance_mm : float
        From there to the camera.
    field_of_view_deg : float
        From the lower to the upper edge of the picture.
    width, height : int
        Size of the picture in pixels.

    Raises
    ------
    InputError
        On values that no camera has.
    """

    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    look_at_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    distance_mm: float = DISTANCE_MM
    field_of_view_deg: float = 20.0
    width: int = WIDTH
    height: int = HEIGHT

    def __post_init__(self) -> None:
        for name in ("rotation", "look_at_mm"):
            values = tuple(float(value) for value in getattr(self, name))
            if len(values) != 3 or not np.isfinite(values).all() or max(map(abs, values)) > 1e7:
                raise InputError(name.replace("_", " "), f"is {values}", "give three numbers")
            object.__setattr__(self, name, values)
        limits = (
            ("distance_mm", "distance", NEAREST_DISTANCE_MM, FARTHEST_DISTANCE_MM),
            ("field_of_view_deg", "field of view", SMALLEST_FIELD_DEG, LARGEST_FIELD_DEG),
            ("width", "width", 16, MAX_SIDE_PX),
            ("height", "height", 16, MAX_SIDE_PX),
        )
        for name, word, low, high in limits:
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(word, f"is {value:g}", f"give {low:g} to {high:g}")
        object.__setattr__(self, "distance_mm", float(self.distance_mm))
        object.__setattr__(self, "field_of_view_deg", float(self.field_of_view_deg))
        object.__setattr__(self, "width", int(self.width))
        object.__setattr__(self, "height", int(self.height))

    @property
    def matrix(self) -> FloatArray:
        """The rotation (3, 3) from the mesh's frame to the camera's."""
        return np.asarray(Rotation.from_rotvec(self.rotation).as_matrix(), dtype=np.float64)

    @property
    def camera(self) -> Camera:
        """Intrinsics in pixels."""
        focal = (self.height / 2) / np.tan(np.deg2rad(self.field_of_view_deg) / 2)
        return Camera(float(focal), float(focal), (self.width - 1) / 2, (self.height - 1) / 2)

    @property
    def angles_deg(self) -> tuple[float, float, float]:
        """Turn, tilt and roll of the mesh in degrees, as ``turned`` takes them."""
        m = self.matrix
        tilt = float(np.arcsin(np.clip(-m[1, 2], -1.0, 1.0)))
        if abs(m[1, 2]) > 1 - 1e-12:  # turn and roll are about one axis: all of it counts as turn
            turn, roll = float(np.arctan2(-m[2, 0], m[0, 0])), 0.0
        else:
            turn, roll = float(np.arctan2(m[0, 2], m[2, 2])), float(np.arctan2(m[1, 0], m[1, 1]))
        return float(np.rad2deg(turn)), float(np.rad2deg(tilt)), float(np.rad2deg(roll))

    def turned(self, turn_deg: float, tilt_deg: float, roll_deg: float) -> MeshView:
        """Return the view with the mesh turned by three angles.

        First it rolls about Z, then tilts about X (+ towards the viewer's feet), then turns about Y (+ to the right).
        """
        rotation = Rotation.from_euler("YXZ", [turn_deg, tilt_deg, roll_deg], degrees=True)
        x, y, z = rotation.as_rotvec().tolist()
        return replace(self, rotation=(x, y, z))

    def rotated(self, rotation: FloatArray) -> MeshView:
        """Return the view with a further rotation (3, 3), in the camera's frame, applied to the mesh."""
        x, y, z = Rotation.from_matrix(rotation @ self.matrix).as_rotvec().tolist()
        return replace(self, rotation=(x, y, z))

    def scaled(self, factor: float) -> MeshView:
        """Return the view that sees the same picture of the mesh ``factor`` times as large."""
        x, y, z = (value * factor for value in self.look_at_mm)
        return replace(self, look_at_mm=(x, y, z), distance_mm=self.distance_mm * factor)

    def into_camera(self, points: ArrayLike, mm_per_unit: float = 1.0) -> FloatArray:
        """Return points (k, 3) of the mesh's frame in the camera's, mm.

        ``mm_per_unit`` scales them first: 1 for mm, ``MeshFile.mm_per_unit`` for numbers as the file has them.
        """
        offset = np.array([0.0, 0.0, self.distance_mm])
        placed = np.asarray(points, dtype=np.float64).reshape(-1, 3) * mm_per_unit - self.look_at_mm
        result: FloatArray = placed @ self.matrix.T - offset
        return result

    def into_mesh(self, points: ArrayLike) -> FloatArray:
        """Return points (k, 3) of the camera's frame, such as the scan's, in the mesh's, mm."""
        offset = np.array([0.0, 0.0, self.distance_mm])
        moved = np.asarray(points, dtype=np.float64).reshape(-1, 3) + offset
        result: FloatArray = moved @ self.matrix + self.look_at_mm
        return result

    def project(self, points: ArrayLike, mm_per_unit: float = 1.0) -> FloatArray:
        """Return the pixels (k, 2) of points (k, 3) of the mesh's frame; NaN behind the camera."""
        seen = self.into_camera(points, mm_per_unit)
        seen[seen[:, 2] > -NEAREST_MM] = np.nan
        return self.camera.project(seen)


@dataclass(frozen=True)
class Placement:
    """A view, how it was found, and how surely (0..1; below ``orient.SURE`` the user should look)."""

    view: MeshView
    confidence: float
    reason: str


def propose_view(mesh: TriangleMesh, width: int = WIDTH, height: int = HEIGHT, seed: int = 0) -> Placement:
    """Return a view that the face fills; where no face is found, the file's own axes and the whole mesh.

    Raises
    ------
    InputError
        For a mesh without area.
    """
    found = orient(mesh, seed)
    if found.confidence < SURE:
        view = whole_view(mesh, width, height)
        return Placement(view, found.confidence, "no face was found in the mesh: its own axes are kept")
    return Placement(face_view(found, width, height), found.confidence, "placed by its symmetry and its nose")


def face_view(found: Orientation, width: int = WIDTH, height: int = HEIGHT) -> MeshView:
    """Return the view of a face from the front, ears and chin inside the picture."""
    tall = 1.35 * found.face_height_mm * max(1.0, 0.75 * height / width)
    return _view(found.rotation, found.face_centre, tall, DISTANCE_MM * found.face_height_mm / 160, width, height)


def whole_view(
    mesh: TriangleMesh, width: int = WIDTH, height: int = HEIGHT, rotation: FloatArray | None = None
) -> MeshView:
    """Return the view of a whole mesh with ``rotation`` (3, 3), or as it stands in its file."""
    rotation = np.eye(3) if rotation is None else rotation
    turned = mesh.vertices[np.unique(mesh.faces)] @ rotation.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    size = np.maximum(high - low, 1e-3)
    tall = 1.1 * max(size[1], size[0] * height / width)
    distance = max(3.0 * tall, float(size[2]) + 2 * tall)
    return _view(rotation, rotation.T @ ((low + high) / 2), tall, distance, width, height)


def _view(rotation: FloatArray, centre: FloatArray, tall: float, distance: float, width: int, height: int) -> MeshView:
    x, y, z = Rotation.from_matrix(rotation).as_rotvec().tolist()
    cx, cy, cz = centre.tolist()
    distance = float(np.clip(distance, NEAREST_DISTANCE_MM, FARTHEST_DISTANCE_MM))
    field = float(np.clip(np.rad2deg(2 * np.arctan(tall / 2 / distance)), SMALLEST_FIELD_DEG, LARGEST_FIELD_DEG))
    return MeshView((x, y, z), (cx, cy, cz), round(distance, 1), round(field, 2), width, height)


def view_mesh(thing: TexturedMesh, view: MeshView, progress: Progress = silent) -> RangeImage:
    """Return what a view sees of a mesh: points without noise, and colour where the mesh has any.

    Faces behind the camera are passed over; pixels whose surface is seen at more than `GRAZING_DEG` are missing, and
    so is what no ray meets. A texture is first reduced to about one texel a pixel, so that nothing flickers.

    Raises
    ------
    InputError
        When no pixel sees the mesh.
    """
    progress(0.0, "placing the camera")
    mesh = thing.mesh
    vertices = view.into_camera(mesh.vertices)
    ahead = (vertices[mesh.faces, 2] <= -NEAREST_MM).all(axis=1)
    corners = mesh.uv_faces
    faces = mesh.faces
    if not ahead.all():
        faces = faces[ahead]
        corners = None if corners is None else corners[ahead]
    if not len(faces):
        raise InputError("view", "the mesh is behind the camera", "place it further away")
    placed = TriangleMesh(vertices, faces)
    seen = rasterise(placed, view.camera, view.width, view.height, progress=part(progress, 0.1, 0.7))
    hit = seen.face_index >= 0
    if not hit.any():
        raise InputError("view", "no pixel sees the mesh", "turn it, or place it automatically")
    progress(0.7, "taking its colour")
    picture = _picture(thing, seen, faces, corners)
    points = np.where(_grazing(placed, seen)[..., None], np.nan, seen.points)
    if np.isnan(points).all():
        raise InputError("view", "sees the mesh only at a grazing angle", "turn it")
    for array in (points, picture):
        if array is not None:
            array.flags.writeable = False
    progress(1.0, "seen")
    return RangeImage(points, picture, view.camera)


def _grazing(mesh: TriangleMesh, seen: Raster) -> NDArray[np.bool_]:
    hit = seen.face_index >= 0
    faces, which = np.unique(seen.face_index[hit], return_inverse=True)
    corners = mesh.vertices[mesh.faces[faces]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    points = seen.points[hit]
    cosine = np.abs(np.einsum("ki,ki->k", normals[which], points)) / np.linalg.norm(points, axis=1)
    result = np.zeros(hit.shape, dtype=bool)
    result[hit] = cosine < np.cos(np.deg2rad(GRAZING_DEG))
    return result


def _picture(thing: TexturedMesh, seen: Raster, faces: IntArray, corners: IntArray | None) -> ColourImage | None:
    texture, uv = thing.texture, thing.mesh.uv
    textured = texture is not None and uv is not None and corners is not None
    if thing.colours is None and not textured:
        return None
    hit = seen.face_index >= 0
    shade = np.full((int(hit.sum()), 3), 255.0)
    if thing.colours is not None:
        shade = seen.interpolate(faces, thing.colours.astype(np.float64))[hit]
    if texture is not None and uv is not None and corners is not None:
        where = seen.interpolate(corners, uv)
        shade = shade * _sampled(texture, where, hit, _is_tiled(uv)) / 255.0
    picture: ColourImage = np.zeros((*hit.shape, 3), dtype=np.uint8)
    picture[hit] = np.clip(np.rint(shade), 0, 255)
    return picture


def _is_tiled(uv: FloatArray) -> bool:
    return bool(len(uv)) and bool(uv.min() < -1e-3 or uv.max() > 1 + 1e-3)


def _sampled(texture: ColourImage, where: FloatArray, hit: NDArray[np.bool_], tiled: bool) -> FloatArray:
    """Return colours (k, 3) at the texture coordinates (H, W, 2) of the pixels that are hit."""
    image = _reduced(texture, _texels_per_pixel(texture, where, hit))
    height, width = image.shape[:2]
    x, y = where[hit, 0] * width - 0.5, where[hit, 1] * height - 0.5
    if not tiled:
        x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    left, top = np.floor(x), np.floor(y)
    right_share, lower_share = (x - left)[:, None], (y - top)[:, None]
    columns = [(left.astype(np.int64) + k) for k in (0, 1)]
    rows = [(top.astype(np.int64) + k) for k in (0, 1)]
    columns = [c % width if tiled else np.minimum(c, width - 1) for c in columns]
    rows = [r % height if tiled else np.minimum(r, height - 1) for r in rows]
    upper = image[rows[0], columns[0]] * (1 - right_share) + image[rows[0], columns[1]] * right_share
    lower = image[rows[1], columns[0]] * (1 - right_share) + image[rows[1], columns[1]] * right_share
    result: FloatArray = upper * (1 - lower_share) + lower * lower_share
    return result


def _texels_per_pixel(texture: ColourImage, where: FloatArray, hit: NDArray[np.bool_]) -> float:
    """Return how many texels lie along a pixel's side, in the median of all neighbours that are both hit."""
    size = np.array([texture.shape[1], texture.shape[0]])
    both = hit[:, 1:] & hit[:, :-1]
    if not both.any():
        return 1.0
    step = np.linalg.norm((where[:, 1:] - where[:, :-1])[both] * size, axis=1)
    return float(np.median(step))


def _reduced(texture: ColourImage, texels: float) -> ColourImage:
    """Return the texture averaged over squares of as many texels as lie in a pixel, at most 8 x 8."""
    import cv2

    factor = min(int(texels + 0.3), 8, texture.shape[0] // 8, texture.shape[1] // 8)
    if factor < 2:
        return texture
    size = texture.shape[1] // factor, texture.shape[0] // factor
    return np.asarray(cv2.resize(texture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
