"""What commands print: one JSON object, or the same figures for people; progress and remarks go to stderr."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

Json = Annotated[bool, Parameter(name="--json", negative="", show_default=False, help="Print exactly one JSON object.")]
"""The argument that every command has."""


def plain(value: Any) -> Any:
    """Return ``value`` as JSON has it: numpy numbers as numbers, what is not finite as null, paths as text."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, str | bool | int) or value is None:
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Sequence):
        return [plain(entry) for entry in value]
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def print_result(values: Mapping[str, Any], as_json: bool) -> None:
    """Print figures to stdout: as exactly one JSON object, or one a line."""
    if as_json:
        print(json.dumps(plain(values), allow_nan=False))
        return
    width = max((len(name) for name in values), default=0)
    for name, value in values.items():
        print(f"{name:<{width}}  {shown(value)}")


def shown(value: Any) -> str:
    """Return one figure as people read it."""
    value = plain(value)
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        # 1e-6 px is a figure of its own; everything else is read to a hundredth of a millimetre.
        return f"{value:.4f}" if value == 0 or abs(value) >= 1e-4 else f"{value:.1e}"
    if isinstance(value, list):
        return "  ".join(shown(entry) for entry in value) or "-"
    return str(value)


def print_table(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Print rows under their columns, numbers to the right."""
    cells = [[shown(value) for value in row] for row in rows]
    widths = [max(len(line[i]) for line in [list(columns), *cells]) for i in range(len(columns))]
    for k, line in enumerate([list(columns), *cells]):
        parts = []
        for i, cell in enumerate(line):
            number = isinstance(rows[max(0, k - 1)][i], int | float) if rows else False
            parts.append(cell.rjust(widths[i]) if number else cell.ljust(widths[i]))
        print("  ".join(parts).rstrip())


def remark(text: str) -> None:
    """Print one line to stderr."""
    print(one_line(text), file=sys.stderr, flush=True)


def one_line(text: str) -> str:
    """Return ``text`` on one line, without control characters."""
    return "".join(c if c.isprintable() else " " for c in " ".join(text.split()))


def progress_lines() -> Callable[[float, str], None]:
    """Return a progress that writes a line to stderr whenever its text changes."""
    last = ""

    def report(fraction: float, text: str) -> None:
        nonlocal last
        if text != last:
            last = text
            remark(f"{fraction:4.0%}  {text}")

    return report
