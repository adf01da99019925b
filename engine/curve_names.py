"""Which curves of a performance drive which shapes of a rig, however each of them spells the names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from engine.shape_names import arkit_mapping, side, words

_DIRECTED = ("jaw", "mouth", "tongue")
"""What moves to a side as a whole: its left and right are no halves."""


def match_curves(curves: Sequence[str], shapes: Sequence[str]) -> tuple[tuple[int, ...], ...]:
    """Return for every shape the curves that drive it, by their numbers; empty for a shape that rests.

    A shape is driven by the curve of its own name; else by the one of the same words and side (``EyeBlinkLeft``,
    ``eyeBlink_L``); else by what both mean in ARKit's names. A curve without a side drives both halves of a shape; a
    shape without a side follows the mean of both curves. Names without letters drive only what is called the same.
    """
    exact = {name: k for k, name in enumerate(curves)}
    spoken = {key: k for k, name in reversed(list(enumerate(curves))) if (key := _spoken(name)) is not None}
    meant = _meant(curves, shapes)
    found: list[tuple[int, ...]] = []
    for name in shapes:
        if name in exact:
            found.append((exact[name],))
        elif (key := _spoken(name)) in spoken:
            found.append((spoken[key],))
        elif name in meant:
            found.append(tuple(sorted(exact[curve] for curve in meant[name])))
        else:
            found.append(_other_side(key, spoken))
    return tuple(found)


def _other_side(key: tuple[str, str] | None, spoken: Mapping[tuple[str, str], int]) -> tuple[int, ...]:
    """Return both halves' curves for a whole shape, the whole's for a half; none where a side is a direction."""
    if key is None or key[0] in _DIRECTED:
        return ()
    word, own = key
    wanted = [(word, "")] if own else [(word, "L"), (word, "R")]
    return tuple(sorted(spoken[other] for other in wanted)) if all(other in spoken for other in wanted) else ()


def _spoken(name: str) -> tuple[str, str] | None:
    """Return the words of a name in one, and its side; None where they are no more than a number."""
    own = side(name)
    plain = [word for word in words(name) if side(word) == ""]
    joined = "".join(plain) or "".join(c for c in name.lower() if c.isalnum())
    return None if not joined or joined.isdecimal() else (joined, own)


def _meant(curves: Sequence[str], shapes: Sequence[str]) -> dict[str, set[str]]:
    """Return by shape the curves that stand for the same of ARKit's names, each name told by one curve alone."""
    told, asked = arkit_mapping(curves).found, arkit_mapping(shapes).found
    meant: dict[str, set[str]] = {}
    for standard, names in asked.items():
        for name in names:
            if len(told.get(standard, ())) == 1:
                meant.setdefault(name, set()).add(told[standard][0])
    return meant
