"""What is written down about a fault of our own, without a window: the command line's half of crash handling."""

from __future__ import annotations

import platform
import sys
import traceback
from datetime import datetime
from pathlib import Path

import platformdirs


def crash_folder() -> Path:
    """Return the folder that crash reports of this user go to."""
    return platformdirs.user_state_path("quasiface", appauthor=False) / "crashes"


def write_report(error: BaseException, folder: Path | None = None) -> Path:
    """Write a crash report (time, versions, traceback) and return its path."""
    folder = folder or crash_folder()
    folder.mkdir(parents=True, exist_ok=True)
    now = datetime.now().astimezone()
    path = folder / f"{now:%Y%m%d-%H%M%S-%f}.txt"
    modules = ("PySide6", "pyvista", "numpy", "scipy", "cv2")
    versions = ", ".join(f"{name} {getattr(sys.modules.get(name), '__version__', 'not loaded')}" for name in modules)
    path.write_text(
        f"Quasiface Studio, {now.isoformat(timespec='seconds')}\n"
        f"Python {sys.version.split()[0]} on {platform.platform()}\n{versions}\n\n"
        + "".join(traceback.format_exception(error)),
        encoding="utf-8",
    )
    return path
