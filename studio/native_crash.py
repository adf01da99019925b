"""A crash that Python cannot catch: its stack is written by `faulthandler`, and told at the next start. No Qt."""

from __future__ import annotations

import contextlib
import faulthandler
import os
import sys
from pathlib import Path
from typing import TextIO

from studio.crash_report import crash_folder

PREFIX, RUNNING, FOUND = "native-", ".running", ".txt"


class NativeWatch:
    """Writes the stack of a native crash of this process to a file of its own.

    Parameters
    ----------
    folder : Path, optional
        Where it lies; by default with the crash reports.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._folder = folder or crash_folder()
        self._path = self._folder / f"{PREFIX}{os.getpid()}{RUNNING}"
        self._file: TextIO | None = None

    def start(self) -> None:
        """Watch from now on; where the folder cannot be written, nothing is watched."""
        with contextlib.suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("w", encoding="utf-8")
            faulthandler.enable(self._file)

    def stop(self) -> None:
        """Watch no more; nothing is left behind."""
        if self._file is None:
            return
        faulthandler.disable()
        self._file.close()
        self._file = None
        with contextlib.suppress(OSError):
            self._path.unlink()

    def left_behind(self) -> tuple[Path, ...]:
        """Return the reports of processes that crashed since the last call, each once; they stay as text files."""
        found = []
        for path in sorted(self._folder.glob(f"{PREFIX}*{RUNNING}")) if self._folder.is_dir() else ():
            number = path.name[len(PREFIX) : -len(RUNNING)]
            if path == self._path or not number.isdecimal() or _alive(int(number)):
                continue
            with contextlib.suppress(OSError):
                if path.stat().st_size:
                    found.append(path.rename(path.with_suffix(FOUND)))
                else:
                    path.unlink()  # it was killed: there is nothing to say
        return tuple(found)


def _alive(number: int) -> bool:
    if sys.platform == "win32":
        return False  # the file of a living process is locked there: renaming fails and it stays
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
