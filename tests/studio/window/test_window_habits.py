"""The window's own habits, on the real window without its 3-D: text scale, layouts, zones, overview, welcome, log."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QByteArray, QRect, QSize, Qt
from PySide6.QtGui import QImage, QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QInputDialog, QWidget

from engine.errors import InputError
from studio.actions import MENUS, SPECS
from studio.app import make_window
from studio.crash_dialog import CrashDialog, show_crash
from studio.layouts import seen_place
from studio.main_window import MainWindow
from studio.overview import OverviewDialog, entries, keys_of
from studio.preferences import PreferencesDialog
from studio.project import recovery
from studio.project.document import Project
from studio.settings import SETTINGS, Settings
from studio.stages import STAGES
from tests.studio.conftest import face_fiducials
from widgets import text_scale, theme


@pytest.fixture
def open_window(qtbot: Any) -> Iterator[Callable[[], MainWindow]]:
    opened: list[MainWindow] = []

    def make() -> MainWindow:
        window = make_window(Settings())
        opened.append(window)
        return window

    yield make
    app = QApplication.instance()
    for window in opened:
        window.session.stack.setClean()
        window.close()
        window.deleteLater()
    assert isinstance(app, QApplication)
    theme.apply(app, theme.DARK, 1.0)


@pytest.fixture
def main_window(open_window: Callable[[], MainWindow]) -> MainWindow:
    return open_window()


def test_every_action_that_is_declared_is_bound_and_none_shares_a_key(main_window: MainWindow) -> None:
    from widgets.viewers import navigation

    actions = main_window.actions_
    main_window.show_stage("basis")
    assert {spec.id for spec in SPECS if not actions.has_deed(spec.id)} == set()
    for stage in STAGES:
        main_window.show_stage(stage.id)
        assert any(actions.is_here(spec.id) and spec.id.startswith(f"{stage.id}.") for spec in SPECS)
        for style in navigation.STYLES:
            main_window.settings["view/navigation"] = style
            taken: dict[str, str] = {}
            for spec in SPECS:
                for key in keys_of(actions[spec.id]) if actions.is_here(spec.id) else ():
                    assert key not in taken, f"{stage.id}, {style}: {key} is of {spec.id} and {taken[key]}"
                    taken[key] = spec.id
            menus = {f"Alt+{menu[0]}" for menu in MENUS}
            assert not menus & set(taken)


def test_the_overview_lists_the_actions_of_the_stage_in_view_with_the_reason_its_menu_gives(
    main_window: MainWindow,
) -> None:
    actions = main_window.actions_
    for stage in ("scan", "basis"):
        main_window.show_stage(stage)
        found = {entry.id: entry for entry in entries(actions) if entry.id}
        assert set(found) == {spec.id for spec in SPECS if actions[spec.id].isVisible()}
        other = {"scan": "basis.", "basis": "scan."}[stage]
        assert {"file.save", "view.heat"} <= set(found) and not any(name.startswith(other) for name in found)
        for name, entry in found.items():
            assert bool(entry.why) == (not actions[name].isEnabled())
            assert entry.why in actions[name].toolTip()
            assert entry.text == actions[name].text().replace("&", "").removesuffix("...")
        groups = {entry.group for entry in entries(actions) if not entry.id}
        assert ("In the picture" in groups) == (stage == "scan")
        assert any(group.startswith("In 3-D") for group in groups)
    assert not any("scan" in (entry.text + entry.tip).lower() for entry in found.values() if entry.group == "View")
    main_window.show_stage("scan")
    assert actions["view.points"].text() == "Scan &points"


def test_the_overview_runs_an_action_after_it_has_closed(main_window: MainWindow) -> None:
    main_window.actions_["help.overview"].trigger()
    dialog = main_window.findChild(OverviewDialog)
    assert dialog is not None and dialog.isVisible()
    QTest.keyClicks(dialog.panel.search, "dark theme")
    QTest.keyClick(dialog.panel.search, Qt.Key.Key_Return)
    assert not dialog.isVisible() and main_window.settings["look/theme"] == "light"
    assert not theme.current().is_dark


def test_text_scale_follows_keys_and_settings_and_everything_follows_it(main_window: MainWindow) -> None:
    actions, table = main_window.actions_, main_window.stage.centre.fiducials.table
    before = (main_window.status.height(), main_window.top.height(), table.verticalHeader().defaultSectionSize())
    icon = main_window.stage.centre.canvas_panel.wire_button.iconSize().width()
    for _ in range(5):
        actions["view.larger"].trigger()
    assert main_window.settings["look/text_scale"] == 150 and text_scale.factor() == 1.5
    after = (main_window.status.height(), main_window.top.height(), table.verticalHeader().defaultSectionSize())
    assert after == tuple(round(1.5 * size) for size in before)
    assert main_window.stage.centre.canvas_panel.wire_button.iconSize().width() == round(1.5 * icon)
    assert theme.font().pixelSize() == 18 and "font-size: 18px" in QApplication.instance().styleSheet()
    for _ in range(9):
        actions["view.larger"].trigger()
    assert text_scale.factor() == 2.0 and not actions["view.larger"].isEnabled()
    actions["view.usual"].trigger()
    main_window.settings["look/text_scale"] = 95
    actions["view.smaller"].trigger()
    assert main_window.settings["look/text_scale"] == 90
    actions["view.usual"].trigger()
    assert before == (
        main_window.status.height(),
        main_window.top.height(),
        table.verticalHeader().defaultSectionSize(),
    )


def test_preferences_act_at_once_and_refuse_a_range_that_is_upside_down(main_window: MainWindow) -> None:
    main_window.actions_["edit.preferences"].trigger()
    dialog = main_window.findChild(PreferencesDialog)
    assert dialog is not None
    assert set(dialog.panel.rows) == {setting.key for setting in SETTINGS if setting.section}
    dialog.panel.changed.emit("look/theme", "light")
    assert not theme.current().is_dark and not main_window.actions_["view.dark"].isChecked()
    high = main_window.settings["view/high"]
    dialog.panel.changed.emit("view/low", high + 1.0)
    assert "below" in dialog.panel.error.text() and main_window.settings["view/low"] < high
    main_window.actions_["view.dark"].trigger()
    assert dialog.panel.rows["look/theme"].input.control.current == "dark"
    dialog.panel.changed.emit("view/high", 0.7)
    dialog.panel.reset_all.click()
    for setting in SETTINGS:
        if setting.section:
            assert main_window.settings[setting.key] == setting.default
    dialog.reject()


def test_layouts_are_kept_under_names_for_the_next_session(
    open_window: Callable[[], MainWindow], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = open_window()
    first.docks["log"].show()
    first.docks["scans"].hide()
    monkeypatch.setattr(QInputDialog, "getText", lambda *_a, **_k: ("pictures only", True))
    first.actions_["window.save_layout"].trigger()
    first.actions_["window.reset"].trigger()
    assert first.docks["log"].isHidden() and not first.docks["scans"].isHidden()
    first.close()
    second = open_window()
    assert list(second.habits.layouts.named) == ["pictures only"]
    assert second.habits.layouts.use("pictures only")
    assert not second.docks["log"].isHidden() and second.docks["scans"].isHidden()
    second.habits.layouts.remove("pictures only")
    assert not second.habits.layouts.named


@pytest.mark.parametrize("kept", ["", "[]", "{", '{"a": 1}', '{"a": "not base 64 \u20ac"}'])
def test_damaged_layouts_leave_the_window_as_it_is(kept: str, main_window: MainWindow) -> None:
    main_window.settings["window/layouts"] = kept
    assert not main_window.habits.layouts.use("a")
    assert "cannot be read" in main_window.message.text.text()
    assert not main_window.docks["scans"].isHidden()


def test_a_layout_of_other_docks_is_survived(open_window: Callable[[], MainWindow]) -> None:
    settings = Settings()
    settings["window/layout"] = QByteArray(b"of another version")
    settings["window/geometry"] = QByteArray(b"nonsense")
    settings.save()
    assert not open_window().docks["scans"].isHidden()


SCREENS = [QRect(0, 0, 1920, 1080), QRect(1920, 0, 1280, 1024)]


@pytest.mark.parametrize(
    ("wanted", "stays"),
    [
        (QRect(100, 100, 1440, 900), True),
        (QRect(2000, 500, 1440, 900), True),
        (QRect(-1300, 0, 1440, 900), False),
        (QRect(5000, 100, 1440, 900), False),
        (QRect(100, -400, 1440, 900), False),
        (QRect(100, 1070, 1440, 900), False),
        (QRect(4000, 0, 4000, 3000), False),
    ],
)
def test_a_window_whose_screen_is_gone_comes_back_whole(wanted: QRect, stays: bool) -> None:
    place = seen_place(wanted, SCREENS)
    assert (place == wanted) == stays
    if not stays:
        assert SCREENS[0].contains(place) and place.size() == wanted.size().boundedTo(QSize(1920, 1080))


def test_the_page_of_an_empty_project_goes_with_the_first_scan_and_lists_recent_projects(
    main_window: MainWindow, make_project: Any, tmp_path: Path, qtbot: Any
) -> None:
    path = tmp_path / "ann.qface"
    main_window.session.take_over(make_project(face_fiducials())[0])
    main_window.session.save(path)
    main_window.session.new()
    main_window.settings.remove("files/recent")
    main_window.show()
    assert main_window.habits.welcome is not None
    page = main_window.habits.welcome.page
    canvas = main_window.stage.centre.canvas_panel.canvas
    assert page.isVisible() and not canvas.isEnabled()
    assert page.size() == main_window.stage.centre.canvas_panel.size()
    main_window.settings.add_recent(path)
    main_window.session.new()
    assert [card.text() for card in page.recent] == ["ann"]
    qtbot.waitUntil(lambda: page.recent[0].has_picture and page.sample.has_picture, timeout=20_000)
    QTest.keyClick(page.recent[0], Qt.Key.Key_Space)
    assert main_window.session.project.path == path
    assert not page.isVisible() and canvas.isEnabled()
    main_window.session.new()
    assert page.isVisible()


def test_zones_are_entered_from_left_to_right_and_each_remembers_its_place(
    main_window: MainWindow, make_project: Any, qtbot: Any
) -> None:
    project, _ = make_project(face_fiducials())
    main_window.session.take_over(project)
    main_window.show()
    main_window.activateWindow()
    qtbot.waitUntil(main_window.isActiveWindow, timeout=10_000)
    zones = main_window.habits.zones
    parts = zones.zones()
    lefts = [part.mapTo(main_window, part.rect().topLeft()).x() for part in parts]
    assert lefts == sorted(lefts) and len(parts) >= 5
    held: list[QWidget] = []
    for part in parts:
        main_window.actions_["window.next_zone"].trigger()
        focus = QApplication.focusWidget()
        assert focus is not None and part.isAncestorOf(focus)
        held.append(focus)
    other = main_window.stage.centre.fiducials.mirror_button
    other.setFocus()
    main_window.actions_["window.next_zone"].trigger()
    main_window.actions_["window.last_zone"].trigger()
    assert QApplication.focusWidget() is other
    assert main_window.stage.centre.canvas_panel.canvas in held


def test_messages_tasks_and_qt_end_in_the_log_dock(main_window: MainWindow, qtbot: Any) -> None:
    view = main_window.habits.log.view
    view.clear_button.click()
    main_window.message.tell("error", "the file is empty; save it again")
    logging.getLogger("elsewhere").warning("careful\nmore")
    done: list[int] = []
    main_window.session.tasks.submit("Counting", lambda _p: 7, done.append)
    main_window.session.tasks.submit("Failing", lambda _p: 1 / 0, done.append, failed=lambda _e: done.append(0))
    qtbot.waitUntil(lambda: len(done) == 2, timeout=10_000)
    text = "\n".join(view.shown)
    assert "the file is empty" in text and "careful" in text and "more" not in text
    assert "Counting: started" in text and "Counting: done after" in text and "Failing: failed after" in text
    view.levels.chosen.emit("info")
    view.levels.set_current("error")
    view.levels.chosen.emit("error")
    assert len(view.shown) == 2
    view.copy()
    assert "save it again" in QApplication.clipboard().text()
    view.clear_requested.emit()
    assert not view.shown


def test_the_log_is_written_whole(main_window: MainWindow, tmp_path: Path) -> None:
    main_window.message.tell("info", "Wrote a face")
    main_window.habits.log.write(tmp_path / "log.txt")
    assert "Wrote a face" in (tmp_path / "log.txt").read_text("utf-8").splitlines()[-1]


def test_broken_settings_are_told_once_in_the_window(open_window: Callable[[], MainWindow], qtbot: Any) -> None:
    path = Settings().path
    path.parent.mkdir(parents=True)
    path.write_bytes(b"\xff\xff")
    window = open_window()
    window.show()
    qtbot.waitUntil(lambda: "studio.ini.bak" in window.message.text.text(), timeout=10_000)
    assert not window.settings.notice


def test_the_crash_dialog_says_what_happened_and_goes_on(main_window: MainWindow, tmp_path: Path, qtbot: Any) -> None:
    report = tmp_path / "report.txt"
    report.write_text("the whole report", "utf-8")
    main_window.show()
    show_crash(main_window, "Something went wrong in the studio", "KeyError: 'nose'\n\nmore", report)
    show_crash(main_window, "Something went wrong in the studio", "second", None)
    qtbot.waitUntil(lambda: main_window.findChild(CrashDialog) is not None, timeout=5_000)
    (dialog,) = main_window.findChildren(CrashDialog)
    panel = dialog.panel
    assert panel.details.toPlainText() == "the whole report" and str(report) in panel.note.text()
    panel.copy_button.click()
    assert QApplication.clipboard().text() == "the whole report"
    assert panel.continue_button.isDefault()
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    assert not dialog.isVisible() and main_window.isVisible()
    show_crash(main_window, "a.ply", "a.ply: is empty; save it again", None)
    assert main_window.message.text.text() == "a.ply: is empty; save it again"


def test_the_dialog_of_a_fault_claims_to_have_kept_the_work_only_where_it_is_on_the_disk(
    main_window: MainWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    from studio import crash_dialog

    def full(*_values: object) -> None:
        raise InputError("disk", "is full", "make room")

    assert crash_dialog._kept(main_window) == "Nothing is unsaved."
    main_window.session.take_over(Project())
    assert "is written down" in crash_dialog._kept(main_window)
    assert main_window.recovery._files.complete
    with monkeypatch.context() as patch:
        patch.setattr(recovery, "write_journal", full)
        text = crash_dialog._kept(main_window)
    assert "could not be written down: save it now" in text and "is written down" not in text


def test_icons_are_drawn_in_the_pixels_of_the_screen(qtbot: Any) -> None:
    for scale in (1.0, 1.5, 2.0):
        picture = theme.icon("lock", "text", 16).pixmap(QSize(16, 16), scale)
        assert picture.size() == QSize(round(16 * scale), round(16 * scale))
        image = picture.toImage().convertToFormat(QImage.Format.Format_ARGB32)
        assert any(image.pixelColor(x, y).alpha() == 255 for x in range(image.width()) for y in range(image.height()))


def test_no_shortcut_is_ambiguous_for_qt() -> None:
    for other in ("basis.", "scan."):
        specs = [spec for spec in SPECS if not spec.id.startswith(other)]
        keys = [QKeySequence(key).toString() for spec in specs for key in spec.shortcuts]
        assert len(keys) == len(set(keys))
