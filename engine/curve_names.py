"""Which curves of a performance drive which shapes of a rig, however each of them spells the names."""

from __future__ import annotations

from collections.abc import Sequence

from engine.shape_names import arkit_mapping, side, words


def match_curves(curves: Sequence[str], shapes: Sequence[str]) -> tuple[tuple[int, ...], ...]:
    """Return for every shape the curves that drive it, by their numbers; empty for a shape that rests.

    A shape is driven by the curve of its own name; else by the one of the same words and side (``EyeBlinkLeft``,
    ``eyeBlink_L``); else by what both mean in ARKit's names. A curve without a side drives both halves of a shape; a
    shape without a side follows the mean of both curves.
    """
    exact = {name: k for k, name in enumerate(curves)}
    spoken = {_spoken(name): k for k, name in reversed(list(enumerate(curves)))}
    meant = _meant(curves, shapes)
    found: list[tuple[int, ...]] = []
    for name in shapes:
        if name in exact:
            found.append((exact[name],))
        elif _spoken(name) in spoken:
            found.append((spoken[_spoken(name)],))
        else:
            found.append(tuple(sorted(exact[curve] for curve in meant.get(name, ()))))
    return tuple(found)


def _spoken(name: str) -> tuple[str, ...]:
    own = side(name)
    plain = [word for word in words(name) if side(word) == ""]
    joined = "".join(plain) or "".join(c for c in name.lower() if c.isalnum())
    return (joined, own)


def _meant(curves: Sequence[str], shapes: Sequence[str]) -> dict[str, set[str]]:
    """Return by shape the curves that stand for the same of ARKit's names, each name told by one curve alone."""
    told, asked = arkit_mapping(curves).found, arkit_mapping(shapes).found
    meant: dict[str, set[str]] = {}
    for standard, names in asked.items():
        for name in names:
            if len(told.get(standard, ())) == 1:
                meant.setdefault(name, set()).add(told[standard][0])
    return meant
