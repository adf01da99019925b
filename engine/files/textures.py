"""Pictures that a mesh is covered with: read at a size that is useful, several of them packed into one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from engine.errors import InputError
from engine.files.image_header import image_header
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


def read_texture(path: Path) -> ColourImage:
    """Return a picture file (h, w, 3) as ``decode_texture``."""
    return decode_texture(read_bytes(path, MAX_IMAGE_BYTES), str(path))


def decode_texture(data: bytes, subject: str) -> ColourImage:
    """Return a PNG, JPEG or TIFF picture (h, w, 3) uint8 RGB of at most ``MAX_PIXELS`` pixels.

    A larger one is halved, quartered or divided by eight while it is decoded.

    Raises
    ------
    InputError
        Naming ``subject``, on other formats, damage, or a picture beyond ``MAX_TEXTURE_PIXELS``.
    """
    largest = MAX_TEXTURE_PIXELS if data.startswith(b"\xff\xd8\xff") else MAX_WHOLE_PIXELS
    header = image_header(data, subject, largest)
    flags = {
        1: cv2.IMREAD_COLOR, 2: cv2.IMREAD_REDUCED_COLOR_2, 4: cv2.IMREAD_REDUCED_COLOR_4, 8: cv2.IMREAD_REDUCED_COLOR_8
    }  # fmt: skip
    share = next(k for k in flags if header.width * header.height <= MAX_PIXELS * k * k or k == 8)
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flags[share] | cv2.IMREAD_IGNORE_ORIENTATION)
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

    One material keeps its picture and coordinates as they are. Several are packed side by side, each with a margin;
    coordinates that repeat a picture are moved into its first copy, and ``Covering.spilled`` counts the faces that
    reach across its edge and are held at it. Materials without a picture become patches of their colour.

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
    if len(materials) == 1 and materials[0].texture is not None and materials[0].colour == _WHITE and placed:
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
    images = [_tinted(m) for m in materials]
    if not known.all():
        # A face without coordinates under a picture takes that picture's mean colour, from a patch of its own.
        for k in np.unique(index[~known]):
            index[~known & (index == k)] = len(images)
            images.append(_patch(images[k].reshape(-1, 3).mean(axis=0)))
    picture, boxes = _packed(images)
    low, size = boxes[index, :2], boxes[index, 2:]
    corners = low[:, None] + corners * size[:, None]
    return Covering(picture, corners.reshape(-1, 2), np.arange(3 * len(index)).reshape(-1, 3), spilled)


def _patch(colour: Sequence[float] | FloatArray) -> ColourImage:
    return np.broadcast_to(np.clip(np.rint(colour), 0, 255).astype(np.uint8), (_PATCH, _PATCH, 3)).copy()


def _tinted(material: Material) -> ColourImage:
    if material.texture is None:
        return _patch(material.colour)
    if material.colour == _WHITE:
        return material.texture
    return np.rint(material.texture * (np.clip(material.colour, 0, 255) / 255)).astype(np.uint8)


def _packed(images: list[ColourImage]) -> tuple[ColourImage, FloatArray]:
    """Return the pictures on shelves in one, and where each lies in it: left, top, width, height as shares."""
    while True:
        places, width, height = _shelves(images)
        if width * height <= MAX_PIXELS and max(width, height) <= MAX_SIDE:
            break
        images = [_halved(image) if image.shape[0] * image.shape[1] > _PATCH * _PATCH else image for image in images]
    picture = np.zeros((height, width, 3), dtype=np.uint8)
    boxes = np.empty((len(images), 4))
    for k, (image, (left, top)) in enumerate(zip(images, places, strict=True)):
        rows, columns = image.shape[:2]
        framed = cv2.copyMakeBorder(image, _MARGIN, _MARGIN, _MARGIN, _MARGIN, cv2.BORDER_REPLICATE)
        picture[top : top + rows + 2 * _MARGIN, left : left + columns + 2 * _MARGIN] = framed
        boxes[k] = (left + _MARGIN) / width, (top + _MARGIN) / height, columns / width, rows / height
    return picture, boxes


def _shelves(images: list[ColourImage]) -> tuple[list[tuple[int, int]], int, int]:
    sizes = [(image.shape[1] + 2 * _MARGIN, image.shape[0] + 2 * _MARGIN) for image in images]
    limit = max(max(w for w, _ in sizes), int(np.sqrt(sum(w * h for w, h in sizes)) * 1.1))
    places: list[tuple[int, int]] = [(0, 0)] * len(images)
    x = y = shelf = width = 0
    for k in sorted(range(len(images)), key=lambda k: -sizes[k][1]):
        w, h = sizes[k]
        if x + w > limit:
            x, y, shelf = 0, y + shelf, 0
        places[k] = (x, y)
        x, shelf, width = x + w, max(shelf, h), max(width, x + w)
    return places, width, y + shelf


def _halved(image: ColourImage) -> ColourImage:
    size = max(1, image.shape[1] // 2), max(1, image.shape[0] // 2)
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
