"""What the name of a shape, a marker, a curve or a part may be: one limit for readers, edits and project files."""

from __future__ import annotations

import re
from collections.abc import Sequence

LONGEST_NAME = 256
"""Most letters of a name."""
_LONE = re.compile("[\ud800-\udfff]")


def is_name(name: str) -> bool:
    """Return whether something can be called so and any file can hold it."""
    return bool(name.strip()) and len(name) <= LONGEST_NAME and _LONE.search(name) is None


def clean_names(names: Sequence[str]) -> tuple[tuple[str, ...], int]:
    """Return names within the limit, and how many of them are not as they were.

    Halves of letters that no text file can hold become U+FFFD, and what is too long is cut; a name that equals
    another one by that gets a number behind it. What was empty or double stays so, for the reader to refuse.
    """
    if all(len(name) <= LONGEST_NAME and _LONE.search(name) is None for name in names):
        return tuple(names), 0
    taken = {name for name in names if is_name(name)}
    found, changed = [], 0
    for name in names:
        clean = _LONE.sub("\ufffd", name)[:LONGEST_NAME]
        if clean != name:
            changed += 1
            whole, number = clean, 2
            while clean in taken:
                end = f" {number}"
                clean, number = whole[: LONGEST_NAME - len(end)] + end, number + 1
            taken.add(clean)
        found.append(clean)
    return tuple(found), changed


def told(changed: int, what: str) -> tuple[str, ...]:
    """Return what a reader says of names it has changed; nothing where there are none."""
    if not changed:
        return ()
    one = changed == 1
    problem = f"longer than {LONGEST_NAME} letters or no text, and {'was' if one else 'were'} shortened or mended"
    return (f"{changed} {what} {'name is' if one else 'names are'} {problem}",)
