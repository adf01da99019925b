"""What people call the same point: names compared by what they say, whatever their case, order and separators."""

from __future__ import annotations

import re

_SPLIT = re.compile(r"[^0-9A-Za-z]+")
_CAMEL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|(?<=[A-Za-z])(?=[0-9])")

_WORDS: dict[str, tuple[str, ...]] = {
    "l": ("left",), "lt": ("left",), "lft": ("left",),
    "r": ("right",), "rt": ("right",), "rgt": ("right",),
    "out": ("outer",), "lateral": ("outer",), "temporal": ("outer",), "tail": ("outer",),
    "in": ("inner",), "inside": ("inner",), "medial": ("inner",), "head": ("inner",),
    "up": ("upper",), "top": ("upper",), "superior": ("upper",), "superius": ("upper",),
    "low": ("lower",), "bottom": ("lower",), "inferior": ("lower",), "inferius": ("lower",), "down": ("lower",),
    "eyebrow": ("brow",), "brows": ("brow",), "eyebrows": ("brow",), "eyes": ("eye",), "canthus": ("eye",),
    "exocanthion": ("eye", "outer"), "ex": ("eye", "outer"), "ectocanthion": ("eye", "outer"),
    "endocanthion": ("eye", "inner"), "en": ("eye", "inner"), "entocanthion": ("eye", "inner"),
    "lips": ("lip",), "labiale": ("lip",), "labium": ("lip",), "ls": ("lip", "upper"), "li": ("lip", "lower"),
    "cheilion": ("mouth",), "ch": ("mouth",),
    "pronasale": ("nose", "tip"), "prn": ("nose", "tip"), "apex": ("tip",),
    "nasion": ("nose", "bridge"), "sellion": ("nose", "bridge"), "root": ("bridge",),
    "nasal": ("nose",),
    "alare": ("nose",), "al": ("nose",), "ala": ("nose",), "alar": ("nose",),
    "pogonion": ("chin",), "pg": ("chin",),
}  # fmt: skip
_SILENT = frozenset(
    ("corner", "end", "point", "of", "the", "middle", "mid", "centre", "center", "wing", "commissure", "lm", "landmark")
)


def words(name: str) -> frozenset[str]:
    """Return what a name says: its words in one spelling, without those that tell nothing apart.

    ``BrowLeftOuter``, ``left eyebrow, outer end`` and ``brow.L.out`` say the same.
    """
    found: set[str] = set()
    for part in _SPLIT.split(name[:200]):
        for word in _CAMEL.split(part):
            low = word.lower()
            if low and low not in _SILENT:
                found.update(_WORDS.get(low, (low,)))
    return frozenset(found)


def plain(name: str) -> str:
    """Return a name without case and separators."""
    return _SPLIT.sub("", name).lower()
