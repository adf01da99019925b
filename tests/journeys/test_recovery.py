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
from studio.restore import RestoreDialog
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
    keeper._retry.stop()
    keeper._lock.unlock()
    keeper.close = lambda: None
    close(hand)


def restore_dialog(hand: Hand) -> Any:
    """Return the dialog that offers lost work, if it is shown."""
    found = [dialog for dialog in hand.window.findChildren(RestoreDialog) if dialog.isVisible()]
    return found[0] if found else None


def recovery_sessions() -> list[Path]:
    return [path for path in recovery_folder().iterdir() if path.is_dir()]


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
    dialog = restore_dialog(second)
    assert dialog.panel.list.count() == 1 and dialog.windowModality() == Qt.WindowModality.WindowModal
    (row,) = dialog.panel._rows
    assert (row.name, row.place) == ("a.qface", str(tmp_path)) and not row.damage
    assert "1 scan, 3 fiducials placed, 3 steps since it was saved" in row.detail
    assert "less than a minute ago" in row.when and row.picture is not None
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    second.rest()
    project = second.window.session.project
    assert project.scans == scans and project.path == tmp_path / "a.qface"
    assert second.window.isWindowModified() and len(second.landmarks.points) == 3
    second.act("file.save")
    assert not second.window.isWindowModified()
    qtbot.waitUntil(lambda: not list(recovery_folder().rglob("*.json")), timeout=5_000)
    close(second)
    assert not list(recovery_folder().iterdir())
    third = hands()
    assert restore_dialog(third) is None
    third.act("file.restore")
    assert "no unsaved work" in third.window.message.text.text()


@pytest.mark.timeout(180)
def test_several_sessions_are_kept_discarded_and_restored_one_by_one(hands: Callable[[], Hand], qtbot: Any) -> None:
    for name in ("base", "car", "man"):
        lost = hands()
        if restore_dialog(lost) is not None:
            QTest.keyClick(restore_dialog(lost), Qt.Key.Key_Escape)
        lost.choose("scan.add", bare_scan(name))
        written(lost, qtbot)
        if name == "car":
            lost.window.recovery._files.journal.write_text("{")
        crash(lost)
        QTest.qWait(20)

    hand = hands()
    panel = restore_dialog(hand).panel
    assert [row.name for row in panel._rows] == ["Untitled", "Damaged session", "Untitled"]
    assert "1 range image can be restored" in panel._rows[1].damage and panel._rows[1].picture is not None
    panel.list.setCurrentRow(0)
    QTest.mouseClick(panel.discard, Qt.MouseButton.LeftButton)
    assert "cannot be brought back" in panel.question.text() and len(panel._rows) == 3
    QTest.mouseClick(panel.keep, Qt.MouseButton.LeftButton)
    assert not panel.question.isVisible() and panel.restore.isVisible() and len(panel._rows) == 3
    for _ in range(2):
        QTest.mouseClick(panel.discard, Qt.MouseButton.LeftButton)
    assert [row.name for row in panel._rows] == ["Damaged session", "Untitled"]
    QTest.mouseClick(panel.restore, Qt.MouseButton.LeftButton)
    hand.rest()
    assert [item.name for item in hand.window.session.project.scans] == ["car"]
    assert "without the journal" in hand.window.message.text.text() and hand.window.isWindowModified()

    hand.window.session.stack.setClean()
    hand.act("file.restore")
    panel = restore_dialog(hand).panel
    QTest.mouseClick(panel.restore, Qt.MouseButton.LeftButton)
    hand.rest()
    assert [item.name for item in hand.window.session.project.scans] == ["base"]
    assert len(recovery_sessions()) == 1, "only what this window has now is left"


def test_a_living_session_is_not_offered_and_a_closed_one_leaves_nothing(hands: Callable[[], Hand], qtbot: Any) -> None:
    first = hands()
    first.choose("scan.add", bare_scan("base"))
    written(first, qtbot)
    second = hands()
    assert restore_dialog(second) is None
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
        assert recover(files).project.scans == () and recover(files).path is None and not recover(files).lost
    finally:
        session.close()
