"""Bakes studio light into vertex colours: occlusion and soft shadows by depth maps of splatted points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from resources.sample.build.source import FloatArray, IntArray

CELL_MM = 1.3
SKY = 140
SHADOW_RAYS = 18


@dataclass(frozen=True)
class Lamp:
    """A distant light: direction from the head, sRGB colour 0..1, strength, half-angle of its soft box in degrees."""

    direction: tuple[float, float, float]
    colour: tuple[float, float, float]
    strength: float
    softness_deg: float


LAMPS = (
    Lamp((-3.2, 2.8, 6.4), (1.0, 0.96, 0.918), 0.79, 14.0),
    Lamp((4.2, -0.2, 5.4), (0.812, 0.878, 1.0), 0.37, 16.0),
    Lamp((0.0, -1.6, 7.4), (1.0, 0.949, 0.918), 0.22, 0.0),
    Lamp((3.6, 2.0, -5.6), (0.918, 0.957, 1.0), 0.55, 0.0),
    Lamp((-4.2, 1.0, -5.1), (1.0, 0.957, 0.918), 0.42, 0.0),
)
AMBIENT = 0.14
# Light seeps sideways through skin, red furthest: each channel's shading wraps round by so much.
WRAP = np.array([0.28, 0.14, 0.10])


@dataclass(frozen=True)
class Gloss:
    """How a surface shines, per vertex: strength (n,) and Blinn's exponent (n,); and how much light wraps, 0..1."""

    strength: FloatArray
    power: FloatArray
    wrap: FloatArray


def vertex_normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return area-weighted unit normals (n, 3)."""
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(vertices)
    for k in range(3):
        for axis in range(3):
            total[:, axis] += np.bincount(faces[:, k], normal[:, axis], len(vertices))
    unit: FloatArray = total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)
    return unit


class DepthMaps:
    """Tells which points of a surface see the sky in a direction."""

    def __init__(self, vertices: FloatArray, faces: IntArray, normals: FloatArray) -> None:
        self.vertices, self.normals = vertices, normals
        self._splats = np.vstack([vertices, vertices[faces].mean(axis=1)])
        self._low = self._splats.mean(axis=0)

    def open_to(self, direction: FloatArray) -> FloatArray:
        """Return how much (n,), 0..1, the vertices see of a unit direction (3,)."""
        helper = np.array([0.0, 1.0, 0.0]) if abs(direction[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
        side = np.cross(direction, helper)
        side /= np.linalg.norm(side)
        frame = np.stack([side, np.cross(side, direction), direction], axis=1)
        splats = (self._splats - self._low) @ frame
        cell = np.floor(splats[:, :2] / CELL_MM).astype(np.int64)
        cell -= cell.min(axis=0)
        size = cell.max(axis=0) + 1
        index = cell[:, 0] * size[1] + cell[:, 1]
        nearest = np.full(size[0] * size[1], -np.inf)
        np.maximum.at(nearest, index, splats[:, 2])
        count = len(self.vertices)
        cosine = np.clip(self.normals @ direction, 0.02, 1)
        slack = 0.7 + CELL_MM * np.minimum(np.sqrt(1 - cosine**2) / cosine, 4.0)
        behind = nearest[index[:count]] - splats[:count, 2] - slack
        visible: FloatArray = np.clip(1 - behind / 1.2, 0, 1)
        return visible


def ambient_occlusion(maps: DepthMaps) -> FloatArray:
    """Return the cosine-weighted share (n,) of a sky, brighter above, that each vertex sees."""
    k = np.arange(SKY) + 0.5
    polar, turn = np.arccos(1 - 2 * k / SKY), np.pi * (1 + 5**0.5) * k
    directions = np.stack([np.cos(turn) * np.sin(polar), np.cos(polar), np.sin(turn) * np.sin(polar)], axis=1)
    seen, possible = np.zeros(len(maps.vertices)), np.full(len(maps.vertices), 1e-9)
    for direction in directions[directions[:, 2] > -0.6]:
        weight = np.clip(maps.normals @ direction, 0, 1) * (0.75 + 0.25 * direction[1])
        seen += weight * maps.open_to(direction)
        possible += weight
    share: FloatArray = np.clip(seen / possible, 0, 1)
    return share


def shade(maps: DepthMaps, occlusion: FloatArray, albedo: FloatArray, gloss: Gloss, view: FloatArray) -> FloatArray:
    """Return lit sRGB colours (n, 3), not clipped, of vertices with an albedo (n, 3), seen from ``view`` (3,), mm."""
    normals = maps.normals
    to_eye = view - maps.vertices
    to_eye /= np.linalg.norm(to_eye, axis=1, keepdims=True)
    light = np.full_like(albedo, AMBIENT)
    shine = np.zeros_like(albedo)
    for lamp in LAMPS:
        wrap = gloss.wrap[:, None] * WRAP * (lamp.direction[2] > 0)
        direction = np.array(lamp.direction) / np.linalg.norm(lamp.direction)
        open_to = _soft_shadow(maps, direction, lamp.softness_deg)[:, None]
        cosine = (normals @ direction)[:, None]
        lambert = np.clip((cosine + wrap) / (1 + wrap), 0, 1)
        light += 0.92 * lamp.strength * np.array(lamp.colour) * lambert * (0.25 + 0.75 * open_to)
        half = direction + to_eye
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        facing = np.clip(np.einsum("ni,ni->n", normals, half), 0, 1) ** gloss.power * gloss.strength
        shine += (facing * np.clip(4 * cosine[:, 0], 0, 1))[:, None] * lamp.strength * np.array(lamp.colour) * open_to
    dark = 1 - 0.86 * (1 - np.clip(occlusion * 1.16, 0, 1) ** 1.15)
    tint = np.stack([dark**0.78, dark, dark**1.06], axis=1)
    return albedo * light * tint + 255 * shine * tint


def _soft_shadow(maps: DepthMaps, direction: FloatArray, softness_deg: float) -> FloatArray:
    if softness_deg == 0:
        return np.ones(len(maps.vertices))
    helper = np.cross(direction, [0.0, 1.0, 0.0])
    helper /= np.linalg.norm(helper)
    other = np.cross(direction, helper)
    k = np.arange(SHADOW_RAYS) + 0.5
    radius, turn = np.sqrt(k / SHADOW_RAYS) * np.tan(np.deg2rad(softness_deg)), np.pi * (1 + 5**0.5) * k
    rays = direction + radius[:, None] * (np.cos(turn)[:, None] * helper + np.sin(turn)[:, None] * other)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    share: FloatArray = np.mean([maps.open_to(ray) for ray in rays], axis=0)
    return share
