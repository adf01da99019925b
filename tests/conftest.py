"""What holds for every test: nothing of the user's is touched, and nothing is left behind.

Windows, threads and timers that outlive their test fail it. Without Qt (``tests/engine`` alone) only threads count.
"""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

HARMLESS_WINDOWS = {"QTipLabel", "QDesktopWidget"}


@pytest.fixture(autouse=True)
def own_home(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Keep settings, crash reports and recovery files of a test in a folder of its own."""
    home = tmp_path_factory.mktemp("home")
    for name in ("XDG_CONFIG_HOME", "XDG_STATE_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(home / name.lower()))
    yield home


@pytest.fixture(autouse=True)
def nothing_left(own_home: Path, request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test that leaves a window, a thread or a running timer behind."""
    uses_qt = "qtbot" in request.fixturenames or "qapp" in request.fixturenames
    threads = set(threading.enumerate())
    windows = set(map(id, _windows())) if uses_qt else set()
    yield
    problems = [f"thread {thread.name}" for thread in _threads_left(threads)]
    if uses_qt:
        _delete_later()
        left = [widget for widget in _windows() if id(widget) not in windows]
        if left or "main_window" in request.fixturenames:
            gc.collect()
            _delete_later()
            left = [widget for widget in _windows() if id(widget) not in windows]
        problems += [f"window {type(w).__name__} {w.objectName()!r} {w.windowTitle()!r}" for w in left]
        problems += [f"timer of {timer.interval()} ms, parent {timer.parent()}" for timer in _timers()]
    assert not problems, "left behind: " + "; ".join(problems)


def _threads_left(before: set[threading.Thread]) -> list[threading.Thread]:
    deadline = time.monotonic() + 2.0
    while True:
        left = [thread for thread in threading.enumerate() if thread not in before and not thread.daemon]
        if not left or time.monotonic() > deadline:
            return left
        time.sleep(0.01)


def _windows() -> list[Any]:
    widgets = sys.modules.get("PySide6.QtWidgets")
    if widgets is None or widgets.QApplication.instance() is None:
        return []
    return [w for w in widgets.QApplication.topLevelWidgets() if type(w).__name__ not in HARMLESS_WINDOWS]


def _timers() -> list[Any]:
    core = sys.modules.get("PySide6.QtCore")
    if core is None:
        return []
    shiboken = sys.modules["shiboken6"]
    timers = [thing for thing in gc.get_objects() if type(thing) is core.QTimer and shiboken.isValid(thing)]
    return [timer for timer in timers if timer.isActive()]


def _delete_later() -> None:
    core = sys.modules["PySide6.QtCore"]
    for _ in range(3):
        core.QCoreApplication.sendPostedEvents(None, core.QEvent.Type.DeferredDelete.value)
        core.QCoreApplication.processEvents()
