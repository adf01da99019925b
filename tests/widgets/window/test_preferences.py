"""The preferences panel is made of declarations alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QCheckBox, QComboBox, QDoubleSpinBox, QLineEdit, QSpinBox

from widgets.parts.segments import Segments
from widgets.window.preferences import PreferencesPanel


@dataclass(frozen=True)
class One:
    key: str
    type: type
    default: Any
    text: str = "What it is for."
    title: str = "Title"
    section: str = "Look"
    choices: tuple[Any, ...] = ()
    labels: tuple[str, ...] = ()
    minimum: float | None = None
    maximum: float | None = None
    unit: str = ""


DECLARED = (
    One("a/on", bool, True, title="Switch"),
    One("a/few", str, "x", title="Few", choices=("x", "y"), labels=("Ex", "Why")),
    One("a/many", int, 1, title="Many", choices=(1, 2, 3, 4)),
    One("b/whole", int, 5, title="Whole", section="Numbers", minimum=0, maximum=60, unit="min"),
    One("b/real", float, 0.2, title="Real", section="Numbers", minimum=0.0, maximum=2.0, unit="mm"),
    One("b/words", str, "", title="Words", section="Numbers", text="Spoken by a parrot."),
    One("c/hidden", str, "", section=""),
)


@pytest.fixture
def panel(qtbot: Any) -> PreferencesPanel:
    panel = PreferencesPanel(DECLARED)
    qtbot.addWidget(panel)
    for setting in DECLARED:
        panel.show_value(setting.key, setting.default)
    panel.resize(640, 480)
    panel.show()
    return panel


def test_type_choices_and_limits_choose_the_control(panel: PreferencesPanel) -> None:
    kinds = {key: type(row.input.control) for key, row in panel.rows.items()}
    assert kinds == {
        "a/on": QCheckBox, "a/few": Segments, "a/many": QComboBox, "b/whole": QSpinBox, "b/real": QDoubleSpinBox,
        "b/words": QLineEdit,
    }  # fmt: skip
    whole = panel.rows["b/whole"].input.control
    assert (whole.minimum(), whole.maximum(), whole.suffix()) == (0, 60, " min")
    for row in panel.rows.values():
        assert row.input.control.accessibleName() == row.setting.title
        assert row.hint.text() == row.setting.text


def test_what_the_hand_does_is_told_with_the_declared_type(panel: PreferencesPanel, qtbot: Any) -> None:
    told: list[tuple[str, Any]] = []
    panel.changed.connect(lambda key, value: told.append((key, value)))
    rows = panel.rows
    QTest.keyClick(rows["a/on"].input.control, Qt.Key.Key_Space)
    QTest.keyClick(rows["a/few"].input.control, Qt.Key.Key_Right)
    panel.sections.setCurrentRow(1)
    whole = rows["b/whole"].input.control
    whole.selectAll()
    QTest.keyClicks(whole, "17")
    QTest.keyClick(whole, Qt.Key.Key_Return)
    QTest.keyClicks(rows["b/words"].input.control, "polly")
    QTest.keyClick(rows["b/words"].input.control, Qt.Key.Key_Return)
    assert told == [("a/on", False), ("a/few", "y"), ("b/whole", 17), ("b/words", "polly")]
    assert [type(value) for _, value in told] == [bool, str, int, str]


def test_showing_a_value_tells_nobody_and_offers_the_way_back(panel: PreferencesPanel) -> None:
    told: list[Any] = []
    panel.changed.connect(lambda *values: told.append(values))
    values = {"a/on": False, "a/few": "y", "a/many": 3, "b/whole": 9, "b/real": 1.5, "b/words": "w"}
    for key, value in values.items():
        assert not panel.rows[key].reset.isEnabled()
        panel.show_value(key, value)
        assert panel.rows[key].reset.isEnabled()
    assert not told
    asked: list[str] = []
    panel.reset_requested.connect(asked.append)
    panel.rows["a/many"].reset.click()
    panel.reset_all.click()
    assert asked == ["a/many", ""]


def test_the_search_looks_through_all_sections(panel: PreferencesPanel) -> None:
    assert not panel.rows["b/words"].isVisible() and panel.rows["a/on"].isVisible()
    QTest.keyClicks(panel.search, "PARROT words")
    assert [key for key, row in panel.rows.items() if row.isVisible()] == ["b/words"]
    assert panel.headings["Numbers"].isVisible() and not panel.headings["Look"].isVisible()
    panel.search.setText("no such thing")
    assert panel.nothing.isVisible()
    panel.search.clear()
    assert panel.rows["a/on"].isVisible() and not panel.rows["b/words"].isVisible()
