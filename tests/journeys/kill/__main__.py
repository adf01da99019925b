"""The long kill test: ``python -m tests.journeys.kill --kills 100 [--seed S] [--at-once N]``, under a display."""

from __future__ import annotations

import argparse
import secrets
import shutil
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from PySide6.QtCore import QCoreApplication

from tests.journeys.kill.killer import MOMENTS, Killed, find_rest, is_cold, kill_one, make_material
from tests.journeys.kill.stalls import Stalls


def main() -> int:
    """Kill, look, and print the figures; 1 when anything was lost."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=secrets.randbelow(10**6))
    parser.add_argument("--at-once", type=int, default=2)
    wanted = parser.parse_args()
    print(f"{wanted.kills} kills, seed {wanted.seed}", flush=True)
    application = QCoreApplication.instance() or QCoreApplication([])
    folder, failures, begun = Path(tempfile.mkdtemp()), [], time.monotonic()
    losses: list[float] = []
    strict: list[tuple[float, str]] = []
    held: list[float] = []
    moments: dict[str, int] = dict.fromkeys(MOMENTS, 0)
    restored = states = 0
    material = make_material(folder / "material")

    def kill(seed: int) -> Killed | AssertionError:
        try:
            return kill_one(seed, material, folder / str(seed), stalls)
        except AssertionError as error:
            return error

    with Stalls(folder) as stalls, ThreadPoolExecutor(wanted.at_once) as pool:
        for killed in pool.map(kill, range(wanted.seed, wanted.seed + wanted.kills)):
            if isinstance(killed, AssertionError):
                failures.append(str(killed))
                print(killed, flush=True)
                continue
            moments[killed.moment] += 1
            states += len(killed.states)
            try:
                left = find_rest(killed)
            except Exception as error:  # every kind of loss is counted, and the others are still looked at
                failures.append(f"{type(error).__name__}: {error}")
                print(failures[-1], flush=True)
                continue
            restored += left.restored
            losses.append(left.lost)
            held.append(killed.stalled)
            strict.append((left.lost, f"{killed.moment}{' cold' if is_cold(killed.seed) else ''}"))
            shutil.rmtree(killed.folder)
    shutil.rmtree(folder, ignore_errors=not failures)
    where = ", ".join(f"{count} in {moment}" for moment, count in moments.items())
    print(
        f"{wanted.kills} kills ({where}) after {states} states; {restored} sessions restored, {len(failures)} failures"
    )
    middle = sorted(losses)[len(losses) // 2] if losses else 0.0
    print(f"work lost: {middle:.2f} s in the middle, {max(losses, default=0.0):.2f} s at most")
    print("each, nothing forgiven: " + ", ".join(f"{lost:.2f} ({where})" for lost, where in strict))
    print(f"the machine was held up for at most {max(held, default=0.0):.2f} s, in {sum(s > 0 for s in held)}")
    print(f"{time.monotonic() - begun:.0f} s")
    del application
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
