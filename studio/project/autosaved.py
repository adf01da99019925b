"""The copy that is written beside a project now and then, and those that somebody has still to decide on. No Qt."""

from __future__ import annotations

import re
import threading
import time
from pathlib import Path

from studio.project.document import SUFFIX, Project


def autosave_path(path: Path) -> Path:
    """Return where the copy of a project lies: ``name.autosave.qface`` beside it."""
    return path.with_name(f"{path.stem}.autosave{path.suffix or SUFFIX}")


def undecided_autosaves(path: Path) -> tuple[tuple[Path, float], ...]:
    """Return the copies of a project that are later than it, or were put aside, each with its time (s since 1970).

    The latest comes first.
    """
    copy, found = autosave_path(path), []
    aside = re.compile(rf"{re.escape(copy.stem)}-\d{{8}}-\d{{6}}(-\d+)?{re.escape(copy.suffix)}")
    try:
        for file in path.parent.iterdir():
            if aside.fullmatch(file.name) or (file.name == copy.name and _later(file, path)):
                found.append((file, file.stat().st_mtime))
    except OSError:
        return ()
    return tuple(sorted(found, key=lambda pair: -pair[1]))


def _later(file: Path, other: Path) -> bool:
    return file.stat().st_mtime_ns > other.stat().st_mtime_ns


def put_aside(copy: Path) -> Path:
    """Rename a copy to ``name.autosave-<its time>.qface``, so that another may be written; nothing is replaced.

    Raises
    ------
    OSError
        When that is not possible; it is still where it was.
    """
    when = time.strftime("%Y%m%d-%H%M%S", time.localtime(copy.stat().st_mtime))
    number, other = 1, copy.with_name(f"{copy.stem}-{when}{copy.suffix}")
    while other.exists():
        number += 1
        other = copy.with_name(f"{copy.stem}-{when}-{number}{copy.suffix}")
    return copy.rename(other)


class OwnAutosaves:
    """The copies of one project that one session has written, until they are dropped.

    Parameters
    ----------
    gate : threading.Lock
        Shared by all of one session: one is written after the other.
    """

    def __init__(self, gate: threading.Lock) -> None:
        self._gate = gate
        self._dropped = False
        self._files: set[Path] = set()

    def __contains__(self, path: object) -> bool:
        return path in self._files

    def claim(self, target: Path) -> None:
        """Say that a copy will be written there; what lies there by then is one of these."""
        self._files.add(target)

    def write(self, project: Project, target: Path) -> bool:
        """Write a copy, in any thread; False where they were dropped meanwhile, and nothing is left of it then."""
        from studio.project import store
        from studio.project.thumbnail import picture_of

        with self._gate:
            if self._dropped:
                return False
            store.remove_remains(target)
            store.save(project, target, picture=picture_of(project))
            if self._dropped:
                target.unlink(missing_ok=True)
            return not self._dropped

    def drop(self) -> None:
        """Delete them, also the one that is being written, as soon as it is.

        Raises
        ------
        OSError
            When one cannot be deleted.
        """
        self._dropped = True
        for path in self._files:
            path.unlink(missing_ok=True)
