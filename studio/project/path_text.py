"""Paths as text that any file can hold, also those whose bytes are no letters of the system. No Qt."""

from __future__ import annotations

import re

_LONE = re.compile("[\ud800-\udfff]")
_WRITTEN = re.compile("\0(d[89a-f][0-9a-f]{2})")


def escaped(text: str) -> str:
    """Return a path as it is written down: what UTF-8 cannot hold becomes a zero byte and four hexadecimal digits.

    Python keeps the bytes of a name that is not UTF-8 as lone surrogates. No path has a zero byte, so that every text
    comes back by `plain` as it was, and paths that need none of this stay as they are.
    """
    return _LONE.sub(lambda found: f"\0{ord(found[0]):04x}", text)


def plain(text: str) -> str:
    """Return the path that was written down by `escaped`."""
    return _WRITTEN.sub(lambda found: chr(int(found[1], 16)), text)
