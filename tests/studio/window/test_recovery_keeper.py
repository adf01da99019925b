"""The journal is never put off, a snapshot never comes too late, and nothing is deleted before it is replaced."""

from __future__ import annotations

import dataclasses
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.errors import InputError
from engine.landmarks import UNSET, Landmark, LandmarkState
from engine.scan.range_image import RangeImage
from studio.project import recovery, store
from studio.project.document import ScanItem, content_key, new_id
from studio.project.lost import describe_lost
from studio.project.path_text import escaped, plain
from studio.project.recovery import journal_of, recover, write_journal
from studio.project.recovery_files import RecoveryFiles
from studio.recovery_keeper import RecoveryKeeper
from studio.scan.commands import AddScan, RemoveScan, SetLandmark
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

    def add(self, seed: int = 0) -> str:
        """Add a scan and return its id."""
        points = np.random.default_rng(seed).normal(size=(40, 40, 3)) - [0, 0, 600]
        scan = RangeImage(points, None, None)
        name = self.session.project.unique_name("base")
        item = ScanItem(new_id(), name, content_key(scan))
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


@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), ValueError("of no kind we know")])
def test_whatever_goes_wrong_with_the_journal_is_told_and_tried_again_without_another_step(
    kept: Kept, qtbot: Any, monkeypatch: pytest.MonkeyPatch, failure: Exception
) -> None:
    def fail() -> None:
        raise failure

    kept.keeper._retry.setInterval(50)
    with monkeypatch.context() as patch:
        patch.setattr(kept.keeper, "_take_folder", fail)
        kept.add()
        qtbot.waitUntil(lambda: bool(kept.told), timeout=5_000)
        qtbot.wait(400)
        assert len(kept.told) == 1 and str(failure.args[-1]) in kept.told[0]
        assert not kept.keeper.secure() and not kept.keeper.is_kept
    qtbot.waitUntil(lambda: kept.keeper.is_kept and not kept.keeper.busy, timeout=5_000)
    assert recover(kept.keeper._files).project.scans == kept.session.project.scans


def test_secure_says_whether_the_newest_journal_is_on_the_disk(
    kept: Kept, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert kept.keeper.secure(20.0), "nothing is unsaved"
    scan_id = kept.add()
    assert kept.keeper.secure(20.0)
    kept.rest(qtbot)  # the range image follows the journal
    assert recover(kept.keeper._files).project.scans == kept.session.project.scans

    def full(*_values: object) -> None:
        raise InputError("disk", "is full", "make room")

    with monkeypatch.context() as patch:
        patch.setattr(recovery, "write_journal", full)
        kept.place(scan_id, 4.0)
        assert not kept.keeper.secure(20.0)
    assert kept.keeper.secure(20.0)


def test_a_path_that_is_not_utf8_is_kept_saved_and_opened_again(kept: Kept, qtbot: Any, tmp_path: Path) -> None:
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/J\xf6rg"))
    try:
        folder.mkdir()
    except OSError:
        pytest.skip("this disk has no such names")
    scan_id = kept.add()
    project = kept.session.project
    source = dataclasses.replace(project.scan(scan_id).source, depth_file=str(folder / "too.ply"))
    project.change_scan(scan_id, source=source)
    kept.session.save(folder / "a.qface")
    kept.place(scan_id, 3.0)
    kept.rest(qtbot)
    assert not kept.told
    found = recover(kept.keeper._files)
    assert found.path == folder / "a.qface" and found.project.scans == project.scans
    assert describe_lost(kept.keeper._files).path == found.path
    kept.session.save()
    kept.session.open(folder / "a.qface")
    assert kept.session.project.scans == project.scans and kept.session.project.scan(scan_id).source == source


@pytest.mark.parametrize("text", ["", "a/b.qface", "Jo\u0308rg \U0001f600 100%", "J\udcf6rg/\udce4", "\ud83d\udcf6f6"])
def test_every_path_comes_back_as_it_was_written_down(text: str) -> None:
    assert plain(escaped(text)) == text and plain(escaped(text).encode().decode()) == text


def test_a_path_that_is_too_long_for_this_machine_keeps_nothing_from_being_restored(kept: Kept, tmp_path: Path) -> None:
    far = Path("/tmp") / ("x" * 300) / "a.qface"
    scan_id = kept.add()
    files = RecoveryFiles.of(kept.folder, "lost")
    files.folder.mkdir(parents=True)
    journal = journal_of(kept.session.project, 1.0, 1, stamp="0" * 64).model_copy(update={"path": str(far)})
    write_journal(journal, files.journal)
    assert kept.keeper.restore(files) == ("the range image of base",)
    assert kept.session.project.path == far and scan_id in kept.session.project and not kept.session.changed_outside


def test_what_cannot_be_restored_can_be_tried_again(kept: Kept, monkeypatch: pytest.MonkeyPatch) -> None:
    files = RecoveryFiles.of(kept.folder, "lost")
    files.folder.mkdir(parents=True)
    write_journal(journal_of(kept.session.project, 1.0, 1), files.journal)

    def fail(*_values: object) -> None:
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as patch:
        patch.setattr(kept.session, "take_over", fail)
        with pytest.raises(PermissionError):
            kept.keeper.restore(files)
    assert kept.keeper.restore(files) == ()


def test_restoring_reads_the_pieces_that_the_journal_names_and_no_others(
    kept: Kept, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone, stays = kept.add(0), kept.add(1)
    kept.rest(qtbot)
    kept.session.stack.push(RemoveScan(kept.session.project, gone))
    kept.rest(qtbot)
    files = kept.keeper._files
    assert len(files.pieces("image")) == 2
    read: list[Path] = []
    real = store.load
    monkeypatch.setattr(store, "load", lambda path: (read.append(path), real(path))[1])
    found = recover(files)
    assert found.project.scans == kept.session.project.scans and not found.lost
    assert read == [files.image(kept.session.project.scan(stays).image_key)]


def test_images_of_removed_scans_go_when_they_take_too_much_room_and_come_back_with_undo(
    kept: Kept, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second, third = kept.add(0), kept.add(1), kept.add(2)
    kept.rest(qtbot)
    files, project = kept.keeper._files, kept.session.project
    pieces = {scan_id: files.image(project.scan(scan_id).image_key) for scan_id in (first, second, third)}
    kept.keeper._kept._spare = int(pieces[second].stat().st_size * 1.5)
    for scan_id in (first, second):
        kept.session.stack.push(RemoveScan(project, scan_id))
    kept.rest(qtbot)
    assert set(files.pieces("image")) == {pieces[second], pieces[third]}
    kept.session.stack.undo()
    kept.session.stack.undo()
    kept.rest(qtbot)
    assert set(files.pieces("image")) == set(pieces.values())
    found = recover(files)
    assert found.project.scans == project.scans and not found.lost


def test_no_image_goes_before_the_journal_that_does_without_it(
    kept: Kept, qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan_id = kept.add()
    kept.rest(qtbot)
    kept.keeper._kept._spare = 0
    before = kept.session.project.scans

    def full(*_values: object) -> None:
        raise InputError("disk", "is full", "make room")

    with monkeypatch.context() as patch:
        patch.setattr(recovery, "write_journal", full)
        kept.session.stack.push(RemoveScan(kept.session.project, scan_id))
        kept.rest(qtbot)
        found = recover(kept.keeper._files)
        assert found.project.scans == before and not found.lost
    assert kept.keeper.secure()
    kept.rest(qtbot)
    assert not kept.keeper._files.pieces("image")


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
