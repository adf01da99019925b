"""How long the machine held everybody up: a process that does next to nothing, and says when even that took long.

``python -m tests.journeys.kill.stalls FOLDER``. It shares the processors and the disk with the studios and none of
their code: what it waits for, no studio could have had either.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from itertools import pairwise
from pathlib import Path
from types import TracebackType

TURN = 0.02
USUAL = 0.25
"""A turn that took no longer than this many seconds is none that the machine was held up in."""


def held_up(times: list[float], begin: float, end: float) -> float:
    """Return for how many seconds between ``begin`` and ``end`` (monotonic) the machine was held up.

    ``times`` are the ends of the turns. What comes beyond the usual of a gap counts.
    """
    return sum(max(0.0, min(b, end) - max(a + USUAL, begin)) for a, b in pairwise(times))


class Stalls:
    """Runs that process while the context lasts, and keeps when its turns ended."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.times: list[float] = []

    def __enter__(self) -> Stalls:
        command = [sys.executable, str(Path(__file__).resolve()), str(self._folder)]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self._reader = threading.Thread(target=self._read)
        self._reader.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.wait()
        self._reader.join()

    def between(self, begin: float, end: float) -> float:
        """Return `held_up`."""
        return held_up(list(self.times), begin, end)

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout:
            for line in self._process.stdout:
                if line.endswith("\n"):
                    self.times.append(float(line))


def main(folder: Path) -> None:
    """Sleep, write a small file to the disk, and say when that was done, again and again until killed."""
    path = folder / "stalls"
    while True:
        with path.open("wb") as handle:
            handle.write(bytes(4096))
            handle.flush()
            os.fsync(handle.fileno())
        print(time.monotonic(), flush=True)
        time.sleep(TURN)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
