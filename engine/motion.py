"""Performances: marker clips, weight curves, and the mesh motion that both become."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.curve_names import match_curves
from engine.errors import InputError, some
from engine.mesh import BoolArray, FloatArray, IntArray, frozen
from engine.shapes import ExpressionBasis, check_names

Reader = Callable[[int, int], FloatArray]
"""``read(start, stop)`` returns the vertex positions (stop - start, N, 3) of frames, mm."""
Kind = Literal["dense", "factored", "driven", "streamed"]
CHUNK_BYTES = 64 << 20


@dataclass(frozen=True)
class MarkerClip:
    """Recorded markers.

    Parameters
    ----------
    labels : sequence of str
        One per marker, none twice.
    positions : (L, K, 3) float
        mm, +Y up, +Z out of the face; NaN where a marker was not seen.
    fps : float
        Frames a second.
    """

    labels: tuple[str, ...]
    positions: FloatArray
    fps: float

    def __post_init__(self) -> None:
        positions, labels = frozen(self.positions, np.float64), tuple(str(label) for label in self.labels)
        if positions.ndim != 3 or positions.shape[2] != 3:
            raise InputError("markers", f"have shape {positions.shape}", "give (frames, markers, 3)")
        check_names(labels, positions.shape[1])
        if np.isinf(positions).any():
            raise InputError("markers", "hold infinite positions", "export them again; a gap is NaN")
        check_fps(self.fps)
        object.__setattr__(self, "labels", labels)
        object.__setattr__(self, "positions", positions)

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def seen(self) -> BoolArray:
        """(L, K) bool: where a marker was seen."""
        seen: BoolArray = np.asarray(np.isfinite(self.positions).all(axis=2), dtype=bool)
        return seen


@dataclass(frozen=True)
class WeightCurves:
    """A weight per shape and frame.

    Parameters
    ----------
    names : sequence of str
        Names of the shapes, none twice.
    weights : (L, n) float
        Finite.
    fps : float
        Frames a second.
    """

    names: tuple[str, ...]
    weights: FloatArray
    fps: float

    def __post_init__(self) -> None:
        weights, names = frozen(self.weights, np.float64), tuple(str(name) for name in self.names)
        if weights.ndim != 2:
            raise InputError("weights", f"have shape {weights.shape}", "give (frames, shapes)")
        check_names(names, weights.shape[1])
        if not np.isfinite(weights).all():
            raise InputError("weights", "hold numbers that are not finite", "export them again")
        check_fps(self.fps)
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "weights", weights)

    def __len__(self) -> int:
        return len(self.weights)


@dataclass(frozen=True)
class MeshMotion:
    """The motion of a mesh, kept in the smallest form that gives every frame exactly; never 3N x L unless it came so.

    Make one with `dense`, `factored`, `driven` or `streamed`. All displacements are from ``neutral``, mm.

    Attributes
    ----------
    kind : {"dense", "factored", "driven", "streamed"}
        ``dense``: ``vertices`` (L, N, 3) positions. ``factored``: ``phi`` (N, K) and ``markers`` (L, K, 3), so that
        ``d(t) = (phi (x) I3) markers(t)`` (Kim & Ko 2007, section 5.2: linear in the markers). ``driven``: ``basis``
        and ``weights`` (L, n), ``d(t) = mean + sum w_i(t) displacements_i``. ``streamed``: ``read`` gives chunks.
    neutral : (N, 3) float
        mm.
    fps : float
        Frames a second.
    length : int
        Number of frames.
    start : int
        Which frame of the whole clip the first one of a dense or streamed motion is.
    """

    kind: Kind
    neutral: FloatArray
    fps: float
    length: int
    vertices: FloatArray | None = None
    phi: FloatArray | None = None
    markers: FloatArray | None = None
    basis: ExpressionBasis | None = None
    weights: FloatArray | None = None
    read: Reader | None = None
    start: int = 0

    @classmethod
    def dense(cls, vertices: FloatArray, neutral: FloatArray, fps: float) -> MeshMotion:
        """Return the motion of positions (L, N, 3), mm; float32 and memory-mapped arrays are kept as they are."""
        neutral = _neutral(neutral)
        if vertices.ndim != 3 or vertices.shape[1:] != neutral.shape:
            problem = f"has shape {vertices.shape} for {len(neutral)} vertices"
            raise InputError("motion", problem, "give (frames, vertices, 3) of one topology")
        return cls("dense", neutral, check_fps(fps), _some_frames(len(vertices)), vertices=vertices)

    @classmethod
    def factored(cls, phi: FloatArray, markers: FloatArray, neutral: FloatArray, fps: float) -> MeshMotion:
        """Return the motion that ``phi`` (N, K) spreads from marker displacements (L, K, 3), mm."""
        neutral, phi, markers = _neutral(neutral), frozen(phi, np.float64), frozen(markers, np.float64)
        if phi.ndim != 2 or len(phi) != len(neutral):
            problem = f"has shape {phi.shape} for {len(neutral)} vertices"
            raise InputError("phi", problem, "give one row a vertex, one column a marker")
        if markers.ndim != 3 or markers.shape[1:] != (phi.shape[1], 3):
            problem = f"have shape {markers.shape} for {phi.shape[1]} markers"
            raise InputError("markers", problem, "give displacements (frames, markers, 3)")
        if not (np.isfinite(phi).all() and np.isfinite(markers).all()):
            raise InputError("markers", "hold numbers that are not finite", "fill the gaps first")
        return cls("factored", neutral, check_fps(fps), _some_frames(len(markers)), phi=phi, markers=markers)

    @classmethod
    def driven(cls, basis: ExpressionBasis, weights: FloatArray, fps: float) -> MeshMotion:
        """Return the motion of a rig under weights (L, n)."""
        weights = frozen(weights, np.float64)
        if weights.ndim != 2 or weights.shape[1] != len(basis):
            problem = f"have shape {weights.shape} for {len(basis)} shapes"
            raise InputError("weights", problem, "give (frames, shapes)")
        if not np.isfinite(weights).all():
            raise InputError("weights", "hold numbers that are not finite", "export them again")
        length = _some_frames(len(weights))
        return cls("driven", basis.neutral, check_fps(fps), length, basis=basis, weights=weights)

    @classmethod
    def streamed(cls, read: Reader, length: int, neutral: FloatArray, fps: float) -> MeshMotion:
        """Return a motion whose positions ``read(start, stop)`` gives chunk by chunk, mm."""
        return cls("streamed", _neutral(neutral), check_fps(fps), _some_frames(length), read=read)

    def __len__(self) -> int:
        return self.length

    def displacements(self, start: int, stop: int, vertices: IntArray | None = None) -> FloatArray:
        """Return displacements (stop - start, V, 3) of frames, mm; of all vertices, or of those given."""
        if not 0 <= start <= stop <= self.length:
            raise InputError("frames", f"{start} to {stop} of {self.length}", "ask for frames that are there")
        at: IntArray | slice = slice(None) if vertices is None else vertices
        if self.kind == "factored" and self.phi is not None and self.markers is not None:
            phi, markers = self.phi[at], self.markers[start:stop]
            spread = phi @ markers.transpose(1, 0, 2).reshape(phi.shape[1], -1)
            return np.ascontiguousarray(spread.reshape(len(phi), stop - start, 3).transpose(1, 0, 2))
        if self.kind == "driven" and self.basis is not None and self.weights is not None:
            shapes = self.basis.displacements[:, at]
            moved = self.weights[start:stop] @ shapes.reshape(len(self.basis), -1)
            found = moved.reshape(stop - start, *shapes.shape[1:])
            return found if self.basis.mean is None else found + self.basis.mean[at]
        positions = self.positions(start, stop)[:, at]
        return np.asarray(positions, dtype=np.float64) - self.neutral[at]

    def positions(self, start: int, stop: int, checked: bool = True) -> NDArray[Any]:
        """Return the positions (stop - start, N, 3) of frames, mm, in the precision that the motion is kept in.

        Those of a dense motion are a view and not copied; what was ``checked`` once need not be again.

        Raises
        ------
        InputError
            With the first frame that holds numbers that are not finite; when frames are not there, or a reader gives
            other ones than it was asked for.
        """
        if not 0 <= start <= stop <= self.length:
            raise InputError("frames", f"{start} to {stop} of {self.length}", "ask for frames that are there")
        if self.vertices is not None:
            found: NDArray[Any] = np.asarray(self.vertices[start:stop])
        elif self.read is not None:
            found = np.asarray(self.read(self.start + start, self.start + stop))
            wanted = (stop - start, *self.neutral.shape)
            if found.shape != wanted:
                raise InputError("motion", f"gives frames of shape {found.shape}, not {wanted}", "export it again")
        else:
            return self.neutral + self.displacements(start, stop)
        if checked:
            self._check_finite(found, start)
        return found

    def _check_finite(self, positions: NDArray[Any], start: int) -> None:
        with np.errstate(all="ignore"):
            if np.isfinite(positions.sum()):
                return
        whole = np.isfinite(positions).all(axis=(1, 2))
        if not whole.all():
            frame = self.start + start + int(np.argmin(whole))
            raise InputError(f"motion, frame {frame + 1}", "holds positions that are not finite", "export it again")

    def frame(self, index: int) -> FloatArray:
        """Return the positions (N, 3) of one frame, mm."""
        placed: FloatArray = self.neutral + self.displacements(index, index + 1)[0]
        return placed

    def chunks(self, vertices: IntArray | None = None, largest: int = CHUNK_BYTES) -> Iterator[tuple[int, FloatArray]]:
        """Yield ``(start, displacements)`` over all frames, in pieces of at most ``largest`` bytes or one frame."""
        # A reader gives whole frames, however few of their vertices are wanted.
        count = len(self.neutral) if vertices is None or self.kind == "streamed" else len(vertices)
        step = max(1, largest // max(1, 24 * count))
        for start in range(0, self.length, step):
            yield start, self.displacements(start, min(start + step, self.length), vertices)

    def slice(self, start: int, stop: int) -> MeshMotion:
        """Return frames ``start`` to ``stop`` (not included) as a motion of their own, without copying them.

        Raises
        ------
        InputError
            When the range is empty or leaves the motion.
        """
        if not 0 <= start < stop <= self.length:
            problem = f"{start}:{stop} does not lie in 0:{self.length}"
            raise InputError("frame range", problem, "choose frames of the motion")
        first = self.start + start
        if self.kind == "dense" and self.vertices is not None:
            vertices = self.vertices[start:stop]
            return MeshMotion("dense", self.neutral, self.fps, stop - start, vertices=vertices, start=first)
        if self.kind == "factored" and self.markers is not None:
            markers = self.markers[start:stop]
            return MeshMotion("factored", self.neutral, self.fps, stop - start, phi=self.phi, markers=markers)
        if self.kind == "driven" and self.weights is not None:
            weights = self.weights[start:stop]
            return MeshMotion("driven", self.neutral, self.fps, stop - start, basis=self.basis, weights=weights)
        return MeshMotion("streamed", self.neutral, self.fps, stop - start, read=self.read, start=first)


def driven_by(basis: ExpressionBasis, curves: WeightCurves) -> tuple[MeshMotion, tuple[str, ...], tuple[str, ...]]:
    """Return the motion of a rig under curves of its shapes' names.

    Returns
    -------
    motion, unused, resting
        Curves that no shape has (head and eye rotations of a phone, for instance), and shapes without a curve.

    Raises
    ------
    InputError
        When no curve drives any shape (``curve_names.match_curves``).
    """
    found = match_curves(curves.names, basis.names)
    resting = tuple(name for name, sources in zip(basis.names, found, strict=True) if not sources)
    if len(resting) == len(basis):
        problem = f"none of its curves ({some(curves.names, 3)}) has the name of a shape ({some(basis.names, 3)})"
        raise InputError("motion", problem, "choose the rig that these curves drive")
    weights = np.zeros((len(curves), len(basis)))
    for i, sources in enumerate(found):
        if sources:
            weights[:, i] = curves.weights[:, sources].mean(axis=1)
    used = {k for sources in found for k in sources}
    unused = tuple(name for k, name in enumerate(curves.names) if k not in used)
    return MeshMotion.driven(basis, weights, curves.fps), unused, resting


def check_fps(fps: float) -> float:
    """Return ``fps`` when it is a frame rate: finite, above 0, at most 100,000."""
    if not (np.isfinite(fps) and 0 < fps <= 1e5):
        raise InputError("frame rate", f"is {fps:g}", "give the frames a second")
    return float(fps)


def _neutral(neutral: FloatArray) -> FloatArray:
    found = frozen(neutral, np.float64)
    if found.ndim != 2 or found.shape[1] != 3 or not np.isfinite(found).all():
        raise InputError("neutral", f"has shape {found.shape} or is not finite", "give a finite position a vertex")
    return found


def _some_frames(length: int) -> int:
    if length < 1:
        raise InputError("motion", "has no frames", "choose another clip or range")
    return length
