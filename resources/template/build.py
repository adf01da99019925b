"""Make ``face.json``: the flat template face, from the drawing of its left half below.

Run ``python -m resources.template.build``. The drawing is a list of feature lines in units of about 0.7 mm on an
average face (+Y down, x = 0 the mid-line); free points between them settle under repelling forces whose length follows
a size field, and the left half is mirrored.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.path import Path as Polygon
from scipy.interpolate import PchipInterpolator
from scipy.spatial import Delaunay, cKDTree

from engine.geometry.normals import smallest_angles
from resources.template.regions import regions

VERTICES = 441
SLIT_Y, MOUTH_HALF, OPENING = 317.0, 33.5, 20.0

FIDUCIALS = {
    "forehead": (0.0, 125.0),
    "brow_left_outer": (86.0, 189.0),
    "brow_left_inner": (22.0, 185.5),
    "eye_left_outer": (73.0, 209.5),
    "eye_left_inner": (26.0, 211.5),
    "nose_bridge": (0.0, 208.0),
    "nose_tip": (0.0, 267.0),
    "nose_left": (24.5, 276.0),
    "mouth_left": (MOUTH_HALF, SLIT_Y),
    "lip_upper": (0.0, 303.0),
    "lip_lower": (0.0, 336.0),
    "chin": (0.0, 363.0),
    "jaw_left": (87.0, 315.0),
}
OUTLINE_ABOVE = [(0, 100), (36, 104), (62, 119), (81, 148), (91, 190), (94, 235), (92, 285), (87, 315)]
OUTLINE_BELOW = [(87, 315), (80, 331), (63, 348), (33, 365), (0, 371)]


def curve(points: Sequence[tuple[float, float]], spacing: float | list[float]) -> np.ndarray:
    """Return points along a smooth curve through ``points``, a spacing apart or at given shares of its length."""
    knots = np.array(points, dtype=float)
    length = np.r_[0, np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))]
    fine = np.linspace(0, length[-1], 800)
    path = np.stack([PchipInterpolator(length, knots[:, k])(fine) for k in range(2)], axis=1)
    travelled = np.r_[0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
    count = max(round(travelled[-1] / spacing), 2) if isinstance(spacing, float) else None
    share = np.linspace(0, 1, count + 1) if count else np.asarray(spacing)
    return np.stack([np.interp(share * travelled[-1], travelled, path[:, k]) for k in range(2)], axis=1)


def opened(points: np.ndarray, below: np.ndarray) -> np.ndarray:
    """Return points of the closed drawing moved apart by half the slit's width, fading away from the mouth."""
    x, y = points.T
    profile = np.sqrt(np.clip(1 - (x / MOUTH_HALF) ** 2, 0, 1))
    reach = np.exp(-(((y - SLIT_Y) / 45) ** 2))
    return np.stack([x, y + np.where(below, 0.5, -0.5) * OPENING * profile * reach], axis=1)


def features() -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the border chains (outline, mid-line, slit below and above, mid-line) and the inner lines."""
    above, below = curve(OUTLINE_ABOVE, list(np.linspace(0, 1, 18))), curve(OUTLINE_BELOW, list(np.linspace(0, 1, 9)))
    outline = np.vstack([above, below[1:]])
    share = [0, 0.17, 0.34, 0.5, 0.66, 0.81, 0.92, 1]
    slit = np.stack([MOUTH_HALF * np.array(share), np.full(8, SLIT_Y)], axis=1)
    low = np.array([(0, y) for y in (371, 363, 354.5, 345, 336, 330, 323.5, SLIT_Y)])
    high = np.array(
        [
            (0, y)
            for y in (SLIT_Y, 312.5, 308, 303, 297, 291, 285, 280, 273.5, 267, 259.5, 251, 242, 233, 224.5, 216, 208)
        ]
        + [(0, y) for y in (199, 189, 177, 162, 144, 125, 112, 100)]
    )
    eye_top = curve([(26, 211.5), (34, 205.5), (48, 201), (62, 203), (73, 209.5)], 6.3)
    eye_low = curve([(26, 211.5), (36, 217), (50, 219.5), (64, 216.5), (73, 209.5)], 6.3)
    fold = curve([(25, 204), (34, 197.5), (49, 193), (66, 195.5), (78, 205)], 8.5)
    bag = curve([(28, 219.5), (38, 225.5), (52, 228.5), (67, 225), (79, 215)], 8.5)
    brow = curve([(22, 185.5), (40, 180), (62, 176), (86, 189)], 9.5)
    lip_high = curve([(0, 303), (7.5, 302), (20, 307), (MOUTH_HALF, SLIT_Y)], 5.6)
    lip_low = curve([(0, 336), (14, 333.5), (25, 327), (MOUTH_HALF, SLIT_Y)], 5.6)
    wing_low, wing_high = (
        curve([(12, 283.5), (19.5, 283), (24.5, 276)], 6.2),
        curve([(24.5, 276), (23, 268.5), (17, 263)], 6.2),
    )
    wing = np.vstack([wing_low, wing_high])
    ridge = curve([(10, 211), (8, 230), (9, 248), (13, 262)], 9.0)
    return [outline, low, slit, slit[::-1], high], [
        eye_top, eye_low, fold, bag, brow, lip_high, lip_low, wing, ridge,
    ]  # fmt: skip


def size_field(points: np.ndarray) -> np.ndarray:
    """Return the wished edge length at ``points``: small at mouth, eyes and nose, large at brow and cheek."""
    _, (eye_top, eye_low, _, _, brow, lip_high, lip_low, wing, ridge) = features()
    size = np.full(len(points), 18.0)
    for line, start, slope in (
        (np.vstack([eye_top, eye_low]), 5.6, 0.26),
        (np.vstack([lip_high, lip_low]), 5.2, 0.27),
        (wing, 5.8, 0.3),
        (ridge, 7.5, 0.3),
        (brow, 8.5, 0.3),
    ):
        size = np.minimum(size, start + slope * cKDTree(line).query(points)[0])
    return size


def settle(
    fixed: np.ndarray, border: np.ndarray, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return all points and the triangles of the half face after the free ones have found their places."""
    inside = Polygon(border)
    free = np.empty((0, 2))
    while len(free) < count:
        trial = rng.uniform(border.min(axis=0), border.max(axis=0), (4000, 2))
        trial = trial[inside.contains_points(trial) & (rng.uniform(size=4000) < (5 / size_field(trial)) ** 2)]
        for point in trial:
            everything = np.vstack([fixed, free])
            if np.linalg.norm(everything - point, axis=1).min() > 0.62 * size_field(point[None])[0]:
                free = np.vstack([free, point])
            if len(free) == count:
                break
    points = np.vstack([fixed, free])
    for _ in range(600):
        faces = triangles(points, inside)
        edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
        vector = points[edges[:, 0]] - points[edges[:, 1]]
        length = np.linalg.norm(vector, axis=1)
        wish = size_field(0.5 * (points[edges[:, 0]] + points[edges[:, 1]]))
        wish *= 1.15 * np.sqrt((length**2).sum() / (wish**2).sum())
        push = np.maximum(wish - length, 0)[:, None] * vector / length[:, None]
        force = np.zeros_like(points)
        np.add.at(force, edges[:, 0], push)
        np.add.at(force, edges[:, 1], -push)
        moved = points[len(fixed) :] + 0.18 * force[len(fixed) :]
        stays = inside.contains_points(moved, radius=-1e-9)
        points[len(fixed) :][stays] = moved[stays]
    return points, triangles(points, inside)


def triangles(points: np.ndarray, inside: Polygon) -> np.ndarray:
    """Return the Delaunay triangles whose middle lies in the half face."""
    every = Delaunay(points).simplices
    faces: np.ndarray = every[inside.contains_points(points[every].mean(axis=1))]
    corner = points[faces]
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    faces = faces[abs(area) > 1e-6]
    flip = area[abs(area) > 1e-6] < 0
    faces[flip] = faces[flip][:, ::-1]
    return faces


def build() -> dict[str, object]:
    """Return the template as the document that is written."""
    chains, lines = features()
    below = [c[:, 1] > SLIT_Y if k == 0 else np.full(len(c), k in (1, 2)) for k, c in enumerate(chains)]
    open_chains = [opened(chain, side) for chain, side in zip(chains, below, strict=True)]
    open_lines = [opened(line, line[:, 1] > SLIT_Y) for line in lines]
    closed_points = [*chains, *lines]
    open_points = [*open_chains, *open_lines]
    everything_open, everything_closed = np.vstack(open_points), np.vstack(closed_points)
    keep: list[int] = []
    for index, point in enumerate(everything_open):
        if all(np.linalg.norm(everything_open[k] - point) > 1e-6 for k in keep):
            keep.append(index)
    fixed, fixed_closed = everything_open[keep], everything_closed[keep]
    middle = int((abs(fixed[:, 0]) < 1e-9).sum())
    count = (VERTICES + middle) // 2 - len(fixed)
    border = np.vstack(open_chains)
    trials = [settle(fixed, border, count, np.random.default_rng(seed)) for seed in range(6)]
    points, faces = max(trials, key=lambda trial: smallest_angle(*trial))
    closed = np.vstack([fixed_closed, closed_again(points[len(fixed) :])])
    return assemble(points, closed, faces)


def smallest_angle(points: np.ndarray, faces: np.ndarray) -> float:
    """Return the smallest angle of all triangles, radians."""
    return float(smallest_angles(np.pad(points, ((0, 0), (0, 1))), faces).min())


def closed_again(points: np.ndarray) -> np.ndarray:
    """Return free points of the open drawing at their closed places (the inverse of ``opened``, by iteration)."""
    result, below = points.copy(), points[:, 1] > SLIT_Y
    for _ in range(60):
        result += points - opened(result, below)
    return result


def assemble(points: np.ndarray, closed: np.ndarray, faces: np.ndarray) -> dict[str, object]:
    """Return both halves as one mesh with its mirror table, layouts and fiducials."""
    count = len(points)
    on_middle = abs(points[:, 0]) < 1e-9
    other = np.arange(count)
    other[~on_middle] = count + np.arange((~on_middle).sum())
    total = count + int((~on_middle).sum())
    mirror = np.empty(total, dtype=int)
    mirror[:count] = other
    mirror[other[~on_middle]] = np.flatnonzero(~on_middle)
    flip = np.array([-1.0, 1.0])
    layouts = {
        "closed": np.vstack([closed, closed[~on_middle] * flip]),
        "open": np.vstack([points, points[~on_middle] * flip]),
    }
    all_faces = np.vstack([faces, other[faces][:, ::-1]])
    names = {name: nearest(closed, place) for name, place in FIDUCIALS.items()}
    names |= {name.replace("left", "right"): int(mirror[v]) for name, v in names.items() if "left" in name}
    slit = np.flatnonzero((abs(closed[:, 1] - SLIT_Y) < 1e-6) & (closed[:, 0] < MOUTH_HALF))
    upper = slit[points[slit, 1] < SLIT_Y]
    lower = slit[points[slit, 1] > SLIT_Y]
    inner = {
        "lip_upper_inner": upper[closed[upper, 0].argmin()],
        "lip_lower_inner": lower[closed[lower, 0].argmin()],
        "lip_upper_inner_left": upper[abs(closed[upper, 0] - 0.5 * MOUTH_HALF).argmin()],
        "lip_lower_inner_left": lower[abs(closed[lower, 0] - 0.5 * MOUTH_HALF).argmin()],
    }
    inner |= {name.replace("left", "right"): mirror[v] for name, v in inner.items() if name.endswith("left")}
    inner = {name: int(vertex) for name, vertex in inner.items()}
    lines = features()[1]
    curves = {
        "lip_upper_inner": slit_curve(upper, closed, names["mouth_left"], mirror),
        "lip_lower_inner": slit_curve(lower, closed, names["mouth_left"], mirror),
        "lip_upper": across([nearest(closed, tuple(place)) for place in lines[5]], mirror),
        "lip_lower": across([nearest(closed, tuple(place)) for place in lines[6]], mirror),
    }
    return {
        "name": "face",
        "faces": all_faces.tolist(),
        "mirror": mirror.tolist(),
        "curves": curves,
        "regions": regions(all_faces, np.round(layouts["closed"], 4), lines),
        "layouts": {
            "closed": {"vertices": np.round(layouts["closed"], 4).tolist(), "fiducials": names},
            "open": {"vertices": np.round(layouts["open"], 4).tolist(), "fiducials": names | inner},
        },
    }


def slit_curve(half: np.ndarray, closed: np.ndarray, corner: int, mirror: np.ndarray) -> list[int]:
    """Return the vertices of one inner lip from corner to corner, from those of its left half."""
    return across([*half[np.argsort(closed[half, 0])].tolist(), corner], mirror)


def across(half: list[int], mirror: np.ndarray) -> list[int]:
    """Return a line from the subject's right to left, from its left half that starts on the mid-line."""
    return [int(mirror[vertex]) for vertex in half[:0:-1]] + [int(vertex) for vertex in half]


def nearest(points: np.ndarray, place: tuple[float, float]) -> int:
    """Return the vertex at ``place``; it must be one of the drawing's own points."""
    distance = np.linalg.norm(points - np.asarray(place), axis=1)
    if distance.min() > 1e-6:
        raise ValueError(f"no vertex at {place}")
    return int(distance.argmin())


if __name__ == "__main__":
    Path(__file__).with_name("face.json").write_text(json.dumps(build(), separators=(",", ":")) + "\n")
