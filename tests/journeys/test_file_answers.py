"""What the window asks about a project's file: changed outside, open elsewhere, damaged, no room, autosave."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMessageBox

from studio.project import store
from studio.project.autosaved import autosave_path
from studio.project.thumbnail import thumbnail_of
from tests.journeys.conftest import close
from tests.journeys.driver import Hand, bare_scan, truth


class Answers:
    """Presses a named button of every question, and remembers what was asked."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.next: list[str] = []
        self.asked: list[str] = []
        answers = self

        def press(box: QMessageBox) -> int:
            answers.asked.append(f"{box.text()} {box.informativeText()}")
            wanted = answers.next.pop(0)
            (button,) = [button for button in box.buttons() if button.text().replace("&", "") == wanted]
            button.click()
            return box.standardButton(button).value

        monkeypatch.setattr(QMessageBox, "exec", press)


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> Answers:
    return Answers(monkeypatch)


@pytest.fixture
def saved(hand: Hand, tmp_path: Path) -> Path:
    """Return the file of a project that is open and was saved, and then got a step."""
    hand.choose("scan.add", bare_scan())
    hand.click(*truth()["forehead"])
    hand.choose("file.save_as", tmp_path / "a.qface")
    hand.click(*truth()["brow_left_outer"])
    return tmp_path / "a.qface"


def change_outside(path: Path, name: str = "theirs") -> None:
    other = store.load(path)
    other.change_scan(other.scans[0].id, name=name)
    store.save(other, path)


def name_of(path: Path) -> str:
    return store.load(path).scans[0].name


def offered(hand: Hand) -> list[str]:
    return [button.text() for button in hand.window.message.offers]


def press(hand: Hand, label: str) -> None:
    (button,) = [button for button in hand.window.message.offers if button.text() == label]
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    hand.rest()


def test_saving_over_a_change_from_outside_asks_first(hand: Hand, saved: Path, answers: Answers) -> None:
    change_outside(saved)
    answers.next = ["Cancel"]
    hand.act("file.save")
    assert name_of(saved) == "theirs" and hand.window.isWindowModified() and "another program" in answers.asked[0]

    answers.next = ["Save as a copy..."]
    hand.choose("file.save", saved.with_name("mine.qface"))
    assert name_of(saved) == "theirs" and name_of(saved.with_name("mine.qface")) == "base"
    assert hand.window.session.project.path == saved.with_name("mine.qface")

    hand.window.open_project(saved)
    hand.rest()
    hand.click(*truth()["brow_left_outer"])
    change_outside(saved, "theirs again")
    answers.next = ["Overwrite"]
    hand.act("file.save")
    assert name_of(saved) == "theirs" and not hand.window.isWindowModified()

    hand.click(*truth()["brow_left_inner"])
    change_outside(saved, "theirs at last")
    answers.next = ["Reload"]
    hand.act("file.save")
    hand.rest()
    assert hand.window.session.project.scans[0].name == "theirs at last" and not hand.window.isWindowModified()
    assert thumbnail_of(saved.with_name("mine.qface")) is not None


def test_a_change_from_outside_is_mentioned_when_it_happens(
    hand: Hand, saved: Path, answers: Answers, qtbot: Any
) -> None:
    change_outside(saved)
    qtbot.waitUntil(lambda: offered(hand) == ["Reload", "Keep mine"], timeout=10_000)
    assert "a.qface was changed by another program" in hand.window.message.text.text()
    press(hand, "Keep mine")
    QTest.qWait(400)
    hand.window.guard.look()
    assert not offered(hand), "it is mentioned once"
    change_outside(saved, "theirs again")
    qtbot.waitUntil(lambda: offered(hand) == ["Reload", "Keep mine"], timeout=10_000)
    answers.next = ["Reload"]
    press(hand, "Reload")
    assert "are lost" in answers.asked[0] and hand.window.session.project.scans[0].name == "theirs again"
    saved.unlink()
    qtbot.waitUntil(lambda: "deleted or moved" in hand.window.message.text.text(), timeout=10_000)
    hand.click(*truth()["brow_left_inner"])
    hand.act("file.save")
    assert name_of(saved) == "theirs again"


def test_a_project_that_is_open_elsewhere_is_opened_as_a_copy(
    hands: Callable[[], Hand], tmp_path: Path, answers: Answers
) -> None:
    first = hands()
    first.choose("scan.add", bare_scan())
    first.choose("file.save_as", tmp_path / "a.qface")
    second = hands()
    answers.next = ["Cancel"]
    second.choose("file.open", tmp_path / "a.qface")
    assert "is open in another window" in answers.asked[0] and not second.window.session.project.scans
    answers.next = ["Open a copy"]
    second.choose("file.open", tmp_path / "a.qface")
    project = second.window.session.project
    assert project.path is None and project.scans == first.window.session.project.scans
    assert "copy of a.qface" in second.window.message.text.text() and not second.window.isWindowModified()


def test_a_full_disk_is_said_and_another_place_offered(
    hand: Hand, saved: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = saved.read_bytes()

    def full(*_values: object) -> str:
        raise sqlite3.OperationalError("database or disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(store, "write_array", full)
        hand.act("file.save")
    text = hand.window.message.text.text()
    assert text.startswith("Not saved: ") and "disk is full" in text and hand.window.message.kind == "error"
    assert saved.read_bytes() == before and hand.window.isWindowModified() and offered(hand) == ["Save as..."]
    from studio import dialogs

    monkeypatch.setattr(dialogs, "save_file", lambda *_values: tmp_path / "other.qface")
    press(hand, "Save as...")
    assert len(store.load(tmp_path / "other.qface").scans[0].landmarks.points) == 2
    assert not hand.window.isWindowModified()


def test_of_a_damaged_project_what_can_be_read_is_offered(hand: Hand, saved: Path) -> None:
    hand.act("file.save")
    data = saved.read_bytes()
    damaged = saved.with_name("damaged.qface")
    damaged.write_bytes(data[: len(data) * 2 // 3])
    hand.choose("file.open", damaged)
    message = hand.window.message
    assert message.kind == "error" and "is cut off" in message.text.text()
    assert "1 of 1 scans are whole" in message.text.text(), "the range image is in the file it was read from"
    assert offered(hand) == ["Open what can be read"]
    landmarks = hand.landmarks
    before = damaged.read_bytes()
    press(hand, "Open what can be read")
    project = hand.window.session.project
    assert project.path is None and hand.window.isWindowModified() and damaged.read_bytes() == before
    assert project.scans[0].landmarks == landmarks and hand.window.session.name == "Untitled"


def test_autosave_writes_a_sibling_that_goes_with_the_next_saving(
    hands: Callable[[], Hand], tmp_path: Path, answers: Answers
) -> None:
    hand = hands()
    guard, saved = hand.window.guard, tmp_path / "a.qface"
    hand.choose("scan.add", bare_scan())
    guard.autosave()
    hand.rest()
    assert not list(tmp_path.iterdir()), "a project without a name is kept by the recovery alone"
    hand.choose("file.save_as", saved)
    guard.autosave()
    hand.rest()
    sibling = autosave_path(saved)
    assert sibling.name == "a.autosave.qface" and not sibling.exists(), "there is nothing unsaved"
    hand.click(*truth()["forehead"])
    before = saved.read_bytes()
    guard.autosave()
    hand.rest()
    assert saved.read_bytes() == before and len(store.load(sibling).scans[0].landmarks.points) == 1
    assert "Autosaved to a.autosave.qface" in hand.window.status.text.text() and hand.window.isWindowModified()
    hand.act("file.save")
    assert not sibling.exists()

    hand.click(*truth()["brow_left_outer"])
    guard.autosave()
    hand.rest()
    kept = sibling.read_bytes()
    answers.next = ["Discard"]
    hand.act("file.new")
    assert not sibling.exists()
    sibling.write_bytes(kept)  # as a machine that lost its power would leave it
    hand.window.open_project(saved)
    hand.rest()
    assert offered(hand) == ["Open the autosave", "Delete it"] and len(hand.landmarks.points) == 1
    press(hand, "Open the autosave")
    assert len(hand.landmarks.points) == 2 and hand.window.isWindowModified()
    assert hand.window.session.project.path == saved
    hand.act("file.save")
    assert len(store.load(saved).scans[0].landmarks.points) == 2 and not sibling.exists()
    hand.window.settings["files/autosave_minutes"] = 0
    assert not guard._clock.isActive()
    hand.window.settings["files/autosave_minutes"] = 7
    assert guard._clock.isActive() and guard._clock.interval() == 7 * 60_000
    close(hand)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.qface"]
