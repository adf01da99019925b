"""After a crash the work of the last second but one is offered again; after a proper end nothing is left to offer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from engine.errors import InputError
from studio.project.recovery import RecoveryFiles, recover
from studio.recovery_keeper import recovery_folder
from studio.session import Session
from studio.settings import Settings
from tests.journeys.conftest import close
from tests.journeys.driver import Hand, bare_scan, truth


def crash(hand: Hand) -> None:
    """End a window as a crash would: its files and its dead lock stay behind."""
    keeper = hand.window.recovery
    keeper._timer.stop()
    keeper._closed = True
    keeper._journals.shutdown()
    keeper._pieces.shutdown()
    keeper._lock.unlock()
    keeper.close = lambda: None
    close(hand)


def written(hand: Hand, qtbot: Any) -> RecoveryFiles:
    """Wait until the journal agrees with the project."""
    files = hand.window.recovery._files

    def agrees() -> bool:
        if not files.complete or hand.window.session.tasks.busy or hand.window.recovery.busy:
            return False
        return recover(files)[0].scans == hand.window.session.project.scans

    qtbot.waitUntil(agrees, timeout=10_000)
    return files


@pytest.mark.timeout(180)
def test_unsaved_work_comes_back_after_a_crash(hands: Callable[[], Hand], qtbot: Any, tmp_path: Path) -> None:
    first = hands()
    first.choose("scan.add", bare_scan("base"))
    first.choose("file.save_as", tmp_path / "a.qface")
    for name in ("forehead", "brow_left_outer", "brow_left_inner"):
        first.click(*truth()[name])
    written(first, qtbot)
    scans = first.window.session.project.scans
    crash(first)

    second = hands()
    assert [button.text() for button in second.window.message.offers] == ["Recover", "Discard"]
    (tmp_path / "text.qface").write_text("no project")
    second.choose("file.open", tmp_path / "text.qface")
    assert second.window.message.kind == "error" and not second.window.message.offers
    second.window.message.button.click()
    QTest.mouseClick(second.window.message.offers[0], Qt.MouseButton.LeftButton)
    second.rest()
    project = second.window.session.project
    assert project.scans == scans and project.path == tmp_path / "a.qface"
    assert second.window.isWindowModified() and len(second.landmarks.points) == 3
    second.act("file.save")
    assert not second.window.isWindowModified()
    qtbot.waitUntil(lambda: not list(recovery_folder().rglob("*.json")), timeout=5_000)
    close(second)
    third = hands()
    assert not third.window.message.offers and not third.window.message.isVisible()


def test_a_living_session_is_not_offered_and_a_closed_one_leaves_nothing(hands: Callable[[], Hand], qtbot: Any) -> None:
    first = hands()
    first.choose("scan.add", bare_scan("base"))
    written(first, qtbot)
    second = hands()
    assert not second.window.message.offers
    close(second)
    close(first)
    assert not list(recovery_folder().rglob("*.json")) and not list(recovery_folder().rglob("*.qface"))


def test_damaged_recovery_files_say_so(qapp: Any, tmp_path: Path) -> None:

    session = Session(Settings(tmp_path / "s.ini"))
    try:
        files = RecoveryFiles.of(tmp_path, "lost")
        files.folder.mkdir()
        for text in ('{"path": "", "scans": [{"id": 5}]}', "{", '{"scans": [], "more": 1}'):
            files.journal.write_text(text)
            with pytest.raises(InputError, match="lost"):
                recover(files)
        files.journal.write_text('{"path": "", "scans": []}')
        assert recover(files)[0].scans == () and recover(files)[1] is None
    finally:
        session.close()
