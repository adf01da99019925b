"""Dense motion as a NumPy archive: ``vertices (L, N, 3)`` and ``fps``."""

from __future__ import annotations

from pathlib import Path

from engine.errors import InputError
from engine.files.dense_checks import MAX_DENSE_BYTES, dense_file
from engine.files.motion_file import MotionFile
from engine.files.npz_arrays import open_npz

MAX_UNPACKED = 1 << 30
"""Most bytes that are unpacked into memory; an archive that is not compressed is mapped and may be larger."""


def read_motion_npz(
    path: str | Path,
    *,
    unit: str | None = None,
    up: str | None = None,
    forward: str | None = None,
    fps: float | None = None,
) -> MotionFile:
    """Read ``vertices (L, N, 3)``, ``fps`` and optionally ``unit`` (mm, cm or m) from a ``.npz`` archive.

    The vertices stay as they are stored (float16, 32 or 64): an array that is not compressed is memory-mapped, a
    compressed one unpacked up to 1 GB.

    Raises
    ------
    InputError
        On a damaged archive, missing or wrong arrays, pickled objects, sizes that the file does not bear out, and
        positions that are not finite (naming the frame).
    """
    path = Path(path)
    with open_npz(path, MAX_DENSE_BYTES) as archive:
        vertices = archive.mapped("vertices", (None, None, 3), "f")
        if vertices is None:
            packed = archive.unpacked_bytes("vertices")
            if packed > MAX_UNPACKED:
                problem = f"is packed and takes {packed / 1e6:.0f} MB"
                remedy = "save it with numpy.savez (not compressed), which is read piece by piece"
                raise InputError(f"{path}, vertices", problem, remedy)
            vertices = archive.array("vertices", (None, None, 3), "f", most=MAX_UNPACKED)
        named = float(archive.array("fps", (), "fiu")) if "fps" in archive else None
        word = str(archive.array("unit", (), "U", 256)) if "unit" in archive else None
    return dense_file(
        path, "npz", vertices, unit=unit, up=up, forward=forward, fps=fps, named_unit=word, named_fps=named
    )
