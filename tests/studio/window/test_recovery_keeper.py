"""The journal is never put off, a snapshot never comes too late, and nothing is deleted before it is replaced."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.errors import InputError
from engine.landmarks import UNSET, Landmark, LandmarkState
from engine.scan.range_image import RangeImage
from studio.project import store
from studio.project.document import ScanItem, content_key, new_id
from studio.project.recovery import recover
from studio.recovery_keeper import RecoveryKeeper
from studio.scan.commands import AddScan, SetLandmark
from studio.session import Session
from studio.settings import Settings


class Kept:
    """A session with its keeper, and what it has told."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "recovery"
        self.session = Session(Settings(folder / "s.ini"))
        self.keeper = RecoveryKeeper(self.session, self.folder)
        self.told: list[str] = []
        self.session.message.connect(lambda _kind, text: self.told.append(text))

    def add(self) -> str:
        """Add a scan and return its id."""
        points = np.random.default_rng(0).normal(size=(40, 40, 3)) - [0, 0, 600]
        scan = RangeImage(points, None, None)
        item = ScanItem(new_id(), "base", content_key(scan))
        self.session.stack.push(AddScan(self.session.project, item, scan))
        return item.id

    def place(self, scan_id: str, x: float) -> None:
        """Place the chin."""
        project = self.session.project
        old = project.scan(scan_id).landmarks["chin"]
        new = Landmark(x, 5.0, LandmarkState.PLACED)
        self.session.stack.push(SetLandmark(project, scan_id, "chin", old, new))

    def files(self, ending: str) -> list[Path]:
        return sorted(self.folder.rglob(f"*{ending}"))

    def rest(self, qtbot: Any) -> None:
        qtbot.waitUntil(lambda: not self.session.tasks.busy and not self.keeper.busy, timeout=10_000)

    def crash(self) -> None:
        """End as a crash would: what is written stays, and the lock is that of nobody."""
        self.rest_of_threads()
        self.session.close()
        self.keeper._lock.unlock()

    def rest_of_threads(self) -> None:
        self.keeper._closed = True
        self.keeper._timer.stop()
        self.keeper._journals.shutdown()
        self.keeper._pieces.shutdown()

    def end(self) -> None:
        self.session.close()
        self.keeper.close()


@pytest.fixture
def kept(qapp: Any, tmp_path: Path) -> Iterator[Kept]:
    one = Kept(tmp_path)
    yield one
    one.end()


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[threading.Event, threading.Event]]:
    """Let snapshots begin, and end only when the second event is set."""
    inside, go_on = threading.Event(), threading.Event()
    real = store.save

    def slow(*values: Any, **more: Any) -> Path:
        inside.set()
        assert go_on.wait(20)
        return real(*values, **more)

    monkeypatch.setattr(store, "save", slow)
    yield inside, go_on
    go_on.set()


def test_steps_that_follow_each_other_do_not_put_the_journal_off(kept: Kept, qtbot: Any) -> None:
    scan_id = kept.add()
    kept.rest(qtbot)
    (journal,) = kept.files(".json")
    before = journal.stat().st_mtime_ns
    for number in range(12):
        kept.place(scan_id, 1.0 + number)
        qtbot.wait(100)
    assert journal.stat().st_mtime_ns > before
    (written,) = recover(kept.keeper._files)[0].scans
    assert written.landmarks["chin"].x >= 7.0


def test_the_journal_waits_for_no_snapshot(kept: Kept, qtbot: Any, held: Any) -> None:
    inside, go_on = held
    scan_id = kept.add()
    kept.place(scan_id, 3.0)
    qtbot.waitUntil(inside.is_set, timeout=5_000)
    qtbot.waitUntil(lambda: kept.keeper._files.complete, timeout=5_000)
    assert not kept.files(".qface")
    early = recover(kept.keeper._files)
    assert early.project.scan(scan_id).landmarks == kept.session.project.scan(scan_id).landmarks
    assert early.lost == ("the range image of base",)
    go_on.set()
    kept.rest(qtbot)
    late = recover(kept.keeper._files)
    assert late.project.scans == kept.session.project.scans and not late.lost


def test_the_journal_waits_for_no_other_task(kept: Kept, qtbot: Any) -> None:
    """All threads of the session are busy; the control is a task that has to wait for one."""
    go_on, control = threading.Event(), threading.Event()
    for _ in range(4):
        kept.session.tasks.submit("busy", lambda _progress: go_on.wait(20), lambda _done: None)
    kept.session.tasks.submit("control", lambda _progress: control.set(), lambda _done: None)
    try:
        scan_id = kept.add()
        kept.place(scan_id, 3.0)
        qtbot.waitUntil(lambda: not kept.keeper.busy, timeout=5_000)
        assert recover(kept.keeper._files).project.scans == kept.session.project.scans
        assert not control.is_set()
    finally:
        go_on.set()


@pytest.mark.parametrize("first", ["session", "keeper"])
def test_closing_during_a_snapshot_leaves_nothing(tmp_path: Path, qtbot: Any, held: Any, first: str) -> None:
    kept = Kept(tmp_path)
    inside, go_on = held
    kept.add()
    qtbot.waitUntil(inside.is_set, timeout=5_000)
    threading.Timer(0.2, go_on.set).start()
    if first == "session":
        kept.end()
    else:
        kept.keeper.close()
        kept.session.close()
    assert not kept.folder.exists() or not list(kept.folder.iterdir())


def test_a_snapshot_of_the_project_before_does_not_come_after(kept: Kept, qtbot: Any, held: Any) -> None:
    inside, go_on = held
    kept.add()
    qtbot.waitUntil(inside.is_set, timeout=5_000)
    kept.session.new()
    go_on.set()
    kept.rest(qtbot)
    assert not kept.files(".qface") and not kept.files(".json") and not kept.files(".part")


def test_a_snapshot_that_fails_is_told_once_and_tried_again(
    kept: Kept, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = store.save

    def full(*_values: object, **_more: object) -> Path:
        raise InputError("disk", "is full", "make room")

    monkeypatch.setattr(store, "save", full)
    scan_id = kept.add()
    kept.rest(qtbot)
    assert len(kept.told) == 1 and "disk: is full; make room" in kept.told[0]
    kept.place(scan_id, 3.0)
    kept.rest(qtbot)
    assert len(kept.told) == 1
    monkeypatch.setattr(store, "save", real)
    kept.place(scan_id, 4.0)
    kept.rest(qtbot)
    assert recover(kept.keeper._files)[0].scans == kept.session.project.scans


def test_what_is_restored_is_kept_until_it_is_written_again(tmp_path: Path, qtbot: Any, held: Any) -> None:
    inside, go_on = held
    go_on.set()
    lost, again = Kept(tmp_path), Kept(tmp_path)
    try:
        scan_id = lost.add()
        lost.place(scan_id, 3.0)
        lost.rest(qtbot)
        lost.crash()
        (files,) = again.keeper.abandoned()
        go_on.clear()
        inside.clear()
        again.keeper.restore(files)
        assert again.session.is_dirty and again.session.project.scan(scan_id).landmarks["chin"] != UNSET
        qtbot.waitUntil(inside.is_set, timeout=5_000)
        assert files.complete, "another crash now would lose it"
        assert not lost.keeper.abandoned() or files not in lost.keeper.abandoned()
        go_on.set()
        again.rest(qtbot)
        assert again.keeper._files.complete and not files.folder.exists()
    finally:
        go_on.set()
        again.end()
    assert not list(again.folder.iterdir())
