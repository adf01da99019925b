"""Tables of numbers in text, read in blocks: fast, in little memory, and every row counted."""

from __future__ import annotations

import re
from typing import IO

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.mesh import FloatArray

MAX_NUMBERS = 12_000_000
"""Most numbers that are read from one text; more belong into a binary file."""

LONGEST_NUMBER = 64
"""Most letters of a number, spaces around it included, on the average over a file."""

_BYTES_AT_ONCE = 1 << 20
_COMMENT = re.compile(rb"(?:#|//).*")
_BLANKS = np.zeros(256, dtype=np.bool_)
_BLANKS[[9, 10, 11, 12, 13, 32]] = True


def read_table(
    handle: IO[bytes],
    subject: str,
    columns: int,
    rows: int | None = None,
    separators: bytes = b"",
    comments: bool = False,
) -> FloatArray:
    """Read rows of ``columns`` numbers each, one row a line; empty lines do not count.

    Parameters
    ----------
    handle : binary file
        Stands at the first row; at the first byte behind the last row afterwards.
    subject : str
        The file's name, and what the rows are, for messages.
    columns : int
        How many numbers stand in a row.
    rows : int, optional
        How many rows there must be. Left out, the rest of the file is read.
    separators : bytes
        Characters that part numbers as blanks do.
    comments : bool
        Whether the rest of a line behind ``#`` or ``//`` is left out.

    Returns
    -------
    (rows, columns) float
        As printed; ``nan`` and ``inf`` are numbers.

    Raises
    ------
    InputError
        On fewer rows than announced, a row of another length, what is no number, or more than `MAX_NUMBERS`.
    """
    start = handle.tell()
    room = (_bytes_left(handle) + 1) // (2 * columns)
    if rows is not None and rows > room:
        raise InputError(subject, f"is cut off: {rows} rows are announced, there is room for {room}", "export it again")
    expected = room + 1 if rows is None else rows
    _check_count(subject, (expected if rows is not None else 0) * columns)
    result = np.empty((min(expected, MAX_NUMBERS // columns + 1), columns))
    table = bytes.maketrans(separators, b" " * len(separators))
    done, kept, ended = 0, b"", expected == 0
    while not ended and (rows is None or done < rows):
        fresh = handle.read(_BYTES_AT_ONCE)
        data, kept = _split_at(kept + fresh, b"\n", not fresh)
        cleaned = _COMMENT.sub(_blanked, data) if comments else data
        cleaned = cleaned.translate(table) if separators else cleaned
        numbers, used = _rows_of(cleaned, columns, expected - done, subject, done)
        _check_count(subject, (done + len(numbers)) * columns)
        result[done : done + len(numbers)] = numbers
        done += len(numbers)
        start += used
        ended = not fresh
        if len(kept) > 4 * _BYTES_AT_ONCE:
            raise InputError(subject, "has a line that is too long for text", "export it again")
    if rows is not None and done < rows:
        raise InputError(subject, f"is cut off: {done} of {rows} rows are there", "export it again")
    if rows is not None:
        handle.seek(start)
    return result if done == len(result) else np.array(result[:done])


def read_numbers(handle: IO[bytes], subject: str, count: int) -> FloatArray:
    """Read ``count`` numbers (count,) parted by blanks and line breaks, and make sure that nothing else follows.

    The handle may be of a packed file: no more is unpacked than that many numbers can take.

    Raises
    ------
    InputError
        On more or fewer numbers, what is no number, or more than `MAX_NUMBERS`.
    """
    _check_count(subject, count)
    result = np.empty(count)
    done, kept, taken = 0, b"", 0
    while fresh := handle.read(_BYTES_AT_ONCE):
        taken += len(fresh)
        data, kept = _split_at(kept + fresh, b" \t\r\n", False)
        done = _append(result, done, data, subject)
        if taken > LONGEST_NUMBER * count + _BYTES_AT_ONCE or len(kept) > _BYTES_AT_ONCE:
            raise InputError(subject, f"is longer than {count} numbers can be", "export it again")
    done = _append(result, done, kept, subject)
    if done < count:
        raise InputError(subject, f"is cut off: {done} of {count} numbers are there", "export it again")
    return result


def numbers_in(line: bytes) -> list[float] | None:
    """Return the numbers of one line, None when something else stands there."""
    try:
        return [float(word) for word in line.split() if b"_" not in word or _refuse()]
    except ValueError:
        return None


def _refuse() -> bool:
    raise ValueError


def _append(result: FloatArray, done: int, data: bytes, subject: str) -> int:
    numbers = _parsed(data, subject, "")
    if done + len(numbers) > len(result):
        raise InputError(subject, f"holds more than {len(result)} numbers", "export it again")
    result[done : done + len(numbers)] = numbers
    return done + len(numbers)


def _rows_of(data: bytes, columns: int, most: int, subject: str, done: int) -> tuple[NDArray[np.float64], int]:
    """Return the first ``most`` rows (k, columns) of whole lines, and how many bytes they and empty lines took."""
    letters = np.frombuffer(data, np.uint8)
    word = ~_BLANKS[letters]
    begins = np.flatnonzero(word[1:] & ~word[:-1]) + 1
    if len(word) and word[0]:
        begins = np.concatenate([[0], begins])
    breaks = np.flatnonzero(letters == 10)
    lengths = np.diff(np.searchsorted(begins, breaks), prepend=0, append=len(begins))[: len(breaks) + 1]
    if len(begins) and int(lengths.sum()) < len(begins):
        lengths = np.append(lengths, len(begins) - int(lengths.sum()))
    filled = np.flatnonzero(lengths)
    if len(filled) > most:
        end = int(breaks[filled[most - 1]]) + 1
        data, filled = data[:end], filled[:most]
    wrong = np.flatnonzero(lengths[filled] != columns)
    if len(wrong):
        place = int(wrong[0])
        problem = f"row {done + place + 1} has {lengths[filled[place]]} columns, not {columns}"
        raise InputError(subject, problem, "export it again")
    numbers = _parsed(data, subject, f" in or after row {done + 1}")
    return numbers.reshape(-1, columns) if len(numbers) == len(filled) * columns else _no_number(subject, ""), len(data)


def _parsed(data: bytes, subject: str, where: str) -> NDArray[np.float64]:
    if not data.strip():
        return np.zeros(0)
    try:
        return np.fromstring(data, dtype=np.float64, sep=" ")
    except ValueError:
        return _no_number(subject, where)


def _no_number(subject: str, where: str) -> NDArray[np.float64]:
    raise InputError(subject, f"holds something that is no number{where}", "export it again")


def _split_at(data: bytes, marks: bytes, last: bool) -> tuple[bytes, bytes]:
    """Return what ends with one of ``marks``, and the rest."""
    if last:
        return data, b""
    end = max(data.rfind(marks[index : index + 1]) for index in range(len(marks))) + 1
    return data[:end], data[end:]


def _blanked(match: re.Match[bytes]) -> bytes:
    return b" " * len(match.group())


def _bytes_left(handle: IO[bytes]) -> int:
    place = handle.tell()
    end = handle.seek(0, 2)
    handle.seek(place)
    return end - place


def _check_count(subject: str, count: int) -> None:
    if count > MAX_NUMBERS:
        problem = f"has more than {MAX_NUMBERS // 1_000_000} million numbers as text"
        raise InputError(subject, problem, "save it in a binary format")
