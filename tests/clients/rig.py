"""Writes the sample's hand-sculpted rig as GLB, and the truth beside it as ``.npz``, for other programs to read."""

from __future__ import annotations

import sys
from pathlib import Path

from engine.files.rig import read_rig
from engine.files.rig_out import write_rig
from studio.basis.sample import HAND, sample_path

if __name__ == "__main__":
    folder, file = Path(sys.argv[1]), read_rig(sample_path(HAND))
    write_rig(folder / "rig.glb", file.rig)
    write_rig(folder / "rig.npz", file.rig)
