"""Where the subject wears markers: 66 on the face, 7 on the head, as places on the resting face."""

from __future__ import annotations

import numpy as np

from resources.sample.build.source import FloatArray

# (x, y) in mm of the head's own frame, subject's left at +x; seen from the front.
MIDDLE = {
    "forehead": 66.0, "glabella": 37.0, "nose_bridge": 20.0, "nose_tip": -6.0, "philtrum": -26.0, "lip_upper": -34.0,
    "lip_lower": -45.5, "below_lip": -53.5, "chin": -64.0, "chin_under": -73.0,
}  # fmt: skip
SIDES = {
    "forehead_inner": (20.0, 62.0), "forehead_outer": (42.0, 58.0), "above_brow_inner": (15.0, 47.0),
    "above_brow_outer": (38.0, 49.0), "brow_inner": (12.5, 34.5), "brow_middle": (24.0, 38.0),
    "brow_arch": (36.0, 38.5), "brow_outer": (49.0, 33.0), "lid_upper": (28.0, 29.0), "lid_fold": (28.5, 33.3),
    "lid_lower": (28.0, 13.5),
    "eye_inner": (13.3, 20.5), "eye_outer": (45.5, 20.5), "nose_side": (10.0, 7.0), "nose_wing": (13.5, -10.0),
    "cheek_inner": (25.0, 4.0), "cheek_bone": (42.0, 5.0), "cheek_front": (31.0, -13.0),
    "cheek_side": (48.0, -14.0), "cheek_low": (37.0, -30.0), "jowl": (53.0, -32.0), "lip_corner": (23.5, -39.5),
    "beside_lip": (31.0, -42.0), "lip_upper_side": (11.5, -35.0), "lip_lower_side": (11.5, -44.5),
    "chin_side": (15.0, -59.0), "jaw_front": (32.0, -56.0), "jaw_side": (48.0, -46.0),
}  # fmt: skip
# On a light frame around the head, in mm of its own frame: the further out, the steadier is the pose they give.
HEAD = {
    "head_front": (0.0, 128.0, 92.0), "head_top": (0.0, 168.0, -5.0), "head_back": (0.0, 70.0, -132.0),
    "head_left": (112.0, 52.0, 12.0), "head_right": (-112.0, 52.0, 12.0),
    "head_low_left": (92.0, -6.0, -78.0), "head_low_right": (-92.0, -6.0, -78.0),
}  # fmt: skip


def place_markers(points: FloatArray, normals: FloatArray) -> dict[str, int]:
    """Return the vertex under each of the 66 markers on the face, by label.

    Parameters
    ----------
    points, normals : (n, 3) float
        Skin at rest in the head's own frame, mm.
    """
    front = np.flatnonzero((normals[:, 2] > 0.12) & (points[:, 2] > 15))

    def foremost(x: float, y: float) -> int:
        # Behind lids and nostrils lies more skin that faces forward: what is in front counts.
        offset = np.linalg.norm(points[front, :2] - [x, y], axis=1) - 0.25 * points[front, 2]
        return int(front[np.argmin(offset)])

    found = {name: foremost(0.0, y) for name, y in MIDDLE.items()}
    for name, (x, y) in SIDES.items():
        left = foremost(x, y)
        found[f"{name}_left"] = left
        found[f"{name}_right"] = int(np.argmin(np.linalg.norm(points - points[left] * [-1, 1, 1], axis=1)))
    return found
