"""What a list of fiducials must fulfil to be a scheme, whatever the template: one finding per thing that is wrong."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from engine.landmarks import LandmarkDefinition

FEWEST, MOST = 4, 400
"""How many fiducials a scheme may have; with three, every scan fits without bending."""

LAYOUTS = ("closed", "open")
"""The layouts of a template that a scheme can stand on."""

LONGEST = {"title": 80, "group": 40, "hint": 300}

SCHEME_NAME = r"^[A-Za-z0-9_](?:[A-Za-z0-9_. -]{0,46}[A-Za-z0-9_])?$"
FIDUCIAL_NAME = r"^[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}$"


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a scheme, or worth knowing.

    Parameters
    ----------
    row : int or None
        The fiducial's place in the clicking order; None for the scheme as a whole.
    field : str
        ``name``, ``group``, ``side``, ``mirror``, ``vertex``, ``hint``, ``title`` or ``layout``.
    problem, remedy : str
        What is wrong and what to do, in one clause each.
    is_error : bool
        Whether the scheme cannot be used because of it.
    """

    row: int | None
    field: str
    problem: str
    remedy: str
    is_error: bool = True

    @property
    def text(self) -> str:
        """Problem and remedy as one sentence."""
        return f"{self.problem}; {self.remedy}" if self.remedy else self.problem


def shown(name: str) -> str:
    """Return a name as it can stand in a sentence: short, and on one line."""
    return name[:64] if name.isprintable() else repr(name[:64])


def check_head(name: str, title: str, layout: str) -> Iterator[Finding]:
    """Yield what is wrong with a scheme's name, title and layout."""
    if not re.fullmatch(SCHEME_NAME, name):
        problem = "is empty" if not name else "has other signs than letters, digits, space, _ . -, or more than 48"
        yield Finding(None, "name", problem, "give the scheme another name")
    yield from _text(None, "title", title)
    if layout not in LAYOUTS:
        yield Finding(None, "layout", f"is {layout[:40]!r}", f"choose {' or '.join(LAYOUTS)}")


def check_fiducials(landmarks: Sequence[LandmarkDefinition]) -> Iterator[Finding]:
    """Yield what is wrong with the fiducials of a scheme: names, texts, pairs, sides, vertex numbers used twice."""
    if not FEWEST <= len(landmarks) <= MOST:
        many = "few" if len(landmarks) < FEWEST else "many"
        yield Finding(None, "name", f"{len(landmarks)} fiducials are too {many}", f"have {FEWEST} to {MOST}")
    rows = {landmark.name: row for row, landmark in reversed(list(enumerate(landmarks)))}
    used: dict[int, int] = {}
    often = Counter(landmark.name for landmark in landmarks)
    for row, landmark in enumerate(landmarks):
        if not re.fullmatch(FIDUCIAL_NAME, landmark.name):
            problem = (
                "the name is empty" if not landmark.name else "the name has other signs than letters, digits, _ . -"
            )
            yield Finding(row, "name", problem, "rename it")
        elif often[landmark.name] > 1 and rows[landmark.name] != row:
            yield Finding(row, "name", f"a landmark name occurs twice, {landmark.name[:64]!r}", "rename one of them")
        yield from _text(row, "group", landmark.group)
        yield from _text(row, "hint", landmark.hint)
        other = rows.get(landmark.mirror)
        if landmark.mirror and (other is None or landmarks[other].mirror != landmark.name):
            yield Finding(
                row, "mirror", f"its mirror {landmark.mirror[:64]!r} does not point back", "name each other as mirror"
            )
        elif other is not None:
            yield from _side(row, landmark, landmarks[other])
        if landmark.vertex is None:
            continue
        if landmark.vertex < 0:
            yield Finding(row, "vertex", f"the vertex is {landmark.vertex}", "give a number of the template")
        elif landmark.vertex in used:
            first = landmarks[used[landmark.vertex]].name
            yield Finding(
                row, "vertex", f"vertex {landmark.vertex} carries {shown(first)} already", "choose another vertex"
            )
        else:
            used[landmark.vertex] = row


def _side(row: int, landmark: LandmarkDefinition, other: LandmarkDefinition) -> Iterator[Finding]:
    alone = landmark.name == other.name
    if alone != (landmark.side == "middle"):
        problem = "is its own mirror but not in the middle" if alone else "is in the middle but has another as mirror"
        yield Finding(row, "side", problem, "correct side or mirror")
    elif not alone and landmark.side == other.side:
        yield Finding(
            row, "side", f"lies on the same side as its mirror {shown(other.name)}", "give one the other side"
        )


def _text(row: int | None, field: str, text: str) -> Iterator[Finding]:
    if len(text) > LONGEST[field]:
        yield Finding(row, field, f"the {field} is longer than {LONGEST[field]} characters", "shorten it")
    elif not text.isprintable():
        yield Finding(row, field, f"the {field} has control characters or more than one line", "take them out")
    elif row is not None and field == "group" and not text.strip():
        yield Finding(row, field, "the group is empty", "name the part of the face")
