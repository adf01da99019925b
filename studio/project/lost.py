"""What is told about a session that ended without saying so, read from its journal alone. No Qt."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path

from engine.errors import InputError
from engine.landmarks import LandmarkState
from studio.project.recovery import read_journal
from studio.project.recovery_files import RecoveryFiles
from studio.project.thumbnail import LARGEST_BYTES, checked


@dataclass(frozen=True)
class LostSession:
    """One session that can be restored.

    Attributes
    ----------
    name, path : str, Path or None
        The project's file name and its place; None where it was never saved.
    time : float
        When the last step was made, seconds since 1970.
    scans, placed, steps, rigs, motions : int
        Scans, placed fiducials, steps since the project was saved, rigs and performances.
    picture : bytes or None
        A PNG of the scan that was looked at.
    damage : str
        What is wrong with it, and what can be saved; empty when nothing is.
    """

    files: RecoveryFiles
    name: str
    path: Path | None
    time: float
    scans: int = 0
    placed: int = 0
    steps: int = 0
    rigs: int = 0
    motions: int = 0
    picture: bytes | None = None
    damage: str = ""


def describe_lost(files: RecoveryFiles) -> LostSession:
    """Return what can be told about a session; nothing is raised."""
    picture = _picture(files.picture)
    try:
        journal = read_journal(files.journal)
    except InputError as error:
        count, rigs, motions = (len(files.pieces(kind)) for kind in ("image", "rig", "motion"))
        parts = [f"{count} range image{'' if count == 1 else 's'}"] if count else []
        parts += [f"{rigs + motions} of rigs and performances"] if rigs + motions else []
        rest = f"{' and '.join(parts)} can be restored" if parts else "nothing can be restored"
        damage = f"{error.problem}; {rest}"
        when = _time(files.journal)
        return LostSession(files, "Damaged session", None, when, count, 0, 0, rigs, motions, picture, damage)
    path = journal.place
    points = [point for scan in journal.scans for point in scan.landmarks.values()]
    return LostSession(
        files,
        path.name if path is not None else "Untitled",
        path,
        journal.time or _time(files.journal),
        len(journal.scans),
        sum(point.state == LandmarkState.PLACED for point in points),
        journal.steps,
        0 if journal.basis is None else len(journal.basis.rigs),
        0 if journal.basis is None else len(journal.basis.motions),
        picture,
    )


def _picture(path: Path) -> bytes | None:
    with contextlib.suppress(OSError):
        if path.stat().st_size <= LARGEST_BYTES:
            return checked(path.read_bytes())
    return None


def _time(path: Path) -> float:
    with contextlib.suppress(OSError):
        return path.stat().st_mtime
    return 0.0
