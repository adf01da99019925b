"""Titles, sections, segments, buttons and tables keep their measures and say what was done to them."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDockWidget, QLabel, QMainWindow

from widgets.parts.buttons import IconButton, KeyButton
from widgets.parts.empty import EmptyState
from widgets.parts.section import Section
from widgets.parts.segments import Segments
from widgets.parts.tables import CheckRow, CheckTable
from widgets.parts.titles import DockTitle

LEFT = Qt.MouseButton.LeftButton


def test_title_floats_and_closes_its_dock(qtbot) -> None:
    window, dock = QMainWindow(), QDockWidget("Fit")
    qtbot.addWidget(window)
    window.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, dock)
    title = DockTitle("Fit", "fresh", dock)
    window.show()
    qtbot.waitExposed(window)
    assert dock.titleBarWidget() is title
    assert title.height() == 28
    assert {b.width() for b in title.buttons.values()} == {20}
    QTest.mouseClick(title.buttons["float"], LEFT)
    assert dock.isFloating()
    QTest.mouseClick(title.buttons["float"], LEFT)
    assert not dock.isFloating()
    QTest.mouseClick(title.buttons["close"], LEFT)
    assert not dock.isVisible()
    title.set_note("stale")
    assert title.note == "stale"


def test_a_section_folds_by_mouse_and_key(qtbot) -> None:
    section = Section("Repair")
    qtbot.addWidget(section)
    value, label = section.add_value("Depth"), QLabel("below")
    section.add_widget(label)
    value.set_text("a_very_long_name.png")
    section.show()
    qtbot.waitExposed(section)
    assert value.toolTip() == "a_very_long_name.png"
    full = section.sizeHint().height()
    QTest.mouseClick(section.heading, LEFT)
    assert not label.isVisible()
    assert section.sizeHint().height() < full
    QTest.keyClick(section.heading, Qt.Key.Key_Space)
    assert label.isVisible()


def test_segments_send_only_what_changes(qtbot) -> None:
    row = Segments([("a", "All"), ("b", "Proposed"), ("c", "None")], name="Filter")
    qtbot.addWidget(row)
    row.resize(row.sizeHint())
    chosen = []
    row.chosen.connect(chosen.append)
    QTest.mouseClick(row, LEFT, pos=row.box("b").center().toPoint())
    QTest.mouseClick(row, LEFT, pos=row.box("b").center().toPoint())
    row.set_current("a")
    row.set_available("b", False, "Nothing is proposed")
    QTest.keyClick(row, Qt.Key.Key_Right)
    assert chosen == ["b", "c"]
    QTest.mouseClick(row, LEFT, pos=row.box("b").center().toPoint())
    assert chosen == ["b", "c"]
    assert row.height() == 24


@pytest.mark.parametrize("button", [lambda: IconButton("plus", "Add (A)"), lambda: KeyButton("Fit", "Ctrl+Enter")])
def test_a_disabled_button_says_why(qtbot, button) -> None:
    made = button()
    qtbot.addWidget(made)
    made.set_available(False, "Place five fiducials first")
    assert not made.isEnabled()
    assert "Place five fiducials first" in made.toolTip()
    made.set_available(True)
    assert made.isEnabled()
    assert "Place five" not in made.toolTip()
    assert made.accessibleName()


def test_a_button_grows_with_its_text(qtbot) -> None:
    button = KeyButton("Fit", "Ctrl+Enter")
    qtbot.addWidget(button)
    before = button.sizeHint()
    button.setText("Fit the face again")
    assert button.sizeHint().width() > before.width()
    assert before.height() == 24


def test_a_table_of_checks_has_a_row_each(qtbot) -> None:
    table = CheckTable("to scan", "mm")
    qtbot.addWidget(table)
    table.set_rows([CheckRow("median", "0.05", "0.07", "ok"), CheckRow("largest", "2.10", "1.50", "fail")])
    assert table.sizeHint().height() == 22 + 2 * 20
    assert "largest 2.10 fail" in table.accessibleDescription()
    table.resize(296, 62)
    picture = table.grab().toImage()
    colours = {picture.pixelColor(x, y).name() for x in range(248, 290) for y in range(42, 62)}
    assert "#e5484d" in colours


def test_an_empty_place_offers_what_belongs_there(qtbot) -> None:
    place = EmptyState("No scan yet", "A range image of the face.", [("Open scan…", "", True)])
    qtbot.addWidget(place)
    with qtbot.waitSignal(place.buttons[0].clicked):
        QTest.mouseClick(place.buttons[0], LEFT)
