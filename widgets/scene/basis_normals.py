"""Vertex normals of one topology again and again: everything that depends on the faces alone is worked out once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy import sparse

Float32 = NDArray[np.float32]


class VertexNormals:
    """Unit normals weighted by area, in buffers that are made once.

    Parameters
    ----------
    faces : (F, 3) int
        Counter-clockwise from outside.
    count : int
        Number of vertices N.
    """

    def __init__(self, faces: NDArray[np.integer], count: int) -> None:
        from scipy import sparse  # with the first rig: empty views need not wait for it

        number = len(faces)
        self._corners = [np.ascontiguousarray(faces[:, k], dtype=np.intp) for k in range(3)]
        ones, columns = np.ones(3 * number, dtype=np.float32), np.repeat(np.arange(number, dtype=np.int32), 3)
        rows = np.asarray(faces, dtype=np.int32).ravel()
        self._around: sparse.csr_matrix = sparse.csr_matrix((ones, (rows, columns)), shape=(count, number))
        self._around.sum_duplicates()
        self._points = [np.empty((number, 3), dtype=np.float32) for _ in range(3)]
        self._across = np.empty((number, 3), dtype=np.float32)
        self._part = np.empty(number, dtype=np.float32)

    def into(self, points: Float32, out: Float32) -> None:
        """Write the normals of ``points`` (N, 3) into ``out`` (N, 3); +Z where a vertex has no face of any area."""
        a, b, c = self._points
        for corner, place in zip(self._corners, self._points, strict=True):
            np.take(points, corner, axis=0, out=place, mode="clip")
        b -= a
        c -= a
        for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
            np.multiply(b[:, i], c[:, j], out=self._across[:, k])
            np.multiply(b[:, j], c[:, i], out=self._part)
            self._across[:, k] -= self._part
        total = self._around @ self._across
        length = np.sqrt(np.einsum("ij,ij->i", total, total))
        flat = length <= 0.0
        length[flat] = 1.0
        np.divide(total, length[:, None], out=out)
        if flat.any():
            out[flat] = (0.0, 0.0, 1.0)
