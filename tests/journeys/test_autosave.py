"""An autosave belongs to whoever left it until somebody decides; one's own goes, and no offer outlives its project."""

from __future__ import annotations

import dataclasses
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from engine.files.limits import write_limits
from engine.scan.limits import Limits
from studio.project import store
from studio.project.autosaved import autosave_path
from studio.project.document import Project
from studio.project.recovery import journal_of, write_journal
from studio.project.recovery_files import RecoveryFiles
from studio.recovery_keeper import recovery_folder
from studio.scan.commands import RenameScan
from studio.scan.limits_dialog import default_path
from tests.journeys.conftest import close
from tests.journeys.driver import Hand
from tests.journeys.test_file_answers import Answers, change_outside, name_of, offered, press

OLD = Path(__file__).parents[1] / "studio" / "data" / "version1.qface"


@pytest.fixture(name="answers")
def make_answers(monkeypatch: pytest.MonkeyPatch) -> Answers:
    return Answers(monkeypatch)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return a project file."""
    return store.save(store.load(OLD), tmp_path / "a.qface")


@pytest.fixture
def found(path: Path) -> tuple[Path, Path]:
    """Return a project file and its later autosave."""
    return path, leave_autosave(path, "lost", 5.0)


@pytest.fixture
def saved(hand: Hand, path: Path) -> Path:
    """Return the file of a project that is open and got a step."""
    hand.window.open_project(path)
    hand.rest()
    rename(hand, "mine")
    return path


def leave_autosave(path: Path, name: str, later: float) -> Path:
    """Leave an autosave as a machine that lost its power would, so many seconds later than the file."""
    other = store.load(path)
    other.change_scan(other.scans[0].id, name=name)
    sibling = store.save(other, autosave_path(path))
    when = path.stat().st_mtime + later
    os.utime(sibling, (when, when))
    return sibling


def rename(hand: Hand, name: str) -> None:
    project = hand.window.session.project
    hand.window.session.stack.push(RenameScan(project, project.scans[0].id, name))


def beside(path: Path) -> dict[str, str]:
    """Return the first scan's name in every other project beside a file."""
    return {file.name: name_of(file) for file in sorted(path.parent.glob("*.qface")) if file != path}


def test_an_autosave_that_nobody_has_decided_on_is_neither_written_over_nor_deleted(
    hands: Callable[[], Hand], found: tuple[Path, Path], answers: Answers
) -> None:
    path, sibling = found
    hand = hands()
    hand.window.open_project(path)
    assert offered(hand) == ["Open the autosave", "Delete it"] and beside(path) == {sibling.name: "lost"}
    rename(hand, "other")
    hand.window.guard.autosave()
    hand.rest()
    (aside,) = set(beside(path)) - {sibling.name}
    assert aside.startswith("a.autosave-2") and beside(path) == {sibling.name: "other", aside: "lost"}
    hand.act("file.save")
    assert beside(path) == {aside: "lost"} and name_of(path) == "other"
    assert offered(hand) == ["Open the autosave", "Delete it"], "it is still to be decided on"
    close(hand)
    assert beside(path) == {aside: "lost"}

    hand = hands()
    hand.window.open_project(path)
    press(hand, "Open the autosave")
    assert hand.window.session.project.scans[0].name == "lost" and hand.window.isWindowModified()
    assert hand.window.session.project.path == path and not offered(hand)
    answers.next = ["Discard"]
    hand.act("file.new")
    assert beside(path) == {aside: "lost"}, "looking at it is no decision"
    hand.window.open_project(path)
    press(hand, "Open the autosave")
    hand.act("file.save")
    assert beside(path) == {} and name_of(path) == "lost"


def test_of_several_autosaves_each_is_offered_and_deleted_by_itself(
    hands: Callable[[], Hand], found: tuple[Path, Path]
) -> None:
    path, sibling = found
    hand = hands()
    hand.window.open_project(path)
    rename(hand, "other")
    close(hand)
    leave_autosave(path, "lost later", 50.0)
    assert sorted(beside(path).values()) == ["lost", "lost later"]
    hand = hands()
    hand.window.open_project(path)
    press(hand, "Delete it")
    assert list(beside(path).values()) == ["lost"] and not sibling.exists()
    press(hand, "Delete it")
    assert beside(path) == {} and not offered(hand)


def test_an_offer_goes_with_the_project_it_was_made_for(
    hands: Callable[[], Hand], found: tuple[Path, Path], tmp_path: Path
) -> None:
    path, sibling = found
    (tmp_path / "other").mkdir()
    other = store.save(store.load(path), tmp_path / "other" / "b.qface")
    hand = hands()
    hand.window.open_project(path)
    (first, *_) = hand.window.message._question[1]
    hand.window.open_project(other)
    assert not offered(hand) and hand.window.message.text.text() == ""
    first[1]()  # and where it is answered all the same
    assert hand.window.session.project.path == other and not hand.window.isWindowModified()
    hand.window.open_project(path)
    change_outside(path)
    hand.window.guard.look()
    (reload, *_) = hand.window.message._question[1]
    hand.window.session.new()
    assert not offered(hand)
    reload[1]()
    assert hand.window.session.project.path is None and sibling.exists()


def test_an_autosave_holds_the_last_steps_also_after_undo(hand: Hand, saved: Path) -> None:
    guard, stack = hand.window.guard, hand.window.session.stack
    for name in ("first", "second"):
        rename(hand, name)
        guard.autosave()
        hand.rest()
        assert beside(saved) == {"a.autosave.qface": name}
        stack.undo()
    stack.redo()
    guard.autosave()
    hand.rest()
    before = autosave_path(saved).stat().st_mtime_ns
    guard.autosave()
    hand.rest()
    assert autosave_path(saved).stat().st_mtime_ns == before, "nothing has changed since"


@pytest.mark.parametrize("end", ["new", "save", "close"])
def test_an_autosave_that_is_still_being_written_leaves_nothing_after_its_project(
    hand: Hand, saved: Path, monkeypatch: pytest.MonkeyPatch, qtbot: Any, end: str
) -> None:
    inside, go_on = threading.Event(), threading.Event()
    real = store.save

    def slow(project: Project, path: Path | None = None, **more: Any) -> Path:
        if path is not None and path == autosave_path(saved):
            inside.set()
            assert go_on.wait(20)
        return real(project, path, **more)

    monkeypatch.setattr(store, "save", slow)
    hand.rest()
    hand.window.guard.autosave()
    gate = hand.window.guard._gate
    qtbot.waitUntil(inside.is_set, timeout=10_000)
    if end == "new":
        hand.window.session.new()
    elif end == "save":
        hand.act("file.save")
    else:
        threading.Timer(0.3, go_on.set).start()
        close(hand)
    go_on.set()
    assert gate.acquire(timeout=20), "it has ended"
    gate.release()
    assert beside(saved) == {}


def test_unsaved_limits_come_back_with_the_rest(hand: Hand, tmp_path: Path) -> None:
    own = dataclasses.replace(Limits(), median_mm=Limits().median_mm * 2)
    lost = Project()
    lost.set_limits(own)
    files = RecoveryFiles.of(recovery_folder(), "lost")
    files.folder.mkdir(parents=True)
    write_journal(journal_of(lost, 1.0, 1), files.journal)
    hand.window.recovery.restore(files)
    assert hand.window.session.project.limits == own
    hand.window.session.stack.setClean()
    default_path().parent.mkdir(parents=True, exist_ok=True)
    write_limits(default_path(), dataclasses.replace(own, median_mm=0.01))
    hand.window.session.new()
    assert hand.window.session.project.limits.median_mm == 0.01, "a new project begins with the user's own"
