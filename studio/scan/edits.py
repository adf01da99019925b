"""What every click means for the fiducials of a scan: plain functions from one set of landmarks to the next. No Qt.

Proposals that follow from the placed points are told from others (mirrored, carried over) by where they lie: a
proposal that lies where the placed points of before put it moves on with them; any other stays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from engine.errors import InputError
from engine.landmarks import UNSET, Landmark, LandmarkScheme, LandmarkSet, LandmarkState
from engine.landmarks import inside as is_inside

PROPOSE_FROM = 5
"""From this many placed points on the rest of a scheme are proposed."""

_SAME_PX = 3.0
"""A proposal nearer than this to where the placed points of before put it follows them; nudges stay below it."""

Positions = Mapping[str, tuple[float, float]]
Propose = Callable[[Positions], Positions]


def placed(landmarks: LandmarkSet, scheme: LandmarkScheme) -> dict[str, tuple[float, float]]:
    """Return the placed positions of ``scheme``, in pixels."""
    return {
        name: (landmarks[name].x, landmarks[name].y)
        for name in landmarks.names(LandmarkState.PLACED, order=scheme.names)
    }


def located(landmarks: LandmarkSet, scheme: LandmarkScheme) -> dict[str, tuple[float, float]]:
    """Return the placed and the proposed positions of ``scheme``, in pixels."""
    names = landmarks.names(LandmarkState.PLACED, LandmarkState.PROPOSED, order=scheme.names)
    return {name: (landmarks[name].x, landmarks[name].y) for name in names}


def inside(x: float, y: float, size: tuple[int, int]) -> tuple[float, float]:
    """Return the nearest position inside a picture of ``size`` (width, height) pixels."""
    return min(max(float(x), 0.0), size[0] - 1.0), min(max(float(y), 0.0), size[1] - 1.0)


def moved(
    landmarks: LandmarkSet,
    scheme: LandmarkScheme,
    name: str,
    position: tuple[float, float],
    size: tuple[int, int],
    propose: Propose,
) -> LandmarkSet:
    """Return the set after ``name`` was placed at a position: the other proposals follow; a locked point stays."""
    if landmarks[name].locked:
        return landmarks
    after = landmarks.moved(name, *inside(*position, size))
    return with_proposals(landmarks, after, scheme, size, propose)


def with_proposals(
    before: LandmarkSet,
    after: LandmarkSet,
    scheme: LandmarkScheme,
    size: tuple[int, int],
    propose: Propose,
    besides: str | None = None,
) -> LandmarkSet:
    """Return ``after`` with every unset point proposed and every proposal that follows the placed points moved on.

    Nothing placed, skipped or locked is touched, nor is ``besides``; below `PROPOSE_FROM` placed points nothing is
    proposed.
    """
    predicted = _predict(after, scheme, size, propose)
    if not predicted:
        return after
    former = _predict(before, scheme, size, propose)
    changes: dict[str, Landmark] = {}
    for name, (x, y) in predicted.items():
        point = after[name]
        follows = point.state == LandmarkState.UNSET or _at(point, former.get(name))
        is_open = point.state in (LandmarkState.UNSET, LandmarkState.PROPOSED) and not point.locked
        if is_open and follows and name != besides:
            changes[name] = Landmark(x, y, LandmarkState.PROPOSED)
    return after.with_points(changes)


def confirmed(landmarks: LandmarkSet, scheme: LandmarkScheme, names: tuple[str, ...] | None = None) -> LandmarkSet:
    """Return the set in which the proposed points (of ``names``, or all of the scheme) are placed where they are."""
    chosen = landmarks.names(LandmarkState.PROPOSED, order=scheme.names if names is None else names)
    return landmarks.with_points({n: replace(landmarks[n], state=LandmarkState.PLACED) for n in chosen})


def skipped(landmarks: LandmarkSet, name: str) -> LandmarkSet:
    """Return the set in which ``name`` is left out; a point left out before comes back unset."""
    point = landmarks[name]
    if point.locked:
        return landmarks
    new = UNSET if point.state == LandmarkState.SKIPPED else Landmark(state=LandmarkState.SKIPPED)
    return landmarks.with_point(name, new)


def unset(landmarks: LandmarkSet, name: str) -> LandmarkSet:
    """Return the set in which ``name`` has no place, if it is not locked."""
    return landmarks if landmarks[name].locked else landmarks.with_point(name, UNSET)


def lock_toggled(landmarks: LandmarkSet, name: str) -> LandmarkSet:
    """Return the set in which ``name`` is locked, or free if it was locked; only placed points are locked."""
    point = landmarks[name]
    if point.state != LandmarkState.PLACED:
        return landmarks
    return landmarks.with_point(name, replace(point, locked=not point.locked))


def proposed(
    landmarks: LandmarkSet, scheme: LandmarkScheme, positions: Positions, size: tuple[int, int]
) -> LandmarkSet:
    """Return the set in which ``positions`` are proposals wherever nothing is placed, skipped or locked."""
    open_states = (LandmarkState.UNSET, LandmarkState.PROPOSED)
    changes = {
        name: Landmark(*inside(*position, size), LandmarkState.PROPOSED)
        for name, position in positions.items()
        if name in scheme and landmarks[name].state in open_states and not landmarks[name].locked
    }
    return landmarks.with_points(changes)


def imported(
    landmarks: LandmarkSet, scheme: LandmarkScheme, positions: Positions, size: tuple[int, int], subject: str
) -> LandmarkSet:
    """Return the set after a file of fiducials was read: its points are placed, locked ones stay.

    Raises
    ------
    InputError
        When the file has no point of the scheme, or one that lies outside the picture.
    """
    chosen = {name: position for name, position in positions.items() if name in scheme}
    if not chosen:
        raise InputError(subject, f"has no point of scheme {scheme.name}", "choose the scheme it was made for")
    for name, position in chosen.items():
        if not is_inside(*position, *size):
            problem = f"{name} at ({position[0]:.1f}, {position[1]:.1f}) lies outside the {size[0]} x {size[1]} picture"
            raise InputError(subject, problem, "use the file of this scan")
    new = {n: Landmark(float(x), float(y), LandmarkState.PLACED) for n, (x, y) in chosen.items()}
    return landmarks.with_points({n: point for n, point in new.items() if not landmarks[n].locked})


def _predict(
    landmarks: LandmarkSet, scheme: LandmarkScheme, size: tuple[int, int], propose: Propose
) -> dict[str, tuple[float, float]]:
    known = placed(landmarks, scheme)
    if not PROPOSE_FROM <= len(known) < len(scheme):
        return {}
    try:
        return {name: inside(*position, size) for name, position in propose(known).items()}
    except InputError:
        return {}  # points on one line say nothing about the rest yet


def _at(point: Landmark, position: tuple[float, float] | None) -> bool:
    if position is None or not point.is_set:
        return False
    return abs(point.x - position[0]) < _SAME_PX and abs(point.y - position[1]) < _SAME_PX
