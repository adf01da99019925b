"""How the points of a mapping are written and typed: ``8``, ``leye.0``, ``8, 8, 57``."""

from __future__ import annotations

from collections.abc import Sequence

from engine.errors import InputError
from engine.landmark_mapping import Source, Sources, index_of


def sources_text(sources: Sources) -> str:
    """Return the points as they are typed."""
    return ", ".join(map(str, sources))


def parse_sources(text: str, labels: Sequence[str]) -> Sources:
    """Return the points that a text names, by label or by index from 0; none for an empty text.

    Raises
    ------
    InputError
        Naming what is no point of the file.
    """
    text = text.strip()
    if not text:
        return ()
    if text in labels:
        return (_source(text, labels),)
    return tuple(_source(part.strip(), labels) for part in text.split(",") if part.strip())


def _source(word: str, labels: Sequence[str]) -> Source:
    if word.isascii() and word.isdigit() and len(word) < 9 and word not in labels:
        number = int(word)
        if number < len(labels):
            return number
    index = index_of(word, labels)
    if index is None:
        remedy = f"give 0 to {len(labels) - 1}, or a name" if labels else "open a file with points"
        raise InputError(f"point {word[:40]!r}", "is not in the file", remedy)
    return index if labels[index] == str(index) else labels[index]
