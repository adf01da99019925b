"""The numbers of a text PLY, read as they are needed: what follows the last row is never looked at."""

from __future__ import annotations

from collections.abc import Sequence
from typing import BinaryIO

from engine.errors import InputError

MOST_WORDS = 60_000_000
"""Most numbers of a file: 3 million vertices with colours and as many faces with texture coordinates have fewer."""

_WIDEST = 1 << 22
_BLOCK = 1 << 20
_LONGEST = 1000
"""Letters of the longest word; a number has fewer."""


class PlyWords:
    """The words of a text from where ``handle`` stands.

    ValueError where one is too long for a number or too many are asked for at once, InputError beyond `MOST_WORDS`.
    """

    def __init__(self, handle: BinaryIO, subject: str) -> None:
        self._handle, self._subject = handle, subject
        self._left = MOST_WORDS
        self._words: list[bytes] = []
        self._place = 0
        self._rest = b""

    def peek(self, count: int) -> list[bytes]:
        """Return the next words, as many of ``count`` as there are, and stay before them."""
        self._fill(count)
        return self._words[self._place : self._place + count]

    def skip(self, count: int) -> None:
        """Go past words that ``peek`` returned."""
        self._place += count

    def take(self, count: int) -> list[bytes]:
        """Return the next ``count`` words and go past them; IndexError where there are fewer."""
        if self._place + count > len(self._words):
            self._fill(count)
            if self._place + count > len(self._words):
                raise IndexError
        self._place += count
        return self._words[self._place - count : self._place]

    def row(self, lists: Sequence[bool]) -> tuple[list[int], int]:
        """Return how many values each property of the next row has, and how many words it takes; stay before it.

        Raises
        ------
        IndexError, ValueError
            Where the row is cut off, or a length is no count.
        """
        lengths, width = [], 0
        for is_list in lists:
            count = 1
            if is_list:
                self._fill(width + 1)
                count, width = int(self._words[self._place + width]), width + 1
            if count < 0:
                raise ValueError
            lengths.append(count)
            width += count
        return lengths, width

    def _fill(self, count: int) -> None:
        if self._place + count <= len(self._words):
            return
        if count > _WIDEST:
            raise ValueError
        self._words, self._place = self._words[self._place :], 0
        while len(self._words) < count and (fresh := self._handle.read(_BLOCK)):
            data = self._rest + fresh
            words = data.split()
            self._rest = b""
            if words and not data[-1:].isspace():
                self._rest = words.pop()
                if len(self._rest) > _LONGEST:
                    raise ValueError
            self._words += words
            self._left -= len(words)
            if self._left < 0:
                problem = f"has more than {MOST_WORDS // 1_000_000} million numbers"
                raise InputError(self._subject, problem, "decimate it, or export it as binary")
        if len(self._words) < count and self._rest:
            self._words.append(self._rest)
            self._rest = b""
