"""Limits go through the panel unchanged, to the last digit, but for the cells that were edited."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDoubleSpinBox

from engine.scan.limits import FIGURES, REGIONS, Bounds, Limits, RegionLimits
from widgets.scan.limits_panel import LimitsPanel

LEFT = Qt.MouseButton.LeftButton
NAMES = tuple(REGIONS)
mm = st.floats(0.0, 1000.0)
share = st.floats(0.0, 1.0)


@st.composite
def bounds(draw: Any, values: Any) -> Bounds:
    return Bounds(*sorted((draw(values), draw(values))))


@st.composite
def limits(draw: Any) -> Limits:
    regions = {
        name: RegionLimits(*(draw(bounds(share if figure == "filled_fraction" else mm)) for figure in FIGURES))
        for name in draw(st.sets(st.sampled_from([*NAMES, "an ear of another template"])))
    }
    whole = [draw(mm), draw(mm), draw(mm), draw(share), draw(st.integers(0, 1000)), draw(mm)]
    return Limits(*whole, tolerance=draw(st.floats(1.0, 1000.0)), regions=regions)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(limits())
def test_showing_limits_changes_none(qtbot, given_limits: Limits) -> None:
    panel = LimitsPanel()
    qtbot.addWidget(panel)
    panel.set_limits(given_limits, NAMES)
    assert panel.limits() == given_limits


def test_only_what_is_edited_changes_and_an_editor_that_is_left_edits_nothing(qtbot) -> None:
    panel = LimitsPanel()
    qtbot.addWidget(panel)
    lids = RegionLimits(median_mm=Bounds(0.0123456, 0.07249321))
    old = replace(Limits(), median_mm=0.07249321, filled_fraction=0.0123456).with_region("lids", lids)
    panel.set_limits(old, NAMES)
    panel.show()
    cells, row = panel.table, NAMES.index("lids")

    def edit(column: int, typed: str) -> None:
        cells.editItem(cells.item(row, column))
        (editor,) = cells.viewport().findChildren(QDoubleSpinBox)
        if typed:
            QTest.keyClicks(editor, typed)
        QTest.keyClick(editor, Qt.Key.Key_Return)
        QTest.qWait(10)

    edit(2, "")
    assert panel.limits() == old, "its editor shows 0.072"
    edit(2, "123.456")
    changed = old.with_region("lids", replace(lids, median_mm=Bounds(0.0123456, 123.456)))
    assert panel.limits() == changed
    panel.face["max_mm"].setValue(2.5)
    assert panel.limits() == replace(changed, max_mm=2.5)
    panel.set_limits(old, NAMES)
    assert panel.limits() == old
