"""What is written down about a fault of our own, without a window: the command line's half of crash handling."""

from __future__ import annotations

import platform
import re
import sys
import traceback
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path

import platformdirs

LONGEST = 200_000
"""Letters of a report that are shown."""

PACKAGES = ("PySide6", "pyvista", "pyvistaqt", "vtk", "numpy", "scipy", "opencv-contrib-python-headless", "pydantic")
_FOLDERS = re.compile(r"""(?<![\w:./\\])(?:[A-Za-z]:[\\/]|~?[\\/])(?=\S)(?:[^:"'<>|\n,;()\[\]]*[\\/])?(?=\S)""")
_OURS = re.compile(r'File "(?:[^"]*?[\\/])?((?:studio|widgets|engine|resources|site-packages)[\\/][^"]*)"')


def crash_folder() -> Path:
    """Return the folder that crash reports of this user go to."""
    return platformdirs.user_state_path("quasiface", appauthor=False) / "crashes"


def write_report(
    error: BaseException,
    folder: Path | None = None,
    facts: Mapping[str, str] | None = None,
    lines: Sequence[str] = (),
) -> Path:
    """Write a crash report and return its path.

    It holds time, versions, ``facts`` (name -> value), the traceback and the last ``lines`` of the log. Of paths only
    the names of files are kept: folders tell who the user is and whom they work for.
    """
    folder = folder or crash_folder()
    folder.mkdir(parents=True, exist_ok=True)
    now = datetime.now().astimezone()
    path = folder / f"{now:%Y%m%d-%H%M%S-%f}.txt"
    told = {"Python": sys.version.split()[0], "System": platform.platform(), **packages(), **(facts or {})}
    text = (
        f"Quasiface Studio {_version('quasiface-studio')}, {now.isoformat(timespec='seconds')}\n"
        + "".join(f"{name}: {value}\n" for name, value in told.items())
        + "\n"
        + "".join(traceback.format_exception(error))
    )
    if lines:
        text += "\nLast lines of the log\n" + "".join(f"{line}\n" for line in lines)
    path.write_text(without_folders(text), encoding="utf-8")
    return path


def packages() -> dict[str, str]:
    """Return name and version of what the studio is built on."""
    return {name: _version(name) for name in PACKAGES}


def without_folders(text: str) -> str:
    """Return a text with every path cut down to the name of its file; our own modules keep theirs from the package on.

    A folder's name with a comma, a colon or a bracket ends the cut early; the user's own folder is cut out before.
    """
    text = _OURS.sub(lambda found: f'File "{found[1]}"', text)
    for home in {str(Path.home()), Path.home().as_posix()}:
        if len(home) > 1:
            text = text.replace(home, "~")
    return "\n".join(line if _OURS.search(line) else _FOLDERS.sub("", line) for line in text.split("\n"))


def _version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version  # only a crash needs it

    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
