"""The fiducial-scheme editor, driven by mouse and keys: vertices, pairs, order, undo, and what it says."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QWidget

from tests.engine.schemes import TEMPLATE, quick, shipped, thorough
from tests.journeys.driver import send_move
from widgets.scan.scheme_draft import SchemeDraft
from widgets.scan.scheme_editor import OfferedScheme, SchemeEditor, SchemeResult
from widgets.scan.scheme_table import FIELDS

LEFT, NONE = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
MIDDLE = 68, 62, 55, 26


@pytest.fixture
def editor(qtbot: Any) -> SchemeEditor:
    view = SchemeEditor(TEMPLATE)
    qtbot.addWidget(view)
    own = [OfferedScheme(quick(), False, ("base",)), OfferedScheme(thorough(), False)]
    view.set_schemes([OfferedScheme(shipped(name), True) for name in ("closed", "open")] + own, "quick")
    view.set_scan("base", "quick", 6)
    view.resize(1208, 728)
    view.show()
    with qtbot.waitExposed(view):
        pass
    view.activateWindow()
    qtbot.waitUntil(lambda: view.isActiveWindow() and view.chart.zoom > 1.0)
    QTest.qWait(20)
    return view


def click(editor: SchemeEditor, vertex: int, off: tuple[float, float] = (0.0, 0.0)) -> None:
    place = editor.chart.place(vertex) + QPointF(*off)
    point = QPoint(round(place.x()), round(place.y()))
    assert editor.chart.viewport().rect().contains(point)
    QTest.mouseMove(editor.chart.viewport(), point)
    QTest.mouseClick(editor.chart.viewport(), LEFT, NONE, point)


def type_into(editor: SchemeEditor, row: int, field: str, text: str) -> None:
    editor.table.edit_field(row, field)
    box = editor.table.viewport().findChildren(QLineEdit)[-1]
    box.selectAll()
    QTest.keyClicks(box, text)
    QTest.keyClick(box, Qt.Key.Key_Return)
    QTest.qWait(10)


def key(widget: QWidget, which: Qt.Key, modifier: Qt.KeyboardModifier = NONE) -> None:
    widget.setFocus()
    QTest.keyClick(widget, which, modifier)


def row_of(editor: SchemeEditor, name: str) -> int:
    row = editor.draft.row_of(name)
    assert row is not None
    return row


def vertex(editor: SchemeEditor, name: str) -> int | None:
    return editor.draft.marks[row_of(editor, name)].vertex


def test_a_click_gives_the_chosen_row_the_nearest_vertex_and_its_partner_the_mirror(editor: SchemeEditor) -> None:
    editor.choose_row(row_of(editor, "jaw_left"))
    free = int(TEMPLATE.mirror[253]) + 1
    click(editor, free, (2.0, -2.0))
    assert vertex(editor, "jaw_left") == free
    assert vertex(editor, "jaw_right") == TEMPLATE.mirror[free]
    assert editor.number.text() == str(free)
    editor.number_button.click()
    assert QGuiApplication.clipboard().text() == str(free)
    assert editor.primary_button.isEnabled() and editor.primary_button.text() == "Save changes"


def test_a_click_on_another_fiducial_takes_that_one_in_hand(editor: SchemeEditor) -> None:
    before = editor.draft
    click(editor, 55)
    assert editor.draft.marks[editor.row].name == "nose_tip" and editor.draft == before
    assert editor.number.text() == "55" and "nose_tip" in editor.about.text()


def test_the_mouse_shows_the_number_before_the_click(editor: SchemeEditor) -> None:
    before, said = editor.draft, []
    editor.chart.vertex_hovered.connect(said.append)
    for target in (90, 294, 180):
        place = editor.chart.place(target)
        send_move(editor.chart.viewport(), place + QPointF(1.0, 0.0), Qt.MouseButton.NoButton)
        assert editor.number.text() == str(target) and f"mirror {TEMPLATE.mirror[target]}" in editor.about.text()
        x, y = TEMPLATE.layout("closed").vertices[target]
        assert f"{x:.1f}, {y:.1f} in the template" in editor.about.text()
    assert said[-3:] == [90, 294, 180] and editor.draft == before


def test_two_vertices_at_one_place_take_turns(editor: SchemeEditor) -> None:
    """The two lips of a closed mouth lie on each other."""
    upper, lower = 46, 32
    assert (TEMPLATE.layout("closed").vertices[upper] == TEMPLATE.layout("closed").vertices[lower]).all()
    editor.add_button.click()
    QTest.qWait(10)
    got = set()
    for _ in range(2):
        click(editor, upper)
        got.add(editor.draft.marks[editor.row].vertex)
    assert got == {upper, lower}


def test_a_new_fiducial_waits_for_its_vertex_and_gets_a_partner(editor: SchemeEditor) -> None:
    count = len(editor.draft.rows)
    editor.add_button.click()
    type_into(editor, editor.row, "name", "cheek_left")
    assert not editor.primary_button.isEnabled() and "vertex" in editor.primary_button.toolTip()
    assert "cheek_left" in editor.message.text() and "click its place" in editor.message.text()
    click(editor, 90)
    assert editor.primary_button.isEnabled()
    editor.mirror_button.click()
    marks = {mark.name: mark for mark in editor.draft.marks}
    assert len(marks) == count + 2
    left, right = marks["cheek_left"], marks["cheek_right"]
    assert (left.mirror, right.mirror) == ("cheek_right", "cheek_left")
    assert (str(left.side), str(right.side), right.vertex) == ("left", "right", 294)
    for _ in range(4):
        QTest.keyClick(editor.table, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert editor.draft == SchemeDraft.of(quick(), TEMPLATE) and not editor.undo_button.isEnabled()
    for _ in range(4):
        editor.redo_button.click()
    assert {mark.name: mark for mark in editor.draft.marks} == marks


def test_typing_names_sides_mirrors_and_numbers(editor: SchemeEditor) -> None:
    type_into(editor, row_of(editor, "eye_left_outer"), "name", "eye_far")
    assert editor.draft.marks[row_of(editor, "eye_right_outer")].mirror == "eye_far"
    type_into(editor, row_of(editor, "eye_far"), "vertex", "79")
    assert vertex(editor, "eye_right_outer") == TEMPLATE.mirror[79]
    before = editor.draft
    type_into(editor, row_of(editor, "eye_far"), "vertex", "4410")
    assert editor.draft == before and "no vertex" in editor.message.text()
    type_into(editor, row_of(editor, "chin"), "name", "nose_tip")
    assert not editor.primary_button.isEnabled() and "occurs twice" in editor.primary_button.toolTip()
    editor.undo()
    type_into(editor, row_of(editor, "chin"), "group", "below")
    type_into(editor, row_of(editor, "chin"), "hint", "Where it ends.")
    mark = editor.draft.marks[row_of(editor, "chin")]
    assert (mark.group, mark.hint) == ("below", "Where it ends.")
    assert editor.draft.renames == {"eye_left_outer": "eye_far"}


def test_a_choice_of_sides_is_taken_at_once(editor: SchemeEditor) -> None:
    row = row_of(editor, "eye_left_outer")
    editor.table.edit_field(row, "side")
    box = editor.table.viewport().findChildren(QComboBox)[-1]
    box.setCurrentText("right")
    box.activated.emit(box.currentIndex())
    assert str(editor.draft.marks[row].side) == "right"
    assert "same side" in editor.message.text() or "lies on the side" in editor.message.text()
    wrong = editor.table.model().wrong(row, FIELDS.index("side"))
    assert wrong is not None and wrong.text in editor.table.model().index(row, 0).data(Qt.ItemDataRole.ToolTipRole)


def test_keys_alone_do_it(editor: SchemeEditor) -> None:
    names = [mark.name for mark in editor.draft.marks]
    key(editor.table, Qt.Key.Key_Down)
    key(editor.table, Qt.Key.Key_Down, Qt.KeyboardModifier.AltModifier)
    assert [mark.name for mark in editor.draft.marks] == [names[0], names[2], names[1], *names[3:]]
    key(editor.table, Qt.Key.Key_Up, Qt.KeyboardModifier.AltModifier)
    key(editor.table, Qt.Key.Key_Up, Qt.KeyboardModifier.AltModifier)
    assert [mark.name for mark in editor.draft.marks][:2] == [names[1], names[0]]
    key(editor.table, Qt.Key.Key_Delete)
    assert names[1] not in editor.draft.scheme().names and editor.draft.marks[editor.row].name == names[0]
    here = editor.draft.vertex(editor.row, TEMPLATE)
    key(editor.chart, Qt.Key.Key_Right)
    there = editor.draft.vertex(editor.row, TEMPLATE)
    edges = {tuple(edge) for edge in TEMPLATE.edges.tolist()}
    flat = TEMPLATE.layout("closed").vertices
    assert (min(here, there), max(here, there)) in edges and flat[there, 0] > flat[here, 0]
    zoom = editor.chart.zoom
    key(editor.chart, Qt.Key.Key_Plus)
    assert editor.chart.zoom > zoom


def test_tab_reaches_everything_and_comes_round(editor: SchemeEditor) -> None:
    editor.choice.setFocus()
    reached = []
    for _ in range(40):
        reached.append(QApplication.focusWidget())
        QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Tab)
        if QApplication.focusWidget() is editor.choice:
            break
    assert {editor.table, editor.chart, editor.name, editor.numbers, editor.cancel_button} <= set(reached)
    assert QApplication.focusWidget() is editor.choice


def test_a_shipped_scheme_is_looked_at_and_duplicated(editor: SchemeEditor) -> None:
    editor.show_scheme("closed")
    before = editor.draft
    editor.choose_row(row_of(editor, "chin"))
    click(editor, 90)
    key(editor.table, Qt.Key.Key_Delete)
    key(editor.table, Qt.Key.Key_Down, Qt.KeyboardModifier.AltModifier)
    QTest.keyClicks(editor.name, "x")
    assert editor.draft == before and not editor.delete_button.isEnabled()
    assert "duplicate" in editor.message.text()
    assert editor.primary_button.isEnabled() and editor.primary_button.text() == "Use scheme"
    editor.duplicate_button.click()
    assert editor.draft.name == "closed_2" and editor.has_changes and not editor.choice.isEnabled()
    editor.name.selectAll()
    QTest.keyClicks(editor.name, "mine")
    said: list[SchemeResult] = []
    editor.finished.connect(said.append)
    editor.everywhere.setChecked(True)
    editor.primary_button.click()
    (result,) = said
    assert (result.scheme.name, result.replaces, result.changed, result.use) == ("mine", None, True, True)
    assert result.everywhere and result.scheme.landmarks == shipped("closed").landmarks
    editor.undo()
    assert editor.draft.name == "closed_2", "what was typed into one field is one step"


def test_what_is_offered_says_why_not(editor: SchemeEditor) -> None:
    assert not editor.primary_button.isEnabled() and "nothing has changed" in editor.primary_button.toolTip()
    assert not editor.remove_button.isEnabled() and "Used by base" in editor.remove_button.toolTip()
    editor.show_scheme("thorough")
    assert editor.remove_button.isEnabled() and not editor.save_button.isVisible()
    removed: list[str] = []
    editor.remove_requested.connect(removed.append)
    editor.remove_button.click()
    assert removed == ["thorough"]
    type_into(editor, 0, "hint", "Other words.")
    assert editor.save_button.isVisible() and editor.primary_button.text() == "Use scheme"
    said: list[SchemeResult] = []
    editor.finished.connect(said.append)
    editor.save_button.click()
    assert not said[0].use and said[0].replaces == "thorough"
    editor.layout_choice.chosen.emit("open")
    assert "on an open mouth" in editor.message.text() and editor.primary_button.isEnabled()


def test_numbers_stand_beside_the_vertices_where_there_is_room(editor: SchemeEditor) -> None:
    editor.numbers.setChecked(True)
    far = editor.chart.grab().toImage()
    assert not editor.chart.numbers_readable
    editor.chart.set_zoom(8.0, editor.chart.place(55))
    assert editor.chart.numbers_readable
    near = editor.chart.grab().toImage()
    editor.numbers.setChecked(False)
    assert editor.chart.grab().toImage() != near and far != near
    place = editor.chart.place(55)
    assert editor.chart.at(place) == 55


EDITS: dict[str, Callable[[SchemeDraft, int, int], SchemeDraft]] = {
    "place": lambda d, row, n: d.placed(row, n, TEMPLATE),
    "add": lambda d, row, n: d.added(row),
    "copy": lambda d, row, n: d.duplicated(row),
    "delete": lambda d, row, n: d.deleted(row) if len(d.rows) > 1 else d,
    "move": lambda d, row, n: d.moved(row, n % len(d.rows)),
    "rename": lambda d, row, n: d.renamed(row, d.free_name(f"p{n}")),
    "mirror": lambda d, row, n: d.mirrored_with(row, d.marks[n % len(d.rows)].name),
}


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.sampled_from(sorted(EDITS)), st.integers(0, 99), st.integers(0, 440)), max_size=12))
def test_pairs_point_at_each_other_after_any_edits(steps: list[tuple[str, int, int]]) -> None:
    draft = SchemeDraft.of(quick(), TEMPLATE)
    for kind, row, number in steps:
        draft = EDITS[kind](draft, row % len(draft.rows), number)
    marks = {mark.name: mark for mark in draft.marks}
    assert len(marks) == len(draft.marks)
    for mark in draft.marks:
        assert not mark.mirror or marks[mark.mirror].mirror == mark.name
    assert len({row.origin for row in draft.rows if row.origin}) == len([row for row in draft.rows if row.origin])
    for row, mark in enumerate(draft.marks):
        at = draft.vertex(row, TEMPLATE)
        if at is not None and at != TEMPLATE.mirror[at] and not mark.mirror:
            pair = draft.with_partner(row, TEMPLATE)
            partner = next(
                other for other in pair.marks if other.name == pair.marks[pair.row_of(mark.name) or 0].mirror
            )
            assert partner.vertex == TEMPLATE.mirror[at] and partner.mirror == mark.name
            break


def test_no_vertex_number_is_out_of_sight_in_a_narrow_table(editor: SchemeEditor) -> None:
    for width in (1208, 900, 760):
        editor.resize(width, 700)
        QTest.qWait(10)
        table = editor.table
        right = table.columnViewportPosition(FIELDS.index("hint"))
        assert 0 < right <= table.viewport().width()
