"""Pictures and depth images from and to PNG, JPEG and TIFF, in RGB order."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.atomic import atomic_write
from engine.files.exr import read_exr
from engine.files.image_header import ImageHeader, image_header
from engine.files.source import read_bytes

MAX_IMAGE_BYTES = 256 << 20


def image_size(path: str | Path) -> tuple[int, int]:
    """Return (width, height) in pixels of an image file without decoding it; InputError as ``read_image``."""
    header = image_header(read_bytes(path, MAX_IMAGE_BYTES), str(path))
    return header.width, header.height


def read_image(path: str | Path) -> NDArray[np.uint8]:
    """Return a picture as (H, W, 3) uint8 in RGB order, the pixels as stored (no rotation by metadata).

    Raises
    ------
    InputError
        When the file is missing, no PNG, JPEG, TIFF or PPM, too large, cut off or damaged.
    """
    image = _decode(path, cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION)
    return image.astype(np.uint8, copy=False)


def read_grey(path: str | Path) -> NDArray[Any]:
    """Return a one-channel image (H, W) in the type it is stored in (uint8, uint16, float32 or float64).

    Raises
    ------
    InputError
        As ``read_image``; also for an image of several channels or of another type.
    """
    image = _decode(path, cv2.IMREAD_UNCHANGED | cv2.IMREAD_IGNORE_ORIENTATION)
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim != 2:
        raise InputError(str(path), f"has {image.shape[2]} channels", "give an image of one channel")
    if image.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        raise InputError(str(path), f"stores {image.dtype}", "give 16-bit integers or floats")
    return image


def encode_image(image: NDArray[Any], kind: str = "png", quality: int = 92) -> bytes:
    """Return the bytes of a ``png`` | ``jpeg`` | ``tiff`` file.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB, or (H, W) uint8 | uint16 (float32 for TIFF)
        The pixels.
    kind : str
        The format.
    quality : int
        0..100, JPEG only.
    """
    pixels = np.ascontiguousarray(image)
    if pixels.ndim not in (2, 3) or (pixels.ndim == 3 and pixels.shape[2] != 3) or pixels.size == 0:
        raise InputError("image", f"has shape {pixels.shape}", "give H x W or H x W x 3 pixels")
    suffixes = {"png": ".png", "jpeg": ".jpg", "tiff": ".tif"}
    if kind not in suffixes:
        raise InputError("image", f"cannot be written as {kind!r}", "choose png, jpeg or tiff")
    if pixels.dtype != np.uint8 and not (pixels.ndim == 2 and pixels.dtype in (np.uint16, np.float32)):
        raise InputError("image", f"stores {pixels.dtype}", "give bytes, or one channel of 16 bits")
    holds = {"png": (np.uint8, np.uint16), "jpeg": (np.uint8,), "tiff": (np.uint8, np.uint16, np.float32)}[kind]
    if pixels.dtype not in holds:
        raise InputError("image", f"stores {pixels.dtype}, which {kind} cannot hold", "choose tiff or png")
    if pixels.ndim == 3:
        pixels = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    options = [cv2.IMWRITE_JPEG_QUALITY, quality] if kind == "jpeg" else []
    done, data = cv2.imencode(suffixes[kind], pixels, options)
    if not done:
        raise InputError("image", f"cannot be written as {kind}", "choose another format")
    return bytes(data)


def write_image(path: str | Path, image: NDArray[Any], quality: int = 92) -> None:
    """Write an image atomically in the format that its name says (.png .jpg .jpeg .tif .tiff); see ``encode_image``."""
    kind = {".png": "png", ".jpg": "jpeg", ".jpeg": "jpeg", ".tif": "tiff", ".tiff": "tiff"}.get(
        Path(path).suffix.lower()
    )
    if kind is None:
        raise InputError(str(path), "does not name an image format", "end it with .png, .jpg or .tif")
    data = encode_image(image, kind, quality)
    with atomic_write(path) as handle:
        handle.write(data)


def _decode(path: str | Path, flags: int) -> NDArray[Any]:
    data = read_bytes(path, MAX_IMAGE_BYTES)
    header: ImageHeader = image_header(data, str(path))
    image: Any
    if header.kind == "exr":
        if flags >= 0:
            raise InputError(str(path), "is an EXR image, which is read for depth only", "save the colours as PNG")
        image = read_exr(data, str(path))
        if image.shape != (header.height, header.width):
            raise InputError(str(path), "is a damaged EXR image", "copy or export it again")
        return np.asarray(image)
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except cv2.error:
        image = None
    finally:
        cv2.utils.logging.setLogLevel(level)
    if image is None or image.shape[:2] != (header.height, header.width):
        raise InputError(str(path), f"is damaged or an unusual kind of {header.kind}", "export it again")
    return np.asarray(image)
