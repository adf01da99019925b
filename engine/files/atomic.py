"""Files that are either whole or untouched."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from engine.errors import InputError
from engine.files.source import kind_of

if sys.platform != "win32":
    import fcntl

ABANDONED_S = 120.0
"""Seconds after which a temporary file that nobody holds counts as left behind."""


@contextmanager
def atomic_write(path: str | Path) -> Iterator[BinaryIO]:
    """Open a file for writing that takes its name only once it is complete and on the disk.

    The bytes go to a temporary file in the same folder, which replaces ``path`` when the block ends. When the block
    raises, or the disk is full, the temporary file is removed and what stood at ``path`` is left as it was. What
    earlier writers of ``path`` left behind, because they were killed, is removed.

    Parameters
    ----------
    path : str or Path
        The file to make or to replace; a symbolic link is followed.

    Yields
    ------
    BinaryIO
        The temporary file, opened for writing bytes.

    Raises
    ------
    InputError
        Where the operating system refuses: no such folder, no permission, disk full.
    """
    path = Path(path)
    temporary: Path | None = None
    try:
        target = path.resolve()
        if target.is_dir():
            raise InputError(str(path), "is a folder", "give a file name")
        sweep(target)
        temporary = target.with_name(f"{_stem(target)}{secrets.token_hex(4)}.part")
        # Not tempfile: its files are private (0600), while a saved document follows the user's umask.
        with os.fdopen(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, 0o666), "wb") as handle:
            _mark(handle.fileno())
            yield handle
            handle.flush()
            os.fsync(handle.fileno())
        temporary.replace(target)
        temporary = None
        _sync_folder(target.parent)
    except (OSError, RuntimeError) as error:
        if isinstance(error, RuntimeError) and "ymlink" not in str(error):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(str(path), f"cannot be written ({reason})", "check the folder and the disk") from error
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                temporary.unlink()


def sweep(path: Path, older_than_s: float = ABANDONED_S) -> None:
    """Remove temporary files of ``path`` whose writers are gone; what a living process writes is never touched.

    Parameters
    ----------
    path : Path
        The file that was to be written.
    older_than_s : float
        Only files whose last change is longer ago; 0 where all their writers are known to have ended.
    """
    stem = _stem(path)
    with contextlib.suppress(OSError), os.scandir(path.parent) as entries:
        for entry in entries:
            if not entry.name.startswith(stem) or not _TOKEN.fullmatch(entry.name[len(stem) :]):
                continue
            with contextlib.suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                if stat.S_ISREG(status.st_mode) and time.time() - status.st_mtime >= older_than_s:
                    _remove_unless_marked(Path(entry.path))


def check_writable(path: str | Path) -> None:
    """Raise an InputError where a file ``path`` clearly cannot be made: no such folder, a folder itself, a bad name."""
    path = Path(path)
    if kind_of(path.parent) != "folder":
        raise InputError(str(path), "its folder does not exist", "make the folder first or choose another")
    if kind_of(path) == "folder":
        raise InputError(str(path), "is a folder", "give a file name")


def _stem(target: Path) -> str:
    # A name may have 255 bytes, and a letter up to four of them.
    return f".{target.name[:50]}."


def _mark(descriptor: int) -> None:
    """Lock a file as long as it is open, however its writer ends; not every file system can."""
    if sys.platform != "win32":
        with contextlib.suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _remove_unless_marked(name: Path) -> None:
    """Remove a file that nobody has locked; OSError where it is, or where the file system cannot tell."""
    if sys.platform == "win32":  # a file that is open there cannot be removed
        name.unlink()
        return
    descriptor = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        name.unlink()
    finally:
        os.close(descriptor)


_TOKEN = re.compile(r"[0-9a-f]{8}\.part")
_BINARY = getattr(os, "O_BINARY", 0)


def _sync_folder(folder: Path) -> None:
    """Make the new name durable too; some systems cannot open a folder, and lose nothing but the guarantee."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
