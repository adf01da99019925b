"""What the basis stage's views show, as values: a rig, a shape twice over, a frame and its reconstructions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.mesh import FloatArray, TriangleMesh
from widgets.scene.basis_rig import Pose, RigLook
from widgets.scene.basis_state import BY_HAND, BY_PCA, BY_QUASI, CHANGE, FRAME_VIEWS, HAND, QUASI, START_RANGE_MM
from widgets.scene.heatmap import HeatRange, share_above, share_text

Rms = tuple[float | None, ...]
"""RMS in mm of the reconstructions by hand, quasi-eigen and PCA shapes; None where it is not known."""
TITLES = ("Hand", "Quasi-eigen")
WHICH: Mapping[str, int] = {"hand": BY_HAND, "quasi_eigen": BY_QUASI, "pca": BY_PCA}
"""The view of a basis' reconstruction."""


class BasisContent:
    """Copies of everything that is shown; normals are worked out when a view first asks for them.

    Attributes
    ----------
    rig : RigLook or None
    name, note : str
        Of the shape.
    titles : (str, str)
        What its two forms are.
    index : int
        Frame, counted from 0.
    rms : mapping of int to float
        View of a reconstruction -> RMS in mm.
    change : (N,) float or None
        Length in mm of what quasi-eigen minus hand shape moves a vertex by; NaN off the skin.
    captured : (K, 3) float32 or None
        Seen markers in mm, NaN where not seen.
    rebuilt : mapping of int to (K, 3) float32
        View of a reconstruction -> its markers, mm.
    clip : mapping of int to (N,) float
        View of a reconstruction -> RMS in mm over the clip, NaN off the skin.
    frames : int
        Of the clip; 0 where it is not known.
    heat : HeatRange
        Range of the change.
    """

    def __init__(self) -> None:
        self.heat = HeatRange(*START_RANGE_MM)
        self._forget()

    def _forget(self) -> None:
        self.rig: RigLook | None = None
        self.name = self.note = ""
        self.titles = TITLES
        self.index = 0
        self.rms: dict[int, float] = {}
        self.change: FloatArray | None = None
        self.captured: NDArray[np.float32] | None = None
        self.rebuilt: dict[int, NDArray[np.float32]] = {}
        self.clip: dict[int, FloatArray] = {}
        self.frames = 0
        self._points: dict[int, NDArray[np.float32]] = {}
        self._poses: dict[int, Pose] = {}

    def set_rig(self, mesh: TriangleMesh | None, skin: NDArray[Any] | None, texture: NDArray[np.uint8] | None) -> None:
        """Take another rig; everything else is forgotten."""
        self._forget()
        self.rig = None if mesh is None else RigLook(mesh, skin, texture)

    def set_shape(
        self,
        name: str,
        hand: FloatArray | None,
        quasi: FloatArray | None,
        note: str = "",
        titles: tuple[str, str] = TITLES,
    ) -> None:
        """Take a shape by its displacements (N, 3) in mm; ``titles`` say what both are."""
        self.name, self.note, self.titles = name, note, titles
        self.change = None
        rest = None if self.rig is None else self.rig.neutral.points
        for view, displacements in ((HAND, hand), (QUASI, quasi)):
            self._put(view, None if displacements is None or rest is None else self._fits(displacements) + rest)
        if hand is not None and quasi is not None and self.rig is not None:
            self.change = self._on_skin(np.linalg.norm(np.asarray(quasi) - np.asarray(hand), axis=1))

    def set_frame(self, index: int, positions: tuple[FloatArray | None, ...], rms_mm: Rms) -> None:
        """Take a frame: original, by hand, by quasi-eigen and by PCA shapes (N, 3) in mm."""
        self.index = index
        for view, placed in zip(FRAME_VIEWS, positions, strict=True):
            self._put(view, None if placed is None or self.rig is None else self._fits(placed))
        views = FRAME_VIEWS[1 : 1 + len(rms_mm)]
        self.rms = {v: float(x) for v, x in zip(views, rms_mm, strict=True) if x is not None and np.isfinite(x)}

    def set_markers(self, captured: FloatArray | None, *rebuilt: FloatArray | None) -> None:
        """Take markers (K, 3) in mm and where reconstructions have them."""
        self.captured = None if captured is None else np.array(captured, dtype=np.float32).reshape(-1, 3)
        views = FRAME_VIEWS[1:]
        self.rebuilt = {
            v: np.array(places, dtype=np.float32).reshape(-1, 3)
            for v, places in zip(views, rebuilt, strict=False)
            if places is not None
        }
        wrong = [len(m) for m in self.rebuilt.values() if self.captured is not None and len(m) != len(self.captured)]
        if wrong:
            problem = f"are {wrong[0]}, captured ones are not as many"
            raise InputError("reconstructed markers", problem, "give one for each")

    def set_clip(self, rms_vertices: FloatArray | None, which: str, frames: int = 0) -> None:
        """Take the RMS (N,) in mm over the clip of a basis, or forget it; ``frames`` are those of the clip."""
        view, self.frames = WHICH[which], frames
        self.clip.pop(view, None)
        if rms_vertices is not None and self.rig is not None:
            self.clip[view] = self._on_skin(np.asarray(rms_vertices, dtype=np.float64))

    @property
    def clip_heat(self) -> HeatRange:
        """The one range of the errors over the clip, by what hand shapes leave where that is known."""
        values = self.clip.get(BY_HAND, next(iter(self.clip.values()), None))
        return HeatRange(0.0, 1.0) if values is None else error_range(values)

    def pose(self, view: int) -> Pose | None:
        """Return the pose a view shows, the same value until other data comes; None where there is none."""
        source = QUASI if view == CHANGE else view
        if source == QUASI and view == CHANGE and self.change is None:
            return None
        points = self._points.get(source)
        if points is None or self.rig is None:
            return None
        if source not in self._poses:
            self._poses[source] = self.rig.pose(points)
        return self._poses[source]

    def has(self, view: int) -> bool:
        """Return whether a view has anything to show."""
        return self.change is not None if view == CHANGE else view in self._points

    def _put(self, view: int, points: NDArray[np.float32] | None) -> None:
        before = self._points.get(view)
        if points is not None and before is not None and np.array_equal(points, before):
            return
        self._poses.pop(view, None)
        if points is None:
            self._points.pop(view, None)
        else:
            self._points[view] = points

    def _fits(self, array: FloatArray) -> NDArray[np.float32]:
        assert self.rig is not None
        if np.shape(array) != (self.rig.count, 3):
            problem = f"have shape {np.shape(array)} for a rig of {self.rig.count} vertices"
            raise InputError("positions", problem, "give those of the rig that is shown")
        return np.array(array, dtype=np.float32)

    def _on_skin(self, values: FloatArray) -> FloatArray:
        assert self.rig is not None
        if values.shape != (self.rig.count,):
            problem = f"have shape {values.shape} for a rig of {self.rig.count} vertices"
            raise InputError("values", problem, "give one a vertex")
        return np.where(self.rig.skin, values, np.nan)


def error_range(values: FloatArray) -> HeatRange:
    """Return a range for errors (N,) in mm, NaN where unknown: up to their 98th percentile, rounded up."""
    known = values[np.isfinite(values)]
    return HeatRange(0.0, rounded_up(float(np.percentile(known, 98)) if len(known) else 0.0))


def rounded_up(value: float) -> float:
    """Return the next step of a half of a power of ten, 1 for nothing."""
    if not value > 0:
        return 1.0
    step = 10.0 ** np.floor(np.log10(value)) / 2
    return float(np.ceil(value / step) * step)


def beyond(values: FloatArray, heat: HeatRange) -> str:
    """Return how much leaves a range in words, such as ``0.2 % above 3 mm``; nothing where nothing does."""
    known = values[~np.isnan(values)]
    outside = len(known) and (share_above(values, heat) > 0 or bool((known < heat.low).any()))
    return f"{share_text(values, heat)} mm" if outside else ""


def counted(number: int) -> str:
    """Return a whole number with thin spaces between thousands."""
    return f"{number:,}".replace(",", "\u2009")
