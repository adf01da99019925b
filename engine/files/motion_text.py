"""What the text formats of motion share: decoding, labels, rows of numbers with gaps."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Sequence
from math import inf
from pathlib import Path

import numpy as np

from engine.errors import InputError, some
from engine.files.source import read_bytes
from engine.mesh import FloatArray

MAX_TEXT_BYTES = 512 << 20
"""Largest table, in bytes: 35,000 frames of 73 markers take 80 MB."""

MAX_COLUMNS = 20_000
MISSING = frozenset(("", "na", "n/a", "nan", "none", "null", "-", "-nan", "nan(ind)", "-nan(ind)", "1.#qnan", "#n/a"))
"""Words for a place that was not measured."""

_LONGEST_LABEL = 200


def decoded(path: str | Path) -> str:
    """Return the text of a file: UTF-8, or UTF-16 where it begins with its mark.

    Raises
    ------
    InputError
        When it cannot be read, or is no text.
    """
    data = read_bytes(path, MAX_TEXT_BYTES)
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if "\0" in text[:100_000]:
        raise InputError(str(path), "is no text", "give a table, or the file with its own ending")
    return text


def check_labels(path: str | Path, labels: Sequence[str], of: str) -> tuple[str, ...]:
    """Return labels, each usable and none twice.

    Raises
    ------
    InputError
        Naming the first that is empty, unprintable or double; with no labels at all, or too many.
    """
    subject = f"{path}, header"
    if not labels:
        raise InputError(subject, f"names no {of}", "export it again")
    if len(labels) > MAX_COLUMNS:
        raise InputError(subject, f"names {len(labels)} {of}s", f"export at most {MAX_COLUMNS}")
    for place, label in enumerate(labels, start=1):
        if not label.strip() or not label.isprintable() or len(label) > _LONGEST_LABEL:
            raise InputError(subject, f"{of} {place} is called {label[:40]!r}", "give it a name")
    known: set[str] = set()
    double = sorted({label for label in labels if label in known or known.add(label)})  # type: ignore[func-returns-value]
    if double:
        raise InputError(subject, f"names the {of} {some(double)} twice", "rename one of them")
    return tuple(labels)


def length_unit(word: str) -> str | None:
    """Return ``mm``, ``cm`` or ``m`` for what a file calls its unit; None for other words."""
    plain = word.strip().lower().removesuffix("s")
    return {"millimeter": "mm", "millimetre": "mm", "centimeter": "cm", "centimetre": "cm"}.get(
        plain, {"meter": "m", "metre": "m"}.get(plain, plain if plain in ("mm", "cm", "m") else None)
    )


def number_table(path: str | Path, rows: Iterable[tuple[int, Sequence[str]]]) -> FloatArray:
    """Return cells as numbers (rows, columns), NaN where one is empty or NA; the rows are of one length.

    Parameters
    ----------
    path : str or Path
        For messages.
    rows : iterable of (int, sequence of str)
        Line numbers and cells; taken one by one, so that no more than a row is kept as text.

    Raises
    ------
    InputError
        Naming the line of the first cell that is no number, or infinite.
    """
    values, count = array("d"), 0
    for line, row in rows:
        try:
            # Python takes 1_000 for a number; tables of numbers do not hold them.
            numbers = [float(cell) if "_" not in cell else _number(path, line, cell) for cell in row]
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            numbers = [_number(path, line, cell) for cell in row]
        if inf in numbers or -inf in numbers:
            raise InputError(f"{path}, line {line}", "holds an infinite number", "correct it, or leave it empty")
        values.extend(numbers)
        count += 1
    return np.frombuffer(values, np.float64).reshape(count, -1) if len(values) else np.empty((count, 0))


def _number(path: str | Path, line: int, cell: str) -> float:
    cell = cell.strip()
    if cell.lower() in MISSING:
        return float("nan")
    try:
        if "_" in cell:
            raise ValueError
        return float(cell)
    except ValueError:
        if cell.count(",") == 1 and "." not in cell and cell.replace(",", "").strip("+-").isdigit():
            remedy = "export the table with decimal points"
            raise InputError(f"{path}, line {line}", f"{cell[:40]!r} has a decimal comma", remedy) from None
        raise InputError(f"{path}, line {line}", f"{cell[:40]!r} is not a number", "correct it") from None
