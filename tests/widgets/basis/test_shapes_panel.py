"""The table of the shapes tells what is meant and changes nothing by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QModelIndex, QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QMenu

from widgets.basis.shapes_panel import EDITS, MAPPINGS, ShapesPanel
from widgets.basis.shapes_table import MIME, ROW, ShapeRow

LEFT, CTRL = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier
NAMES = ("jaw_open", "smile", "brow_lower", "still", "blink")
ROWS = [
    ShapeRow("jaw_open", 0.41, 0.98, thumbnail=np.full((20, 30, 3), 90, np.uint8)),
    ShapeRow("smile", 0.53, 0.93),
    ShapeRow("brow_lower", 1.36, 0.71),
    ShapeRow("still", 0.0, float("nan")),
    ShapeRow("blink", 0.37, 0.97),
]


@pytest.fixture
def panel(qtbot) -> ShapesPanel:
    made = ShapesPanel()
    qtbot.addWidget(made)
    made.resize(232, 420)
    made.set_shapes(ROWS)
    made.show()
    qtbot.waitExposed(made)
    return made


def click(panel: ShapesPanel, row: int, modifiers=Qt.KeyboardModifier.NoModifier) -> None:
    place = panel.view.visualRect(panel.view.shapes.index(row)).center()
    QTest.mouseClick(panel.view.viewport(), LEFT, modifiers, place)


def listed(panel: ShapesPanel) -> list[str]:
    return [row.name for row in panel.view.shapes.rows]


def test_a_click_looks_at_a_shape_and_ctrl_marks_more(panel: ShapesPanel) -> None:
    looked, marked = [], []
    panel.selected.connect(looked.append)
    panel.selection_changed.connect(marked.append)
    click(panel, 1)
    click(panel, 3, CTRL)
    assert looked == ["smile", "still"] and marked[-1] == ("smile", "still") == panel.selection
    panel.set_current("blink")
    assert panel.selection == ("blink",) and len(looked) == 2, "what is set tells nobody"
    panel.set_shapes(ROWS[::-1])
    assert panel.selection == ("blink",) and panel.current == "blink"
    panel.set_shapes(ROWS[:2])
    assert panel.current is None and panel.note == "2"


def test_shapes_below_the_limit_bear_a_mark(panel: ShapesPanel) -> None:
    assert [row.drifts(0.85) for row in ROWS] == [False, False, True, False, False]
    model = panel.view.shapes
    tip = model.data(model.index(2), Qt.ItemDataRole.ToolTipRole)
    assert "0.71" in tip and "below 0.85" in tip
    before = panel.view.grab().toImage()
    panel.set_cosine_limit(0.5)
    assert panel.view.grab().toImage() != before
    assert "below" not in model.data(model.index(2), Qt.ItemDataRole.ToolTipRole)


def test_find_and_columns_only_change_what_is_listed(panel: ShapesPanel) -> None:
    header = panel.header
    x = {"name": 60, "mm": header.width() - 80, "cosine": header.width() - 20}
    QTest.mouseClick(header, LEFT, pos=QPoint(x["cosine"], 10))
    assert listed(panel) == ["brow_lower", "smile", "blink", "jaw_open", "still"]
    QTest.mouseClick(header, LEFT, pos=QPoint(x["mm"], 10))
    assert listed(panel)[0] == "brow_lower" and listed(panel)[-1] == "still"
    QTest.mouseClick(header, LEFT, pos=QPoint(x["mm"], 10))
    assert listed(panel) == list(NAMES) == [row.name for row in panel.rows]
    QTest.keyClicks(panel.find_field, "B")
    assert listed(panel) == ["brow_lower", "blink"]
    assert not panel.view.shapes.may_move
    QTest.keyClicks(panel.find_field, "zzz")
    assert listed(panel) == [] and panel.none_found.isVisible()


@pytest.mark.parametrize(("typed", "wanted"), [("grin ", [("smile", "grin")]), ("smile", []), ("   ", [])])
def test_a_name_is_typed_in_its_row(panel: ShapesPanel, typed: str, wanted: list) -> None:
    told = []
    panel.rename_requested.connect(lambda *pair: told.append(pair))
    panel.rename_requested.connect(lambda old, new: panel.set_shapes([replace(r, name=new) if r.name == old else r
                                                                      for r in panel.rows]))  # fmt: skip
    click(panel, 1)
    QTest.keyClick(panel.view, Qt.Key.Key_F2)
    editor = panel.view.viewport().findChild(QLineEdit)
    assert editor.text() == "smile" and editor.geometry().right() < panel.view.width()
    editor.setText(typed)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    QApplication.processEvents()
    assert told == wanted and listed(panel)[1] == panel.rows[1].name == (wanted[0][1] if wanted else "smile")


@pytest.mark.parametrize(
    ("moved", "before", "wanted"),
    [
        (("blink",), 0, ("blink", "jaw_open", "smile", "brow_lower", "still")),
        (("smile", "still"), 5, ("jaw_open", "brow_lower", "blink", "smile", "still")),
        (("jaw_open", "blink"), 2, ("smile", "jaw_open", "blink", "brow_lower", "still")),
        (("smile",), 2, None),
    ],
)
def test_rows_that_are_dropped_ask_for_another_order(panel: ShapesPanel, moved, before, wanted) -> None:
    told = []
    panel.reorder_requested.connect(told.append)
    model = panel.view.shapes
    indexes = [model.index(NAMES.index(name)) for name in reversed(moved)]
    data = model.mimeData(indexes)
    assert data.hasFormat(MIME)
    model.dropMimeData(data, Qt.DropAction.MoveAction, before, 0, QModelIndex())
    assert told == ([wanted] if wanted else [])
    assert listed(panel) == list(NAMES), "the table waits for the rig"


def test_the_menu_offers_what_can_be_done_and_says_why_not(panel: ShapesPanel) -> None:
    told = []
    panel.edit_requested.connect(lambda *pair: told.append(pair))
    panel.set_edit_available("mirror", False, "the mesh has no mirror image")
    click(panel, 0)
    menu = QMenu(panel)
    panel.fill_menu(menu)
    texts = {a.text().split("\t")[0]: a for a in menu.actions() if a.text()}
    assert set(texts) == {"Rename", *(text for text, _ in EDITS.values()), *MAPPINGS.values(), "Copy table",
                          "Copy picture", "Save picture…"}  # fmt: skip
    assert panel.cells()[3] == ["brow_lower", "1.36", "0.71"]
    assert not texts["Combine into one"].isEnabled() and "two shapes" in texts["Combine into one"].toolTip()
    assert not texts["Mirror left / right"].isEnabled()
    assert texts["Mirror left / right"].toolTip() == "the mesh has no mirror image"
    texts["Split left / right"].trigger()
    click(panel, 4, CTRL)
    panel.fill_menu(menu)
    {a.text(): a for a in menu.actions()}["Combine into one"].trigger()
    QTest.keyClick(panel.view, Qt.Key.Key_Delete)
    assert told == [("split", ("jaw_open",)), ("combine", ("jaw_open", "blink")), ("remove", ("jaw_open", "blink"))]
    mapped = []
    panel.mapping_requested.connect(mapped.append)
    {a.text(): a for a in menu.actions()}[MAPPINGS["facs"]].trigger()
    assert mapped == ["facs"]
    menu.deleteLater()


def test_the_last_shape_stays(panel: ShapesPanel) -> None:
    told = []
    panel.edit_requested.connect(lambda *pair: told.append(pair))
    panel.set_shapes(ROWS[:1])
    click(panel, 0)
    QTest.keyClick(panel.view, Qt.Key.Key_Delete)
    assert told == []


def test_an_empty_table_offers_to_open_a_rig(panel: ShapesPanel) -> None:
    panel.set_shapes([])
    asked = []
    panel.add_requested.connect(lambda: asked.append(1))
    assert panel.empty.isVisible() and panel.note == ""
    QTest.mouseClick(panel.empty.buttons[0], LEFT)
    assert asked == [1]


def test_rows_keep_their_height(panel: ShapesPanel) -> None:
    assert panel.view.visualRect(panel.view.shapes.index(0)).height() == ROW == 28
