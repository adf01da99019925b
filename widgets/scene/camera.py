"""Standard views of a face, and how a hand turns, shifts and nears it. All in mm, +Y up, +Z out of the face."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

VIEWS: dict[str, tuple[float, float, float]] = {
    "three_quarter": (-0.52, 0.10, 1.0),
    "front": (0.0, 0.0, 1.0),
    "left": (1.0, 0.0, 0.0),
    "right": (-1.0, 0.0, 0.0),
    "three_quarter_left": (0.52, 0.10, 1.0),
    "back": (0.0, 0.0, -1.0),
    "top": (0.0, 1.0, 0.0),
    "bottom": (0.0, -1.0, 0.0),
    "below": (0.0, -0.75, 1.0),
}
"""Where the camera stands, seen from the face; left is the subject's left (+X)."""

ANGLE_DEG = 20.0
"""Vertical opening of the camera: long enough a lens for a portrait."""

_STEEPEST = np.radians(88.0)
_STANDS_OFF_MM = 3000.0
"""How far an orthographic camera stands from what it looks at: in front of every head, whatever it shows."""


def look(
    camera: Any, points: FloatArray, view: str, aspect: float = 1.0, margin: float = 1.12, lift: float = 0.0
) -> None:
    """Place a camera at a standard view so that points just fill the picture.

    Parameters
    ----------
    camera : vtkCamera
    points : (N, 3) float
        What must be seen, mm: vertices, or the corners of a box.
    view : str
        A name in ``VIEWS``.
    aspect : float
        Width over height of the picture.
    margin : float
        Room around the points; 1 touches the edges.
    lift : float
        How far above the middle they stand, in parts of the picture's height.
    """
    frame(camera, points, np.array(VIEWS[view]), aspect, margin, lift)


def frame(
    camera: Any, points: FloatArray, direction: FloatArray, aspect: float, margin: float = 1.12, lift: float = 0.0
) -> None:
    """Bring points (N, 3), mm, into the picture, seen from ``direction`` (towards the camera); see ``look``."""
    back = direction / np.linalg.norm(direction)
    up = _upright(back)
    right = np.cross(up, back)
    points = np.asarray(points, dtype=np.float64)
    across, upward, near = points @ right, points @ up, points @ back
    high = np.tan(np.radians(ANGLE_DEG) / 2.0) / margin
    wide = high * aspect
    # Perspective shows near points larger: put the middle of what is seen, not of what there is, into the middle.
    x, y, z = 0.5 * (across.min() + across.max()), 0.5 * (upward.min() + upward.max()), float(near.mean())
    distance = 1.0
    for _ in range(4):
        distance = float(max((np.abs(across - x) / wide + near).max(), (np.abs(upward - y) / high + near).max())) - z
        depth = distance + z - near
        x += _uneven((across - x) / depth) * distance
        y += _uneven((upward - y) / depth) * distance
    if camera.GetParallelProjection():
        x, y = 0.5 * (across.min() + across.max()), 0.5 * (upward.min() + upward.max())
        distance = float(max(np.abs(across - x).max() / wide, np.abs(upward - y).max() / high))
    distance = max(distance, 8.0)
    y -= lift * 2.0 * distance * np.tan(np.radians(ANGLE_DEG) / 2.0)
    place(camera, x * right + y * up + z * back, back, distance)


def place(camera: Any, focus: FloatArray, back: FloatArray, distance: float) -> None:
    """Let a camera look at ``focus`` (mm) against ``back``, at a distance in mm that says how large things are.

    An orthographic camera shows what lies at its focus as large as the other does from this distance.
    """
    camera.SetViewAngle(ANGLE_DEG)
    camera.SetFocalPoint(*focus)
    camera.SetViewUp(*_upright(back))
    if camera.GetParallelProjection():
        camera.SetParallelScale(distance * np.tan(np.radians(ANGLE_DEG) / 2.0))
        distance = _STANDS_OFF_MM
    camera.SetPosition(*(focus + back * distance))


def distance_of(camera: Any) -> float:
    """Return the distance in mm from which a perspective camera shows its focus as large as this one does."""
    if camera.GetParallelProjection():
        return float(camera.GetParallelScale() / np.tan(np.radians(camera.GetViewAngle()) / 2.0))
    return float(np.linalg.norm(np.array(camera.GetPosition()) - np.array(camera.GetFocalPoint())))


def set_orthographic(camera: Any, on: bool) -> None:
    """Draw without perspective, or with it; what lies at the focus keeps its size."""
    back, away = axes(camera)[0], distance_of(camera)
    camera.SetParallelProjection(on)
    place(camera, np.array(camera.GetFocalPoint()), back, away)


def set_focus(camera: Any, point: FloatArray) -> None:
    """Move the focus along the line of sight to the depth of ``point`` (mm); the picture stays as it is."""
    position, focal = np.array(camera.GetPosition()), np.array(camera.GetFocalPoint())
    back = axes(camera)[0]
    depth = float((focal - np.asarray(point)) @ back)
    if camera.GetParallelProjection():
        camera.SetPosition(*(position - depth * back))
    elif float((position - focal) @ back) + depth < 8.0:
        return
    camera.SetFocalPoint(*(focal - depth * back))


def corners(box: Sequence[float]) -> FloatArray:
    """Return the eight corners (8, 3) of a box of x, y, z ranges."""
    ranges = np.array(box, dtype=np.float64).reshape(3, 2)
    return np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, 3)


def orbit(camera: Any, pivot: FloatArray, yaw: float, pitch: float) -> None:
    """Turn a camera around ``pivot`` (mm) by yaw and pitch (radians): terrain-like, the horizon stays level."""
    position, focal = np.array(camera.GetPosition()), np.array(camera.GetFocalPoint())
    back = (position - focal) / np.linalg.norm(position - focal)
    height = float(np.arcsin(np.clip(back[1], -1.0, 1.0)))
    pitch = float(np.clip(height + pitch, -_STEEPEST, _STEEPEST)) - height
    right = np.cross(np.array([0.0, 1.0, 0.0]), back)
    right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-9 else np.array([1.0, 0.0, 0.0])
    turn = _rotation(np.array([0.0, 1.0, 0.0]), yaw) @ _rotation(right, -pitch)
    camera.SetPosition(*(pivot + turn @ (position - pivot)))
    camera.SetFocalPoint(*(pivot + turn @ (focal - pivot)))
    camera.SetViewUp(*_upright(turn @ back))


def pan(camera: Any, dx: float, dy: float, depth_at: FloatArray, height: float) -> None:
    """Shift a camera by (dx, dy) pixels, +Y up, of a picture ``height`` high; ``depth_at`` (mm) follows the hand."""
    position, focal = np.array(camera.GetPosition()), np.array(camera.GetFocalPoint())
    back, right, up = axes(camera)
    if camera.GetParallelProjection():
        scale = 2.0 * camera.GetParallelScale() / height
    else:
        depth = max(float((position - depth_at) @ back), 1.0)
        scale = 2.0 * depth * np.tan(np.radians(camera.GetViewAngle()) / 2.0) / height
    shift = -scale * (dx * right + dy * up)
    camera.SetPosition(*(position + shift))
    camera.SetFocalPoint(*(focal + shift))


def zoom(camera: Any, factor: float, target: FloatArray) -> None:
    """Near ``target`` (mm) by ``factor`` > 1, or leave it; the target keeps its place in the picture."""
    position, focal = np.array(camera.GetPosition()), np.array(camera.GetFocalPoint())
    if camera.GetParallelProjection():
        away = distance_of(camera)
        factor = float(np.clip(factor, away / 20_000.0, max(away / 8.0, 1e-9)))
        back = axes(camera)[0]
        sideways = (target - focal) - float((target - focal) @ back) * back
        shift = (1.0 - 1.0 / factor) * sideways
        camera.SetParallelScale(camera.GetParallelScale() / factor)
        camera.SetPosition(*(position + shift))
        camera.SetFocalPoint(*(focal + shift))
        return
    away = float(np.linalg.norm(position - target))
    factor = float(np.clip(factor, away / 20_000.0, away / 8.0)) if away > 8.0 else min(factor, 1.0)
    camera.SetPosition(*(target + (position - target) / factor))
    camera.SetFocalPoint(*(target + (focal - target) / factor))


def axes(camera: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the unit vectors towards the camera, to the right and up in the picture."""
    back = np.array(camera.GetPosition()) - np.array(camera.GetFocalPoint())
    back /= np.linalg.norm(back)
    right = np.cross(np.array(camera.GetViewUp()), back)
    right /= np.linalg.norm(right)
    return back, right, np.cross(back, right)


def ray(camera: Any, x: float, y: float, width: float, height: float) -> tuple[FloatArray, FloatArray]:
    """Return the segment in mm that is seen at pixel (x, y), origin bottom left, of a picture width x height."""
    position = np.array(camera.GetPosition())
    back, right, up = axes(camera)
    near, far = camera.GetClippingRange()
    if camera.GetParallelProjection():
        scale = camera.GetParallelScale()
        start = position + scale * ((2.0 * x - width) / height * right + (2.0 * y / height - 1.0) * up)
        return start - near * back, start - far * back
    tangent = np.tan(np.radians(camera.GetViewAngle()) / 2.0)
    across = (2.0 * x / width - 1.0) * tangent * width / height
    upward = (2.0 * y / height - 1.0) * tangent
    direction = -back + across * right + upward * up
    return position + near * direction, position + far * direction


def on_plane(camera: Any, segment: tuple[FloatArray, FloatArray], through: FloatArray) -> FloatArray:
    """Return where a segment crosses the plane through a point (mm) that faces the camera."""
    back = axes(camera)[0]
    start, direction = segment[0], segment[1] - segment[0]
    return np.asarray(start + direction * float((through - start) @ back) / float(direction @ back))


def project(camera: Any, points: FloatArray, width: float, height: float) -> FloatArray:
    """Return pixel positions (k, 2), origin bottom left, of points (k, 3) mm in a picture width x height."""
    back, right, up = axes(camera)
    offset = np.asarray(points, dtype=np.float64) - np.array(camera.GetPosition())
    if camera.GetParallelProjection():
        scale = np.full(len(offset), height / (2.0 * camera.GetParallelScale()))
    else:
        scale = height / (-2.0 * (offset @ back) * np.tan(np.radians(camera.GetViewAngle()) / 2.0))
    return np.stack([width / 2.0 + scale * (offset @ right), height / 2.0 + scale * (offset @ up)], axis=-1)


def clip(camera: Any, bounds: Sequence[float]) -> None:
    """Set the near and far plane around a box (x, y, z ranges, mm)."""
    box = np.array(bounds, dtype=np.float64).reshape(3, 2)
    centre, radius = box.mean(axis=1), 0.5 * float(np.linalg.norm(box[:, 1] - box[:, 0])) + 1.0
    depth = float((np.array(camera.GetPosition()) - centre) @ axes(camera)[0])
    near = max(depth - radius, 1.0, 0.002 * (depth + radius))
    camera.SetClippingRange(near, max(depth + radius, near + 10.0))


def eye_of(camera: Any, point: FloatArray) -> FloatArray:
    """Return the place in mm that ``point`` (mm) is seen from; without perspective that is straight before it."""
    if not camera.GetParallelProjection():
        return np.array(camera.GetPosition())
    return np.asarray(point + _STANDS_OFF_MM * axes(camera)[0])


def _uneven(slopes: FloatArray) -> float:
    return 0.5 * float(slopes.min() + slopes.max())


def _upright(back: FloatArray) -> FloatArray:
    up = np.array([0.0, 1.0, 0.0]) - back[1] * back
    if np.linalg.norm(up) > 1e-6:
        return np.asarray(up / np.linalg.norm(up))
    return np.array([0.0, 0.0, -np.sign(back[1])])  # as the horizon lies just before the camera stands upright


def _rotation(axis: FloatArray, angle: float) -> FloatArray:
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew)
