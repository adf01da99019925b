"""What the parts of a face are called, whatever a program calls its materials, groups and nodes."""

from __future__ import annotations

import re
from itertools import pairwise

_WORDS = {
    "teeth": ("teeth", "tooth", "gum", "gums", "denture", "dentures", "upperteeth", "lowerteeth"),
    "tongue": ("tongue",),
    "lashes": ("eyelash", "eyelashes", "lash", "lashes"),
    "brows": ("eyebrow", "eyebrows", "brow", "brows"),
    "hair": ("hair", "beard", "scalp"),
    "eyes": ("eye", "eyes", "eyeball", "eyeballs", "cornea", "iris", "sclera", "pupil", "eyeleft", "eyeright"),
    "skin": ("skin", "face", "head", "body"),
}
_SPLIT = re.compile(r"[^A-Za-z]+|(?<=[a-z])(?=[A-Z])")


def part_name(*names: str) -> str | None:
    """Return what the first name that says so is a part of; None where no name says anything.

    One of ``skin``, ``eyes``, ``teeth``, ``tongue``, ``lashes``, ``brows`` and ``hair``: ``Eye_L``, ``M_EyeBall`` and
    ``eyes`` are eyes, ``Head.001`` is skin.
    """
    for name in names:
        words = [word.lower() for word in _SPLIT.split(name) if word]
        words += [a + b for a, b in pairwise(words)]
        for part, known in _WORDS.items():
            if any(word in known for word in words):
                return part
    return None
