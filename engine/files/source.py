"""Opening a file that somebody else made: what is checked before its first byte is believed."""

from __future__ import annotations

import stat
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Literal

from engine.errors import InputError

MAX_BYTES = 1 << 30
"""Largest file that is read, in bytes."""

MAX_PIXELS = 16_000_000
"""Largest image and range image, in pixels (a face at 0.1 mm fills four million)."""


def checked_file(path: str | Path, largest: int = MAX_BYTES) -> Path:
    """Return ``path`` when it names a readable regular file of 1 to ``largest`` bytes.

    Raises
    ------
    InputError
        When it is missing, a folder, a device or pipe, empty, too large, or may not be read.
    """
    path = Path(path)
    try:
        if not path.exists():
            raise InputError(str(path), "there is no such file", "check the name and the folder")
        if path.is_dir():
            raise InputError(str(path), "is a folder", "give a file")
        if not path.is_file():
            raise InputError(str(path), "is not a regular file", "copy it to a file first")
        size = path.stat().st_size
        if size == 0:
            raise InputError(str(path), "is empty", "copy or export it again")
        if size > largest:
            raise InputError(str(path), f"has {size / 1e6:.0f} MB, more than {largest / 1e6:.0f}", "make it smaller")
        with path.open("rb"):
            pass
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(str(path), f"cannot be read ({reason})", "check its name and rights") from error
    return path


def kind_of(path: str | Path) -> Literal["file", "folder", "other"] | None:
    """Return what stands at ``path``; None where nothing does.

    Raises
    ------
    InputError
        Where the operating system refuses to look: a name too long for it, a folder without permission.
    """
    try:
        mode = Path(path).stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(_short(path), f"cannot be used ({reason})", "check its name and rights") from error
    return "folder" if stat.S_ISDIR(mode) else "file" if stat.S_ISREG(mode) else "other"


def _short(path: str | Path) -> str:
    text = str(path)
    return text if len(text) <= 240 else f"{text[:120]}...{text[-60:]}"


def read_bytes(path: str | Path, largest: int = MAX_BYTES) -> bytes:
    """Return the bytes of a file that passed ``checked_file``."""
    path = checked_file(path, largest)
    try:
        with path.open("rb") as handle:
            return handle.read(largest)
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "check the disk") from error


def beside(document: Path, name: str, field: str) -> Path:
    """Return the file that ``document`` names in ``field``, which must lie in the document's folder or below.

    Raises
    ------
    InputError
        On an absolute path, ``..``, a link that leads out of the folder, or a missing or unreadable file.
    """
    subject = f"{document}, {field}"
    posix, windows = PurePosixPath(name), PureWindowsPath(name)
    outside = posix.is_absolute() or windows.drive or windows.root or ".." in (*posix.parts, *windows.parts)
    if not name.strip() or "\0" in name or outside:
        raise InputError(subject, f"{name!r} does not lie beside the file", "give a relative path without '..'")
    try:
        target = (document.parent / name).resolve()
        inside = target.is_relative_to(document.parent.resolve())
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(subject, f"{name!r} cannot be followed", "check the link") from error
    if not inside:
        raise InputError(subject, f"{name!r} leads out of the folder", "copy the file beside it")
    try:
        return checked_file(document.parent / name)
    except InputError as error:
        raise InputError(f"{subject}, {name[:200]!r}", error.problem, error.remedy) from error


def check_pixels(subject: str, width: int, height: int, largest: int = MAX_PIXELS) -> None:
    """Raise InputError for an image size that is not 1 to ``largest`` pixels."""
    if width < 1 or height < 1:
        raise InputError(subject, f"its size is {width} x {height} pixels", "export it again")
    if width * height > largest:
        limit = f"more than {largest // 1_000_000} million"
        raise InputError(subject, f"its size is {width} x {height} pixels, {limit}", "scale it down")
