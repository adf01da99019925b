"""Chooses the vertices that carry the fiducials, ten further anatomical points, and the skin the proof looks at."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from engine.mesh import TriangleMesh
from engine.scan.range_image import Camera
from engine.scan.virtual import visible_points
from resources.sample.build.source import FloatArray, IntArray

# Where to look on the subject's resting face: (x, y) in mm of the head's own frame, subject's left at +x.
MIDDLE = {"forehead": 66.0, "nose_bridge": 22.0, "chin": -63.0}
SIDES = {
    "brow_{}_outer": (52.5, 33.0),
    "brow_{}_inner": (13.0, 34.0),
    "eye_{}_outer": (41.3, 21.2),
    "eye_{}_inner": (14.3, 20.2),
    "nose_{}": (15.0, -9.5),
    "mouth_{}": (22.2, -39.3),
    "jaw_{}": (46.0, -40.0),
}
ANATOMY_MIDDLE = {"philtrum": -27.0, "mentolabial_fold": -54.0}
ANATOMY_SIDES = {
    "brow_{}_middle": (32.0, 38.5),
    "cheek_{}": (33.0, -5.0),
    "nose_wing_top_{}": (12.0, -3.0),
    "eyelid_{}_lower": (28.5, 13.5),
}
SURE = 1.5  # mm round a chosen place that a vertex is looked for in


class PointChooser:
    """Picks dense skin vertices by where they lie on the resting face.

    Parameters
    ----------
    neutral : (n, 3) float
        Dense skin of the subject at rest in the head's frame, mm.
    normals : (n, 3) float
        Its vertex normals.
    """

    def __init__(self, neutral: FloatArray, normals: FloatArray) -> None:
        self.neutral = neutral
        self.front = np.flatnonzero((normals[:, 2] > 0.15) & (neutral[:, 2] > 20))
        self.middle = np.flatnonzero((np.abs(neutral[:, 0]) < 0.15) & (normals[:, 2] > -0.2) & (neutral[:, 2] > 60))

    def near(self, x: float, y: float) -> int:
        """Return the front-facing vertex nearest to (x, y) mm."""
        return int(self.front[np.argmin(np.hypot(*(self.neutral[self.front, :2] - [x, y]).T))])

    def on_middle(self, y: float) -> int:
        """Return the foremost mid-line vertex near height y mm."""
        offset = np.abs(self.neutral[self.middle, 1] - y) - 0.05 * self.neutral[self.middle, 2]
        return int(self.middle[np.argmin(offset)])

    def mirror(self, vertex: int) -> int:
        """Return the vertex on the other side."""
        return int(np.argmin(np.linalg.norm(self.neutral - self.neutral[vertex] * [-1, 1, 1], axis=1)))

    def both(self, places: dict[str, tuple[float, float]]) -> dict[str, int]:
        """Return the vertices of paired places."""
        result = {}
        for pattern, place in places.items():
            left = self.near(*place)
            result[pattern.format("left")], result[pattern.format("right")] = left, self.mirror(left)
        return result


def outer_points(chooser: PointChooser, lips: FloatArray) -> dict[str, int]:
    """Return the 20 fiducials of the closed scheme; ``lips`` (n,) is the painted lip mask, 0..1."""
    found = {name: chooser.on_middle(y) for name, y in MIDDLE.items()} | chooser.both(SIDES)
    middle, heights = chooser.middle, chooser.neutral[chooser.middle]
    nose = middle[(heights[:, 1] < 0) & (heights[:, 1] > -40)]
    found["nose_tip"] = int(nose[np.argmax(chooser.neutral[nose, 2])])
    lip = middle[lips[middle] > 0.5]
    found["lip_upper"] = int(lip[np.argmax(chooser.neutral[lip, 1])])
    found["lip_lower"] = int(lip[np.argmin(chooser.neutral[lip, 1])])
    return found


def anatomical_points(chooser: PointChooser) -> dict[str, int]:
    """Return ten points that no scheme names."""
    return {name: chooser.on_middle(y) for name, y in ANATOMY_MIDDLE.items()} | chooser.both(ANATOMY_SIDES)


def inner_lip_points(
    chooser: PointChooser,
    lips: FloatArray,
    widest: FloatArray,
    corner: float,
    poses: Iterable[tuple[TriangleMesh, Camera]],
) -> dict[str, int]:
    """Return the six points on the inner lip border: middle and quarter points.

    Of the lip vertices at one place along the mouth it takes the innermost that every open mouth shows.

    Parameters
    ----------
    widest : (n, 3) float
        Dense skin with the mouth wide open, which tells the lips apart and orders them from the outside in, mm.
    corner : float
        Distance of the mouth corner from the middle at rest, mm.
    poses : pairs of TriangleMesh and Camera
        The open mouths before their scanner.
    """
    gap = widest[:, 1] - chooser.neutral[:, 1]
    lip = np.flatnonzero((lips > 0.3) & (chooser.neutral[:, 2] > 85))
    lower = gap[lip] < np.median(gap[lip])
    seen = list(poses)

    def innermost(x: float, own: IntArray, inward: float) -> int:
        at = own[np.abs(chooser.neutral[own, 0] - x) < (0.15 if x == 0 else SURE)]
        order = at[np.argsort(-inward * widest[at, 1])]
        return next(int(v) for v in order if all(visible_points(m, c, m.vertices[v])[1][0] for m, c in seen))

    found = {}
    for name, own, inward in (("lip_upper_inner", lip[~lower], -1.0), ("lip_lower_inner", lip[lower], 1.0)):
        found[name] = innermost(0.0, own, inward)
        left = innermost(corner / 2, own, inward)
        found[f"{name}_left"], found[f"{name}_right"] = left, chooser.mirror(left)
    return found


def face_skin(
    neutral: FloatArray, skin: IntArray, seen: IntArray, fiducials: dict[str, int], hidden: Callable[[IntArray], IntArray]
) -> IntArray:
    """Return the skin faces inside the outermost fiducials that the scanner sees on the resting face.

    ``skin`` (F, 3) are the skin's triangles and ``seen`` the numbers of those that some pixel meets; ``hidden`` says
    (k,) bool of given faces that they belong to mouth or nostrils.
    """
    names = ("forehead", "brow_left_outer", "jaw_left", "chin", "jaw_right", "brow_right_outer")
    ring = neutral[[fiducials[n] for n in names], :2]
    middle = neutral[skin].mean(axis=1)[:, :2]
    inside = np.ones(len(skin), dtype=bool)
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        side = (b - a)[0] * (middle - a)[:, 1] - (b - a)[1] * (middle - a)[:, 0]
        inside &= side < 0
    seen = seen[(seen < len(skin)) & (seen >= 0)]
    chosen = seen[inside[seen]]
    return chosen[~hidden(chosen)]
