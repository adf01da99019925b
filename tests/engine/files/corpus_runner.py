"""Every file is read in a process of its own kind: memory limited and measured, time limited, streams watched.

``python -m tests.engine.files.corpus_runner`` is the worker: a line of JSON (reader, path) in, a line of JSON out.
"""

from __future__ import annotations

import importlib
import json
import queue
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

ROOT = Path(__file__).parents[3]
LONGEST_S = 10.0
"""Most seconds of the processor; on an idle machine they are seconds."""

HANG_S = 60.0
MOST_MB = 1024
_ROOM = 1600 << 20

Make = Callable[[Path], Path]
"""Writes a file into the folder that it is given, and returns its path."""

READERS = {
    "scan": ("engine.files.scan", "read_scan"),
    "mesh": ("engine.files.mesh_file", "read_mesh"),
    "rig": ("engine.files.rig", "read_rig"),
    "rig folder": ("tests.engine.files.corpus_rigs", "read_rig_beside"),
    "fiducials": ("engine.files.landmarks_json", "read_fiducials"),
    "landmarks": ("engine.files.landmarks", "read_landmarks"),
    "mapping": ("engine.files.mapping", "read_mapping"),
    "scheme": ("engine.files.scheme", "read_scheme"),
    "template": ("engine.files.template", "read_template"),
    "limits": ("engine.files.limits", "read_limits"),
    "motion": ("engine.files.motion", "read_motion"),
    "pairs": ("engine.files.marker_pairs", "read_marker_pairs"),
    "image": ("engine.files.images", "read_image"),
    "grey": ("engine.files.images", "read_grey"),
    "project": ("studio.project.store", "load"),
    "journal": ("studio.project.recovery", "read_journal"),
}


@dataclass(frozen=True)
class Outcome:
    """What became of a file: ``value``, ``refused``, ``traceback``, ``crash`` or ``hang``; message, time and memory."""

    kind: str
    message: str = ""
    subject: str = ""
    remedy: str = ""
    seconds: float = 0.0
    megabytes: float = 0.0


def run(jobs: Iterable[tuple[str, Make]], workers: int = 2) -> tuple[list[Outcome], str]:
    """Return the outcome of every (reader, what writes the file), and what the workers printed on standard error."""
    todo: queue.SimpleQueue[tuple[int, str, Make] | None] = queue.SimpleQueue()
    listed = list(jobs)
    for index, (reader, make) in enumerate(listed):
        todo.put((index, reader, make))
    results: list[Outcome] = [Outcome("crash", "was never read")] * len(listed)
    with tempfile.TemporaryFile() as errors:
        threads = [threading.Thread(target=_drain, args=(todo, results, errors)) for _ in range(workers)]
        for thread in threads:
            todo.put(None)
            thread.start()
        for thread in threads:
            thread.join()
        errors.seek(0)
        return results, errors.read().decode("utf-8", "replace")


def _drain(todo: queue.SimpleQueue[Any], results: list[Outcome], errors: IO[bytes]) -> None:
    worker: _Worker | None = None
    while (job := todo.get()) is not None:
        index, reader, make = job
        worker = worker or _Worker(errors)
        with tempfile.TemporaryDirectory(prefix="corpus") as name:
            results[index] = worker.read(reader, make(Path(name)))
        if results[index].kind in ("hang", "crash"):
            worker.stop()
            worker = None
    if worker is not None:
        worker.stop()


class _Worker:
    def __init__(self, errors: IO[bytes]) -> None:
        command = [sys.executable, "-W", "error", "-m", "tests.engine.files.corpus_runner"]
        self._process = subprocess.Popen(
            command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True
        )
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()
        self._lines.get(timeout=60)

    def _listen(self) -> None:
        for line in self._process.stdout:
            self._lines.put(line)
        self._lines.put("")

    def read(self, reader: str, path: Path) -> Outcome:
        try:
            self._process.stdin.write(json.dumps([reader, str(path)]) + "\n")
            self._process.stdin.flush()
            line = self._lines.get(timeout=HANG_S)
        except queue.Empty:
            return Outcome("hang", f"took more than {HANG_S:.0f} s", seconds=HANG_S)
        except OSError:
            line = ""
        return Outcome(**json.loads(line)) if line else Outcome("crash", "the process ended")

    def stop(self) -> None:
        self._process.kill()
        self._process.wait()
        self._process.stdin.close()
        self._process.stdout.close()


def _serve() -> None:
    readers = {name: getattr(importlib.import_module(module), function) for name, (module, function) in READERS.items()}
    from engine.errors import InputError

    answers = sys.stdout
    sys.stdout = sys.stderr  # nothing that is printed may pass for an answer
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + _ROOM, used + _ROOM))
    print("ready", file=answers, flush=True)
    for line in sys.stdin:
        name, path = json.loads(line)
        Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
        before, start = _status("VmRSS"), time.process_time()
        found: dict[str, Any] = {"kind": "value"}
        try:
            readers[name](Path(path))
        except InputError as error:
            found = {"kind": "refused", "message": str(error), "subject": error.subject, "remedy": error.remedy}
        except BaseException as error:
            found = {"kind": "traceback", "message": f"{type(error).__name__}: {str(error)[:300]} {_place(error)}"}
        found |= {"seconds": time.process_time() - start, "megabytes": max(0, _status("VmHWM") - before) / 1024}
        print(json.dumps(found), file=answers, flush=True)


def _place(error: BaseException) -> str:
    trace, where = error.__traceback__, ""
    while trace is not None:
        code = trace.tb_frame.f_code
        if str(ROOT) in code.co_filename and ".venv" not in code.co_filename:
            where = f"{Path(code.co_filename).name}:{trace.tb_lineno}"
        trace = trace.tb_next
    return where


def _status(key: str) -> int:
    return int(Path("/proc/self/status").read_text().split(f"{key}:")[1].split()[0])


if __name__ == "__main__":
    _serve()
