"""Settings, actions and crash reports, each by itself."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QWidget

from engine.errors import InputError
from studio.actions import MENUS, SPECS, Actions
from studio.crash import CrashHandler
from studio.settings import RECENT_LIMIT, SETTINGS, Settings


def test_settings_come_back_with_their_type(tmp_path: Path, qapp: Any) -> None:
    first = Settings(tmp_path / "s.ini")
    first["view/high"] = 0.25
    first["look/theme"] = "light"
    first["files/recent"] = ["one"]
    first.save()
    second = Settings(tmp_path / "s.ini")
    assert second["view/high"] == 0.25 and isinstance(second["view/high"], float)
    assert second["look/theme"] == "light" and second["files/recent"] == ["one"]
    with pytest.raises(KeyError):
        second["not/declared"]


def test_a_damaged_value_reads_as_the_default(tmp_path: Path, qapp: Any) -> None:
    (tmp_path / "s.ini").write_text("[view]\nhigh=wide\n")
    assert Settings(tmp_path / "s.ini")["view/high"] == next(s.default for s in SETTINGS if s.key == "view/high")


def test_recent_projects_are_those_that_exist_newest_first(tmp_path: Path, qapp: Any) -> None:
    settings = Settings(tmp_path / "s.ini")
    paths = [tmp_path / f"{k}.qface" for k in range(RECENT_LIMIT + 3)]
    for path in paths:
        path.touch()
        settings.add_recent(path)
    settings.add_recent(paths[-2])
    paths[-1].unlink()
    recent = settings.recent()
    assert recent[0] == paths[-2] and paths[-1] not in recent
    assert len(recent) == RECENT_LIMIT - 1 == len(set(recent))


def test_no_shortcut_is_declared_twice_and_every_key_is_valid() -> None:
    keys = [key for spec in SPECS for key in spec.shortcuts]
    for other in ("basis.", "scan."):  # actions of two stages are never in reach at once
        here = [key for spec in SPECS if not spec.id.startswith(other) for key in spec.shortcuts]
        assert len(here) == len(set(here))
    assert all(not QKeySequence(key).isEmpty() for key in keys)
    assert len({spec.id for spec in SPECS}) == len(SPECS)
    assert {spec.menu for spec in SPECS} <= set(MENUS)


def test_a_disabled_action_says_why_and_what_key_it_has(qtbot: Any) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    actions = Actions(window)
    why = ["there is no scan"]
    ran: list[int] = []
    actions.bind("scan.fit", lambda: ran.append(1), lambda: why[0])
    actions.refresh()
    action = actions["scan.fit"]
    assert not action.isEnabled()
    assert "there is no scan" in action.toolTip() and "Ctrl+Enter" in action.toolTip()
    action.trigger()
    why[0] = ""
    actions.refresh()
    action.trigger()
    assert ran == [1] and "no scan" not in action.toolTip() and "no scan" not in action.statusTip()


@pytest.mark.qt_no_exception_capture
def test_crash_is_written_and_shown_and_input_error_is_only_shown(tmp_path: Path, capsys: Any) -> None:
    shown: list[tuple[str, str, Path | None]] = []
    handler = CrashHandler(lambda *args: shown.append(args), tmp_path)
    before = sys.excepthook
    handler.install()
    try:
        try:
            {}["nose"]
        except KeyError as error:
            sys.excepthook(type(error), error, error.__traceback__)
        problem = InputError("a.ply", "is empty", "save it again")
        sys.excepthook(InputError, problem, None)
    finally:
        handler.uninstall()
    assert sys.excepthook is before
    (report,) = tmp_path.glob("*.txt")
    assert "KeyError: 'nose'" in report.read_text() and "test_settings_actions_crash" in report.read_text()
    assert shown[0][2] == report and str(report) in shown[0][1]
    assert shown[1] == ("a.ply", "a.ply: is empty; save it again", None)
