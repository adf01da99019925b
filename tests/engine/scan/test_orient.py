"""The face of a mesh in any position: turned, cropped, noisy, uneven; and what is no face is not taken for one."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import resources
from engine.mesh import TriangleMesh
from engine.scan.face_relief import RELIEF, STEP_MM, TOP_MM
from engine.scan.orient import SURE, orient
from resources.sample.head import Heads

DATA = Path(__file__).resolve().parents[4] / "shared" / "data"


@lru_cache(maxsize=1)
def heads() -> Heads:
    return Heads.load(resources.sample_path("truth.npz"))


def head(name: str) -> tuple[TriangleMesh, np.ndarray]:
    """Return a head, mm, and its true turn, tilt and roll as the file stands, degrees (NaN where nobody knows it)."""
    if name == "ict":
        path = DATA / "rigs" / "ict_facekit.npz"
        if not path.is_file():
            pytest.skip("the ICT face kit is not here")
        stored = np.load(path)
        return TriangleMesh(stored["neutral"] * 10, stored["triangles"]), np.zeros(3)
    return TriangleMesh(heads().vertices(name), heads().faces), np.zeros(3)


def off(rotation: np.ndarray) -> np.ndarray:
    """Return yaw, pitch and roll (3,) in degrees by which a frame (rows left, up, forward) is off the axes."""
    _, up, forward = rotation
    return np.rad2deg([np.arctan2(forward[0], forward[2]), np.arcsin(forward[1]), np.arctan2(up[0], up[1])])


def changed(mesh: TriangleMesh, kind: str, rng: np.random.Generator) -> TriangleMesh:
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    low, high = np.percentile(middle, [5, 95], axis=0)
    if kind == "noise":
        return mesh.with_vertices(mesh.vertices + rng.normal(scale=0.4, size=mesh.vertices.shape))
    if kind == "uneven":
        return mesh.with_vertices(mesh.vertices * np.exp(rng.uniform(-0.08, 0.08, 3)))
    if kind == "neck":
        normal = np.array([rng.uniform(-0.4, 0.4), -1, -rng.uniform(0, 0.6)])
        kept = (middle - (low + high) / 2) @ (normal / np.linalg.norm(normal)) < 0.28 * (high - low)[1]
        return TriangleMesh(mesh.vertices, mesh.faces[kept])
    if kind == "side":
        normal = np.array([1, 0.3, -0.6]) / np.linalg.norm([1, 0.3, -0.6])
        kept = (middle - (low + high) / 2) @ normal < 0.25 * np.ptp(middle @ normal)
        return TriangleMesh(mesh.vertices, mesh.faces[kept])
    return mesh


@pytest.mark.parametrize(
    ("name", "kind"), [("ict", "neck"), ("base", "side"), ("stranger", "uneven"), ("too", "noise")]
)
def test_the_face_looks_forward_from_any_position(name: str, kind: str) -> None:
    rng = np.random.default_rng(sum(map(ord, name + kind)))
    mesh, _ = head(name)
    turn = Rotation.random(random_state=rng).as_matrix()
    shape = changed(mesh, kind, rng)
    found = orient(TriangleMesh(shape.vertices @ turn.T + rng.normal(scale=80, size=3), shape.faces))
    yaw, pitch, roll = off(found.rotation @ turn)
    assert abs(yaw) < 2 and abs(roll) < 2 and abs(pitch) < 8, (yaw, pitch, roll)
    assert found.confidence > SURE
    np.testing.assert_allclose(found.rotation @ found.rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(found.rotation) > 0


def test_the_middle_of_the_face_is_where_its_fiducials_are() -> None:
    mesh, _ = head("stranger")
    found = orient(mesh)
    points = mesh.vertices[list(heads().fiducials_of("stranger").values())]
    assert np.linalg.norm(found.face_centre - points.mean(axis=0)) < 15
    assert np.ptp(points[:, 1]) < found.face_height_mm < 2 * np.ptp(points[:, 1])


@pytest.mark.parametrize("kind", ["box", "egg"])
def test_what_is_no_face_is_not_trusted(kind: str) -> None:
    ball = trimesh.creation.icosphere(5)
    shape = {
        "egg": (ball.vertices * [75, 120, 95], ball.faces),
        "box": ((box := trimesh.creation.box((150, 220, 180)).subdivide().subdivide()).vertices, box.faces),
    }[kind]
    assert orient(TriangleMesh(*shape)).confidence < 0.35 < SURE


def test_the_relief_is_that_of_the_sample_heads() -> None:
    """Each value is the mean of both heads' front, both sides, within half a cell's slope."""
    fronts = []
    for name in ("base", "stranger"):
        mesh, _ = head(name)
        tip = mesh.vertices[heads().fiducials["nose_tip"]]
        from engine.scan.range_image import Camera
        from engine.scan.raster import rasterise

        far, columns, rows = 100_000.0, 2 * len(RELIEF[0]) - 1, len(RELIEF)
        camera = Camera(far / STEP_MM, far / STEP_MM, (columns - 1) / 2, TOP_MM / STEP_MM)
        seen = rasterise(mesh.with_vertices(mesh.vertices - tip - [0, 0, far]), camera, columns, rows, 5)
        depth = (seen.points[..., 2] + far).reshape(rows, 5, columns, 5)
        depth = np.nanmean(depth, axis=(1, 3))
        middle = columns // 2
        fronts.append((depth[:, middle:] + depth[:, middle::-1]) / 2)
    np.testing.assert_allclose(np.mean(fronts, axis=0), RELIEF, atol=1.0)
