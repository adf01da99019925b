"""Scans and meshes whose every number is known, and PLY files written by other code than ours."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from engine.mesh import TriangleMesh
from engine.scan.range_image import Camera, RangeImage

CAMERA = Camera(fx=60.0, fy=58.0, cx=15.2, cy=11.7)


def planted_scan(width: int = 32, height: int = 24, missing: bool = True, colour: bool = True) -> RangeImage:
    """A bump of 100 mm at about 650 mm, with a missing corner and a hole."""
    rng = np.random.default_rng(7)
    rows, columns = np.indices((height, width))
    depth = 650.0 - 40.0 * np.exp(-((rows - height / 2) ** 2 + (columns - width / 2) ** 2) / 60.0)
    depth += rng.normal(0, 0.5, depth.shape)
    if missing:
        depth[:4, :5] = np.nan
        depth[height // 2, width // 3] = np.nan
    picture = rng.integers(0, 256, (height, width, 3), dtype=np.uint8) if colour else None
    return RangeImage(CAMERA.points(depth), picture, CAMERA)


def ply_bytes(
    scan: RangeImage, encoding: str, form: str, kind: str = "float", factor: float = 1.0, upwards: bool = False
) -> bytes:
    """An organised PLY file (``form``: ``full`` or ``grid``) made vertex by vertex with ``struct``."""
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[encoding]
    points, colour = scan.points * factor, scan.colour
    if upwards:
        points, colour = points[::-1], None if colour is None else colour[::-1]
    valid = np.isfinite(points).all(axis=2).ravel()
    kept = np.flatnonzero(valid) if form == "grid" else np.arange(valid.size)
    lines = ["ply", f"format {encoding} 1.0", "comment planted", f"obj_info num_cols {scan.width}"]
    lines += [f"obj_info num_rows {scan.height}", f"element vertex {len(kept)}"]
    lines += [f"property {kind} {axis}" for axis in "xyz"]
    if colour is not None:
        lines += [f"property uchar {name}" for name in ("red", "green", "blue")]
    if form == "grid":
        lines += [f"element range_grid {valid.size}", "property list uchar int vertex_indices"]
    body = bytearray()
    for index in kept:
        xyz = [float(value) for value in points.reshape(-1, 3)[index]]
        rgb = [] if colour is None else [int(value) for value in colour.reshape(-1, 3)[index]]
        if order:
            body += struct.pack(order + ("fff" if kind == "float" else "ddd") + "B" * len(rgb), *xyz, *rgb)
        else:
            body += (" ".join([*(repr(value) for value in xyz), *map(str, rgb)]) + "\n").encode()
    if form == "grid":
        number = 0
        for there in valid:
            if order:
                body += struct.pack(order + "Bi", 1, number) if there else b"\0"
            else:
                body += f"1 {number}\n".encode() if there else b"0\n"
            number += int(there)
    return ("\n".join([*lines, "end_header"]) + "\n").encode() + bytes(body)


def write(path: Path, data: bytes) -> Path:
    """Write ``data`` and return ``path``."""
    path.write_bytes(data)
    return path


def seamed_mesh() -> tuple[TriangleMesh, np.ndarray]:
    """A strip of a cylinder closed on itself: its chart has a seam, so two columns of uv share their vertices."""
    around, rings = 12, 5
    angle = 2 * np.pi * np.arange(around) / around
    height = np.linspace(-30, 30, rings)
    vertices = np.array([(80 * np.sin(a), y, 80 * np.cos(a) - 600) for y in height for a in angle])
    normals = np.array([(np.sin(a), 0.0, np.cos(a)) for _ in height for a in angle])
    uv = np.array([((i + 0.5) / (around + 1), (r + 0.5) / rings) for r in range(rings) for i in range(around + 1)])
    faces, uv_faces = [], []
    for r in range(rings - 1):
        for i in range(around):
            a, b = r * around + i, r * around + (i + 1) % around
            ua, ub = r * (around + 1) + i, r * (around + 1) + i + 1
            faces += [(a, b, b + around), (a, b + around, a + around)]
            uv_faces += [(ua, ub, ub + around + 1), (ua, ub + around + 1, ua + around + 1)]
    return TriangleMesh(vertices, faces, uv, uv_faces), normals


def picture(width: int = 64, height: int = 48) -> np.ndarray:
    """A texture in which every pixel is different, so that a flip or a swap of channels is seen."""
    rows, columns = np.indices((height, width))
    return np.stack([4 * columns, 5 * rows, (columns + 2 * rows) % 200], axis=2).astype(np.uint8)
