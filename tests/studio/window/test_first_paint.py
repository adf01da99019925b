"""What the first paint does not wait for: the libraries of 3-D, pictures, fits and reports come after it."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import sys
from studio.app import make_window
from studio.settings import Settings
window = make_window(Settings())
print(*(name for name in ("pyvista", "vtkmodules", "cv2", "scipy", "matplotlib") if name in sys.modules))
import os
sys.stdout.flush()
os._exit(0)
"""


def test_a_window_is_made_without_3d_pictures_or_fits() -> None:
    ended = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    heavy = set(ended.stdout.split())
    assert not heavy
