"""The file of an older version is kept beside the new one when it is saved over for the first time. No Qt."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path

from engine.errors import InputError
from studio.project.migrations import version_now
from studio.project.reading import version_of


def keep_older(path: Path) -> Path | None:
    """Keep the file at ``path`` under another name where an older program wrote it; nothing happens to the file itself.

    Returns
    -------
    Path or None
        ``name.v1.qface.bak`` beside it (with a number where that name is taken by other content); None where there is
        nothing to keep.

    Raises
    ------
    InputError
        When the copy cannot be written.
    """
    try:
        version = version_of(path, whole=False)
    except InputError:
        return None
    if version >= version_now():
        return None
    source = path.resolve()
    for number in range(1, 1000):
        name = f"{source.stem}.v{version}{'' if number == 1 else f'-{number}'}{source.suffix}.bak"
        kept = source.with_name(name)
        try:
            if kept.exists():
                if kept.read_bytes() == source.read_bytes():
                    return kept
                continue
            _copy(source, kept)
        except OSError as error:
            problem = f"the copy of the older file cannot be written ({error.strerror})"
            raise InputError(str(kept), problem, "save the project under another name") from error
        return kept
    raise InputError(str(path), "has too many copies of older versions", "save the project under another name")


def _copy(source: Path, target: Path) -> None:
    """Give the content a second name, or copy it where the disk has no second names."""
    with contextlib.suppress(OSError, NotImplementedError):
        os.link(source, target)  # saving replaces the first name, so the content stays under this one
        return
    part = target.with_name(f".{target.name[:50]}.part")
    try:
        shutil.copy2(source, part)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
