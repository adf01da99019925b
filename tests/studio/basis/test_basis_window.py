"""The basis stage in the window: files that are lost, choices, words of the menus, docks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studio.app import make_window
from studio.basis.loading import load_motion, load_rig
from studio.main_window import MainWindow
from studio.project import store
from studio.project.basis_items import BasisSetup
from studio.project.document import Project
from studio.settings import Settings
from tests.studio.basis.small import take, write_files
from widgets.parts.choice_dialog import ChoiceDialog


@pytest.fixture
def window(qtbot: Any, tmp_path: Path) -> Iterator[MainWindow]:
    made = make_window(Settings(tmp_path / "settings.ini"))
    yield made
    qtbot.waitUntil(lambda: not made.session.tasks.busy, timeout=20_000)
    made.session.stack.setClean()
    made.close()
    made.deleteLater()


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path, Path]:
    return write_files(tmp_path)


def project_file(files: tuple[Path, Path, Path], folder: Path, lost: str = "") -> Path:
    """Return the file of a hand rig, a driver and a performance; what ``lost`` names was saved without its content."""
    rig, motion = load_rig(files[0]), load_motion(files[1])
    driver = load_rig(files[0].rename(files[0].with_name("driver.npz")), unit="cm")
    project = Project()
    basis = project.basis
    for entry in (rig, driver):
        basis.rigs.insert(len(basis.rigs), entry.item)
    basis.motions.insert(0, motion.item)
    basis.set_setup(BasisSetup(rig.item.id, motion.item.id, driver.item.id))
    if lost != "hand":
        basis.keep_rig(rig.content)
    if lost != "driver":
        basis.keep_rig(driver.content)
    if lost != "motion":
        basis.keep_motion(motion.item.content, motion.data)
    return store.save(project, folder / "basis.qface")


def rest(window: MainWindow, qtbot: Any) -> None:
    qtbot.waitUntil(lambda: not window.session.tasks.busy, timeout=20_000)


def test_a_lost_driving_rig_is_asked_for_and_taken_when_it_is_the_same(
    window: MainWindow, files: tuple[Path, Path, Path], tmp_path: Path, qtbot: Any
) -> None:
    assert window.open_project(project_file(files, tmp_path, "driver"))
    window.show_stage("basis")
    stage, relink = window.stage, window.actions_["basis.relink"]
    rest(window, qtbot)
    step = stage.teller._next()
    assert relink.isEnabled() and step.action == "basis.relink" and "the shapes of driver are lost" in step.text
    stage.files.missing.read(stage.context.basis.driver, tmp_path / "driver.npz")
    rest(window, qtbot)
    assert stage.context.basis.missing == () and not relink.isEnabled()
    assert window.session.stack.count() == 1 and window.message.text.text() == ""


def test_another_file_takes_the_place_of_a_lost_one_only_when_that_was_agreed_to(
    window: MainWindow, files: tuple[Path, Path, Path], tmp_path: Path, qtbot: Any
) -> None:
    assert window.open_project(project_file(files, tmp_path, "motion"))
    window.show_stage("basis")
    stage = window.stage
    other = tmp_path / "other.npz"
    np.savez(other, vertices=take()[:25], fps=24.0, unit=np.array("mm"))
    item = stage.context.motion
    stage.files.missing.read(item, other)
    rest(window, qtbot)
    assert "25 frames instead of 60, 24 frames a second instead of 30" in window.message.text.text()
    assert stage.context.motion == item and not window.session.stack.count()
    window.message.offers[0].click()
    assert stage.context.motion == replace(stage.context.motion, frames=25, fps=24.0)
    assert stage.context.basis.missing == () and stage.context.motion.id == item.id
    rest(window, qtbot)


def test_there_is_nothing_to_choose_from_one_rig_and_another_is_chosen_in_the_house_dialog(
    window: MainWindow, files: tuple[Path, Path, Path], tmp_path: Path, qtbot: Any
) -> None:
    assert window.open_project(project_file(files, tmp_path))
    window.show_stage("basis")
    rest(window, qtbot)
    one, several = window.actions_["basis.choose_motion"], window.actions_["basis.choose_hand"]
    assert not one.isEnabled() and "there is only one performance" in one.toolTip()
    several.trigger()
    dialog = window.findChild(ChoiceDialog)
    assert dialog is not None and dialog.primary.text() == "Use rig" and dialog.names.currentText() == "artist"
    dialog.names.setCurrentIndex(1)
    dialog.primary.click()
    assert window.session.project.basis.hand.name == "driver"
    rest(window, qtbot)


def test_a_project_that_holds_a_basis_alone_opens_in_its_stage_where_its_own_views_are_in_the_menu(
    window: MainWindow, files: tuple[Path, Path, Path], tmp_path: Path, qtbot: Any
) -> None:
    window.show_stage("basis")
    actions, views = window.actions_, window.stage.centre.views
    assert all(not actions[name].isEnabled() for name in ("view.wire", "view.points", "view.heat", "basis.wipe"))
    window.show_stage("scan")
    assert window.open_project(project_file(files, tmp_path))
    assert window.stage_id == "basis"
    rest(window, qtbot)
    assert actions["basis.side"].isChecked() and actions["basis.wipe"].isEnabled()
    actions["basis.wipe"].trigger()
    assert views.state.mode == "wipe" and not actions["basis.side"].isChecked()
    actions["basis.wipe"].trigger()
    assert views.state.mode == "wipe" and actions["basis.wipe"].isChecked()
    views.tools.modes.chosen.emit("grid")
    assert actions["basis.grid"].isChecked() and not actions["basis.wipe"].isChecked()
    actions["basis.pca"].trigger()
    assert views.state.pca and window.stage.display.frames.pca
    views.tools.buttons["clip"].click()
    assert views.state.clip_heat and actions["basis.clip_heat"].isChecked()


def test_layouts_maximised_views_and_messages_stay_in_their_stage(window: MainWindow) -> None:
    def shown() -> set[str]:
        return {name for name, dock in window.docks.items() if not dock.isHidden()}

    layouts = window.habits.layouts
    scan_docks = shown()
    layouts.save("mine")
    window.show_stage("basis")
    basis_docks = shown()
    assert basis_docks and not basis_docks & scan_docks and not layouts.named
    window.docks["shape"].hide()
    layouts.save("mine")
    window.docks["shape"].show()
    assert layouts.use("mine") and shown() == basis_docks - {"shape"}

    maximise = window.stage.centre.views.tools.buttons["maximise"]
    maximise.setChecked(True)
    window.stage.centre.views.maximise_requested.emit(True)
    assert shown() == set()
    window.message.tell("error", "the rig cannot be read")
    window.show_stage("scan")
    assert shown() == scan_docks and window.message.text.text() == ""
    window.show_stage("basis")
    assert shown() == basis_docks - {"shape"}
    assert not maximise.isChecked()
    layouts.remove("mine")
    window.show_stage("scan")
    assert list(layouts.named) == ["mine"] and layouts.use("mine") and shown() == scan_docks
