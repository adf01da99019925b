"""The hostile corpus: files that no honest program writes, made by script, and what every reader makes of them.

``python -m tests.engine.files.corpus`` reads all of them and prints the figures.
"""

from __future__ import annotations

import re
import sys
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.engine.files.corpus_bombs import bombs
from tests.engine.files.corpus_runner import LONGEST_S, MOST_MB, Make, Outcome, run
from tests.engine.files.corpus_seeds import Seed, seeds

_NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")
_LIES = (b"-1", b"0", b"1000000000", b"99999999999999999999", b"1e400", b"nan")
_MOST_FIELDS = 6
_FLIPS = 6


@dataclass(frozen=True)
class Case:
    """One file of the corpus: its name, the reader, and what writes it into a folder of its own."""

    name: str
    reader: str
    make: Make


def cases() -> list[Case]:
    """Return the whole corpus, always the same."""
    good = seeds()
    found = [Case(name, reader, make) for name, (reader, make) in bombs(good).items()]
    for key, seed in good.items():
        for label, data in [*_cut(seed.data), *_flipped(seed.data), *_lied(seed.data), *_encoded(seed.data)]:
            found.append(Case(f"{key}: {label}", seed.reader, _damaged(seed, data)))
    return found


def _damaged(seed: Seed, data: bytes) -> Make:
    def make(home: Path) -> Path:
        for name, content in seed.beside:
            (home / name).write_bytes(content)
        (home / seed.name).write_bytes(data)
        return home / seed.name

    return make


def _cut(data: bytes) -> list[tuple[str, bytes]]:
    """Cut at the end of the first header lines, after the first bytes, in the middle and just before the end."""
    lines = [match.end() for match in re.finditer(rb"\n", data[:2000])][:12]
    places = sorted({1, 3, 8, *lines, len(data) // 3, len(data) // 2, len(data) - 2} - {0, len(data)})
    return [(f"cut after {place} bytes", data[:place]) for place in places if place < len(data)]


def _flipped(data: bytes) -> list[tuple[str, bytes]]:
    rng = np.random.default_rng(len(data))
    result = []
    for _ in range(_FLIPS):
        damaged = bytearray(data)
        for place in rng.integers(0, min(len(data), 4000), 3):
            damaged[place] ^= 1 << int(rng.integers(8))
        result.append((f"bits flipped {len(result)}", bytes(damaged)))
    return result


def _lied(data: bytes) -> list[tuple[str, bytes]]:
    """Give the first numbers of a text header other values."""
    found = list(_NUMBER.finditer(data[:1500]))[:_MOST_FIELDS]
    return [
        (f"number {index} is {lie.decode()}", data[: match.start()] + lie + data[match.end() :])
        for index, match in enumerate(found)
        for lie in _LIES
    ]


def _encoded(data: bytes) -> list[tuple[str, bytes]]:
    line = data.find(b"\n") + 1
    return [
        ("in utf-16", data.decode("latin-1").encode("utf-16")),
        ("with line breaks of Windows", data.replace(b"\n", b"\r\n")),
        ("with line breaks of old", data.replace(b"\n", b"\r")),
        ("with zeros in front", bytes(16) + data),
        ("with the first line twice", data[:line] + data),
        ("twice", data + data),
        ("with a letter that is no UTF-8", data[:line] + b"\xff\xfe" + data[line:]),
    ]


def read_all(chosen: list[Case]) -> tuple[list[Outcome], str]:
    """Write and read every case; return the outcomes, and what was printed on standard error."""
    return run((case.reader, case.make) for case in chosen)


def complaint(case: Case, found: Outcome) -> str:
    """Return what is wrong with the answer to a file; empty where it is a value, or a refusal as it should be."""
    if found.kind not in ("value", "refused"):
        return f"{found.kind}: {found.message}"
    if found.seconds > LONGEST_S:
        return f"took {found.seconds:.1f} s"
    if found.megabytes > MOST_MB:
        return f"took {found.megabytes:.0f} MB"
    if found.kind == "refused":
        if "\n" in found.message:
            return f"is refused in several lines: {found.message[:200]!r}"
        if "/corpus" not in found.subject:
            return f"is refused without naming the file: {found.message[:200]!r}"
        if not found.remedy:
            return f"is refused without advice: {found.message[:200]!r}"
        if len(found.message) > 1200:
            return f"is refused in {len(found.message)} letters"
    return ""


def main() -> int:
    """Read the corpus and print counts, the worst time and the worst memory; 1 when a file got the better of us."""
    chosen = [case for case in cases() if not sys.argv[1:] or any(word in case.name for word in sys.argv[1:])]
    start = time.perf_counter()
    outcomes, printed = read_all(chosen)
    wrong = [
        (case.name, text) for case, found in zip(chosen, outcomes, strict=True) if (text := complaint(case, found))
    ]
    for name, text in wrong:
        print(f"WRONG  {name}: {text}")
    pairs = list(zip(chosen, outcomes, strict=True))
    slowest = max(pairs, key=lambda pair: pair[1].seconds)
    largest = max(pairs, key=lambda pair: pair[1].megabytes)
    counts = Counter(found.kind for found in outcomes)
    print(f"{len(chosen)} files in {time.perf_counter() - start:.0f} s: {dict(counts)}, {len(wrong)} wrong")
    print(f"by reader: {dict(Counter(case.reader for case in chosen))}")
    print(f"slowest {slowest[1].seconds:.2f} s of the processor ({slowest[0].name})")
    print(f"largest {largest[1].megabytes:.0f} MB above the start ({largest[0].name})")
    if printed:
        print(f"printed on standard error: {printed[:2000]}")
    return 1 if wrong or printed else 0


if __name__ == "__main__":
    sys.exit(main())
