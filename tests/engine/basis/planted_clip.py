"""A face that moves as planted on the sample's rig: face markers, head markers and the head's own motion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

import resources
from engine.basis.binding import MarkerPair
from engine.files.marker_pairs import read_marker_pairs
from engine.files.rig import read_rig
from engine.geometry.rigid import RigidTransform
from engine.mesh import TriangleMesh
from engine.motion import MarkerClip
from engine.shapes import Rig

HEAD = tuple(f"top{k}" for k in range(7))
"""Names that say nothing of a head."""


@cache
def sample_rig() -> Rig:
    return read_rig(resources.sample_path("performance", "animator_24.npz")).rig


@cache
def sample_pairs() -> tuple[MarkerPair, ...]:
    return tuple(read_marker_pairs(resources.sample_path("performance", "MARKERS.json")))


@dataclass(frozen=True)
class PlantedClip:
    """``displacements`` (L, K, 3) of the face markers on the rig; the clip shows them through the head's ``poses``."""

    clip: MarkerClip
    displacements: np.ndarray
    poses: tuple[RigidTransform, ...]
    placement: RigidTransform


def planted_clip(
    frames: int = 90, seed: int = 0, placement: RigidTransform | None = None, still: bool = False, noise: float = 0.0
) -> PlantedClip:
    """Return a clip whose first frame shows the neutral face and the head at rest.

    ``placement`` leads from the clip's frame into the rig's; ``still`` holds the head.
    """
    rng = np.random.default_rng(seed)
    mesh, pairs = sample_rig().mesh, sample_pairs()
    rest = np.array([mesh.vertices[pair.target] for pair in pairs if isinstance(pair.target, int)])
    time = np.linspace(0, 2 * np.pi, frames)
    wave = np.stack([np.sin((k + 1) * time) for k in range(5)], axis=1)
    displacements = np.einsum("lk,kmc->lmc", wave, rng.normal(0, 1.5, (5, len(rest), 3)))
    high = mesh.vertices[mesh.vertices[:, 1] > np.percentile(mesh.vertices[:, 1], 97)]
    top = high[np.linspace(0, len(high) - 1, len(HEAD)).astype(int)]
    swing = np.column_stack([0.3 * np.sin(time), 0.5 * np.sin(2 * time), 0.2 * np.sin(3 * time)]) * (not still)
    shift = np.column_stack([20 * np.sin(time), 8 * np.sin(time), 30 * (1 - np.cos(time))]) * (not still)
    poses = tuple(RigidTransform(Rotation.from_rotvec(r).as_matrix(), t) for r, t in zip(swing, shift, strict=True))
    back = (placement or RigidTransform.identity()).inverse()
    seen = np.stack(
        [back.apply(pose.apply(np.vstack([rest + d, top]))) for pose, d in zip(poses, displacements, strict=True)]
    )
    seen = seen + rng.normal(0, noise, seen.shape) if noise else seen
    labels = (*(pair.label for pair in pairs), *HEAD)
    return PlantedClip(MarkerClip(labels, seen, 120.0), displacements, poses, placement or RigidTransform.identity())


def with_gaps(clip: MarkerClip, gaps: dict[str, slice]) -> MarkerClip:
    """Return the clip with markers lost in some frames."""
    positions = clip.positions.copy()
    for label, frames in gaps.items():
        positions[frames, clip.labels.index(label)] = np.nan
    return MarkerClip(clip.labels, positions, clip.fps)


def lips() -> tuple[TriangleMesh, int]:
    """Two sheets 0.1 mm apart, joined at both ends like lips: the mesh, and the first vertex of the lower one."""
    columns, rows = 41, 12
    across, up = np.meshgrid(np.linspace(-40, 40, columns), np.linspace(0.05, 30, rows))
    upper = np.column_stack([across.ravel(), up.ravel(), np.zeros(across.size)])
    lower = upper * [1, -1, 1]
    grid = np.arange(rows * columns).reshape(rows, columns)
    quads = [(grid[r, c], grid[r, c + 1], grid[r + 1, c + 1], grid[r + 1, c]) for r in range(rows - 1)
             for c in range(columns - 1)]  # fmt: skip
    first = np.array([[q[0], q[1], q[2]] for q in quads] + [[q[0], q[2], q[3]] for q in quads])
    second = first[:, ::-1] + len(upper)
    # The corners: the outermost vertices of both first rows are one.
    join = np.arange(2 * len(upper))
    for column in (0, columns - 1):
        join[len(upper) + column] = column
    return TriangleMesh(np.vstack([upper, lower]), np.vstack([first, join[second]])), len(upper)
