"""Units are chosen and taken back, results lose no step, and what is shown follows what was changed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QWidget

import resources
from engine.files.scan import read_scan
from studio import main_window
from studio.app import make_window
from studio.settings import Settings
from studio.stages import DockSpec, Stage
from tests.journeys.conftest import close
from tests.journeys.driver import Hand, bare_scan, truth


@pytest.fixture
def metres(tmp_path: Path) -> Path:
    """A scan whose numbers are metres, which its file does not say."""
    scan = read_scan(resources.sample_path("subject", "base.json")).scan
    np.savez(tmp_path / "face.npz", points=scan.points / 1000.0, colour=scan.colour)
    return tmp_path / "face.npz"


def test_a_file_without_a_unit_is_read_again_in_the_chosen_one(hand: Hand, metres: Path) -> None:
    hand.choose("scan.add", metres)
    panel, project = hand.stage.centre.inputs.source_panel, hand.window.session.project
    scan_id = hand.stage.context.scan_id
    assert "rather" in hand.window.message.text.text()
    assert panel.unit.isVisible() and panel.unit.currentText() == "mm" and "assumed" in panel.unit.toolTip()
    hand.click(*truth()["forehead"])
    first, landmarks = project.range_image(scan_id), hand.landmarks

    panel.unit.setFocus()
    QTest.keyClick(panel.unit, Qt.Key.Key_End)
    hand.rest()
    assert panel.unit.currentText() == "m" and "m, as asked" in panel.unit.toolTip()
    image = project.range_image(scan_id)
    np.testing.assert_allclose(image.points, first.points * 1000.0, rtol=1e-12)
    assert hand.landmarks == landmarks and hand.window.session.stack.undoText() == "Read face in m"

    hand.act("edit.undo")
    assert project.range_image(scan_id) is first and panel.unit.currentText() == "mm"
    hand.act("edit.redo")
    assert panel.unit.currentText() == "m"

    metres.unlink()
    panel.unit.setFocus()
    QTest.keyClick(panel.unit, Qt.Key.Key_Home)
    hand.rest()
    assert hand.window.message.kind == "error" and "face.npz" in hand.window.message.text.text()
    assert panel.unit.currentText() == "m" and project.range_image(scan_id) is image

    hand.choose("scan.add", bare_scan("base"))
    assert not panel.unit.isVisible()


def test_late_fits_keep_what_can_be_redone(hand: Hand) -> None:
    hand.act("scan.sample")
    hand.rest()
    stack, project = hand.window.session.stack, hand.window.session.project
    hand.stage.editor.set_options({"smooth": False})
    stack.undo()
    hand.act("scan.fit_all")
    hand.rest()
    assert {project.state(item.id).kind for item in project.scans} == {"fresh"}
    assert stack.canRedo() and stack.count() == 2 and hand.stage.shown is not None
    stack.undo()
    assert not project.scans


def test_a_result_can_be_saved_without_an_edit(hand: Hand, tmp_path: Path) -> None:
    hand.act("scan.sample")
    hand.rest()
    hand.choose("file.save_as", tmp_path / "a.qface")
    assert not hand.window.actions_["file.save"].isEnabled()
    hand.act("scan.fit_all")
    hand.rest()
    assert not hand.window.isWindowModified()
    hand.act("file.save")
    assert not hand.window.actions_["file.save"].isEnabled()
    hand.window.open_project(tmp_path / "a.qface")
    project = hand.window.session.project
    assert {project.state(item.id).kind for item in project.scans} == {"fresh"}


def test_the_spikes_shown_are_those_of_the_height_that_is_set(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[int] = []
    real = hand.canvas.set_missing

    def watch(valid: Any, spikes: Any) -> None:
        shown.append(0 if spikes is None else int(spikes.sum()))
        real(valid, spikes)

    monkeypatch.setattr(hand.canvas, "set_missing", watch)
    hand.choose("scan.add", bare_scan("base"))
    first = shown[-1]
    hand.stage.centre.inputs.source_panel.spike_mm.setValue(30.0)
    hand.rest()
    assert 0 <= shown[-1] < first
    hand.stage.centre.inputs.source_panel.remove_spikes.setChecked(False)
    hand.rest()
    assert shown[-1] == 0
    hand.act("edit.undo")
    hand.act("edit.undo")
    hand.rest()
    assert shown[-1] == first


def test_f_goes_between_face_and_picture_and_the_zoom_is_kept_from_scan_to_scan(hand: Hand) -> None:
    hand.act("scan.sample")
    hand.rest()
    framed = hand.canvas.zoom
    hand.act("view.frame")
    assert hand.canvas.zoom < framed
    hand.act("view.frame")
    assert hand.canvas.zoom == pytest.approx(framed)
    hand.canvas.set_zoom(5.0, QPointF(100, 100))
    place = hand.canvas.to_picture(QPointF(0, 0))
    hand.stage.context.select_scan(hand.window.session.project.scans[2].id)
    hand.rest()
    after = hand.canvas.to_picture(QPointF(0, 0))
    assert hand.canvas.zoom == 5.0 and (after.x(), after.y()) == (place.x(), place.y())


def test_the_copied_command_is_that_of_the_fit(hand: Hand) -> None:
    hand.choose("scan.add", bare_scan("base"))
    action = hand.window.actions_["scan.copy_command"]
    assert not action.isEnabled() and "Not now" in action.toolTip()
    hand.choose("scan.import", resources.sample_path("subject", "base_fiducials.json"))
    hand.stage.editor.set_options({"levels": 1})
    hand.act("scan.copy_command")
    text = QGuiApplication.clipboard().text()
    assert text.startswith("quasiface scan fit ") and "--levels 1" in text and "--unit" not in text
    assert "base_fiducials.json" in hand.window.message.text.text()


def test_the_share_of_picture_and_3d_is_remembered_and_reset(hands: Callable[[], Hand]) -> None:
    first = hands()
    splitter = first.stage.centre._splitter
    at_first = splitter.sizes()
    splitter.setSizes([700, 300])
    chosen = splitter.sizes()
    assert abs(chosen[0] - at_first[0]) > 50
    close(first)
    second = hands()
    splitter = second.stage.centre._splitter
    assert abs(splitter.sizes()[0] - chosen[0]) <= 8
    second.stage.centre.template_dock.hide()
    second.act("window.reset")
    assert abs(splitter.sizes()[0] - at_first[0]) <= 8 and second.stage.centre.template_dock.isVisible()


class OtherStage:
    """A stage with one dock."""

    def __init__(self) -> None:
        self.centre: QWidget = QLabel("other")
        self.docks = (DockSpec("other", "Other", QWidget(), Qt.DockWidgetArea.LeftDockWidgetArea, 100),)
        self.closed = self.was_reset = False

    zones: tuple[QWidget, ...] = ()
    empty_place = None
    subject = ""

    @property
    def usual_view(self) -> QWidget:
        return self.centre

    def came_into_view(self) -> None:
        self.was_shown = True

    def reset_layout(self) -> None:
        self.was_reset = True

    def close(self) -> None:
        self.closed = True


def test_tabs_choose_stages_and_all_are_closed(qtbot: Any, own_home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = OtherStage()
    monkeypatch.setattr(main_window, "STAGES", (*main_window.STAGES, Stage("other", "Other", lambda _window: other)))
    window = make_window(Settings())
    qtbot.addWidget(window)
    assert list(window.stages) == ["scan"] and window.stage is window.stages["scan"]
    assert "other" not in window.docks and not window.docks["scans"].isHidden()
    tab = window.findChild(QWidget, "stage_other")
    tab.click()
    assert other.was_shown and window.stage_id == "other" and not window.actions_["scan.fit"].isVisible()
    assert window.stage is other and window._stack.currentWidget() is other.centre and tab.isChecked()
    assert not window.docks["other"].isHidden() and window.docks["scans"].isHidden()
    window.findChild(QWidget, "stage_scan").click()
    assert window.stage is window.stages["scan"] and not window.docks["scans"].isHidden()
    assert window.docks["other"].isHidden() and window.actions_["scan.fit"].isVisible()
    window.actions_["window.reset"].trigger()
    assert other.was_reset
    assert window.close() and other.closed
