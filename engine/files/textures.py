"""Pictures that a mesh is covered with: read at a size that is useful, several of them packed into one."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from engine.errors import InputError
from engine.files.image_header import ImageHeader, image_header
from engine.files.images import MAX_IMAGE_BYTES
from engine.files.source import MAX_PIXELS, read_bytes
from engine.mesh import BoolArray, FloatArray, IntArray
from engine.scan.range_image import ColourImage

MAX_TEXTURE_PIXELS = 1 << 28
"""Most pixels of a JPEG texture (16,384 x 16,384), which is decoded at a reduced size."""

MAX_WHOLE_PIXELS = 1 << 26
"""Most pixels of a texture of another format, which has to be decoded whole (8,192 x 8,192)."""

MAX_SIDE = 16_384
_PATCH, _MARGIN = 16, 8
_WHITE = (255.0, 255.0, 255.0)


@dataclass(frozen=True)
class Material:
    """What some faces of a mesh are covered with: a picture, and an sRGB colour 0..255 that tints it (white: none)."""

    texture: ColourImage | None = None
    colour: tuple[float, float, float] = _WHITE


class PictureBudget:
    """Reads the pictures of one mesh, each once, as long as there is room and time for another.

    Their pixels count before they are decoded: those of a JPEG, which can be decoded at a reduced size, as what comes
    out of it or a quarter of them, whichever is more.
    """

    def __init__(self, pixels: int = MAX_WHOLE_PIXELS, length: int = 2 * MAX_IMAGE_BYTES) -> None:
        self._pixels, self._bytes = pixels, length
        self._read: dict[Path, ColourImage | InputError] = {}
        self._decoded: dict[bytes, ColourImage | InputError] = {}

    def read(self, path: Path) -> ColourImage:
        """Return a picture file (h, w, 3) as ``decode``."""
        key = path.resolve()
        if key not in self._read:
            try:
                if path.stat().st_size > self._bytes:
                    raise self._spent(str(path))
                self._read[key] = self.decode(read_bytes(path, MAX_IMAGE_BYTES), str(path))
            except InputError as error:
                self._read[key] = error
        return _picture_or_error(self._read[key])

    def decode(self, data: bytes | memoryview, subject: str) -> ColourImage:
        """Return a PNG, JPEG or TIFF picture (h, w, 3) uint8 RGB of at most ``MAX_PIXELS`` pixels.

        A larger one is halved, quartered or divided by eight while it is decoded.

        Raises
        ------
        InputError
            Naming ``subject``, on other formats, damage, a picture beyond ``MAX_TEXTURE_PIXELS``, or one for which
            the pictures before it have left no room.
        """
        if len(data) > self._bytes:
            raise self._spent(subject)
        self._bytes -= len(data)
        key = hashlib.blake2b(data).digest()
        if key not in self._decoded:
            try:
                self._decoded[key] = self._new(bytes(data), subject)
            except InputError as error:
                self._decoded[key] = error
        return _picture_or_error(self._decoded[key])

    def _new(self, data: bytes, subject: str) -> ColourImage:
        reducible = data.startswith(b"\xff\xd8\xff")
        if self._pixels <= 0:
            raise self._spent(subject)
        # What is too large for the budget is refused by its header's first lines, before anything is unpacked.
        largest = min(MAX_TEXTURE_PIXELS, 4 * self._pixels) if reducible else min(MAX_WHOLE_PIXELS, self._pixels)
        header = image_header(data, subject, largest)
        pixels = header.width * header.height
        share = next(k for k in _REDUCED if pixels <= MAX_PIXELS * k * k or k == 8)
        cost = max(pixels // 4, pixels // share**2) if reducible else pixels
        if cost > self._pixels:
            raise self._spent(subject)
        self._pixels -= cost
        return _decoded(data, header, share, subject)

    def _spent(self, subject: str) -> InputError:
        problem = "there is no room for it: the pictures of the mesh are too large together"
        return InputError(subject, problem, "scale them down")


_REDUCED = {
    1: cv2.IMREAD_COLOR, 2: cv2.IMREAD_REDUCED_COLOR_2, 4: cv2.IMREAD_REDUCED_COLOR_4, 8: cv2.IMREAD_REDUCED_COLOR_8
}  # fmt: skip


def _picture_or_error(found: ColourImage | InputError) -> ColourImage:
    if isinstance(found, InputError):
        raise found
    return found


def _decoded(data: bytes, header: ImageHeader, share: int, subject: str) -> ColourImage:
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), _REDUCED[share] | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error:
        image = None
    finally:
        cv2.utils.logging.setLogLevel(level)
    if image is None or abs(image.shape[0] * share - header.height) >= 2 * share:
        raise InputError(subject, f"is damaged or an unusual kind of {header.kind}", "export it again")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)


@dataclass(frozen=True)
class Covering:
    """One picture for a whole mesh, and where each corner of each face lies in it; ``spilled`` as ``cover`` says."""

    texture: ColourImage | None
    uv: FloatArray | None
    uv_faces: IntArray | None
    spilled: int = 0


def cover(
    materials: Sequence[Material], face_material: IntArray, uv: FloatArray | None, uv_faces: IntArray | None
) -> Covering:
    """Return the one picture that covers a mesh of several materials.

    One material, or several that look alike, keep their picture and coordinates as they are. Others are packed side by
    side, each with a margin; coordinates that repeat a picture are moved into its first copy, and ``Covering.spilled``
    counts the faces that reach across its edge and are held at it. Materials without a picture become patches of their
    colour.

    Parameters
    ----------
    materials : sequence of Material
        What the faces name.
    face_material : (F,) int
        Which one covers a face; -1 for none.
    uv : (U, 2) float, optional
        Texture coordinates, origin at the top left.
    uv_faces : (F, 3) int, optional
        Indices into ``uv``; -1 where a corner has none.
    """
    used = np.unique(face_material)
    materials = [materials[k] if k >= 0 else Material() for k in used]
    index = np.searchsorted(used, face_material)
    if all(m.texture is None and m.colour == _WHITE for m in materials):
        return Covering(None, None, None)
    placed = uv is not None and uv_faces is not None and bool((uv_faces >= 0).all())
    alike = len({(id(material.texture), material.colour) for material in materials}) == 1
    if alike and materials[0].texture is not None and materials[0].colour == _WHITE and placed:
        return Covering(materials[0].texture, uv, uv_faces)
    corners = np.full((len(face_material), 3, 2), 0.5)
    known: BoolArray = np.zeros(len(face_material), dtype=bool)
    if uv is not None and uv_faces is not None and len(uv):
        known = np.asarray((uv_faces >= 0).all(axis=1), dtype=bool)
        corners[known] = uv[uv_faces[known]]
    corners -= np.floor(corners.min(axis=1, keepdims=True))
    pictured = np.array([m.texture is not None for m in materials])[index] & known
    spilled = int((corners[pictured].max(axis=(1, 2)) > 1 + 1e-6).sum())
    corners = np.clip(corners, 0.0, 1.0)
    # Materials that look the same share a place in the picture.
    looks = list(dict.fromkeys((id(m.texture), m.colour) for m in materials))
    pieces = [next(m for m in materials if (id(m.texture), m.colour) == look) for look in looks]
    index = np.array([looks.index((id(m.texture), m.colour)) for m in materials])[index]
    if not known.all():
        # A face without coordinates under a picture takes that picture's mean colour, from a patch of its own.
        for k in np.unique(index[~known]):
            index[~known & (index == k)] = len(pieces)
            pieces.append(Material(None, _mean(pieces[k])))
    picture, boxes = _packed(pieces)
    low, size = boxes[index, :2], boxes[index, 2:]
    corners = low[:, None] + corners * size[:, None]
    return Covering(picture, corners.reshape(-1, 2), np.arange(3 * len(index)).reshape(-1, 3), spilled)


def _mean(material: Material) -> tuple[float, float, float]:
    if material.texture is None:
        return material.colour
    red, green, blue, _ = cv2.mean(material.texture)
    tint = material.colour
    return red * tint[0] / 255, green * tint[1] / 255, blue * tint[2] / 255


def _piece(material: Material, width: int, height: int, reduced: dict[int, ColourImage]) -> ColourImage:
    """Return a material (height, width, 3): its picture, reduced and tinted, or its colour; keep the reduced ones."""
    colour = np.clip(material.colour, 0, 255)
    if material.texture is None:
        return np.broadcast_to(np.rint(colour).astype(np.uint8), (height, width, 3)).copy()
    image = reduced.get(id(material.texture), material.texture)
    while image.shape[:2] != (height, width):
        image = _halved(image)
    reduced[id(material.texture)] = image
    if material.colour == _WHITE:
        return image
    table = np.rint(np.arange(256)[:, None] * (colour / 255)).astype(np.uint8)
    return np.stack([table[:, k][image[..., k]] for k in range(3)], axis=2)


def _packed(materials: list[Material]) -> tuple[ColourImage, FloatArray]:
    """Return the materials on shelves in one picture, and where each lies in it: left, top, width, height as shares.

    The room is found by their sizes alone; then one after the other is made, so that no two are there at once.
    """
    sizes = [(_PATCH, _PATCH) if m.texture is None else (m.texture.shape[1], m.texture.shape[0]) for m in materials]
    while True:
        places, width, height = _shelves(sizes)
        if width * height <= MAX_PIXELS and max(width, height) <= MAX_SIDE:
            break
        sizes = [(max(1, w // 2), max(1, h // 2)) if w * h > _PATCH * _PATCH else (w, h) for w, h in sizes]
    picture = np.zeros((height, width, 3), dtype=np.uint8)
    boxes = np.empty((len(materials), 4))
    reduced: dict[int, ColourImage] = {}
    for k, (material, (left, top), (columns, rows)) in enumerate(zip(materials, places, sizes, strict=True)):
        piece = _piece(material, columns, rows, reduced)
        framed = cv2.copyMakeBorder(piece, _MARGIN, _MARGIN, _MARGIN, _MARGIN, cv2.BORDER_REPLICATE)
        picture[top : top + rows + 2 * _MARGIN, left : left + columns + 2 * _MARGIN] = framed
        boxes[k] = (left + _MARGIN) / width, (top + _MARGIN) / height, columns / width, rows / height
    return picture, boxes


def _shelves(inner: list[tuple[int, int]]) -> tuple[list[tuple[int, int]], int, int]:
    sizes = [(width + 2 * _MARGIN, height + 2 * _MARGIN) for width, height in inner]
    limit = max(max(w for w, _ in sizes), int(np.sqrt(sum(w * h for w, h in sizes)) * 1.1))
    places: list[tuple[int, int]] = [(0, 0)] * len(sizes)
    x = y = shelf = width = 0
    for k in sorted(range(len(sizes)), key=lambda k: -sizes[k][1]):
        w, h = sizes[k]
        if x + w > limit:
            x, y, shelf = 0, y + shelf, 0
        places[k] = (x, y)
        x, shelf, width = x + w, max(shelf, h), max(width, x + w)
    return places, width, y + shelf


def _halved(image: ColourImage) -> ColourImage:
    size = max(1, image.shape[1] // 2), max(1, image.shape[0] // 2)
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
