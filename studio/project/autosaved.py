"""The copy that is written beside a project now and then. No Qt."""

from __future__ import annotations

from pathlib import Path

from studio.project.document import SUFFIX


def autosave_path(path: Path) -> Path:
    """Return where the copy of a project lies: ``name.autosave.qface`` beside it."""
    return path.with_name(f"{path.stem}.autosave{path.suffix or SUFFIX}")


def later_autosave(path: Path) -> Path | None:
    """Return the copy of a project where there is one that is later than the project itself."""
    copy = autosave_path(path)
    try:
        return copy if copy.stat().st_mtime_ns > path.stat().st_mtime_ns else None
    except OSError:
        return None
