"""Custom schemes that tests share: a quick one of 12 points, one of 30, and every way of spoiling one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import resources
from engine.files.scheme import read_scheme
from engine.files.template import read_template
from engine.landmarks import LandmarkDefinition, LandmarkScheme, Side
from engine.scan.scheme_vertices import with_vertices

TEMPLATE = read_template(resources.template_path())
QUICK = (
    "forehead", "eye_left_outer", "eye_left_inner", "eye_right_inner", "eye_right_outer", "nose_tip", "mouth_left",
    "mouth_right", "lip_upper", "lip_lower", "chin", "jaw_left", "jaw_right",
)[1:]  # fmt: skip
CHEEKS = {"cheek_upper": 90, "cheek_side": 140, "temple": 5, "nose_side": 180, "lip_outer": 112}
"""Five more vertices on the subject's left; with their mirrors a scheme of 20 has 30."""


@cache
def shipped(name: str) -> LandmarkScheme:
    return with_vertices(TEMPLATE, read_scheme(resources.scheme_path(name)))


@cache
def quick() -> LandmarkScheme:
    """Twelve points of the closed scheme."""
    marks = tuple(mark for mark in shipped("closed") if mark.name in QUICK)
    return LandmarkScheme("quick", "12 points", marks, "closed")


@cache
def thorough(layout: str = "closed") -> LandmarkScheme:
    """All points of a shipped scheme and ten more."""
    more = []
    for name, vertex in CHEEKS.items():
        left, right = f"{name}_left", f"{name}_right"
        more += [
            LandmarkDefinition(left, "cheeks", Side.LEFT, right, f"Here: {name}.", vertex),
            LandmarkDefinition(right, "cheeks", Side.RIGHT, left, "", int(TEMPLATE.mirror[vertex])),
        ]
    return LandmarkScheme("thorough", "ten points more", (*shipped(layout).landmarks, *more), layout)


def changed(scheme: LandmarkScheme, name: str, /, **fields: object) -> tuple[LandmarkDefinition, ...]:
    """Return the fiducials with some fields of one replaced; they need not be a scheme any more."""
    return tuple(replace(mark, **fields) if mark.name == name else mark for mark in scheme)  # type: ignore[arg-type]
