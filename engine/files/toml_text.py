"""TOML from a file, as a table whose depth and names a reader can bear."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from engine.errors import InputError
from engine.files.source import read_bytes

MAX_TOML_BYTES = 1 << 20

_MOST_PARTS = 50
_PART = re.compile(r"""[ \t]*(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*""")


def load_toml(path: str | Path, remedy: str, largest: int = MAX_TOML_BYTES) -> dict[str, Any]:
    """Return the table that a UTF-8 TOML file holds.

    Parameters
    ----------
    path : str or Path
        The file.
    remedy : str
        What to do when it is no TOML.
    largest : int
        Most bytes that are read.

    Raises
    ------
    InputError
        When the file cannot be read, is not UTF-8 or not TOML, is nested too deeply or has a name of too many parts.
    """
    data = read_bytes(path, largest)
    try:
        text = data.decode("utf-8-sig")
        if _longest_name(text) > _MOST_PARTS:
            raise InputError(str(path), f"has a name of more than {_MOST_PARTS} parts", remedy)
        return tomllib.loads(text)
    except RecursionError as error:
        raise InputError(str(path), "cannot be read as TOML (nested too deeply)", remedy) from error
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        reason = " ".join(str(error).split())[:120]
        raise InputError(str(path), f"cannot be read as TOML ({reason})", remedy) from error


def _longest_name(text: str) -> int:
    """Return about how many parts the longest dotted name has; it takes room that grows with their square."""
    longest = run = 0
    for piece in text.split("."):
        run = run + 1 if _PART.fullmatch(piece) else 0
        longest = max(longest, run)
    return longest
