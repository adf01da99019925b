"""What every reader of landmarks returns: points in the file's order, with what they are called."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, InvalidOperation, localcontext

import numpy as np

from engine.errors import InputError
from engine.mesh import FloatArray, frozen

MAX_LANDMARK_BYTES = 64 << 20
"""Largest table of landmarks that is read, in bytes: an hour of 68 points a frame has less."""

MAX_POINTS = 10_000
"""Most points that one picture may have."""

FARTHEST = 1e9
"""A coordinate beyond this is no landmark."""

ORIGINS = (0.0, 0.5, 1.0)
"""What files call the centre of the top left pixel."""

DEFAULT_ORIGIN = {"json": 0.0, "pts": 1.0, "ljson": 0.0, "csv": 0.0}
"""The origin that each format is read and written with unless another is asked for."""


@dataclass(frozen=True)
class LandmarkFile:
    """Landmarks of one picture or mesh, as a file has them.

    Parameters
    ----------
    points : (n, 2) or (n, 3) float
        2-D: x, y in pixels, centres at integers, origin top left. 3-D: x, y, z in the file's own unit and frame.
        NaN where the file names a point and gives it no place.
    labels : tuple of str
        What each point is called, each once; its index as text where the file has no names.
    group : str
        Which of ``groups`` was read: the group of an ``.ljson``, the row of a table; empty where there is only one.
    groups : tuple of str
        All that the file holds, in its order.
    image_size : (int, int), optional
        Width and height of the picture that the points were placed on, where the file says so.
    origin : float
        What the file calls the centre of the top left pixel: 0, 0.5 or 1; already taken off 2-D ``points``.
    format : str
        ``json``, ``pts``, ``ljson`` or ``csv``.
    remarks : tuple of str
        In words, what was assumed about the file.

    Raises
    ------
    InputError
        On wrong shapes, a label that occurs twice, and a group that is not among the groups.
    """

    points: FloatArray
    labels: tuple[str, ...]
    group: str = ""
    groups: tuple[str, ...] = ("",)
    image_size: tuple[int, int] | None = None
    origin: float = 0.0
    format: str = "json"
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        points = frozen(self.points, np.float64)
        if points.ndim != 2 or points.shape[1] not in (2, 3):
            raise InputError("landmarks", f"have shape {points.shape}", "give two or three coordinates a point")
        if len(points) != len(self.labels):
            raise InputError("landmarks", f"{len(self.labels)} labels for {len(points)} points", "give one a point")
        if len(set(self.labels)) != len(self.labels):
            twice = next(name for name in self.labels if self.labels.count(name) > 1)
            raise InputError("landmarks", f"the name {twice[:60]!r} occurs twice", "rename one of the points")
        if self.group not in self.groups:
            raise InputError("landmarks", f"no group {self.group[:60]!r}", "choose one of the file's groups")
        if self.origin not in ORIGINS:
            raise InputError("origin", f"{self.origin:g} is not known", "choose 0, 0.5 or 1")
        points = points.copy() if not np.isfinite(points).all() else points
        if points.flags.writeable:
            points[~np.isfinite(points).all(axis=1)] = np.nan  # a point with half a place has none
            points.flags.writeable = False
        object.__setattr__(self, "points", points)

    @property
    def dimension(self) -> int:
        """2 for pixels, 3 for points in space."""
        return int(self.points.shape[1])

    @property
    def named(self) -> bool:
        """Whether the file names its points; else their labels are their indices."""
        return any(label != str(index) for index, label in enumerate(self.labels))

    @property
    def present(self) -> int:
        """How many points have a place."""
        return int(np.isfinite(self.points).all(axis=1).sum())


def checked_origin(origin: float | None, kind: str) -> float:
    """Return the origin that a file is read with; InputError for one that no tool uses."""
    chosen = DEFAULT_ORIGIN[kind] if origin is None else float(origin)
    if chosen not in ORIGINS:
        raise InputError("origin", f"{origin} is not known", "choose 0, 0.5 or 1")
    return chosen


def chosen_group(subject: str, groups: tuple[str, ...], group: str | None) -> tuple[str, tuple[str, ...]]:
    """Return the group to read and what to say about the choice: the first where none is asked for.

    Raises
    ------
    InputError
        When the file does not hold the group that is asked for.
    """
    if group is not None:
        if group not in groups:
            known = ", ".join(name[:40] for name in groups[:5]) + ("" if len(groups) <= 5 else ", ...")
            raise InputError(subject, f"has no group {group[:60]!r}", f"choose one of: {known}")
        return group, ()
    if len(groups) == 1:
        return groups[0], ()
    return groups[0], (f"{groups[0]!r} taken, the first of {len(groups)} groups",)


def number(text: str, place: str) -> float:
    """Return a coordinate that a text file gives; NaN for an empty cell and the usual words for a missing one.

    Raises
    ------
    InputError
        Naming ``place``, on a decimal comma, on what is no number, and on one that no picture and no mesh reaches.
    """
    text = text.strip()
    if text.lower() in _MISSING:
        return float("nan")
    # Python takes 1_000 for a number, and digits of any script; files of numbers do not hold them.
    if "_" in text or not text.isascii() or len(text) > _LONGEST:
        raise InputError(place, f"{text[:40]!r} is not a number", "correct it")
    try:
        value = float(text)
    except ValueError:
        if text.count(",") == 1 and "." not in text and text.replace(",", "").strip("+-").isdigit():
            raise InputError(
                place, f"{text[:40]!r} has a decimal comma", "export the table with decimal points"
            ) from None
        raise InputError(place, f"{text[:40]!r} is not a number", "correct it") from None
    if not abs(value) <= FARTHEST:
        raise InputError(place, f"{text[:40]!r} is no place", "correct it, or leave it empty where it is missing")
    return value


def shifted_text(value: float, origin: float) -> str:
    """Return the shortest text of ``value + origin`` from which `shifted_number` gives ``value`` again, bit by bit."""
    if not origin:
        return repr(float(value))
    with localcontext() as context:
        context.prec = 400  # the smallest double has 324 zeros behind its point
        total = (Decimal(repr(float(value))) + Decimal(repr(origin))).normalize()
    return format(total, "f")


def shifted_number(text: str, origin: float, place: str) -> float:
    """Return the coordinate of a text without its origin, as exactly as the text gives it; see `number`."""
    value = number(text, place)
    if not origin or value != value:
        return value
    try:
        with localcontext() as context:
            context.prec = 400
            return float(Decimal(text.strip()) - Decimal(repr(origin)))
    except InvalidOperation:
        return value - origin


def checked_name(name: str, place: str) -> str:
    """Return a point's name as files may give it; InputError for an empty, endless or unprintable one."""
    name = name.strip()
    if not name or not name.isprintable() or len(name) > _LONGEST:
        raise InputError(place, f"the name {name[:60]!r} cannot be used", "rename the point")
    return name


_MISSING = frozenset(("", "na", "n/a", "nan", "none", "null", "-"))
_LONGEST = 400
