"""Iris and pupil on eyeballs that have no texture: a face that looks at nobody is hard to judge."""

from __future__ import annotations

import numpy as np

from engine.mesh import FloatArray, IntArray, TriangleMesh
from widgets.scene.background import rgb

_PUPIL, _IRIS, _RIM = np.radians((9.0, 25.0, 28.5))
"""Half opening of pupil, iris and its dark rim, seen from the middle of the eyeball."""
_BLACK, _INNER, _OUTER, _DARK = "#141210", "#8a9a86", "#5d6f66", "#2c3330"


def iris_colours(mesh: TriangleMesh, faces: IntArray, source: IntArray, base: FloatArray) -> FloatArray:
    """Return the colours (n, 3), 0..255, of eye vertices with iris and pupil painted around each eye's front.

    Every connected side of the face, left and right of x = 0, is taken for one ball that looks along +Z.

    Parameters
    ----------
    mesh : TriangleMesh
        The neutral face.
    faces : (f,) int
        Faces of all eyes.
    source : (n,) int
        Vertices to colour.
    base : (n, 3) float
        Their colour without an iris.
    """
    points = mesh.vertices[source]
    found = base.copy()
    used = mesh.vertices[np.unique(mesh.faces[faces])]
    middle = float(used[:, 0].mean())
    for side in (points[:, 0] > middle, points[:, 0] <= middle):
        if side.sum() < 24:
            continue
        centre = _centre(points[side])
        along = points[side] - centre
        angle = np.arccos(np.clip(along[:, 2] / np.maximum(np.linalg.norm(along, axis=1), 1e-9), -1.0, 1.0))
        found[side] = _paint(angle, base[side])
    return found


def _centre(points: FloatArray) -> FloatArray:
    """Return the centre (3,) of the sphere that fits points (k, 3) best (algebraic least squares)."""
    offset = points.mean(axis=0)
    local = points - offset
    system = np.column_stack([2.0 * local, np.ones(len(local))])
    solution = np.linalg.lstsq(system, (local**2).sum(axis=1), rcond=None)[0]
    return np.asarray(offset + solution[:3])


def _paint(angle: FloatArray, base: FloatArray) -> FloatArray:
    black, inner, outer, dark = (np.array(rgb(c)) * 255.0 for c in (_BLACK, _INNER, _OUTER, _DARK))
    across = np.clip((angle - _PUPIL) / (_IRIS - _PUPIL), 0.0, 1.0)[:, None]
    colours = base.copy()
    iris = inner + across * (outer - inner)
    colours[angle < _RIM] = dark
    colours[angle < _IRIS] = iris[angle < _IRIS]
    colours[angle < _PUPIL] = black
    return colours
