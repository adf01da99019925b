"""Positions of OBJ files whose faces are, byte for byte, those of another that has been read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.files.source import read_bytes
from engine.mesh import FloatArray

_LARGEST = 512 << 20


class ObjTwin:
    """Reads the shapes beside a neutral face many times faster than as meshes of their own, where that is the same.

    Parameters
    ----------
    path : Path
        The neutral face.
    count : int
        Its vertices.
    """

    def __init__(self, path: Path, count: int) -> None:
        self._count = count
        self._faces = _parts(read_bytes(path, _LARGEST))[1]

    def positions(self, path: Path) -> FloatArray | None:
        """Return the positions (N, 3) of a file; None where it has to be read as a mesh to know."""
        block, faces = _parts(read_bytes(path, _LARGEST))
        if not faces or faces != self._faces:
            return None
        if block.count(b"v ") != self._count or block.count(b"\n") != self._count:
            return None
        words = block.replace(b"v ", b"").split()
        if len(words) != 3 * self._count:
            return None
        try:
            return np.array(list(map(float, words))).reshape(-1, 3)
        except ValueError:
            return None


def _parts(data: bytes) -> tuple[bytes, bytes]:
    """Return the lines from the first to the last position, and all from the first face on; empty where unusual."""
    if b"\\" in data:
        return b"", b""
    data = b"\n" + data.replace(b"\r\n", b"\n")
    face = data.find(b"\nf ")
    first, last = data.find(b"\nv ", 0, max(face, 0)), data.rfind(b"\nv ", 0, max(face, 0))
    if face < 0 or first < 0:
        return b"", b""
    return data[first + 1 : data.find(b"\n", last + 1) + 1], data[face:].rstrip()
