"""Landmarks of another tool go through the real dialog: seen, mapped, changed by hand and clicks, one step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

import resources
from engine.files.landmarks import read_landmarks, write_landmarks
from engine.files.mapping import read_mapping
from engine.landmark_mapping import invert_mapping
from engine.landmarks import LandmarkState
from studio.cli import main
from studio.scan.fiducial_export import FiducialExportDialog
from studio.scan.fiducial_files import shipped_mappings
from studio.scan.fiducial_import import FiducialImportDialog
from tests.journeys.driver import Hand, bare_scan, truth

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def ibug(tmp_path: Path) -> Path:
    """Write the truth of the closed mouth as 68 points; the ones no fiducial tells lie in the upper left corner."""
    mapping = next(m for m in shipped_mappings() if m.name == "ibug68")
    known = {name: place for name, place in truth().items() if name != "forehead"}
    done = invert_mapping(mapping, known)
    rest = np.column_stack([np.arange(68) % 17 * 12.0 + 8, np.arange(68) // 17 * 12.0 + 8])
    points = np.where(np.isfinite(done.points), done.points, rest)
    write_landmarks(tmp_path / "face.pts", points, [str(k) for k in range(68)])
    return tmp_path / "face.pts"


def opened(hand: Hand, kind: type) -> Any:
    dialogs = hand.window.findChildren(kind)
    assert dialogs, "no dialog was opened"
    hand.qtbot.waitExposed(dialogs[-1])
    QTest.qWait(30)
    return dialogs[-1]


def press(button: Any) -> None:
    assert button.isEnabled(), button.toolTip()
    QTest.mouseClick(button, LEFT)


def row(dialog: Any, name: str) -> Any:
    return next(r for r in dialog.panel.table.rows.rows if r.name == name)


def click_point(dialog: Any, index: int) -> None:
    canvas = dialog.panel.canvas
    x, y = dialog._found.pixels[index]
    place = canvas.to_view(QPointF(x, y))
    at = QPoint(round(place.x()), round(place.y()))
    assert canvas.viewport().rect().contains(at)
    QTest.mouseMove(canvas.viewport(), at)
    QTest.mouseClick(canvas.viewport(), LEFT, Qt.KeyboardModifier.NoModifier, at)


def test_points_of_another_tool_become_fiducials_in_one_step(
    hand: Hand, ibug: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hand.choose("scan.add", bare_scan())
    hand.click(*truth()["forehead"])

    before, count = hand.landmarks, hand.window.session.stack.count()
    hand.choose("scan.import", ibug)
    dialog = opened(hand, FiducialImportDialog)
    panel = dialog.panel
    assert panel.mapping.currentText() == "iBUG, 68 points" and panel.accept.text() == "Import 19 fiducials"
    assert row(dialog, "chin").source == "8, 8, 57" and row(dialog, "chin").state == "ok"
    assert row(dialog, "forehead").source == "" and "1 not in the mapping: forehead" in panel.report.text()
    # The command does the same without a window.
    assert main([*_words(panel.command.command)[1:-1], str(tmp_path / "out.json"), "--json"]) == 0
    assert set(read_landmarks(tmp_path / "out.json").labels) == set(truth()) - {"forehead"}
    # A wrong point, typed: refused in the dialog, nothing is lost.
    panel.edited.emit("nose_tip", "99")
    assert "point '99': is not in the file" in panel.alarm.text() and row(dialog, "nose_tip").source == "30"
    # A row is selected, a point is clicked: it is assigned; typed back.
    panel.table.choose("nose_tip")
    click_point(dialog, 33)
    assert row(dialog, "nose_tip").source == "33" and panel.command.command == ""
    assert "changed" in panel.mapping.currentText()
    answer = lambda *_a, **_k: (str(tmp_path / "mine.toml"), "")  # noqa: E731
    monkeypatch.setattr(QFileDialog, "getSaveFileName", answer)
    press(panel.save_button)
    assert read_mapping(tmp_path / "mine.toml").entries["nose_tip"] == (33,) and "mine.toml" in panel.command.command
    panel.table.setFocus()
    QTest.keyClick(panel.table, Qt.Key.Key_Delete)
    assert row(dialog, "nose_tip").source == "" and panel.accept.text() == "Import 18 fiducials"
    panel.edited.emit("nose_tip", "30")
    assert hand.landmarks == before and hand.window.session.stack.count() == count
    press(panel.accept)
    hand.rest()
    assert hand.window.session.stack.count() == count + 1
    for name, (x, y) in truth().items():
        if name != "forehead":
            assert hand.landmarks[name].state is LandmarkState.PLACED
            assert (hand.landmarks[name].x, hand.landmarks[name].y) == pytest.approx((x, y), abs=1e-9)
    assert hand.landmarks["forehead"] == before["forehead"]
    hand.window.session.stack.undo()
    assert hand.landmarks == before


def _words(command: str) -> list[str]:
    import shlex

    return shlex.split(command)


def test_sizes_that_differ_are_scaled_only_when_asked_and_escape_changes_nothing(hand: Hand, tmp_path: Path) -> None:
    hand.choose("scan.add", bare_scan())
    half = {name: ((x + 0.5) / 2 - 0.5, (y + 0.5) / 2 - 0.5) for name, (x, y) in truth().items()}
    write_landmarks(tmp_path / "half.json", np.array(list(half.values())), list(half), (320, 240))
    hand.stage.files.drop([tmp_path / "half.json"])
    hand.rest()
    dialog = opened(hand, FiducialImportDialog)
    assert "320 x 240" in dialog.panel.alarm.text() and not dialog.panel.accept.isEnabled()
    QTest.mouseClick(dialog.panel.scale, LEFT, pos=QPoint(8, dialog.panel.scale.height() // 2))
    assert dialog.panel.accept.text() == "Import 20 fiducials"
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    hand.rest()
    assert not hand.landmarks.points and hand.window.session.stack.count() == 1
    hand.choose("scan.import", tmp_path / "half.json")
    dialog = opened(hand, FiducialImportDialog)
    QTest.mouseClick(dialog.panel.scale, LEFT, pos=QPoint(8, dialog.panel.scale.height() // 2))
    dialog.panel.state.setFocus()
    QTest.keyClick(dialog.panel.state, Qt.Key.Key_Right)
    press(dialog.panel.accept)
    hand.rest()
    for name, (x, y) in truth().items():
        point = hand.landmarks[name]
        assert point.state is LandmarkState.PROPOSED and (point.x, point.y) == pytest.approx((x, y), abs=1e-9)


def test_fiducials_go_out_as_points_of_another_tool_and_come_back(hand: Hand, tmp_path: Path) -> None:
    hand.choose("scan.add", bare_scan())
    hand.choose("scan.import", resources.sample_path("subject", "base_fiducials.json"))
    hand.choose("scan.export", tmp_path / "out.pts")
    dialog = opened(hand, FiducialExportDialog)
    assert dialog.panel.accept.isEnabled(), "all 20 are placed, so .pts can hold them by their order"
    choose(dialog, "ibug68")
    assert not dialog.panel.accept.isEnabled() and "cannot leave points out" in dialog.panel.report.text()
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    hand.rest()
    assert not (tmp_path / "out.pts").exists()
    hand.choose("scan.export", tmp_path / "out.ljson")
    dialog = opened(hand, FiducialExportDialog)
    choose(dialog, "menpo_face")
    assert dialog.panel.accept.text() == "Export 19 fiducials" and "forehead" in dialog.panel.report.text()
    press(dialog.panel.command.button)
    assert QGuiApplication.clipboard().text().startswith("quasiface fiducials convert base_fiducials.json")
    press(dialog.panel.accept)
    hand.rest()
    assert read_landmarks(tmp_path / "out.ljson").present == 19
    placed = hand.landmarks
    hand.window.session.stack.undo()
    hand.choose("scan.import", tmp_path / "out.ljson")
    press(opened(hand, FiducialImportDialog).panel.accept)
    hand.rest()
    for name in set(truth()) - {"forehead"}:
        back, there = hand.landmarks[name], placed[name]
        assert (back.x, back.y) == pytest.approx((there.x, there.y), abs=1e-9)


def choose(dialog: Any, key: str) -> None:
    box = dialog.panel.mapping
    box.setCurrentIndex(box.findData(key))
    box.activated.emit(box.currentIndex())
