"""A set of fiducials of one's own: made in the editor, clicked, fitted, renamed, undone, saved and opened again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QLineEdit, QMessageBox

from engine.files.scheme import read_scheme
from engine.landmarks import LandmarkState
from studio.scan.scheme_dialog import SchemeDialog
from tests.journeys.driver import LEFT, NO_KEY, Hand, bare_scan, truth
from widgets.scan.scheme_editor import SchemeEditor

CHEEK = 140


@pytest.fixture
def ready(hand: Hand) -> Hand:
    """A window with one scan whose 20 fiducials are placed."""
    hand.choose("scan.add", bare_scan())
    for name, place in truth().items():
        hand.stage.editor.move(name, *place)
    hand.rest()
    return hand


def open_editor(hand: Hand) -> SchemeEditor:
    hand.act("scan.scheme")
    dialog = next(d for d in QApplication.topLevelWidgets() if isinstance(d, SchemeDialog) and d.isVisible())
    hand.qtbot.waitUntil(lambda: dialog.isActiveWindow() and dialog.editor.chart.zoom > 1.0)
    QTest.qWait(30)
    return dialog.editor


def type_name(editor: SchemeEditor, text: str) -> None:
    box = editor.table.viewport().findChildren(QLineEdit)[-1]
    box.selectAll()
    QTest.keyClicks(box, text)
    QTest.keyClick(box, Qt.Key.Key_Return)
    QTest.qWait(20)


def test_a_scheme_of_ones_own_from_the_editor_to_the_face(ready: Hand, tmp_path: Path, monkeypatch: Any) -> None:
    hand, session = ready, ready.window.session
    usual = session.project.fit(hand.stage.context.scan_id)
    panel = hand.stage.centre.inputs.source_panel

    # Duplicate the closed scheme, call it "mine", add a cheek where the template is clicked, and its partner.
    editor = open_editor(hand)
    QTest.mouseClick(editor.duplicate_button, LEFT)
    QTest.keyClicks(editor.name, "mine")
    editor.choose_row(len(editor.draft.rows) - 1)
    QTest.mouseClick(editor.add_button, LEFT)
    QTest.qWait(20)
    type_name(editor, "cheek_left")
    place = editor.chart.place(CHEEK)
    QTest.mouseClick(editor.chart.viewport(), LEFT, NO_KEY, QPoint(round(place.x()), round(place.y())))
    QTest.mouseClick(editor.mirror_button, LEFT)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *a, **k: (str(tmp_path / "mine.toml"), ""))
    QTest.mouseClick(editor.export_button, LEFT)
    assert editor.primary_button.text() == "Use scheme" and editor.primary_button.isEnabled()
    QTest.mouseClick(editor.primary_button, LEFT)
    hand.rest()
    assert session.stack.undoText() == "Use scheme mine"
    assert panel.scheme.currentText() == "mine, 22 points" and hand.stage.context.scheme.name == "mine"
    assert read_scheme(tmp_path / "mine.toml") == session.project.schemes["mine"]

    # The two new points are proposed; the template panel tells their vertex.
    marks = hand.landmarks
    assert marks["cheek_left"].state == marks["cheek_right"].state == LandmarkState.PROPOSED
    hand.stage.context.select_fiducial("cheek_left")
    button = hand.stage.centre.template_panel.vertex_button
    assert button.isVisible() and button.text() == f"vertex {CHEEK}"
    QTest.mouseClick(button, LEFT)
    assert QApplication.clipboard().text() == str(CHEEK)

    # Confirmed, and so fitted: the face lies on the scan as before.
    hand.act("scan.confirm_all")
    hand.rest()
    scan_id = hand.stage.context.scan_id
    assert session.project.state(scan_id).kind == "fresh"
    face = session.project.fit(scan_id)
    assert face.scheme == "mine" and face.fiducial_residual_px < 1e-6
    assert np.nanmedian(face.deviation_mm) <= 1.05 * np.nanmedian(usual.deviation_mm)

    # A fiducial is renamed: its point goes along in one step, and comes back in one.
    before, count = hand.landmarks, session.stack.count()
    editor = open_editor(hand)
    assert not editor.has_changes and editor.draft.name == "mine"
    editor.table.edit_field(editor.draft.row_of("chin"), "name")
    type_name(editor, "chin_tip")
    assert editor.primary_button.text() == "Save changes"
    QTest.mouseClick(editor.primary_button, LEFT)
    hand.rest()
    assert session.stack.count() == count + 1
    assert hand.landmarks["chin_tip"] == before["chin"] and not hand.landmarks["chin"].is_set
    assert session.project.state(scan_id).kind == "fresh", "followed by a fit of its own"
    hand.act("edit.undo")
    hand.rest()
    assert hand.landmarks == before and "chin" in hand.stage.context.scheme

    # Esc asks before edits are lost.
    editor = open_editor(hand)
    QTest.keyClick(editor.table, Qt.Key.Key_Delete)
    answers = [QMessageBox.StandardButton.Cancel, QMessageBox.StandardButton.Discard]
    monkeypatch.setattr(QMessageBox, "exec", lambda _box: answers.pop(0))
    dialog = editor.window()
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    assert dialog.isVisible() and editor.has_changes
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    hand.rest()
    assert not answers and session.project.schemes["mine"].names[0] == "forehead"

    # The project brings its scheme along.
    hand.choose("file.save_as", tmp_path / "own.qface")
    kept = session.project.schemes["mine"]
    session.new()
    assert panel.scheme.count() == 2
    session.open(tmp_path / "own.qface")
    hand.rest()
    assert hand.stage.context.scheme == kept and panel.scheme.currentText() == "mine, 22 points"
    assert session.project.state(scan_id).kind == "fresh"


def test_the_scheme_choice_lists_all_and_the_file_of_another_is_taken_in(
    ready: Hand, tmp_path: Path, monkeypatch: Any
) -> None:
    hand, panel = ready, ready.stage.centre.inputs.source_panel
    (tmp_path / "bad.toml").write_text("name = 3")
    (tmp_path / "quick.toml").write_text(_quick())
    QTest.mouseClick(panel.scheme_button, LEFT)
    dialog = next(d for d in QApplication.topLevelWidgets() if isinstance(d, SchemeDialog) and d.isVisible())
    editor = dialog.editor
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *a, **k: (str(tmp_path / "bad.toml"), ""))
    QTest.mouseClick(editor.import_button, LEFT)
    assert "bad.toml, name" in editor.message.text() and editor.draft.name == "closed"
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *a, **k: (str(tmp_path / "quick.toml"), ""))
    QTest.mouseClick(editor.import_button, LEFT)
    assert editor.draft.name == "quick" and len(editor.draft.rows) == 12
    QTest.mouseClick(editor.primary_button, LEFT)
    hand.rest()
    listed = [panel.scheme.itemText(k) for k in range(panel.scheme.count())]
    assert listed == ["closed, 20 points", "open, 26 points", "quick, 12 points"]
    assert panel.scheme.currentText() == "quick, 12 points"
    assert hand.window.session.project.state(hand.stage.context.scan_id).kind == "fresh"
    hand.act("edit.undo")
    hand.rest()
    assert panel.scheme.count() == 2 and hand.stage.context.scheme.name == "closed"


def _quick() -> str:
    from engine.files.scheme import SchemeEntry
    from tests.engine.schemes import quick

    entry = SchemeEntry.of(quick())
    lines = [f'name = "{entry.name}"', f'title = "{entry.title}"', 'layout = "closed"']
    for mark in entry.landmark:
        lines += ["[[landmark]]", f"vertex = {mark.vertex}"]
        lines += [f'{key} = "{getattr(mark, key)}"' for key in ("name", "group", "side", "mirror", "hint")]
    return "\n".join(lines)
