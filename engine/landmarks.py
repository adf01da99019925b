"""Named points: a scheme says which there are, a set says where they are on one picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from types import MappingProxyType

import numpy as np

from engine.errors import InputError
from engine.mesh import FloatArray
from engine.scheme_checks import check_fiducials, check_head, shown


class LandmarkState(StrEnum):
    """How far the user has come with a landmark."""

    UNSET = "unset"
    PROPOSED = "proposed"
    PLACED = "placed"
    SKIPPED = "skipped"


class Side(StrEnum):
    """The subject's side that a landmark lies on."""

    LEFT = "left"
    RIGHT = "right"
    MIDDLE = "middle"


@dataclass(frozen=True)
class LandmarkDefinition:
    """One named point of a scheme.

    ``mirror`` names the point of the other side (the point itself on the mid-line, empty for one without a partner);
    ``hint`` tells the user in a sentence where to click. ``vertex`` is the template's vertex that carries it; None
    where the template's own layout names the fiducial.
    """

    name: str
    group: str
    side: Side
    mirror: str
    hint: str
    vertex: int | None = None


@dataclass(frozen=True)
class LandmarkScheme:
    """An ordered list of landmarks; the order is the one they are clicked in.

    Parameters
    ----------
    name, title : str
        What it is called in files, and in words.
    landmarks : tuple of LandmarkDefinition
        In clicking order.
    layout : {"closed", "open"}
        The layout of a template that its vertices are taken from.

    Raises
    ------
    InputError
        Naming the first fiducial and field that is wrong: a name that occurs twice, a mirror that does not point back,
        two on one side, a vertex used twice (``engine.scheme_checks``).
    """

    name: str
    title: str
    landmarks: tuple[LandmarkDefinition, ...]
    layout: str = "closed"

    def __post_init__(self) -> None:
        for finding in (
            *check_head(self.name, self.title, self.layout),
            *check_fiducials(self.landmarks),
        ):
            part = finding.field if finding.row is None else shown(self.landmarks[finding.row].name)
            raise InputError(f"scheme {shown(self.name)}, {part}", finding.problem, finding.remedy)

    @property
    def names(self) -> tuple[str, ...]:
        """All names in clicking order."""
        return tuple(landmark.name for landmark in self.landmarks)

    def __getitem__(self, name: str) -> LandmarkDefinition:
        for landmark in self.landmarks:
            if landmark.name == name:
                return landmark
        raise KeyError(name)

    def __contains__(self, name: object) -> bool:
        return any(landmark.name == name for landmark in self.landmarks)

    def __iter__(self) -> Iterator[LandmarkDefinition]:
        return iter(self.landmarks)

    def __len__(self) -> int:
        return len(self.landmarks)


@dataclass(frozen=True)
class Landmark:
    """Where one landmark is: pixel coordinates, how far it is, whether it is locked.

    ``x`` and ``y`` are in pixels (centres at integers) and NaN while the point is unset or skipped without a place.
    """

    x: float = float("nan")
    y: float = float("nan")
    state: LandmarkState = LandmarkState.UNSET
    locked: bool = False

    @property
    def is_set(self) -> bool:
        """Whether the point has a place, confirmed or not."""
        return self.state in (LandmarkState.PLACED, LandmarkState.PROPOSED)


UNSET = Landmark()


def inside(x: float, y: float, width: int, height: int) -> bool:
    """Return whether (x, y) lies on a picture of ``width`` x ``height`` pixels, whose centres are at integers.

    The border pixels belong to it whole, so coordinates go from -0.5 to size - 0.5; what is not finite lies outside.
    """
    return bool(-0.5 <= x <= width - 0.5 and -0.5 <= y <= height - 0.5)


@dataclass(frozen=True)
class LandmarkSet:
    """The landmarks of one picture by name; a name that is not there is unset."""

    points: Mapping[str, Landmark]

    def __post_init__(self) -> None:
        object.__setattr__(
            self,
            "points",
            MappingProxyType({name: point for name, point in dict(self.points).items() if point != UNSET}),
        )

    def __reduce__(self) -> tuple[type[LandmarkSet], tuple[object, ...]]:
        # A read-only mapping cannot be sent to another process.
        return LandmarkSet, (dict(self.points),)

    @classmethod
    def placed(cls, positions: Mapping[str, tuple[float, float]]) -> LandmarkSet:
        """Return a set in which every given position, in pixels, is placed."""
        return cls({n: Landmark(float(p[0]), float(p[1]), LandmarkState.PLACED) for n, p in positions.items()})

    def __getitem__(self, name: str) -> Landmark:
        return self.points.get(name, UNSET)

    def __hash__(self) -> int:
        return hash(tuple(sorted(self.points.items())))

    def with_point(self, name: str, point: Landmark) -> LandmarkSet:
        """Return a set in which ``name`` is ``point``."""
        return LandmarkSet({**self.points, name: point})

    def with_points(self, points: Mapping[str, Landmark]) -> LandmarkSet:
        """Return a set in which all of ``points`` are replaced."""
        return LandmarkSet({**self.points, **points})

    def moved(self, name: str, x: float, y: float) -> LandmarkSet:
        """Return a set in which ``name`` is placed at (x, y) pixels and keeps its lock."""
        point = replace(self[name], x=float(x), y=float(y), state=LandmarkState.PLACED)
        return self.with_point(name, point)

    def names(self, *states: LandmarkState, order: Iterable[str]) -> tuple[str, ...]:
        """Return the names of ``order`` that are in one of ``states``, in that order."""
        return tuple(name for name in order if self[name].state in states)

    def positions(self, names: Iterable[str]) -> FloatArray:
        """Return the pixel positions (k, 2) of ``names``; NaN where unset."""
        return np.array([(self[n].x, self[n].y) for n in names], dtype=np.float64).reshape(-1, 2)

    def next_unfinished(self, order: tuple[str, ...], after: str | None = None) -> str | None:
        """Return the first unset or proposed name after ``after``, going round once; None when all are done."""
        start = order.index(after) + 1 if after in order else 0
        for name in order[start:] + order[:start]:
            if self[name].state in (LandmarkState.UNSET, LandmarkState.PROPOSED):
                return name
        return None
