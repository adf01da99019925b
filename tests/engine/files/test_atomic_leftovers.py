"""What a killed writer leaves behind goes with the next writing of the same file; what is being written stays."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from engine.files.atomic import ABANDONED_S, atomic_write, sweep

WRITER = """
import sys, time
from engine.files.atomic import atomic_write
with atomic_write(sys.argv[1]) as handle:
    handle.write(b"half")
    handle.flush()
    print("writing", flush=True)
    time.sleep(60)
"""


def parts(folder: Path) -> list[Path]:
    return sorted(folder.glob(".*.part"))


def age(path: Path, seconds: float) -> None:
    then = time.time() - seconds
    os.utime(path, (then, then), follow_symlinks=False)


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_killed_writer_s_part_goes_and_a_living_one_s_stays(tmp_path: Path, how: signal.Signals) -> None:
    target = tmp_path / "a.glb"
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(target)], env=environment, stdout=subprocess.PIPE, text=True
    )
    try:
        assert writer.stdout is not None and writer.stdout.readline() == "writing\n"
        (left,) = parts(tmp_path)
        age(left, 10 * ABANDONED_S)
        with atomic_write(target) as handle:
            handle.write(b"whole")
        sweep(target, 0.0)
        assert parts(tmp_path) == [left], "its writer lives, however old it is"
    finally:
        writer.send_signal(how)
        writer.communicate()
    assert parts(tmp_path) == [left]
    with atomic_write(tmp_path / "b.glb") as handle:
        handle.write(b"another file")
    assert parts(tmp_path) == [left]
    with atomic_write(target) as handle:
        handle.write(b"again")
    assert parts(tmp_path) == [] and target.read_bytes() == b"again"


def test_only_old_parts_of_the_same_file_are_removed(tmp_path: Path) -> None:
    target = tmp_path / "a.glb"
    young, old = tmp_path / ".a.glb.00000000.part", tmp_path / ".a.glb.0123abcd.part"
    others = [tmp_path / name for name in (".a.glb.notes.part", ".a.glb.x.0123abcd.part", "a.glb.0123abcd.part")]
    for path in (young, old, *others):
        path.write_bytes(b"x")
    (tmp_path / ".a.glb.11111111.part").symlink_to(others[0])
    (tmp_path / ".a.glb.22222222.part").mkdir()
    os.mkfifo(tmp_path / ".a.glb.33333333.part")
    for path in tmp_path.iterdir():
        age(path, 1.0 if path == young else 2 * ABANDONED_S)
    before = set(tmp_path.iterdir())
    with atomic_write(target) as handle:
        handle.write(b"new")
    assert set(tmp_path.iterdir()) == before - {old} | {target}
    sweep(target, 0.0)
    assert not young.exists() and all(path.exists() for path in others)
