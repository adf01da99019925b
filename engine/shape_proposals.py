"""Edits of shapes as they are asked for with a click: what the new shapes are called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from engine.errors import InputError
from engine.shape_edits import Combine, Duplicate, Mirror, Remove, Rename, ShapeEdit, Split
from engine.shape_names import partner, side

KINDS = ("mirror", "split", "combine", "duplicate", "remove")
"""What ``proposed_edits`` knows."""


def proposed_edits(kind: str, names: Sequence[str], all_names: Sequence[str]) -> tuple[ShapeEdit, ...]:
    """Return the edits for shapes that are marked.

    ``mirror`` makes the shape of the other side, in the place of the one there is; a shape without a side is mirrored
    under a name of its own. ``split`` takes ``_L`` and ``_R``, ``combine`` adds the shapes up and keeps them,
    ``duplicate`` puts a copy behind each, ``remove`` takes them out.

    Parameters
    ----------
    kind : str
        One of ``KINDS``.
    names : sequence of str
        The shapes meant, in their order.
    all_names : sequence of str
        All shapes of the rig.

    Raises
    ------
    InputError
        For another kind, no shapes, one shape to combine, or a shape of one side to split.
    """
    if not names:
        raise InputError("shapes", "none is marked", "mark a shape first")
    taken = set(all_names)
    made: list[ShapeEdit] = []
    if kind == "remove":
        return (Remove(tuple(names)),)
    if kind == "combine":
        if len(names) < 2:
            raise InputError(f"shape {names[0]!r}", "is only one", "mark two shapes or more")
        return (Combine(tuple((name, 1.0) for name in names), _free(_joined(names), taken)),)
    for name in names:
        if kind == "mirror":
            to = partner(name) or _free(f"{name} mirrored", taken)
            made.append(Mirror(name, to, replace=to in all_names))
            taken.add(to)
        elif kind == "split":
            if side(name) and (partner(name) in taken):
                raise InputError(f"shape {name!r}", "is one half already", f"its other half is {partner(name)!r}")
            halves = _free(f"{name}_L", taken), _free(f"{name}_R", taken)
            made.append(Split(name, *halves))
            taken.update(halves)
        elif kind == "duplicate":
            copy = _free(f"{name} copy", taken)
            made.append(Duplicate(name, copy))
            taken.add(copy)
        else:
            raise InputError("shape edit", f"{kind!r} is not known", f"choose {', '.join(KINDS)}")
    return tuple(made)


def rename_edits(names: Mapping[str, str], all_names: Sequence[str]) -> tuple[Rename, ...]:
    """Return the edits that give shapes new names at once, also where one takes the name that another gives up.

    Parameters
    ----------
    names : mapping of str to str
        New names by old ones; those that stay alike are passed over.
    all_names : sequence of str
        All shapes of the rig.
    """
    wanted = {old: new for old, new in names.items() if old != new}
    taken = {*all_names, *wanted.values()}
    first, then = [], []
    for old, new in wanted.items():
        if new in wanted:
            between = _free(f"{new} new", taken)
            taken.add(between)
            first.append(Rename(old, between))
            then.append(Rename(between, new))
        else:
            then.append(Rename(old, new))
    return (*first, *then)


def _joined(names: Sequence[str]) -> str:
    """Return a name for a sum: the shapes' own without a side where they are two halves, else all of them."""
    if len(names) == 2 and partner(names[0]) == names[1]:
        first, second = names
        same = next((k for k, (a, b) in enumerate(zip(first, second, strict=False)) if a != b), 0)
        whole = first[:same].rstrip("_-. ")
        if whole:
            return whole
    return " + ".join(names)[:200]


def _free(name: str, taken: set[str]) -> str:
    found, number = name, 2
    while found in taken:
        found, number = f"{name} {number}", number + 1
    return found
