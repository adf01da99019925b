"""Chooses the vertices that carry the fiducials, ten further anatomical points, and the skin the proof looks at."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

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
    "nose_{}": (13.8, -9.5),
    "mouth_{}": (22.2, -39.3),
    "jaw_{}": (46.0, -40.0),
}
ANATOMY_MIDDLE = {"philtrum": -27.0, "mentolabial_fold": -56.5}
ANATOMY_SIDES = {
    "brow_{}_middle": (32.0, 38.5),
    "cheek_{}": (33.0, -5.0),
    "nose_wing_top_{}": (12.0, -3.0),
    "eyelid_{}_lower": (28.5, 13.5),
}
ON_MIDDLE = 0.15  # mm; the expression units are not quite symmetric
PARTED_PX = 3.0
CLEAR_MM = 1.2

Mouth = tuple[TriangleMesh, Camera, NDArray[np.bool_]]
"""A mouth before its scanner, and which of its vertices are clearly seen."""


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
        self.middle = np.flatnonzero(
            (np.abs(neutral[:, 0]) < ON_MIDDLE) & (normals[:, 2] > -0.2) & (neutral[:, 2] > 60)
        )

    def near(self, x: float, y: float) -> int:
        """Return the front-facing vertex nearest to (x, y) mm."""
        distance = np.linalg.norm(self.neutral[self.front, :2] - [x, y], axis=1)
        return int(self.front[np.argmin(distance)])

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


def face_points(chooser: PointChooser) -> dict[str, int]:
    """Return the fiducials of the closed scheme but those of the lips."""
    found = {name: chooser.on_middle(y) for name, y in MIDDLE.items()} | chooser.both(SIDES)
    middle, heights = chooser.middle, chooser.neutral[chooser.middle]
    nose = middle[(heights[:, 1] < 0) & (heights[:, 1] > -40)]
    found["nose_tip"] = int(nose[np.argmax(chooser.neutral[nose, 2])])
    return found


def anatomical_points(chooser: PointChooser) -> dict[str, int]:
    """Return ten points that no scheme names."""
    return {name: chooser.on_middle(y) for name, y in ANATOMY_MIDDLE.items()} | chooser.both(ANATOMY_SIDES)


def lip_points(
    chooser: PointChooser, lips: FloatArray, widest: FloatArray, corner: float, mouths: Mapping[str, tuple[bool, Mouth]]
) -> tuple[dict[str, int], dict[str, dict[str, int]]]:
    """Return the lip points: two on the outer border, and six on the inner one, middle and halfway to the corners.

    Of the lip vertices at one place along the mouth it takes the outermost, or the innermost, that every mouth shows.
    The lower border alone is what it is, seen or not: a pushed out lip overhangs it. Such a mouth has a point of its
    own, the lowest of the lip that it clearly shows.
    Towards the corners the lips of a rounded mouth touch: the points move inwards until all open mouths part them.

    Parameters
    ----------
    lips : (n,) float
        The painted lip mask, 0..1.
    widest : (n, 3) float
        Dense skin with the mouth wide open, which tells the lips apart and orders them from the outside in, mm.
    corner : float
        Distance of the mouth corner from the middle at rest, mm.
    mouths : mapping of str to (bool, Mouth)
        The mouths by scan, and whether they are open.

    Returns
    -------
    points : dict of str to int
        Vertices by name.
    own : dict of str to dict of str to int
        By name and scan, the vertices of those scans that hide the common one.
    """
    middle = chooser.middle[lips[chooser.middle] > 0.5]
    height = chooser.neutral[middle, 1]
    everyone = [m for _, m in mouths.values()]
    open_mouths = [m for is_open, m in mouths.values() if is_open]
    upwards = middle[np.argsort(height)]
    found = {"lip_upper": _first_seen(upwards[::-1], everyone), "lip_lower": int(upwards[0])}
    lowest = {scan: _first_seen(upwards, [mouth]) for scan, (_, mouth) in mouths.items()}
    own = {"lip_lower": {scan: vertex for scan, vertex in lowest.items() if vertex != found["lip_lower"]}}
    gap = widest[:, 1] - chooser.neutral[:, 1]
    lip = np.flatnonzero((lips > 0.3) & (chooser.neutral[:, 2] > 85))
    lower = gap[lip] < (gap[lip].min() + gap[lip].max()) / 2
    inwards = {"lip_upper_inner": (lip[~lower], -1.0), "lip_lower_inner": (lip[lower], 1.0)}

    def pair(x: float, width: float) -> tuple[int, int]:
        pair = []
        for own, inward in inwards.values():
            at = own[np.abs(chooser.neutral[own, 0] - x) < width]
            pair.append(_first_seen(at[np.argsort(-inward * widest[at, 1])], open_mouths))
        return pair[0], pair[1]

    found |= dict(zip(inwards, pair(0.0, ON_MIDDLE), strict=True))
    for share in np.arange(0.5, 0.2, -0.04):
        sides = pair(share * corner, 0.7)
        heights = [np.ptp(camera.project(mesh.vertices[list(sides)])[:, 1]) for mesh, camera, _ in open_mouths]
        if min(heights) >= PARTED_PX:
            break
    for name, left in zip(inwards, sides, strict=True):
        found[f"{name}_left"], found[f"{name}_right"] = left, chooser.mirror(left)
    return found, own


def clearly_seen(mesh: TriangleMesh, camera: Camera, truth_points: FloatArray) -> NDArray[np.bool_]:
    """Return which vertices (n,) are seen with the four pixels round them, so that no rounding hides them.

    ``truth_points`` (H, W, 3) are what the pixels of the mesh's scan see, mm.
    """
    pixels = camera.project(mesh.vertices)
    height, width = truth_points.shape[:2]
    inside = (pixels >= 0) & (pixels <= [width - 1, height - 1])
    seen: NDArray[np.bool_] = np.asarray(inside.all(axis=1))
    corner = np.clip(np.floor(pixels).astype(np.int64), 0, [width - 2, height - 2])
    for right, down in ((0, 0), (1, 0), (0, 1), (1, 1)):
        there = truth_points[corner[:, 1] + down, corner[:, 0] + right]
        seen = seen & (np.nan_to_num(np.linalg.norm(there - mesh.vertices, axis=1), nan=np.inf) < CLEAR_MM)
    return seen


def _first_seen(vertices: IntArray, mouths: Sequence[Mouth]) -> int:
    for vertex in vertices:
        if all(
            clear[vertex] and visible_points(mesh, camera, mesh.vertices[vertex])[1][0]
            for mesh, camera, clear in mouths
        ):
            return int(vertex)
    raise ValueError("no vertex here is seen in every mouth")


def face_skin(
    neutral: FloatArray,
    skin: IntArray,
    seen: IntArray,
    fiducials: dict[str, int],
    hidden: Callable[[IntArray], NDArray[np.bool_]],
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
