"""The rows of a PLY file, text or binary: only what a mesh is made of is kept, the rest is walked past."""

from __future__ import annotations

import struct
from array import array
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.files.mesh_parts import MAX_FACES, check_counts
from engine.files.ply_header import PlyElement, PlyHeader
from engine.files.ply_words import PlyWords
from engine.mesh import IntArray

_MOST_ROWS = 8_000_000
"""Most rows of all elements together, those that are passed over among them."""

_MOST_CELLS = 9_000_000
"""Most values and lists of rows that differ in length, which are gone through one by one."""

_MOST_VALUES = 8 * MAX_FACES
_PIECE = 1 << 20


@dataclass(frozen=True)
class PlyLists:
    """A list property of many rows: how long each is, and all values one behind the other."""

    sizes: IntArray
    values: NDArray[Any]


PlyTable = dict[str, "NDArray[Any] | PlyLists"]


def ply_tables(path: Path, handle: BinaryIO, header: PlyHeader, wanted: frozenset[str]) -> dict[str, PlyTable]:
    """Return the properties ``wanted`` of the elements ``vertex`` and ``face``.

    ``handle`` stands behind the header. What follows the last row of both is not looked at.

    Raises
    ------
    InputError
        On counts that the file does not bear out or that are too large, and rows that are cut off or no numbers.
    """
    subject = str(path)
    there = [element.name for element in header.elements]
    for name in ("vertex", "face"):
        if name not in there:
            raise InputError(subject, f"has no element {name}", "export it as a mesh")
    last = max(there.index("vertex"), there.index("face"))
    tables: dict[str, PlyTable] = {}
    rows, left = 0, path.stat().st_size - handle.tell()
    parts = header.elements[: last + 1]
    for element in parts:
        check_counts(subject, element.count if element.name == "vertex" else 0, 0)
        if element.count > 4 * MAX_FACES:
            raise InputError(subject, f"has {element.count} rows of {element.name[:40]}", "decimate it")
        rows += element.count
        if rows > _MOST_ROWS:
            raise InputError(subject, f"has more than {_MOST_ROWS // 1_000_000} million rows", "decimate it")
        least = element.count * (_least(element, header.order))
        if least > left:
            problem = f"is cut off: {element.count} rows of {element.name[:40]} need {least} bytes, {left} are there"
            raise InputError(subject, problem, "export it again")
    needed = [(element, wanted if element.name in ("vertex", "face") else frozenset()) for element in parts]
    if header.order:
        data, place = handle.read(), 0
        for element, names in needed:
            tables[element.name], place = _binary(data, place, element, header.order, names, subject)
    else:
        words = PlyWords(handle, subject)
        for element, names in needed:
            tables[element.name] = _text(words, element, names, subject)
    return tables


def _least(element: PlyElement, order: str) -> int:
    """Return the fewest bytes of a row."""
    if not order:
        return 2 * len(element.properties)
    return sum(np.dtype(item.length_type or item.type).itemsize for item in element.properties)


def _binary(
    data: bytes, start: int, element: PlyElement, order: str, wanted: frozenset[str], subject: str
) -> tuple[PlyTable, int]:
    if element.count == 0:
        return _split(element, {}, 0), start
    lengths = _row_lengths(data, start, element, order, subject)
    fields: list[Any] = []
    for item, length in zip(element.properties, lengths, strict=True):
        if item.length_type is not None:
            fields.append((f"n {item.name}", order + item.length_type))
        fields.append((item.name, order + item.type, (length,)) if item.length_type else (item.name, order + item.type))
    row = np.dtype(fields)
    stop = start + element.count * row.itemsize
    if stop <= len(data):
        table = np.frombuffer(data, row, element.count, start)
        lists = [(item, n) for item, n in zip(element.properties, lengths, strict=True) if item.length_type]
        if all((table[f"n {item.name}"] == n).all() for item, n in lists):
            return _split(element, {name: table[name] for name in element.names if name in wanted}, element.count), stop
    return _ragged(data, start, element, order, wanted, subject)


def _row_lengths(data: bytes, place: int, element: PlyElement, order: str, subject: str) -> list[int]:
    """Return the list lengths of the row at ``place``, 1 for what is no list."""
    lengths = []
    for item in element.properties:
        size, count = np.dtype(item.type).itemsize, 1
        if item.length_type is not None:
            step = np.dtype(item.length_type).itemsize
            if place + step > len(data):
                raise _cut_off(element, subject)
            count = int(np.frombuffer(data, order + item.length_type, 1, place)[0])
            place += step
        if count < 0 or place + count * size > len(data):
            raise _cut_off(element, subject)
        place += count * size
        lengths.append(count)
    return lengths


def _ragged(
    data: bytes, place: int, element: PlyElement, order: str, wanted: frozenset[str], subject: str
) -> tuple[PlyTable, int]:
    """Read rows of differing lengths one after the other."""
    _check_cells(element, subject)
    plans = [
        (
            None if i.length_type is None else struct.Struct(order + _CODES[i.length_type]).unpack_from,
            0 if i.length_type is None else np.dtype(i.length_type).itemsize,
            np.dtype(i.type).itemsize,
            array("q") if i.name in wanted else None,
            array("q"),
        )
        for i in element.properties
    ]
    end = len(data)
    try:
        for _ in range(element.count):
            for length, step, size, starts, sizes in plans:
                number = 1
                if length is not None:
                    (number,) = length(data, place)
                    place += step
                if starts is not None:
                    starts.append(place)
                    sizes.append(number)
                if number < 0:
                    raise _cut_off(element, subject)
                place += number * size
            if place > end:
                raise _cut_off(element, subject)
    except struct.error as error:
        raise _cut_off(element, subject) from error
    raw = np.frombuffer(data, np.uint8)
    columns: PlyTable = {}
    for item, (_, _, width, starts, sizes) in zip(element.properties, plans, strict=True):
        if starts is None:
            continue
        many = np.array(sizes, dtype=np.int64)
        if many.sum() > _MOST_VALUES:
            raise InputError(subject, f"has {many.sum()} values of {item.name[:40]}", "decimate it")
        offset = np.repeat(np.array(starts, dtype=np.int64) - width * (np.cumsum(many) - many), many)
        offset += width * np.arange(len(offset))
        values = np.empty(len(offset), np.dtype(order + item.type))
        for low in range(0, len(offset), _PIECE):
            taken = raw[offset[low : low + _PIECE, None] + np.arange(width)]
            values[low : low + _PIECE] = taken.reshape(-1).view(values.dtype)
        columns[item.name] = values if item.length_type is None else PlyLists(many, values)
    return columns, place


def _check_cells(element: PlyElement, subject: str) -> None:
    if element.count * len(element.properties) > _MOST_CELLS:
        problem = f"has {element.count} rows of {element.name[:40]} that differ in length"
        raise InputError(subject, problem, "cut its faces into triangles, or decimate it")


_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}


def _text(words: PlyWords, element: PlyElement, wanted: frozenset[str], subject: str) -> PlyTable:
    """Read rows of text, many at a time as long as their lists are of one length."""
    kept: dict[str, list[NDArray[Any]]] = {item.name: [] for item in element.properties if item.name in wanted}
    sizes: dict[str, list[NDArray[Any]]] = {name: [] for name in kept}
    row = 0
    try:
        while row < element.count:
            lengths, width = words.row([item.length_type is not None for item in element.properties])
            rows = min(max(1, _PIECE // 4 // max(width, 1)), element.count - row)
            block = words.peek(rows * width) if width else []
            if _is_even(block, element, lengths, width, rows):
                column = 0
                for item, count in zip(element.properties, lengths, strict=True):
                    column += item.length_type is not None
                    if item.name in wanted:
                        taken = [block[k::width] for k in range(column, column + count)]
                        table = np.array([list(map(float, numbers)) for numbers in taken]).T.reshape(-1)
                        kept[item.name].append(table)
                        sizes[item.name].append(np.full(rows, count))
                    column += count
                words.skip(rows * width)
            else:
                _check_cells(element, subject)
                _ragged_text(words, element, rows, kept, sizes)
            row += rows
    except (ValueError, IndexError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            subject, f"its {element.name[:40]} rows are no numbers or cut off", "export it again"
        ) from error
    columns: PlyTable = {}
    for item in element.properties:
        if item.name in wanted:
            everything = np.concatenate([np.zeros(0), *kept[item.name]])
            many = np.concatenate([np.zeros(0, dtype=np.int64), *sizes[item.name]])
            columns[item.name] = everything if item.length_type is None else PlyLists(many, everything)
    return columns


def _is_even(block: list[bytes], element: PlyElement, lengths: list[int], width: int, rows: int) -> bool:
    """Whether all rows of a block have lists as long as those of the first."""
    if len(block) < rows * width:
        return False
    column = 0
    for item, count in zip(element.properties, lengths, strict=True):
        if item.length_type is not None:
            if block[column::width].count(block[column]) != rows:
                return False
            column += 1
        column += count
    return True


def _ragged_text(
    words: PlyWords,
    element: PlyElement,
    rows: int,
    kept: dict[str, list[NDArray[Any]]],
    sizes: dict[str, list[NDArray[Any]]],
) -> None:
    numbers = {name: array("d") for name in kept}
    counts = {name: array("q") for name in kept}
    for _ in range(rows):
        for item in element.properties:
            many = 1 if item.length_type is None else int(words.take(1)[0])
            if many < 0:
                raise ValueError
            taken = words.take(many)
            if item.name in kept:
                numbers[item.name].extend(map(float, taken))
                counts[item.name].append(many)
    for name in kept:
        kept[name].append(np.array(numbers[name], dtype=np.float64))
        sizes[name].append(np.array(counts[name], dtype=np.int64))


def _split(element: PlyElement, columns: dict[str, NDArray[Any]], count: int) -> PlyTable:
    """Return equal lists as ``PlyLists`` and the rest as it is."""
    result: PlyTable = {}
    for item in element.properties:
        if item.name not in columns and count:
            continue
        column = columns.get(item.name, np.zeros(0))
        if item.length_type is None:
            result[item.name] = column
        else:
            sizes = np.full(count, column.shape[1] if column.ndim == 2 else 0, dtype=np.int64)
            result[item.name] = PlyLists(sizes, column.reshape(-1))
    return result


def _cut_off(element: PlyElement, subject: str) -> InputError:
    return InputError(subject, f"is cut off in its {element.name[:40]} rows", "export it again")
