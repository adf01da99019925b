"""What files and folders mean that somebody drops on the window: scans, and fiducials. No Qt."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

# The readers are imported where they are used: the window's first paint does not wait for them.

LARGEST_FOLDER = 200
"""More scans of one folder are not taken in at once: an open project holds them all in memory."""

_BELONGINGS = ("_fiducials", "_landmarks", ".fiducials", "")
"""What stands between a scan's name and the ending of its fiducials, the surest first."""

_HEAD = 1 << 16
"""Within so many bytes a JSON file shows by its keys what it is."""


@dataclass(frozen=True)
class ScanToRead:
    """A scan's file and what is known about it before it is read.

    ``fiducials`` is the file of its fiducials; ``scheme`` is empty where these are to decide.
    """

    path: Path
    fiducials: Path | None = None
    name: str = ""
    word: str = ""
    held: str = ""
    scheme: str = ""


@dataclass(frozen=True)
class Dropped:
    """Dropped files by their meaning; ``left_out`` says in words what cannot be used and why."""

    scans: tuple[ScanToRead, ...] = ()
    fiducials: tuple[Path, ...] = ()
    left_out: tuple[str, ...] = ()


def sort_files(paths: Iterable[Path]) -> Dropped:
    """Return what the files, and those that lie directly in the folders among them, are.

    A file of fiducials named after a scan beside it (``too.abs`` and ``too_fiducials.json``, ``too.pts``) goes with
    it; one that was dropped without a scan stands alone. Folders give their scans in natural order and nothing else.
    """
    from engine.files.scan import has_scan_ending

    scans: list[Path] = []
    fiducials: list[Path] = []
    left_out: list[str] = []
    for path in dict.fromkeys(map(Path, paths)):
        if path.is_dir():
            found = scans_in(path)
            scans += found[:LARGEST_FOLDER]
            if not found:
                left_out.append(f"{path.name} holds no scan")
            if len(found) > LARGEST_FOLDER:
                left_out.append(f"{path.name} holds {len(found)} scans: only the first {LARGEST_FOLDER} are read")
        elif _is_fiducials(path):
            fiducials.append(path)
        elif has_scan_ending(path):
            scans.append(path)
        else:
            left_out.append(f"{path.name} is neither a scan nor fiducials")
    scans = list(dict.fromkeys(scans))
    taken = tuple(ScanToRead(path, fiducials_beside(path)) for path in scans)
    owned = {scan.fiducials for scan in taken}
    alone = tuple(path for path in fiducials if path not in owned)
    return Dropped(taken, alone, tuple(left_out))


def scans_in(folder: Path) -> list[Path]:
    """Return the scans that lie directly in a folder, in natural order: ``take2`` before ``take10``."""
    from engine.files.scan import has_scan_ending

    try:
        files = [path for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")]
    except OSError:
        return []
    scans = [path for path in files if has_scan_ending(path) and not _is_fiducials(path)]
    return sorted(scans, key=_natural)


def fiducials_beside(scan: Path) -> Path | None:
    """Return the file of fiducials that is named after a scan and lies beside it, if there is one."""
    from engine.files.landmarks import ENDINGS

    for belonging in _BELONGINGS:
        for ending in ENDINGS:
            for stem in dict.fromkeys((scan.stem, scan.name.split(".")[0])):
                path = scan.with_name(f"{stem}{belonging}{ending}")
                if path != scan and path.is_file() and (belonging or ending != ".txt") and _is_fiducials(path):
                    return path
    return None


def _is_fiducials(path: Path) -> bool:
    """Whether a file holds landmarks rather than a scan, judged by its ending and, for JSON and text, its content."""
    from engine.files.landmarks import ENDINGS

    ending = path.suffix.lower()
    if ending not in ENDINGS:
        return False
    if ending == ".txt":
        return path.stem.lower().endswith(tuple(part for part in _BELONGINGS if part))
    if ending != ".json":
        return True
    try:
        with path.open("rb") as handle:
            head = handle.read(_HEAD)
    except OSError:
        return False
    named = {key for key in (b"depth", b"disparity", b"points", b"groups", b"landmarks") if b'"' + key + b'"' in head}
    return bool(named) and not named & {b"depth", b"disparity"}


def _natural(path: Path) -> list[tuple[int, int | str]]:
    parts = re.split(r"(\d{1,18})", path.name.lower())
    return [(0, int(part)) if part.isdigit() else (1, part) for part in parts]
