"""Kills studios in the middle of their work, and looks at what is left of it."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import resources
from engine.files.depth_json import write_depth_scan
from engine.files.landmarks_json import read_fiducials, write_fiducials
from engine.files.scan import read_scan
from engine.scan.range_image import Camera, RangeImage
from studio.project import store
from studio.project.document import Project
from studio.recovery_keeper import RecoveryKeeper
from studio.session import Session
from studio.settings import APPLICATION, Settings
from tests.journeys.kill.stalls import Stalls
from tests.journeys.kill.state import digest

ROOT = Path(__file__).parents[3]
SECOND = 1.0
"""What was done longer ago than this must be there."""
MOMENTS = ("any", "save", "piece", "fit")
"""When a studio is killed: at any time, or just after one of these began."""
COLD = 4
"""Every so many studios one has loaded nothing beforehand: its first steps come while modules are being imported."""
_STEP = 4


@dataclass(frozen=True)
class Killed:
    """One studio that was killed.

    ``reports`` are its lines, ``moment`` what it was killed in, ``killed`` the time (monotonic, s), ``stalled`` for how
    many of the last seconds the machine was held up, as another process measured it (`stalls`).
    """

    seed: int
    folder: Path
    reports: tuple[dict[str, Any], ...]
    moment: str
    killed: float
    stalled: float

    @property
    def states(self) -> tuple[dict[str, Any], ...]:
        """The lines that say what the project was."""
        return tuple(report for report in self.reports if "digest" in report)

    @property
    def allowed(self) -> set[str]:
        """Digests of the states of the last second in which the machine ran, and of the last one before it."""
        early = [k for k, report in enumerate(self.states) if report["t"] <= self.killed - SECOND - self.stalled]
        return {report["digest"] for report in self.states[early[-1] if early else 0 :]}

    def __str__(self) -> str:
        steps = len(self.states)
        cold = " (cold)" if is_cold(self.seed) else ""
        return f"seed {self.seed}{cold}: killed in {self.moment} after {steps} states, {self.folder}"


@dataclass(frozen=True)
class Left:
    """What was found after a kill: the state, whether a session had to be restored, and the seconds of work lost."""

    digest: str
    restored: bool
    lost: float


def make_material(folder: Path) -> Path:
    """Write small scans of the sample with their fiducials, which all studios read; returns the folder."""
    (folder / "scans").mkdir(parents=True)
    for name in ("base", "too", "man"):
        full = read_scan(resources.sample_path("subject", f"{name}.json")).scan
        camera, at = full.camera, _STEP // 2
        assert camera is not None and full.colour is not None
        small = Camera(camera.fx / _STEP, camera.fy / _STEP, (camera.cx - at) / _STEP, (camera.cy - at) / _STEP)
        depth = -full.points[at::_STEP, at::_STEP, 2]
        colour = np.ascontiguousarray(full.colour[at::_STEP, at::_STEP])
        write_depth_scan(folder / "scans" / f"{name}.json", RangeImage(small.points(depth), colour, small), 0.05)
    positions = read_fiducials(resources.sample_path("subject", "base_fiducials.json")).positions
    near = {name: ((x - at) / _STEP, (y - at) / _STEP) for name, (x, y) in positions.items()}
    write_fiducials(folder / "face_fiducials.json", near, (160, 120))
    return folder


def is_cold(seed: int) -> bool:
    """Return whether the studio of a seed loads nothing before it begins."""
    return seed // len(MOMENTS) % COLD == 0


def kill_one(seed: int, material: Path, folder: Path, stalls: Stalls) -> Killed:
    """Start a studio, let it work, kill it and return what it said."""
    chance = random.Random(seed)
    moment = MOMENTS[seed % len(MOMENTS)]
    shutil.copytree(material, folder)
    (folder / "work").mkdir()
    cold = ["cold"] if is_cold(seed) else []
    command = [sys.executable, "-m", "tests.journeys.kill.child", str(seed), str(folder), *cold]
    reports: list[dict[str, Any]] = []
    with (folder / "errors.txt").open("w") as errors:
        process = subprocess.Popen(
            command, cwd=ROOT, env=_environment(folder), stdout=subprocess.PIPE, stderr=errors, text=True
        )
        reader = threading.Thread(target=_read, args=(process, reports))
        reader.start()
        try:
            struck = _wait(process, reports, moment, chance)
            killed = time.monotonic()
        finally:
            process.send_signal(signal.SIGKILL)
            process.wait()
            reader.join()
    trouble = (folder / "errors.txt").read_text()
    assert struck and "Traceback" not in trouble, f"seed {seed}, the studio ended by itself: {trouble[-3000:]}"
    return Killed(seed, folder, tuple(reports), struck, killed, stalls.between(killed - 4 * SECOND, killed))


def _read(process: subprocess.Popen[str], reports: list[dict[str, Any]]) -> None:
    assert process.stdout is not None
    with process.stdout:
        for line in process.stdout:
            if line.endswith("}\n"):  # the last one may be half a line
                reports.append(json.loads(line))


def _wait(process: subprocess.Popen[str], reports: list[dict[str, Any]], moment: str, chance: random.Random) -> str:
    """Wait until it is time to kill, and return what it is killed in; empty when it ended by itself."""
    number, delay, longest = chance.randint(1, 3), chance.uniform(0.0, 0.03), chance.uniform(0.3, 3.0)
    latest = time.monotonic() + 60.0
    begun = False
    while process.poll() is None and time.monotonic() < latest:
        if not begun and any(report.get("what") == "step" for report in tuple(reports)):
            begun, latest = True, time.monotonic() + longest
        if moment != "any" and sum(report.get("about") == moment for report in tuple(reports)) >= number:
            time.sleep(delay)
            return moment
        time.sleep(0.002)
    return "any" if begun and process.poll() is None else ""


def recovery_folder_of(killed: Killed) -> Path:
    """Return where the studio kept its unsaved work."""
    return killed.folder / "xdg_state_home" / APPLICATION / "recovery"


def find_rest(killed: Killed) -> Left:
    """Return what a new session finds, and leave nothing behind; fails where something of what was said is missing."""
    session = Session(Settings(killed.folder / "looker.ini"))
    keeper = RecoveryKeeper(session, recovery_folder_of(killed))
    project_file = killed.folder / "work" / "face.qface"
    try:
        found = keeper.abandoned()
        assert len(found) <= 1, f"{killed}: {len(found)} sessions"
        saved = store.load(project_file) if project_file.exists() else None
        if found:
            keeper.restore(found[0])
            project = session.project
        else:
            project = saved if saved is not None else Project()
        state = digest(project)
        places = [k for k, report in enumerate(killed.states) if report["digest"] == state]
        assert places, f"{killed}: what is left never was"
        following = killed.states[places[-1] + 1 :]
        lost = max(0.0, killed.killed - following[0]["t"]) if following else 0.0
        assert state in killed.allowed, f"{killed}: {lost:.2f} s are lost, held up for {killed.stalled:.2f} s"
        if saved is not None:
            assert digest(saved) in {report["digest"] for report in killed.states}, f"{killed}: the file was never so"
        return Left(state, bool(found), lost)
    finally:
        session.stack.setClean()
        session.close()
        keeper.close()
        _check_remains(killed)


def _check_remains(killed: Killed) -> None:
    work = {path.name for path in (killed.folder / "work").iterdir()}
    assert work <= {"face.qface"}, f"{killed}: {work} beside the project"
    folder = recovery_folder_of(killed)
    rest = sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []
    assert not rest, f"{killed}: {rest} in the recovery folder"


def _environment(folder: Path) -> dict[str, str]:
    names = ("XDG_CONFIG_HOME", "XDG_STATE_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME")
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    return {**os.environ, **threads, **{name: str(folder / name.lower()) for name in names}}
