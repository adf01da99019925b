"""The table of the fiducials: what is listed, chosen, typed and refused."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit

from engine.landmarks import LandmarkState
from tests.widgets.conftest import LOCKED, PROPOSED, SKIPPED, UNSET
from widgets.parts.landmark_table import NAME, LandmarkTable, X, Y


@pytest.fixture
def table(qtbot, scheme, landmarks) -> LandmarkTable:
    view = LandmarkTable()
    qtbot.addWidget(view)
    view.resize(296, 440)
    view.set_scheme(scheme)
    view.set_landmarks(landmarks)
    view.show()
    qtbot.waitExposed(view)
    view.activateWindow()
    view.setFocus()
    return view


def texts(table: LandmarkTable, name: str) -> list[str]:
    row = table.model().names.index(name)
    return [table.model().index(row, column).data() for column in (NAME, X, Y)]


def test_all_landmarks_in_clicking_order_with_places_to_a_tenth(table, scheme, positions) -> None:
    assert table.model().names == scheme.names
    x, y = positions["nose_tip"]
    assert texts(table, "nose_tip") == ["nose_tip", f"{x:.1f}", f"{y:.1f}"]
    assert texts(table, UNSET) == [UNSET, "", ""]
    assert texts(table, SKIPPED) == [SKIPPED, "", "skipped"]


def test_rows_and_header_have_their_heights(table) -> None:
    assert table.rowHeight(0) == 20
    assert table.horizontalHeader().height() == 22
    assert table.model().headerData(X, Qt.Orientation.Horizontal) == "x px"


def test_the_filter_lists_what_is_proposed(table, landmarks) -> None:
    table.set_proposed_only(True)
    assert table.model().names == (PROPOSED,)
    table.set_landmarks(landmarks.moved(PROPOSED, 3, 4))
    assert table.model().names == ()
    table.set_proposed_only(False)
    assert table.model().rowCount() == 20


def test_a_click_chooses_and_news_do_not(table, qtbot, landmarks) -> None:
    chosen = []
    table.selected.connect(chosen.append)
    table.set_current("chin")
    table.set_landmarks(landmarks.moved("chin", 5, 5))
    assert chosen == []
    row = table.model().names.index("nose_left")
    box = table.visualRect(table.model().index(row, NAME))
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, box.center())
    assert chosen == ["nose_left"]
    QTest.keyClick(table, Qt.Key.Key_Down)
    assert chosen == ["nose_left", "nose_right"]


def _type(table: LandmarkTable, name: str, column: int, text: str) -> bool:
    index = table.model().index(table.model().names.index(name), column)
    table.setCurrentIndex(index)
    if not index.flags() & Qt.ItemFlag.ItemIsEditable:
        return False
    middle = table.visualRect(index).center()
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=middle)
    QTest.mouseDClick(table.viewport(), Qt.MouseButton.LeftButton, pos=middle)
    QApplication.processEvents()
    editor = table.viewport().findChild(QLineEdit)
    assert editor is not None
    editor.selectAll()
    QTest.keyClicks(editor, text)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    QApplication.processEvents()
    return True


@pytest.mark.parametrize(("column", "text", "value"), [(X, "12.5", 12.5), (Y, "7,25", 7.25)])
def test_a_typed_place_is_asked_for_and_not_kept(table, positions, column, text, value) -> None:
    asked = []
    table.edited.connect(lambda *values: asked.append(values))
    before = texts(table, "nose_tip")
    assert _type(table, "nose_tip", column, text)
    x, y = positions["nose_tip"]
    expected = (value, y) if column == X else (x, value)
    assert asked == [("nose_tip", pytest.approx(expected[0]), pytest.approx(expected[1]))]
    assert texts(table, "nose_tip") == before


def test_letters_cannot_be_typed_and_the_same_value_is_no_edit(table, positions) -> None:
    asked = []
    table.edited.connect(lambda *values: asked.append(values))
    assert _type(table, "nose_tip", X, "abc")
    assert _type(table, "nose_tip", X, f"{positions['nose_tip'][0]:.1f}")
    assert asked == []


@pytest.mark.parametrize("name", [LOCKED, UNSET, SKIPPED])
def test_what_is_locked_or_has_no_place_cannot_be_typed_over(table, name) -> None:
    assert not _type(table, name, X, "5")


def test_delete_asks_to_unset_and_return_goes_on_to_the_window(table) -> None:
    asked = []
    table.unset_requested.connect(asked.append)
    table.set_current("nose_tip")
    QTest.keyClick(table, Qt.Key.Key_Delete)
    QTest.keyClick(table, Qt.Key.Key_Return)
    assert asked == ["nose_tip"]
    assert table.state() == LandmarkTable.State.NoState


def test_the_mark_tells_state_and_side(table, landmarks, scheme) -> None:
    def ink(name: str) -> set[str]:
        index = table.model().index(table.model().names.index(name), 0)
        image = table.viewport().grab(table.visualRect(index)).toImage()
        return {image.pixelColor(x, y).name() for x in range(image.width()) for y in range(image.height())}

    assert "#2fb8a6" in ink("mouth_left")
    assert "#9b7cf2" in ink("nose_right")
    centre = table.visualRect(table.model().index(table.model().names.index(PROPOSED), 0)).center()
    picture = table.viewport().grab().toImage()
    assert picture.pixelColor(14, centre.y()).name() not in ("#9b7cf2", "#2fb8a6")
    assert landmarks[PROPOSED].state is LandmarkState.PROPOSED
