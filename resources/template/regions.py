"""Which triangles of the template belong to brows, lids, nose, lips and so on, drawn like the template itself.

Every region is a closed outline on the left half of the drawing of ``build.py`` (its units, +Y down, closed lips). Lids
and lips follow the template's own feature lines, whose points are vertices, so that their borders are edges. A triangle
belongs to the first region whose outline holds its centre, or to what is left over: forehead above the eyes' corners,
cheeks below.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.path import Path as Polygon

NAMES = ("brows", "lids", "eyes", "nose", "lips", "mouth", "cheeks", "jaw", "forehead")

BROW = [(14, 196), (13, 181), (40, 171), (63, 163), (98, 171), (98, 199), (78, 196), (60, 186), (45, 187), (30, 195)]
"""From root to tail, as wide as hair grows and the bone under it."""
LID = [(25, 213), (24, 204), (22, 199), (30, 192), (45, 183), (60, 183), (80, 195), (83, 206), (76, 213)]
"""Above the fold the soft skin up to the brow; below, the lid ends at the line of the bag."""
NOSE = [
    (0, 196),
    (14, 193),
    (25, 204),
    (25, 213),
    (17, 215),
    (17, 232),
    (23, 250),
    (29, 262),
    (30, 278),
    (23, 289),
    (0, 291),
]
"""From the root between the brows over the side wall and the wing to where the upper lip begins."""
MOUTH = [(0, 283), (26, 283), (34, 296), (43, 308), (45, 318), (43, 330), (30, 340), (15, 345), (0, 346)]
"""The skin around the lips: from the nose to the fold of the chin, between the folds beside the mouth."""
JAW = [(0, 342), (16, 342), (30, 337), (43, 326), (55, 318), (70, 304), (84, 293), (100, 285), (100, 400), (0, 400)]
"""Chin and jaw, from the fold under the lower lip to the ear."""
TEMPLE_Y = 207.0
"""What is left over above this height is forehead and temple, below it cheek."""


def regions(faces: np.ndarray, closed: np.ndarray, lines: Sequence[np.ndarray]) -> dict[str, list[int]]:
    """Return the faces of every region.

    Parameters
    ----------
    faces : (F, 3) int
        Triangles of both halves.
    closed : (N, 2) float
        The drawing with closed lips, x = 0 the mid-line.
    lines : sequence of (k, 2) float
        The inner feature lines of ``build.features``.
    """
    eye_top, eye_low, fold, bag, _, lip_high, lip_low = lines[:7]
    outlines = {
        "eyes": np.vstack([eye_top, eye_low[::-1]]),
        "lips": np.vstack([lip_high, lip_low[::-1]]),
        "lids": np.vstack([fold, bag[::-1]]),
        "brows": np.array(BROW),
        "upper lids": np.array(LID),
        "nose": np.array(NOSE),
        "mouth": np.array(MOUTH),
        "jaw": np.array(JAW),
    }
    centre = np.abs(closed[faces].mean(axis=1) * [1, 0]) + closed[faces].mean(axis=1) * [0, 1]
    found = np.where(centre[:, 1] < TEMPLE_Y, NAMES.index("forehead"), NAMES.index("cheeks"))
    for name, outline in reversed(outlines.items()):
        found[Polygon(outline).contains_points(centre)] = NAMES.index(name.split()[-1])
    return {name: np.flatnonzero(found == k).tolist() for k, name in enumerate(NAMES)}
