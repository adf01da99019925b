"""Names that nothing else has: ids of items, and keys that tell content from content."""

from __future__ import annotations

import hashlib
import secrets
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from engine.scan.range_image import RangeImage


def new_id(kind: str = "scan") -> str:
    """Return an id that no other item has; it begins with what the item is."""
    return f"{kind}-{secrets.token_hex(6)}"


def array_key(array: np.ndarray[Any, Any]) -> str:
    """Return the content key of an array: SHA-256 of type, shape and bytes, in hex."""
    digest = hashlib.sha256(f"{array.dtype.str}{array.shape}".encode())
    digest.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)
    return digest.hexdigest()


def content_key(scan: RangeImage) -> str:
    """Return the key of a scan's content: points, colour picture and camera."""
    camera = scan.camera
    parts = [
        array_key(scan.points),
        "" if scan.colour is None else array_key(scan.colour),
        "" if camera is None else repr((camera.fx, camera.fy, camera.cx, camera.cy)),
    ]
    return hashlib.sha256("|".join(parts).encode()).hexdigest()
