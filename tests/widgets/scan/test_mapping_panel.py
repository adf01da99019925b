"""The mapping table and its picture say what the user wants, by mouse and by keys alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QComboBox

from engine.landmarks import Side
from widgets.scan.mapping_panel import MappingChoice, MappingPanel, MappingReport
from widgets.scan.mapping_table import MappingRow

LABELS = ("0", "1", "2", "3")
POINTS = np.array([[20.0, 20.0], [80.0, 20.0], [np.nan, np.nan], [50.0, 70.0]])
ROWS = (
    MappingRow("eye_left_outer", Side.LEFT, "1", "ok", "Outer corner."),
    MappingRow("eye_right_outer", Side.RIGHT, "0", "outside"),
    MappingRow("chin", Side.MIDDLE, "", ""),
)


@pytest.fixture
def panel(qtbot: Any) -> Iterator[MappingPanel]:
    panel = MappingPanel()
    qtbot.addWidget(panel)
    panel.resize(1000, 640)
    panel.canvas.set_pictures(np.full((90, 100, 3), 128, np.uint8), None)
    panel.canvas.set_points(POINTS, LABELS)
    panel.table.set_labels(LABELS)
    panel.show_rows(ROWS, "a note")
    panel.show_choice(MappingChoice((("a", "A"), ("b", "B")), "b", ("1", "2"), "2", 1.0, False, (100, 90)))
    panel.show_report(MappingReport(1, ("1 of 3 found",)))
    panel.show()
    panel.activateWindow()
    qtbot.waitExposed(panel)
    QTest.qWait(20)
    yield panel
    panel.close()


def test_what_is_shown_can_be_read(panel: MappingPanel) -> None:
    assert panel.mapping.currentText() == "B" and panel.group.currentText() == "2" and panel.origin.current == "1"
    assert panel.accept.text() == "Import 1 fiducial" and panel.accept.isEnabled()
    assert not panel.across.isEnabled(), "a size is typed only where scaling was chosen"
    panel.show_choice(MappingChoice((("a", "A"),), "a", ("",), "", None))
    assert panel.group.isHidden() and panel.origin.isHidden() and panel.scale.isHidden()
    panel.show_report(MappingReport(0, (), "", "bad.pts: is empty"))
    assert panel.alarm.text() == "bad.pts: is empty" and not panel.accept.isEnabled()
    assert "is empty" in panel.accept.toolTip()


def test_keys_alone_choose_type_and_leave_out(panel: MappingPanel, qtbot: Any) -> None:
    table = panel.table
    table.setFocus()
    chosen: list[str] = []
    panel.chosen.connect(chosen.append)
    table.choose("eye_left_outer")
    QTest.keyClick(table, Qt.Key.Key_Down)
    assert chosen[-1] == "eye_right_outer"
    with qtbot.waitSignal(panel.edited) as left_out:
        QTest.keyClick(table, Qt.Key.Key_Delete)
    assert left_out.args == ["eye_right_outer", ""]
    QTest.keyClick(table, Qt.Key.Key_Return)
    editor = table.viewport().findChild(QComboBox)
    assert editor is not None and [editor.itemText(k) for k in range(editor.count())] == ["", *LABELS]
    QTest.keyClicks(editor, "3, 1")
    with qtbot.waitSignal(panel.edited) as typed:
        QTest.keyClick(editor, Qt.Key.Key_Return)
    assert typed.args == ["eye_right_outer", "3, 1"]
    reached: set[Any] = set()
    widget: Any = panel.mapping
    for _ in range(200):
        if widget.focusPolicy() & Qt.FocusPolicy.TabFocus:
            reached.add(widget)
        widget = widget.nextInFocusChain()
    wanted = {panel.open_button, panel.save_button, panel.group, panel.origin, panel.scale, table, panel.canvas,
              panel.state, panel.cancel, panel.accept}  # fmt: skip
    assert wanted <= reached
    for button in (panel.open_button, panel.save_button, panel.scale):
        assert "&" in button.text()


def test_a_point_is_clicked_hovered_and_ringed(panel: MappingPanel, qtbot: Any) -> None:
    canvas = panel.canvas
    canvas.set_used({1: (Side.LEFT, "eye_left_outer")})
    canvas.set_chosen([1, 3])
    place = canvas.to_view(QPointF(*POINTS[3]))
    at = QPoint(round(place.x()), round(place.y()))
    with qtbot.waitSignal(panel.point_clicked) as clicked:
        QTest.mouseClick(canvas.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, at)
    assert clicked.args == [3]
    far = QPoint(at.x() + 30, at.y())
    with qtbot.assertNotEmitted(panel.point_clicked, wait=20):
        QTest.mouseClick(canvas.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, far)
    assert canvas.point_at(QPointF(at)) == 3 and canvas.point_at(QPointF(far)) is None
    plain = canvas.grab().toImage()
    canvas.set_chosen([])
    assert canvas.grab().toImage() != plain, "the selected points are ringed"


@pytest.mark.parametrize("how", ["typed", "picked", "closed"])
def test_a_point_of_the_list_is_taken_once(panel: MappingPanel, how: str) -> None:
    edits: list[tuple[str, str]] = []
    panel.edited.connect(lambda name, text: edits.append((name, text)))
    panel.table.choose("chin")
    panel.table.setFocus()
    QTest.keyClick(panel.table, Qt.Key.Key_Return)
    editor = panel.table.viewport().findChild(QComboBox)
    assert editor is not None
    if how == "typed":
        QTest.keyClicks(editor, "3")
        QTest.keyClick(editor, Qt.Key.Key_Return)
    elif how == "picked":
        editor.showPopup()
        QTest.keyClick(editor.view(), Qt.Key.Key_End)
        QTest.keyClick(editor.view(), Qt.Key.Key_Return)
    else:
        panel.hide()
    QTest.qWait(20)
    assert edits == ([] if how == "closed" else [("chin", "3")])
