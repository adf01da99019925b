"""Windows come and go without a trace, remember their layout, ask before a loss, and rest when nothing is done."""

from __future__ import annotations

import gc
import time
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psutil
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox

import resources
from studio.app import make_window
from studio.settings import Settings
from tests.journeys.conftest import close
from tests.journeys.driver import Hand, bare_scan, truth
from widgets import theme


@pytest.mark.timeout(180)
def test_windows_open_and_close_without_a_trace(hands: Callable[[], Hand], qtbot: Any) -> None:
    counts, gone = [], []
    for _ in range(3):
        hand = hands()
        hand.choose("scan.add", bare_scan("base"))
        hand.click(*truth()["forehead"])
        gone.append(weakref.ref(hand.window))
        close(hand)
        del hand
        QTest.qWait(50)
        gc.collect()
        counts.append(len(QApplication.allWidgets()))
    assert counts[2] <= counts[0] + 2, counts


def test_layout_theme_and_range_are_remembered(hands: Callable[[], Hand], qtbot: Any) -> None:
    first = hands()
    first.window.docks["fit"].hide()
    first.window.show_dock("history")
    first.stage.centre.views.bar_range(0.0, 0.5, None)
    first.act("view.dark")
    assert not theme.current().is_dark
    close(first)
    second = hands()
    assert not theme.current().is_dark and not second.window.actions_["view.dark"].isChecked()
    assert not second.window.docks["fit"].isVisible() and second.window.docks["history"].isVisible()
    assert second.stage.centre.views.range == (0.0, 0.5)
    second.act("window.reset")
    assert second.window.docks["fit"].isVisible() and not second.window.docks["history"].isVisible()
    second.act("view.dark")
    assert theme.current().is_dark


def test_unsaved_changes_are_asked_about(hand: Hand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answers: list[QMessageBox.StandardButton] = []
    asked: list[str] = []

    def answer(box: QMessageBox) -> int:
        asked.append(box.text())
        return answers.pop(0).value

    monkeypatch.setattr(QMessageBox, "exec", answer)
    hand.choose("scan.add", bare_scan("base"))
    hand.choose("file.save_as", tmp_path / "a.qface")
    hand.click(*truth()["forehead"])
    project = hand.window.session.project

    answers[:] = [QMessageBox.StandardButton.Cancel]
    assert not hand.window.close() and hand.window.isVisible()
    answers[:] = [QMessageBox.StandardButton.Cancel]
    hand.act("file.new")
    assert hand.window.session.project is project and "a.qface" in asked[-1]
    answers[:] = [QMessageBox.StandardButton.Save]
    hand.act("file.new")
    assert hand.window.session.project is not project and not hand.window.session.project.scans
    hand.window.open_project(tmp_path / "a.qface")
    hand.rest()
    assert len(hand.landmarks.points) == 1
    hand.click(*truth()["brow_left_outer"])
    answers[:] = [QMessageBox.StandardButton.Discard]
    assert hand.window.close()
    assert not answers


def test_the_window_rests_when_nothing_is_done(hand: Hand) -> None:
    hand.choose("scan.add", bare_scan("base"))
    hand.choose("scan.import", resources.sample_path("subject", "base_fiducials.json"))
    QTest.qWait(1000)
    process = psutil.Process()
    start, begun = sum(process.cpu_times()[:2]), time.monotonic()
    QTest.qWait(2000)
    assert (sum(process.cpu_times()[:2]) - start) / (time.monotonic() - begun) < 0.08


def test_the_sample_opens_as_one_step_and_every_face_becomes_fresh(hand: Hand) -> None:
    hand.act("scan.sample")
    hand.rest()
    project = hand.window.session.project
    assert [item.name for item in project.scans] == ["base", "car", "man", "she", "eel", "too"]
    assert hand.window.session.stack.count() == 1
    hand.act("scan.fit_all")
    hand.rest()
    assert {project.state(item.id).kind for item in project.scans} == {"fresh"}
    assert all(len(project.fit(item.id).folded_faces) == 0 for item in project.scans)
    hand.act("edit.undo")
    hand.key(Qt.Key.Key_N)
    while hand.window.session.stack.canUndo():
        hand.window.session.stack.undo()
    assert not project.scans and "open the sample" in hand.window.status.text.text()


def test_every_action_in_the_menus_works_or_says_why_not(qtbot: Any, own_home: Path) -> None:
    window = make_window(Settings())
    qtbot.addWidget(window)
    seen = set()
    for entry in window.top.menus.actions():
        menu = entry.menu()
        menu.aboutToShow.emit()
        for action in menu.actions():
            if action.objectName():
                seen.add(action.objectName())
                assert action.toolTip(), action.objectName()
                if not action.isEnabled():
                    assert "Not now: " in action.toolTip() and action.property("why"), action.objectName()
    assert {"scan.fit", "file.save", "edit.undo", "view.heat", "window.reset"} <= seen
    assert not window.actions_["scan.fit"].isEnabled()
    window.session.stack.setClean()
