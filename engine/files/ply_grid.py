"""The element ``range_grid`` of a PLY file: for every pixel the index of its vertex, or none."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, Literal

import numpy as np

from engine.errors import InputError
from engine.files.ply_header import PlyElement
from engine.mesh import IntArray

_ROWS_AT_ONCE = 1 << 16
_BYTES_AT_ONCE = 4 << 20
_LONGEST_NUMBER = 9

Block = tuple[IntArray, int]
"""Vertex indices of the rows of a block, -1 for none, and how many bytes they took."""


def read_range_grid(path: Path, handle: BinaryIO, order: str, element: PlyElement, vertices: int) -> IntArray:
    """Read a range grid and return the vertex index (rows,) of every pixel, -1 where nothing was measured.

    It is read in blocks and given up at the first row that cannot be right.

    Parameters
    ----------
    path : Path
        The file, for messages.
    handle : BinaryIO
        Stands at the element's first row; at the first byte behind its last row afterwards.
    order : str
        ``<`` or ``>`` for the byte order; empty for text.
    element : PlyElement
        The element as declared: one list.
    vertices : int
        How many vertices the file declares.

    Raises
    ------
    InputError
        When the file is too short for the rows, a row is no list of 0 or 1 index, or an index has no vertex.
    """
    items = element.properties
    if len(items) != 1 or items[0].length_type is None or items[0].type[0] == "f":
        raise InputError(f"{path}, range_grid", "is not one list of vertex indices", "export it again")
    start = handle.tell()
    left = path.stat().st_size - start
    least = np.dtype(items[0].length_type).itemsize * element.count if order else 2 * element.count - 1
    if left < least:
        problem = f"is cut off: {element.count} rows of its range_grid need {least} bytes or more, {left} are there"
        raise InputError(str(path), problem, "export it again")
    parse = _binary_parser(order, items[0].length_type, items[0].type) if order else _parse_text
    result = np.full(element.count, -1, dtype=np.int64)
    done, kept = 0, b""
    while done < element.count:
        fresh = handle.read(_BYTES_AT_ONCE)
        data = kept + fresh
        indices, used = parse(data, element.count - done, not fresh)
        wrong = np.flatnonzero((indices >= vertices) | (indices < -1))
        if len(wrong):
            row = done + int(wrong[0])
            problem = f"row {row} names vertex {indices[wrong[0]]}, there are {vertices}: it does not fit the vertices"
            raise InputError(f"{path}, range_grid", problem, "export it again")
        result[done : done + len(indices)] = indices
        done += len(indices)
        start += used
        kept = data[used:]
        # What is left of a good block is less than a row; text may have any number of empty lines.
        if done < element.count and (not fresh or len(kept) > _BYTES_AT_ONCE // 2):
            raise InputError(str(path), f"is damaged or cut off in row {done} of its range_grid", "export it again")
    handle.seek(start)
    return result


def _binary_parser(order: str, length: str, index: str) -> Callable[[bytes, int, bool], Block]:
    endian: Literal["little", "big"] = "little" if order == "<" else "big"
    wide, size = np.dtype(length).itemsize, np.dtype(index).itemsize
    none, one = re.escape(bytes(wide)), re.escape((1).to_bytes(wide, endian))
    row = b"(?:%b|%b.{%d})" % (none, one, size)
    some = re.compile(b"%b{0,%d}+" % (row, _ROWS_AT_ONCE), re.DOTALL)
    each = re.compile(row, re.DOTALL)

    def parse(data: bytes, most: int, last: bool) -> Block:
        # The place of a row depends on all before it: the regular expression walks, NumPy does the rest.
        found, position, count = [], 0, 0
        while count < most and (match := some.match(data, position)) and match.end() > position:
            rows = each.findall(data, position, match.end())[: most - count]
            lengths = np.fromiter(map(len, rows), np.int64, len(rows))
            ends = position + np.cumsum(lengths)
            filled = lengths > wide
            places = ends[filled][:, None] - size + np.arange(size)
            indices = np.full(len(rows), -1, dtype=np.int64)
            values = np.frombuffer(data, np.uint8)[places].view(order + index).ravel()
            # An index below 0 must not pass for "none".
            indices[filled] = np.where(values < 0, -2, values)
            found.append(indices)
            position, count = int(ends[-1]), count + len(rows)
        return np.concatenate([np.zeros(0, np.int64), *found]), position

    return parse


def _parse_text(data: bytes, most: int, last: bool) -> Block:
    if not last:
        data = data[: data.rfind(b"\n") + 1]
    letters = np.frombuffer(data, np.uint8)
    digit = (letters >= 48) & (letters <= 57)
    alien = ~digit & (letters != 32) & ((letters < 9) | (letters > 13))
    if alien.any():
        # The rows before it still count, so that the message names the right one.
        data = data[: data.rfind(b"\n", 0, int(alien.argmax())) + 1]
        letters, digit = letters[: len(data)], digit[: len(data)]
    edges = np.flatnonzero(np.diff(digit.view(np.int8), prepend=np.int8(0), append=np.int8(0)))
    starts, ends = edges[::2], edges[1::2]
    breaks = np.flatnonzero(letters == 10)
    line = np.searchsorted(breaks, starts)
    first = np.flatnonzero(np.diff(line, prepend=-1))
    words = np.diff(first, append=len(starts))
    short = ends - starts <= _LONGEST_NUMBER
    numbers = np.fromstring(data, dtype=np.int64, sep=" ") if len(starts) else np.zeros(0, np.int64)
    head, second = numbers[first], np.minimum(first + 1, max(len(numbers) - 1, 0))
    right = ((words == 1) & (head == 0)) | ((words == 2) & (head == 1))
    right &= short[first] & ((words == 1) | short[second])
    count = min(most, len(first) if right.all() else int(right.argmin()))
    if count == 0:
        return np.zeros(0, np.int64), 0
    indices = np.where(words[:count] == 2, numbers[second[:count]], -1)
    end = int(line[first[count - 1]])
    return indices, int(breaks[end]) + 1 if end < len(breaks) else len(data)
