"""The capture session: 66 + 7 markers on the performing head, recorded with noise and gaps, and the rigs beside it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from engine.files.atomic import atomic_write
from resources.sample.build import light, performance
from resources.sample.build.c3d_out import write_c3d
from resources.sample.build.layout import HEAD, place_markers
from resources.sample.build.rig_shapes import (
    HAND_A,
    RigHead,
    arkit_names,
    mpfb_names,
    rig_head,
    rounded,
    sculpted,
    unit_shapes,
)
from resources.sample.build.source import FloatArray, HeadSource, unpack_wheel
from resources.sample.head import Heads

FOLDER = "performance"
RIG_A, RIG_B, CLIP, PAIRS = "animator_24.npz", "mpfb_34.npz", "speech_emotion.c3d", "MARKERS.json"
LATE_SHARE = 0.15
"""RMS share of the performance that no unit explains."""
LATE_HERTZ = (4.2, 5.0)
LATE_SIZES = (1.0, 0.4)
"""How much of it swings sideways, and forward."""
NOISE_MM = 0.1
"""RMS distance of a marker from where it is."""
SCALE_MM = 0.02
GAPS = 16
_STILL_MM = 1e-6


@dataclass(frozen=True)
class Performance:
    """What was performed, before the cameras: displacements (6000, 66, 3) of the face markers in the head, mm.

    ``explained`` is what the face units do, ``late`` the soft tissue that no unit does.
    """

    labels: tuple[str, ...]
    vertices: tuple[int, ...]
    explained: FloatArray
    late: FloatArray


def build_performance(wheel: Path | None, out: Path, seed: int = performance.SEED) -> None:
    """Write rigs, clip and pairs into ``out/performance``; ``out/truth.npz`` must be there."""
    source = HeadSource(unpack_wheel(wheel))
    head = rig_head(source, Heads.load(out / "truth.npz"))
    names = arkit_names(source)
    units = unit_shapes(source, head, names)
    folder = out / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    _write_rig(folder / RIG_A, head, HAND_A, sculpted(head, units[[names.index(name) for name in HAND_A]]))
    _write_rig(folder / RIG_B, head, mpfb_names(source), unit_shapes(source, head, mpfb_names(source)))
    played = perform(head, names, units, seed)
    write_c3d(folder / CLIP, (*played.labels, *HEAD), record(head, played, seed), performance.FPS, SCALE_MM)
    pairs = [
        {"name": label, "source": label, "target": vertex}
        for label, vertex in zip(played.labels, played.vertices, strict=True)
    ]
    (folder / PAIRS).write_text(json.dumps({"pairs": pairs}, indent=1) + "\n")


def perform(head: RigHead, names: tuple[str, ...], units: FloatArray, seed: int = performance.SEED) -> Performance:
    """Return the performance of the 52 ``units`` (n, N, 3), with ``LATE_SHARE`` of motion that is in none of them."""
    skin = head.skin
    normals = light.vertex_normals(head.mesh.vertices, head.mesh.faces)
    placed = place_markers(head.mesh.vertices[skin], normals[skin])
    face = skin[list(placed.values())]
    amounts = performance.weights(names, seed)
    explained = np.einsum("ln,nkc->lkc", amounts, units[:, face])
    late = _late(head.mesh.vertices[face], units[:, face], amounts[:, names.index("jawOpen")], seed)
    late *= LATE_SHARE / np.sqrt(1 - LATE_SHARE**2) * np.sqrt((explained**2).sum() / (late**2).sum())
    return Performance(tuple(placed), tuple(int(v) for v in face), explained, late)


def record(head: RigHead, played: Performance, seed: int = performance.SEED) -> FloatArray:
    """Return positions (6000, 73, 3) in mm as the cameras saw them: head moving, noise, gaps as NaN."""
    rng = np.random.default_rng(seed + 2)
    face, frame = head.mesh.vertices[list(played.vertices)], np.array(list(HEAD.values()))
    held = np.repeat(frame[None], performance.FRAMES, axis=0)
    positions = np.concatenate([face + played.explained + played.late, held], axis=1)
    turn, shift = performance.head_motion(seed)
    rotation = Rotation.from_rotvec(turn).as_matrix()
    pivot = np.array([0.0, -60.0, 0.0])
    positions = np.einsum("lij,lkj->lki", rotation, positions - pivot) + pivot + shift[:, None]
    positions += NOISE_MM / np.sqrt(3) * rng.standard_normal(positions.shape)
    for _ in range(GAPS):
        marker = rng.integers(positions.shape[1])
        start = rng.integers(200, performance.FRAMES - 200)
        length = rng.integers(4, 46)
        positions[start : start + length, marker] = np.nan
    return np.asarray(positions)


def _late(rest: FloatArray, units: FloatArray, jaw: FloatArray, seed: int) -> FloatArray:
    """Return how cheeks and jowls follow late (L, K, 3): sideways when the head turns, forward when jaw and head stop.

    Two smooth fields over the soft parts of the face, less what any combination of units can do at the markers; each
    swings as a damped spring.
    """
    x, y, _ = rest.T
    soft = np.exp(-(((np.abs(x) - 38) / 22) ** 2) - ((y + 18) / 30) ** 2)
    soft += 0.55 * np.exp(-((x / 30) ** 2) - ((y + 55) / 22) ** 2)
    fields = np.zeros((2, len(rest), 3))
    fields[0, :, 0] = fields[1, :, 2] = soft
    modes = fields.reshape(2, -1)
    span = units.reshape(len(units), -1)
    span = span[np.linalg.norm(span, axis=1) > _STILL_MM]
    axes, _ = np.linalg.qr(span.T)
    modes = modes - (modes @ axes) @ axes.T
    modes /= np.linalg.norm(modes, axis=1)[:, None]
    turn, _ = performance.head_motion(seed)
    shaken = np.gradient(np.gradient(turn, axis=0), axis=0)
    drives = np.stack([shaken[:, 1], 0.5 * shaken[:, 2] - np.gradient(np.gradient(jaw))], axis=1)
    late = performance.late_tissue(drives / drives.std(axis=0), LATE_HERTZ) * LATE_SIZES
    return np.asarray((late @ modes).reshape(len(late), *rest.shape))


def _write_rig(path: Path, head: RigHead, names: tuple[str, ...], shapes: FloatArray) -> None:
    mesh = head.mesh
    arrays = {
        "neutral": mesh.vertices.astype(np.float32),
        "faces": mesh.faces.astype(np.int32),
        "names": np.array(names),
        "displacements": rounded(shapes).astype(np.float32),
        "unit": np.array("mm"),
        "uv": np.asarray(mesh.uv).astype(np.float32),
        **{f"part_{name}": faces.astype(np.int32) for name, faces in mesh.parts.items()},
    }
    with atomic_write(path) as handle:
        np.savez_compressed(handle, allow_pickle=False, **arrays)
