"""What a scan's name and fiducials must fulfil, wherever they come from: a command or a project file."""

from __future__ import annotations

import math
from collections.abc import Iterable

from engine.errors import InputError
from engine.landmarks import Landmark, LandmarkScheme, inside
from studio.scan.job import SCHEMES, scheme_of

LONGEST_NAME = 120


def check_name(name: str) -> None:
    """Raise an InputError unless ``name`` can name a scan and, later, the files written from it."""
    if not name.strip():
        raise InputError("name", "is empty", "give the scan a name")
    if len(name) > LONGEST_NAME:
        raise InputError(f"name {name[:20]!r}...", f"is longer than {LONGEST_NAME} characters", "shorten it")
    if any(c in '/\\:*?"<>|' or ord(c) < 32 for c in name) or not name.strip(". "):
        raise InputError(f"name {name!r}", "cannot name a file", 'leave out / \\ : * ? " < > | and control characters')


def known_landmarks(schemes: Iterable[LandmarkScheme] = ()) -> frozenset[str]:
    """Return the names that are in any of the shipped schemes, or in ``schemes``."""
    return frozenset(name for scheme in (*map(scheme_of, SCHEMES), *schemes) for name in scheme.names)


def check_landmark(name: str, point: Landmark, width: int, height: int, schemes: Iterable[LandmarkScheme] = ()) -> None:
    """Raise an InputError unless ``point`` has a known name and, where it is set, lies inside the picture (pixels).

    Known are the names of the shipped schemes and of ``schemes``, the project's own.
    """
    subject = f"fiducial {name}"
    if name not in known_landmarks(schemes):
        raise InputError(subject, "is in no scheme", "use the names of the scheme")
    if not point.is_set:
        return
    if not (math.isfinite(point.x) and math.isfinite(point.y)):
        raise InputError(subject, "has no finite place", "click it in the picture")
    if not inside(point.x, point.y, width, height):
        where = f"({point.x:.1f}, {point.y:.1f})"
        raise InputError(subject, f"lies at {where}, outside the {width} x {height} picture", "place it inside")
