"""What every motion reader returns, and what is checked and said about every motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.mesh import FloatArray
from engine.motion import MarkerClip, MeshMotion, WeightCurves, check_fps

MotionKind = Literal["markers", "weights", "dense"]

DEFAULT_FPS = 30.0
"""Frames a second of a file that does not say."""

MAX_FRAMES = 2_000_000
"""Most frames of a performance: four and a half hours at 120 Hz."""

_COMMON_RATES = (23.976, 24, 25, 29.97, 30, 48, 50, 59.94, 60, 90, 100, 119.88, 120, 150, 180, 200, 240, 250, 300, 500)


@dataclass(frozen=True)
class DenseClip:
    """Vertex positions of every frame, in the file's own numbers until they are asked for.

    Parameters
    ----------
    vertices : (L, N, 3) float
        As stored; may be memory-mapped, and is never copied as a whole.
    fps : float
        Frames a second.
    scale : float
        Millimetres in one of the file's units.
    axes : (3, 3) float, optional
        Rotation from the file's frame into ours (+Y up, +Z out of the face); None where they are the same.
    """

    vertices: NDArray[Any]
    fps: float
    scale: float = 1.0
    axes: FloatArray | None = None

    def __post_init__(self) -> None:
        if self.vertices.ndim != 3 or self.vertices.shape[2] != 3 or not self.vertices.size:
            raise InputError("motion", f"has shape {self.vertices.shape}", "give (frames, vertices, 3)")
        check_fps(self.fps)

    def __len__(self) -> int:
        return len(self.vertices)

    @property
    def count(self) -> int:
        """Number of vertices."""
        return int(self.vertices.shape[1])

    def read(self, start: int, stop: int) -> FloatArray:
        """Return positions (stop - start, N, 3) of frames in mm, in our frame."""
        positions = np.asarray(self.vertices[start:stop], dtype=np.float64)
        if self.axes is not None:
            positions = positions @ self.axes.T
        return positions * self.scale if self.scale != 1 else positions

    def motion(self, neutral: FloatArray) -> MeshMotion:
        """Return the motion of a mesh that rests at ``neutral`` (N, 3), mm.

        Raises
        ------
        InputError
            When the neutral face has another number of vertices.
        """
        if len(neutral) != self.count:
            problem = f"has {self.count} vertices, the rig {len(neutral)}"
            raise InputError("motion", problem, "choose a motion of the same topology")
        if self.scale == 1 and self.axes is None:
            return MeshMotion.dense(self.vertices, neutral, self.fps)
        return MeshMotion.streamed(self.read, len(self), neutral, self.fps)


@dataclass(frozen=True)
class MotionFile:
    """A performance as it was read, and what was taken for granted.

    Parameters
    ----------
    data : MarkerClip or WeightCurves or DenseClip
        Positions are in mm, +Y up, +Z out of the face.
    kind : {"markers", "weights", "dense"}
        Which of the three.
    format : str
        ``c3d``, ``trc``, ``marker csv``, ``live link``, ``weights csv``, ``glb``, ``pc2`` or ``npz``.
    unit : str
        The unit the file's numbers were taken in: ``mm``, ``cm``, ``m`` or a number of millimetres (``"85.3 mm"``);
        empty for weights.
    up, forward : str
        The file's axes that point up and out of the face: ``"y"``, ``"-z"``; empty for weights.
    assumed : str
        In words, where unit, axes and frame rate came from.
    guessed : tuple of str
        Which of ``unit``, ``up``, ``forward`` and ``fps`` nobody stated.
    source_files : tuple of Path
        All files that were read, the one the user named first.
    warnings : tuple of str
        What the user should look at: gaps, dropped frames, left out markers, unlikely sizes.
    gaps : int
        Positions (frames x markers) where a marker was not seen.
    dropped : int
        Frames that the file's time code skips.
    unseen : tuple of str
        Labels of markers that no frame shows; they are not in ``data``.
    """

    data: MarkerClip | WeightCurves | DenseClip
    kind: MotionKind
    format: str
    unit: str
    assumed: str
    source_files: tuple[Path, ...]
    up: str = "y"
    forward: str = "z"
    guessed: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    gaps: int = 0
    dropped: int = 0
    unseen: tuple[str, ...] = ()

    @property
    def fps(self) -> float:
        """Frames a second."""
        return self.data.fps


def choose_fps(subject: str, requested: float | None, named: float | None) -> tuple[float, str, bool]:
    """Return (frames a second, in words where they came from, whether they are a guess).

    Raises
    ------
    InputError
        When the rate that counts is no frame rate.
    """
    if requested is not None:
        return check_fps(requested), f"{requested:g} frames a second, as asked", False
    if named is None:
        return DEFAULT_FPS, f"{DEFAULT_FPS:g} frames a second assumed: the file names none", True
    if not (np.isfinite(named) and 0 < named <= 1e5):
        problem = f"names a frame rate of {named:g}"
        raise InputError(subject, problem, "state the frames a second (--fps), or correct the file")
    return float(named), f"{named:g} frames a second, as in the file", False


def settled_rate(measured: float, within: float) -> tuple[float, bool]:
    """Return the customary or whole rate within a share of a measured one, else that one; and whether it moved."""
    best = min(_COMMON_RATES, key=lambda rate: abs(rate / measured - 1))
    whole = float(np.rint(measured))
    if abs(whole / measured - 1) < min(1e-3, abs(best / measured - 1)):
        best = whole
    if abs(best / measured - 1) > within:
        return float(f"{measured:.9g}"), False
    return float(best), abs(best / measured - 1) > 1e-6


def rate_of_times(times: FloatArray) -> tuple[float | None, tuple[str, ...]]:
    """Return the frame rate that times (L,), s, tell, and what is odd about them; None where they do not go on.

    Steps above 1.5 of the usual one are gaps; those that turn back have no say.
    """
    steps = np.diff(times)
    forward = steps[steps > 0]
    if not len(forward):
        return None, ("the time stands still or turns back and is not used",) if len(steps) else ()
    usual = float(np.median(forward))
    even = forward[forward <= 1.5 * usual]
    mean = float(even.mean())
    jitter = float(np.abs(even / mean - 1).max()) / len(even)
    rate, snapped = settled_rate(1 / mean, max(1e-3, jitter))
    said = [f"the frame rate {rate:g} is near to what the time tells, {1 / mean:.6g}"] if snapped else []
    gaps, turns = int((steps > 1.5 * usual).sum()), int((steps <= 0).sum())
    if gaps:
        said.append(f"the time has {gaps} {'gap' if gaps == 1 else 'gaps'}: the clip is shorter than the performance")
    if turns:
        said.append(
            f"the time turns back {turns} {'time' if turns == 1 else 'times'}: several takes may be in one file"
        )
    return rate, tuple(said)


def nearest_rate(measured: float) -> float:
    """Return the customary frame rate within 1 % of a measured one, else the measured one to 4 digits."""
    rates = np.array(_COMMON_RATES, dtype=np.float64)
    off = np.abs(rates / measured - 1)
    if off.min() > 0.01:
        return float(f"{measured:.4g}")
    # 29.97 and 30 are nearer to each other than a clock is sure of: the round one, unless the other fits far better.
    near = rates[off <= max(5e-4, 1.05 * off.min())]
    whole = near[near == np.rint(near)]
    return float(whole[0] if len(whole) else rates[off.argmin()])
