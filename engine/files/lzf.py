"""Unpacking of LZF, the compression of binary PCD files."""

from __future__ import annotations

MOST_PIECES = 8_000_000
"""Pieces after which unpacking is given up: 16 million points of 12 bytes that cannot be packed are 6 million."""


class LzfError(ValueError):
    """The packed bytes are damaged, or do not hold what was announced."""


def unpack_lzf(packed: bytes, length: int) -> bytearray:
    """Return the ``length`` bytes that ``packed`` holds.

    A piece is a byte below 32, n, and n + 1 bytes to copy; or a byte whose upper three bits are a length (7: the next
    byte is added to it) and whose lower five bits with one more byte say how far back that many bytes and two stand.
    Room is taken as bytes are unpacked, never on the word of the packed bytes.

    Raises
    ------
    LzfError
        When a piece is cut off, points before the beginning, goes beyond ``length`` or does not reach it, or when
        there are more than `MOST_PIECES`.
    """
    out = bytearray()
    place, end, filled = 0, len(packed), 0
    try:
        for _ in range(MOST_PIECES):
            if place >= end or filled > length:
                break
            control = packed[place]
            place += 1
            if control < 32:
                control += 1
                out += packed[place : place + control]
                place += control
                filled += control
                continue
            size = control >> 5
            if size == 7:
                size += packed[place]
                place += 1
            size += 2
            source = filled - ((control & 31) << 8) - packed[place] - 1
            place += 1
            if source < 0:
                raise LzfError("a piece points before the beginning")
            if source + size <= filled:
                out += out[source : source + size]
            else:
                pattern = bytes(out[source:])
                out += (pattern * (size // len(pattern) + 1))[:size]
            filled += size
        else:
            raise LzfError(f"it is in more than {MOST_PIECES // 1_000_000} million pieces")
    except IndexError as error:
        raise LzfError("the last piece is cut off") from error
    if place > end:
        raise LzfError("the last piece is cut off")
    if filled != length:
        raise LzfError(f"it unpacks to {'more than' if filled > length else f'{filled} of'} {length} bytes")
    return out
