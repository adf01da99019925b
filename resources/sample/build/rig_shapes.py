"""The subject's head as a rig: one mesh of skin, eyes, teeth and tongue, the 52 face units and two hand-made bases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from engine.mesh import BoolArray, TriangleMesh
from engine.shapes import SKIN
from resources.sample.build.source import FloatArray, HeadSource, IntArray
from resources.sample.head import Heads, subdivide

LEVELS = {SKIN: 1, "teeth_upper": 1, "teeth_lower": 1, "tongue": 1}
NECK_MM = -112.0
NECK_RIM_MM = -118.0
"""Skin that reaches below the first is left out, the shoulders; what then is the rim is drawn down to the second."""
EYE_RINGS, EYE_SPOKES, EYE_SPAN_DEG = 14, 28, 105.0
CORNEA_HEIGHT, CORNEA_WIDTH = 0.082, 0.41
STEP_MM = 1.0 / 128.0
"""Shapes are rounded to this: far below what is seen, and it packs well."""

# What the animator sculpted of what this performer does: brows, lids, cheeks, nose, jaw, and the mouth's main pulls.
HAND_A = (
    "browDownLeft", "browDownRight", "browInnerUp", "browOuterUpLeft", "browOuterUpRight",
    "eyeBlinkLeft", "eyeBlinkRight", "cheekSquintLeft", "cheekSquintRight", "noseSneerLeft", "noseSneerRight",
    "jawOpen", "mouthSmileLeft", "mouthSmileRight", "mouthFrownLeft", "mouthFrownRight", "mouthPucker", "mouthFunnel",
    "mouthStretchLeft", "mouthStretchRight", "mouthUpperUpLeft", "mouthUpperUpRight",
    "mouthLowerDownLeft", "mouthLowerDownRight",
)  # fmt: skip
INSIDE = ("mouth", "sockets")
SOCKET_MM = 1.0
"""Skin that lies nearer than this to an eyeball is the inner side of a lid, or the socket behind it."""
SCULPT_SHARE = 0.30
SCULPT_SCALE_MM = 38.0
SCULPT_REACH_MM = 28.0
SCULPT_SEED = 29


@dataclass(frozen=True)
class RigHead:
    """The mesh, and what carries displacements of the source's vertices onto it.

    ``carry`` is (N, cage): the Catmull-Clark matrix of skin, teeth and tongue, with empty rows for the eyes.
    """

    mesh: TriangleMesh
    carry: sp.csr_matrix
    eyes: tuple[IntArray, IntArray]
    centres: FloatArray
    radius: float

    @property
    def skin(self) -> IntArray:
        """Vertices of the skin that can be seen."""
        found: IntArray = np.unique(self.mesh.faces[self.mesh.parts[SKIN]])
        return found

    @property
    def tissue(self) -> IntArray:
        """Vertices of the skin, the inside of the mouth and the eye sockets: one surface."""
        found: IntArray = np.unique(self.mesh.faces[np.concatenate([self.mesh.parts[p] for p in (SKIN, *INSIDE)])])
        return found


def rig_head(source: HeadSource, heads: Heads) -> RigHead:
    """Return the subject's resting head: skin one Catmull-Clark step finer than its cage, without shoulders.

    What lies behind lips and lids are parts of their own, so that figures on the skin are of what is seen.
    """
    cage, cage_uv, white = heads.cage("base").copy(), heads._data["cage_uv"], heads._data["white_uv"]
    skin = heads._data["quads_skin"].astype(np.int64)
    kept = (cage[skin][..., 1] > NECK_MM).all(axis=1)
    skin, inside = skin[kept], {name: hidden[kept] for name, hidden in _inside(source, heads, cage).items()}
    cage[_rim(skin), 1] = NECK_RIM_MM
    blocks, quads, start = [], {}, 0
    for part, levels in LEVELS.items():
        own = skin if part == SKIN else heads._data[f"quads_{part}"].astype(np.int64)
        used, local = np.unique(own, return_inverse=True)
        pick = sp.csr_matrix((np.ones(len(used)), (np.arange(len(used)), used)), (len(used), len(cage)))
        matrix, fine = subdivide(local.reshape(-1, 4), len(used), levels)
        blocks.append(matrix @ pick)
        quads[part] = fine + start
        start += matrix.shape[0]
    ball, triangles = eyeball()
    balls = heads.eyes("base")
    eyes = tuple(start + k * len(ball) + np.arange(len(ball)) for k in range(2))
    carry = sp.vstack([*blocks, sp.csr_matrix((2 * len(ball), len(cage)))]).tocsr()
    vertices = np.asarray(carry @ cage)
    for own, eye in zip(eyes, balls, strict=True):
        vertices[own] = eye[:3] + eye[3] * ball
    seen = ~np.logical_or.reduce(list(inside.values()))
    faces = {name: _triangles(quads[SKIN][np.tile(own, 4)]) for name, own in ({SKIN: seen} | inside).items()}
    faces |= {"eyes": np.vstack([triangles + eye[0] for eye in eyes])}
    faces |= {name: _triangles(quads[name]) for name in LEVELS if name != SKIN}
    parts, count = {}, 0
    for name, own in faces.items():
        parts[name] = np.arange(count, count + len(own))
        count += len(own)
    uv = np.asarray(carry @ cage_uv)
    uv[quads["teeth_upper"].min() :] = white
    mesh = TriangleMesh(rounded(vertices), np.vstack(list(faces.values())), uv, parts=parts)
    return RigHead(mesh, carry, eyes, balls[:, :3], float(balls[0, 3]))  # type: ignore[arg-type]


def unit_shapes(source: HeadSource, head: RigHead, names: tuple[str, ...]) -> FloatArray:
    """Return the displacements (n, N, 3) of face units on the rig, mm; eyes turn about their centres."""
    shapes = np.zeros((len(names), *head.mesh.vertices.shape))
    for shape, name in zip(shapes, names, strict=True):
        unit = source.unit(name)
        shape[:] = head.carry @ unit[source.used]
        for own, theirs, centre in zip(head.eyes, source.eye_vertices, head.centres, strict=True):
            shape[own] = _turned(source.positions[theirs], unit[theirs], head.mesh.vertices[own] - centre)
    return shapes


def arkit_names(source: HeadSource) -> tuple[str, ...]:
    """Return the names of the 52 face units, sorted."""
    return tuple(sorted(path.stem for path in (source.data / "faceunits01" / "targets" / "faceunits").glob("*.target")))


def mpfb_names(source: HeadSource) -> tuple[str, ...]:
    """Return the names of MPFB's 34 expression units, sorted."""
    folder = source.data / "mpfb2" / "targets" / "expression" / "units" / "caucasian"
    return tuple(sorted(path.name.removesuffix(".target.gz") for path in folder.glob("*.target.gz")))


def sculpted(head: RigHead, shapes: FloatArray, seed: int = SCULPT_SEED) -> FloatArray:
    """Return shapes (n, N, 3) re-sculpted: each plus a smooth random field of 30 % of its size, mm.

    Size is the RMS displacement over the skin. The field is a Gaussian random field of ``SCULPT_SCALE_MM``, under
    the unit's own amount of motion blurred in space, so that both sides of the lips and lids get the same of it. What
    it would press into an eyeball is slid out again.
    """
    rng = np.random.default_rng(seed)
    tissue = head.tissue
    seen = np.searchsorted(tissue, head.skin)
    points = head.mesh.vertices[tissue]
    blur, some = _blur(points)
    result = shapes.copy()
    for shape in result:
        reach = np.sqrt(blur @ (shape[tissue[some]] ** 2).sum(axis=1))
        field = smooth_field(points, rng, SCULPT_SCALE_MM) * reach[:, None]
        field *= SCULPT_SHARE * rms(shape[head.skin]) / rms(field[seen])
        shape[tissue] = _outside_eyes(head, points, shape[tissue], field)
    return rounded(result)


def smooth_field(points: FloatArray, rng: np.random.Generator, scale_mm: float, waves: int = 96) -> FloatArray:
    """Return a Gaussian random vector field (n, 3) over points (n, 3), by random Fourier features (Rahimi 2007)."""
    frequency = rng.standard_normal((waves, 3)) / scale_mm
    phase = rng.uniform(0, 2 * np.pi, waves)
    field: FloatArray = np.cos(points @ frequency.T + phase) @ rng.standard_normal((waves, 3)) * np.sqrt(2 / waves)
    return field


def rms(displacements: FloatArray) -> float:
    """Return the RMS length of displacements (..., 3), mm."""
    return float(np.sqrt((displacements**2).sum(axis=-1).mean()))


def eyeball() -> tuple[FloatArray, IntArray]:
    """Front of a unit eyeball with its cornea, looking along +Z: vertices (n, 3), triangles."""
    polar = np.linspace(0, 1, EYE_RINGS + 1)[1:] * np.deg2rad(EYE_SPAN_DEG)
    angle = np.arange(EYE_SPOKES) / EYE_SPOKES * 2 * np.pi
    radius, height = np.sin(polar)[:, None], np.cos(polar)[:, None]
    height = height + CORNEA_HEIGHT * np.exp(-((radius / CORNEA_WIDTH) ** 2)) * (height > 0)
    ring = np.stack(np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), height), axis=2).reshape(-1, 3)
    here = np.arange(EYE_SPOKES)
    after = (here + 1) % EYE_SPOKES
    triangles = [np.stack([np.zeros_like(here), 1 + here, 1 + after], axis=1)]
    for k in range(EYE_RINGS - 1):
        a, b = 1 + k * EYE_SPOKES, 1 + (k + 1) * EYE_SPOKES
        triangles += [np.stack([a + here, b + here, b + after], axis=1)]
        triangles += [np.stack([a + here, b + after, a + after], axis=1)]
    return np.vstack([[[0.0, 0.0, 1 + CORNEA_HEIGHT]], ring]), np.vstack(triangles)


def _blur(points: FloatArray) -> tuple[sp.csr_matrix, IntArray]:
    """Return what averages values at some of the points over ``SCULPT_REACH_MM`` in space (n, some), and which."""
    from scipy.spatial import cKDTree

    some = np.arange(0, len(points), 7)
    near = cKDTree(points).sparse_distance_matrix(cKDTree(points[some]), 3 * SCULPT_REACH_MM, output_type="coo_matrix")
    kernel = np.exp(-0.5 * (near.data / SCULPT_REACH_MM) ** 2)
    weight = sp.csr_matrix((kernel, (near.row, near.col)), near.shape)
    return sp.diags(1 / np.asarray(weight.sum(axis=1)).ravel()) @ weight, some


def _outside_eyes(head: RigHead, points: FloatArray, shape: FloatArray, field: FloatArray) -> FloatArray:
    moved = shape + field
    for centre in head.centres:
        away = points + moved - centre
        distance = np.linalg.norm(away, axis=1)
        before = np.linalg.norm(points + shape - centre, axis=1)
        least = np.minimum(before, head.radius * (1 + CORNEA_HEIGHT) + 0.6)
        inside = distance < least
        moved[inside] += (away * ((least - distance) / np.maximum(distance, 1e-9))[:, None])[inside]
    return moved


def _turned(rest: FloatArray, moved: FloatArray, eye: FloatArray) -> FloatArray:
    """Return how an eye (n, 3) about its centre moves: by the rotation of the source's eyeball."""
    from scipy.spatial.transform import Rotation

    if not moved.any():
        return np.zeros_like(eye)
    after = rest + moved
    turn, _ = Rotation.align_vectors(after - after.mean(axis=0), rest - rest.mean(axis=0))
    return np.asarray(turn.apply(eye) - eye)


def _inside(source: HeadSource, heads: Heads, cage: FloatArray) -> dict[str, BoolArray]:
    """Return which quads (Q,) of the skin's cage line the mouth, by the wheel's painted mask, and the eye sockets."""
    picture = source.mask("inside-mouth")
    tall, wide = picture.shape
    at = source.charts[source.chart_quads].mean(axis=1)
    painted = picture[
        np.clip((at[:, 1] * tall).astype(int), 0, tall - 1), np.clip((at[:, 0] * wide).astype(int), 0, wide - 1)
    ]
    middle = cage[heads._data["quads_skin"]].mean(axis=1)
    within = [np.linalg.norm(middle - eye[:3], axis=1) < eye[3] + SOCKET_MM for eye in heads.eyes("base")]
    sockets = np.logical_or(*within)
    return {"mouth": (painted > 0.5) & ~sockets, "sockets": sockets}


def _rim(quads: IntArray) -> IntArray:
    """Return the vertices on the border of quads (Q, 4), low on the neck."""
    sides = np.sort(np.vstack([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1)
    edges, uses = np.unique(sides, axis=0, return_counts=True)
    found: IntArray = np.unique(edges[uses == 1])
    return found


def _triangles(quads: IntArray) -> IntArray:
    return np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def rounded(values: FloatArray) -> FloatArray:
    """Return values in whole steps of ``STEP_MM``."""
    return np.round(values / STEP_MM) * STEP_MM
